#pragma once

#include <Eigen/Dense>
#include <opencv2/core.hpp>
#include <vector>

#include "Core/Frame.h"

/// Inside this component only: what the tracker needs of one frame, computed once, inside a box
/// around the organ.
namespace kerf {

class TrackerImages {
 public:
  /// @param wanted box that has to be covered, full image px
  /// @param last box of the frame before: kept while it suffices, else the wanted one with a margin
  /// is taken
  void Load(const Frame& frame, const cv::Rect& wanted, int window_px, int levels,
            const cv::Rect& last = {});
  /// The same frame inside another box.
  void Reload(const cv::Rect& box, int window_px, int levels);

  const cv::Rect& Box() const { return box_; }
  Eigen::Vector2f Origin() const {
    return {static_cast<float>(box_.x), static_cast<float>(box_.y)};
  }
  const cv::Mat& Grey() const { return grey_; }      ///< 8-bit, in the box
  const cv::Mat& Smooth() const { return smooth_; }  ///< 32-bit float, slightly blurred, in the box
  /// 8-bit: highlights and instruments, in the box.
  const cv::Mat& Excluded() const { return excluded_; }
  /// The same mask for a patch, or none where nothing is excluded within this radius of a place in
  /// the box.
  const cv::Mat& ExcludedNear(const Eigen::Vector2f& place, float radius_px) const;
  const std::vector<cv::Mat>& Pyramid() const { return pyramid_; }
  /// Inside the image (not merely the box) with this margin. @param pixel full image px
  bool Inside(const Eigen::Vector2f& pixel, float margin_px) const;
  bool InstrumentAt(const Eigen::Vector2f& pixel) const;

 private:
  Frame frame_;
  cv::Rect box_;
  cv::Mat grey_, smooth_, excluded_, instruments_;
  cv::Mat excluded_blocks_;  ///< non-zero where a block of the mask is not empty
  std::vector<cv::Mat> pyramid_;
};

}  // namespace kerf
