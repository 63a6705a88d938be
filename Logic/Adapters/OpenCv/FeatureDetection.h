#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

/// Inside this component only: interest points on OpenCV's matrices.
namespace kerf {

struct InterestPoint {
  float u = 0, v = 0;  ///< px, sub-pixel
  float score = 0;     ///< larger is better; comparable within one detector
};

/// Fast-Hessian ("speeded-up") points: maxima of the determinant of box-filter Hessians over place
/// and scale.
/// @param grey 8-bit, 1 channel. @return unordered in strength, in scan order
std::vector<InterestPoint> FastHessianPoints(const cv::Mat& grey, double threshold);

/// Points of the named detector (see TrackerOptions::detector) inside `mask`.
/// @throws UsageError on an unknown name
std::vector<InterestPoint> DetectInterestPoints(const cv::Mat& grey, const cv::Mat& mask,
                                                const std::string& detector);

/// Where new features start: points of the named detector on plain, textured tissue, spread evenly
/// and away from `taken`; corners fill in where the detector finds too few.
/// @param grey 8-bit; @param excluded 8-bit, what is not plain tissue; @param taken px
std::vector<InterestPoint> StartingPoints(const cv::Mat& grey, const cv::Mat& excluded,
                                          const std::string& detector, int wanted,
                                          const std::vector<cv::Point2f>& taken);

}  // namespace kerf
