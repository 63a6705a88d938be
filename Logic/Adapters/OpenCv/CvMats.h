#pragma once

#include <opencv2/core.hpp>

#include "Core/Frame.h"

/// Inside this component only: OpenCV views of Core's images, without a copy.
namespace kerf {

/// The matrix reads the image's memory: it must not outlive the image, and nobody may write to it.
inline cv::Mat ViewOf(const Image& image) {
  return cv::Mat(image.height, image.width, CV_8UC(image.channels),
                 const_cast<std::uint8_t*>(image.data.data()));
}

/// A copy that owns its pixels.
inline Image ToImage(const cv::Mat& mat) {
  Image image{mat.cols, mat.rows, mat.channels(), {}};
  image.data.resize(static_cast<std::size_t>(mat.cols) * mat.rows * mat.channels());
  cv::Mat view = ViewOf(image);
  mat.copyTo(view);
  return image;
}

}  // namespace kerf
