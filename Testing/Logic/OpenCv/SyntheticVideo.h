#pragma once

#include <unistd.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <string>

#include "Adapters/OpenCv/CvMats.h"
#include "Core/Frame.h"

/// Pictures whose motion is known exactly.
namespace kerf::test {

/// A reddish texture of blobs of several sizes, the same for the same seed.
inline cv::Mat Tissue(int width, int height, int seed) {
  cv::RNG random(seed);
  cv::Mat sum(height, width, CV_32F, cv::Scalar(0));
  for (const int size : {3, 6, 12}) {
    cv::Mat noise(height, width, CV_32F);
    random.fill(noise, cv::RNG::NORMAL, 0, 1);
    cv::GaussianBlur(noise, noise, {0, 0}, size);
    cv::Scalar mean, deviation;
    cv::meanStdDev(noise, mean, deviation);
    sum += noise / deviation[0];
  }
  cv::Mat red, other, bgr;
  sum.convertTo(red, CV_8U, 22, 150);
  sum.convertTo(other, CV_8U, 16, 70);
  cv::merge(std::vector<cv::Mat>{other, other, red}, bgr);
  return bgr;
}

inline Frame MakeFrame(int index, const cv::Mat& bgr) {
  return Frame{index, index / 25.0, std::make_shared<const Image>(ToImage(bgr))};
}

inline Image FullMask(int width, int height, int border = 0) {
  cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
  mask(cv::Rect(border, border, width - 2 * border, height - 2 * border)).setTo(255);
  return ToImage(mask);
}

/// A folder of its own, removed at the end.
class Scratch {
 public:
  explicit Scratch(const std::string& name)
      : path_(std::filesystem::temp_directory_path() /
              ("kerf-test-" + name + "-" + std::to_string(getpid()))) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string Path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace kerf::test
