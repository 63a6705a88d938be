#include "Adapters/OpenCv/CameraFile.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <opencv2/core.hpp>
#include <sstream>

#include "Core/Errors.h"

namespace kerf {
namespace {

cv::FileStorage OpenStorage(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be opened");
  std::ostringstream text;
  text << in.rdbuf();
  try {
    cv::FileStorage storage(text.str(), cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (storage.isOpened()) return storage;
  } catch (const cv::Exception&) {
  }
  throw InputError(path, "", "is not an OpenCV FileStorage (YAML, XML or JSON)");
}

cv::Mat Matrix(const cv::FileStorage& storage, const std::string& path, const char* key) {
  const cv::FileNode node = storage[key];
  if (node.empty()) throw InputError(path, key, "is missing");
  cv::Mat stored, matrix;
  try {
    stored = node.mat();
  } catch (const cv::Exception&) {
    throw InputError(path, key, "is not a matrix");
  }
  if (stored.empty() || stored.channels() != 1) throw InputError(path, key, "is not a matrix");
  stored.convertTo(matrix, CV_64F);
  if (!cv::checkRange(matrix)) throw InputError(path, key, "holds a value that is not a number");
  return matrix;
}

cv::Mat Matrix(const cv::FileStorage& storage, const std::string& path, const char* key, int rows,
               int columns) {
  cv::Mat matrix = Matrix(storage, path, key);
  if (matrix.rows != rows || matrix.cols != columns)
    throw InputError(path, key,
                     "is " + std::to_string(matrix.rows) + "x" + std::to_string(matrix.cols) +
                         ", expected " + std::to_string(rows) + "x" + std::to_string(columns));
  return matrix;
}

int Size(const cv::FileStorage& storage, const std::string& path, const char* key) {
  const cv::FileNode node = storage[key];
  if (node.empty()) throw InputError(path, key, "is missing");
  if (!node.isInt() && !node.isReal()) throw InputError(path, key, "is not a number");
  const double value = node.real();
  if (!(value >= 1 && value <= 1e6) || value != std::floor(value))
    throw InputError(path, key, "is not a positive whole number");
  return static_cast<int>(value);
}

Eigen::Isometry3d RigidTransform(const cv::Mat& matrix, const std::string& path, const char* key) {
  Eigen::Matrix4d m;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) m(r, c) = matrix.at<double>(r, c);
  if ((m.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-6)
    throw InputError(path, key, "has a last row other than 0 0 0 1");
  // RAS worlds arrive here already flipped, so a proper rotation is expected.
  const Mat3 rotation = m.topLeftCorner<3, 3>();
  if ((rotation.transpose() * rotation - Mat3::Identity()).cwiseAbs().maxCoeff() > 1e-3 ||
      rotation.determinant() < 0)
    throw InputError(path, key, "is not a rigid transform");
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = rotation;
  transform.translation() = m.topRightCorner<3, 1>();
  return transform;
}

CameraModel Intrinsics(const cv::FileStorage& storage, const std::string& path) {
  CameraModel camera;
  camera.width = Size(storage, path, "image_width");
  camera.height = Size(storage, path, "image_height");
  const cv::Mat k = Matrix(storage, path, "camera_matrix", 3, 3);
  camera.fx = k.at<double>(0, 0);
  camera.fy = k.at<double>(1, 1);
  camera.cx = k.at<double>(0, 2);
  camera.cy = k.at<double>(1, 2);
  const double rest[] = {k.at<double>(0, 1), k.at<double>(1, 0), k.at<double>(2, 0),
                         k.at<double>(2, 1), k.at<double>(2, 2) - 1.0};
  for (double value : rest)
    if (std::abs(value) > 1e-9)
      throw InputError(path, "camera_matrix",
                       "has skew or is not of the form fx 0 cx; 0 fy cy; 0 0 1");
  if (!storage["distortion_coefficients"].empty()) {
    const cv::Mat d = Matrix(storage, path, "distortion_coefficients");
    if (d.rows != 1 && d.cols != 1)
      throw InputError(path, "distortion_coefficients", "is not a single row or column");
    // OpenCV writes 4, 5, 8, 12 or 14; those beyond k1 k2 p1 p2 k3 are only accepted as zeros.
    for (int i = 0; i < static_cast<int>(d.total()); ++i) {
      const double value = d.at<double>(i);
      if (i < 5)
        camera.distortion[i] = value;
      else if (value != 0.0)
        throw InputError(path, "distortion_coefficients",
                         "uses more than the five coefficients k1 k2 p1 p2 k3");
    }
  }
  return camera;
}

std::string MatrixText(const char* key, int rows, int columns, const double* values) {
  std::string text = std::string(key) + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
                     "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ ";
  for (int i = 0; i < rows * columns; ++i) {
    char number[40];
    // 17 digits read back to the same bits; a point marks a real number.
    std::snprintf(number, sizeof number, "%.17g", values[i]);
    std::string value = number;
    if (value.find_first_of(".en") == std::string::npos) value += ".";
    text += value;
    text += i + 1 == rows * columns ? " ]\n" : i % 4 == 3 ? ",\n       " : ", ";
  }
  return text;
}

}  // namespace

CameraModel ReadCameraIntrinsics(const std::string& path) {
  const cv::FileStorage storage = OpenStorage(path);
  CameraModel camera = Intrinsics(storage, path);
  camera.Validate(path);
  return camera;
}

CameraModel ReadCameraFile(const std::string& path) {
  const cv::FileStorage storage = OpenStorage(path);
  CameraModel camera = Intrinsics(storage, path);
  if (!storage["camera_from_world"].empty()) {
    camera.camera_from_world =
        RigidTransform(Matrix(storage, path, "camera_from_world", 4, 4), path, "camera_from_world");
  } else if (!storage["T_cam_from_ct"].empty()) {
    // Columns of x and y change sign with the world's axes (RAS → LPS).
    cv::Mat pose = Matrix(storage, path, "T_cam_from_ct", 4, 4);
    pose.col(0) *= -1.0;
    pose.col(1) *= -1.0;
    camera.camera_from_world = RigidTransform(pose, path, "T_cam_from_ct");
  } else {
    throw InputError(path, "camera_from_world", "is missing, and so is T_cam_from_ct");
  }
  camera.Validate(path);
  return camera;
}

bool CameraFileHasPose(const std::string& path) {
  const cv::FileStorage storage = OpenStorage(path);
  return !storage["camera_from_world"].empty() || !storage["T_cam_from_ct"].empty();
}

std::string ReadCalibrationTime(const std::string& path) {
  const cv::FileStorage storage = OpenStorage(path);
  const cv::FileNode node = storage["calibration_time"];
  const std::string time = node.isString() ? node.string() : std::string();
  // It is written into other files as it is.
  const bool plain = std::all_of(time.begin(), time.end(), [](unsigned char c) {
    return std::isprint(c) && c != '"' && c != '\\';
  });
  return plain ? time : std::string();
}

std::optional<int> CalibrationAge_days(const std::string& time, std::time_t now) {
  for (const char* format : {"%Y-%m-%d", "%a %b %d %H:%M:%S %Y", "%a %d %b %Y %I:%M:%S %p"}) {
    std::tm calibrated{};
    std::istringstream in(time);
    in.imbue(std::locale::classic());
    in >> std::get_time(&calibrated, format);
    // A text that breaks off does not fail: what was not read stays 0.
    if (in.fail() || calibrated.tm_mday == 0 || calibrated.tm_year == 0) continue;
    const double days = std::difftime(now, timegm(&calibrated)) / 86400.0;
    if (!(std::abs(days) < 1e6)) continue;
    if (days < 0 && days > -1) return 0;  // of another time zone
    return static_cast<int>(std::floor(days));
  }
  return std::nullopt;
}

void WriteCameraFile(const std::string& path, const CameraModel& camera,
                     const std::string& calibrated) {
  const double k[9] = {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
  const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> pose = camera.camera_from_world.matrix();
  const std::string time = calibrated.empty() ? "" : "calibration_time: \"" + calibrated + "\"\n";
  const std::string text =
      "%YAML:1.0\n---\n# camera_from_world maps the patient frame (LPS, mm) to the OpenCV camera "
      "frame\nspace: LPS\n" +
      time + "image_width: " + std::to_string(camera.width) +
      "\nimage_height: " + std::to_string(camera.height) + "\n" +
      MatrixText("camera_matrix", 3, 3, k) +
      MatrixText("distortion_coefficients", 1, 5, camera.distortion.data()) +
      MatrixText("camera_from_world", 4, 4, pose.data());
  namespace fs = std::filesystem;
  const fs::path target(path);
  std::error_code error;
  if (target.has_parent_path()) fs::create_directories(target.parent_path(), error);
  const fs::path temporary = target.parent_path() / ("." + target.filename().string() + ".partial");
  std::ofstream out(temporary, std::ios::binary);
  out << text;
  out.close();
  if (!out) throw InputError(path, "", "cannot be written");
  fs::rename(temporary, target, error);
  if (error) throw InputError(path, "", "cannot be written: " + error.message());
}

}  // namespace kerf
