#pragma once

#include <opencv2/core.hpp>
#include <vector>

/// Inside this component only: the masks of ImageMasks.h on OpenCV's matrices.
namespace kerf {

/// @param bgr 8-bit, 3 channels. @return 8-bit mask of the same size
cv::Mat FindInstruments(const cv::Mat& bgr);
cv::Mat FindHighlights(const cv::Mat& bgr);

/// Connected components of a mask, 0 for what is not in it. OpenCV's own statistics take three
/// times as long.
struct Components {
  cv::Mat labels;         ///< int, of the mask's size
  std::vector<int> area;  ///< px, by label
};
Components ComponentsOf(const cv::Mat& mask, int connectivity);

}  // namespace kerf
