#include "Adapters/OpenCv/TrackerImages.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/Masks.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

/// Room for motion between frames and for the patches' corners; the box is renewed when less than
/// the half is left.
constexpr int kMargin = 64;
/// Side of the blocks in which the mask of excluded pixels is summed up, px.
constexpr int kBlock = 8;

}  // namespace

void TrackerImages::Load(const Frame& frame, const cv::Rect& wanted, int window_px, int levels,
                         const cv::Rect& last) {
  if (!frame.image || frame.image->data.empty() || frame.image->channels != 3)
    throw InputError("video", "frame " + std::to_string(frame.index), "no colour image");
  const cv::Rect whole(0, 0, frame.image->width, frame.image->height);
  const auto grown = [&](int margin) {
    return cv::Rect(wanted.x - margin, wanted.y - margin, wanted.width + 2 * margin,
                    wanted.height + 2 * margin) &
           whole;
  };
  frame_ = frame;
  const cv::Rect needed = grown(kMargin / 2);
  cv::Rect box = last & whole;
  if (wanted.empty()) {
    if (box.empty()) box = whole;
  } else if (box.empty() || (box & needed) != needed) {
    box = grown(kMargin);
  }
  instruments_ = FindInstruments(ViewOf(*frame.image));
  Reload(box, window_px, levels);
}

void TrackerImages::Reload(const cv::Rect& box, int window_px, int levels) {
  box_ = box;
  const cv::Mat colour = ViewOf(*frame_.image)(box_);
  cv::cvtColor(colour, grey_, cv::COLOR_BGR2GRAY);
  grey_.convertTo(smooth_, CV_32F);
  cv::GaussianBlur(smooth_, smooth_, {5, 5}, 0.8);
  excluded_ = FindHighlights(colour);
  cv::bitwise_or(excluded_, instruments_(box_), excluded_);
  const cv::Size blocks((box_.width + kBlock - 1) / kBlock, (box_.height + kBlock - 1) / kBlock);
  excluded_blocks_ = cv::Mat::zeros(blocks, CV_8U);
  for (int y = 0; y < excluded_.rows; ++y) {
    const std::uint8_t* row = excluded_.ptr<std::uint8_t>(y);
    std::uint8_t* out = excluded_blocks_.ptr<std::uint8_t>(y / kBlock);
    for (int block = 0; block < blocks.width; ++block) {
      std::uint64_t pixels = 0;  // of the block in this row, all at once
      const int x = block * kBlock;
      std::memcpy(&pixels, row + x, std::min(kBlock, excluded_.cols - x));
      if (pixels != 0) out[block] = 255;
    }
  }
  // Freshly allocated: the previous frame's pyramid is still in use.
  pyramid_.clear();
  cv::buildOpticalFlowPyramid(grey_, pyramid_, {window_px, window_px}, levels, true);
}

const cv::Mat& TrackerImages::ExcludedNear(const Eigen::Vector2f& place, float radius_px) const {
  static const cv::Mat none;
  const int x0 = std::max(0, static_cast<int>(place.x() - radius_px) / kBlock);
  const int y0 = std::max(0, static_cast<int>(place.y() - radius_px) / kBlock);
  const int x1 =
      std::min(excluded_blocks_.cols - 1, static_cast<int>(place.x() + radius_px) / kBlock);
  const int y1 =
      std::min(excluded_blocks_.rows - 1, static_cast<int>(place.y() + radius_px) / kBlock);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x)
      if (excluded_blocks_.at<std::uint8_t>(y, x) != 0) return excluded_;
  return none;
}

bool TrackerImages::Inside(const Eigen::Vector2f& pixel, float margin_px) const {
  return pixel.x() >= margin_px && pixel.y() >= margin_px &&
         pixel.x() <= static_cast<float>(frame_.image->width - 1) - margin_px &&
         pixel.y() <= static_cast<float>(frame_.image->height - 1) - margin_px;
}

bool TrackerImages::InstrumentAt(const Eigen::Vector2f& pixel) const {
  const int u = cvRound(pixel.x()), v = cvRound(pixel.y());
  return u >= 0 && v >= 0 && u < instruments_.cols && v < instruments_.rows &&
         instruments_.at<std::uint8_t>(v, u) != 0;
}

}  // namespace kerf
