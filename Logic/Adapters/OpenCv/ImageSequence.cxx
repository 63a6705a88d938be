#include "Adapters/OpenCv/ImageSequence.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

bool IsImageName(const fs::path& path) {
  std::string suffix = path.extension().string();
  for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  static const char* const kSuffixes[] = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".ppm"};
  return std::any_of(std::begin(kSuffixes), std::end(kSuffixes),
                     [&](const char* known) { return suffix == known; });
}

ImageSequence ListFolder(const std::string& folder) {
  ImageSequence sequence;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && IsImageName(entry.path()))
      sequence.files.push_back(entry.path().string());
  if (sequence.files.empty()) throw InputError(folder, "frame 0", "no image in this folder");
  std::sort(sequence.files.begin(), sequence.files.end(), NaturalLess);
  return sequence;
}

/// Prefix, zero-padded width and suffix of `name%05d.png`.
struct Pattern {
  std::string prefix, suffix;
  int digits = 0;
};

Pattern ParsePattern(const std::string& text) {
  const fs::path path(text);
  const std::string name = path.filename().string();
  const std::size_t percent = name.find('%');
  std::size_t end = percent;
  if (percent != std::string::npos) {
    end = percent + 1;
    while (end < name.size() && std::isdigit(static_cast<unsigned char>(name[end]))) ++end;
  }
  if (percent == std::string::npos || end >= name.size() || name[end] != 'd' || end - percent > 3 ||
      name.find('%', end) != std::string::npos)
    throw InputError(text, "", "not a pattern of numbered images such as frame_%05d.png");
  Pattern pattern;
  pattern.prefix = name.substr(0, percent);
  pattern.suffix = name.substr(end + 1);
  pattern.digits = end > percent + 1 ? std::stoi(name.substr(percent + 1, end - percent - 1)) : 0;
  return pattern;
}

ImageSequence ListPattern(const std::string& text) {
  const Pattern pattern = ParsePattern(text);
  fs::path folder = fs::path(text).parent_path();
  if (folder.empty()) folder = ".";
  if (!fs::is_directory(folder)) throw InputError(text, "", "no such folder");
  std::map<long, std::string> numbered;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const std::size_t fixed = pattern.prefix.size() + pattern.suffix.size();
    if (name.size() <= fixed || name.compare(0, pattern.prefix.size(), pattern.prefix) != 0 ||
        name.compare(name.size() - pattern.suffix.size(), std::string::npos, pattern.suffix) != 0)
      continue;
    const std::string digits = name.substr(pattern.prefix.size(), name.size() - fixed);
    if (digits.size() > 9 || static_cast<int>(digits.size()) < pattern.digits ||
        !std::all_of(digits.begin(), digits.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; }))
      continue;
    numbered[std::stol(digits)] = entry.path().string();
  }
  if (numbered.empty()) throw InputError(text, "frame 0", "no image matches this pattern");
  ImageSequence sequence;
  long expected = numbered.begin()->first;
  for (const auto& [number, file] : numbered) {
    if (number != expected) {
      sequence.gap = "number " + std::to_string(expected) + " is missing, " +
                     std::to_string(number) + " exists; the frames before it are used";
      break;
    }
    sequence.files.push_back(file);
    ++expected;
  }
  return sequence;
}

}  // namespace

bool NaturalLess(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  const auto digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  while (i < a.size() && j < b.size()) {
    if (digit(a[i]) && digit(b[j])) {
      std::size_t i_end = i, j_end = j;
      while (i < a.size() && a[i] == '0') ++i;
      while (j < b.size() && b[j] == '0') ++j;
      for (i_end = i; i_end < a.size() && digit(a[i_end]);) ++i_end;
      for (j_end = j; j_end < b.size() && digit(b[j_end]);) ++j_end;
      if (i_end - i != j_end - j) return i_end - i < j_end - j;
      const int order = a.compare(i, i_end - i, b, j, j_end - j);
      if (order != 0) return order < 0;
      i = i_end;
      j = j_end;
    } else {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
    }
  }
  if ((i < a.size()) != (j < b.size())) return j < b.size();
  return a < b;  // equal but for leading zeros
}

ImageSequence ListImageSequence(const std::string& folder_or_pattern) {
  if (folder_or_pattern.find('%') != std::string::npos && !fs::is_directory(folder_or_pattern))
    return ListPattern(folder_or_pattern);
  if (!fs::is_directory(folder_or_pattern))
    throw InputError(folder_or_pattern, "", "no such folder");
  return ListFolder(folder_or_pattern);
}

std::optional<Image> ReadImageFile(const std::string& path) {
  cv::Mat mat;
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return std::nullopt;
  try {
    mat = cv::imread(path, cv::IMREAD_COLOR);
  } catch (const cv::Exception&) {
    return std::nullopt;  // a header that announces an absurd size
  }
  if (mat.empty()) return std::nullopt;
  return ToImage(mat);
}

void WriteImageFile(const std::string& path, const Image& image) {
  const fs::path target(path);
  const std::string part =
      (target.parent_path() / (target.stem().string() + ".part" + target.extension().string()))
          .string();
  bool written = false;
  try {
    written = cv::imwrite(part, ViewOf(image));
  } catch (const cv::Exception&) {
    throw InputError(path, "", "not a known image format");
  }
  if (!written) throw InputError(path, "", "cannot be written");
  fs::rename(part, target);
}

}  // namespace kerf
