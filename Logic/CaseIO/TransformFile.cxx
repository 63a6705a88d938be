#include "CaseIO/TransformFile.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

#include "Core/Errors.h"
#include "Core/Types.h"

namespace kerf {
namespace {

std::vector<double> Numbers(const std::string& text, const std::string& path,
                            const std::string& element) {
  std::vector<double> numbers;
  std::istringstream words(text);
  std::string word;
  while (words >> word) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
      throw InputError(path, element, "\"" + word + "\" is not a finite number");
    numbers.push_back(value);
  }
  return numbers;
}

Eigen::Affine3d FromItk(const std::string& text, const std::string& path) {
  std::istringstream lines(text);
  std::string line, type;
  std::vector<double> parameters, center;
  while (std::getline(lines, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    const auto colon = line.find(':');
    if (line.empty() || line[0] == '#' || colon == std::string::npos) continue;
    const std::string key = line.substr(0, colon), value = line.substr(colon + 1);
    if (key == "Transform") {
      if (!type.empty()) throw InputError(path, "Transform", "there is more than one");
      std::istringstream(value) >> type;
    } else if (key == "Parameters") {
      parameters = Numbers(value, path, key);
    } else if (key == "FixedParameters") {
      center = Numbers(value, path, key);
    }
  }
  if (type.rfind("AffineTransform_", 0) != 0 && type.rfind("MatrixOffsetTransformBase_", 0) != 0)
    throw InputError(path, "Transform",
                     "is a \"" + type + "\"; a linear AffineTransform is expected");
  if (parameters.size() != 12) throw InputError(path, "Parameters", "are not twelve numbers");
  if (center.empty()) center.assign(3, 0.0);
  if (center.size() != 3) throw InputError(path, "FixedParameters", "are not three numbers");
  Eigen::Affine3d from_parent = Eigen::Affine3d::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) from_parent.linear()(r, c) = parameters[3 * r + c];
  const Vec3 middle(center[0], center[1], center[2]);
  from_parent.translation() =
      Vec3(parameters[9], parameters[10], parameters[11]) + middle - from_parent.linear() * middle;
  return from_parent;
}

void RequireInvertible(const Eigen::Affine3d& t, const std::string& path) {
  if (!(std::abs(t.linear().determinant()) > 1e-9))
    throw InputError(path, "matrix", "cannot be inverted");
}

}  // namespace

Eigen::Affine3d ReadTransformFile(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be opened");
  std::ostringstream content;
  content << in.rdbuf();
  const std::string text = content.str();
  if (text.rfind("\x89HDF", 0) == 0)
    throw InputError(path, "", "is an HDF5 transform: save it as .tfm");
  if (text.find("#Insight Transform File") != std::string::npos) {
    const Eigen::Affine3d from_parent = FromItk(text, path);
    RequireInvertible(from_parent, path);
    return from_parent.inverse();
  }
  const auto numbers = Numbers(text, path, "matrix");
  if (numbers.size() != 16)
    throw InputError(path, "matrix",
                     "has " + std::to_string(numbers.size()) + " numbers, sixteen are expected");
  if (numbers[12] != 0 || numbers[13] != 0 || numbers[14] != 0 || numbers[15] != 1)
    throw InputError(path, "matrix", "has a last row other than 0 0 0 1");
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) transform.linear()(r, c) = numbers[4 * r + c];
    transform.translation()[r] = numbers[4 * r + 3];
  }
  RequireInvertible(transform, path);
  return transform;
}

}  // namespace kerf
