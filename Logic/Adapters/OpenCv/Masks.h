#pragma once

#include <opencv2/core.hpp>

/// Inside this component only: the masks of ImageMasks.h on OpenCV's matrices.
namespace kerf {

/// @param bgr 8-bit, 3 channels. @return 8-bit mask of the same size
cv::Mat FindInstruments(const cv::Mat& bgr);
cv::Mat FindHighlights(const cv::Mat& bgr);

}  // namespace kerf
