#include "Adapters/OpenCv/OrganSegmentation.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/Masks.h"
#include "Core/Errors.h"
#include "Core/Features.h"

namespace kerf {
namespace {

/// Worked on at a third of the size.
constexpr int kShrink = 3;
/// Colour without brightness (the rim of an organ is dark): shares of red and of green, 64 steps
/// each over 0 to 0.8.
constexpr int kSteps = 64, kBins = kSteps * kSteps;
/// How far the outline may be from the model's, and within what distance the model's word fades, px
/// of the full image.
constexpr float kReach_px = 45.0F, kFade_px = 15.0F;
/// Colours are learnt this far from the model's outline, px of the full image.
constexpr float kCertain_px = 12.0F;

/// cv::INTER_AREA, to the bit; its loops for this factor are not vectorized.
void Shrink(const cv::Mat& bgr, const cv::Size& size, cv::Mat* out) {
  if (kShrink * size.width != bgr.cols || kShrink * size.height != bgr.rows) {
    cv::resize(bgr, *out, size, 0, 0, cv::INTER_AREA);
    return;
  }
  out->create(size, CV_8UC3);
  constexpr unsigned kArea = kShrink * kShrink;
  const int row_length = 3 * kShrink * size.width;
  std::vector<std::uint16_t> sum(row_length);
  for (int y = 0; y < size.height; ++y) {
    const std::uint8_t* row[kShrink];
    for (int k = 0; k < kShrink; ++k) row[k] = bgr.ptr<std::uint8_t>(kShrink * y + k);
    for (int i = 0; i < row_length; ++i)
      sum[i] = static_cast<std::uint16_t>(row[0][i] + row[1][i] + row[2][i]);
    std::uint8_t* mean = out->ptr<std::uint8_t>(y);
    for (int x = 0; x < size.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const std::uint16_t* s = sum.data() + 9 * x + c;
        mean[3 * x + c] = static_cast<std::uint8_t>((s[0] + s[3] + s[6] + kArea / 2) / kArea);
      }
  }
}

int BinOf(const cv::Vec3b& bgr) {
  // The offset keeps nearly black pixels, which have no colour, near grey.
  const float scale = kSteps / 0.8F / static_cast<float>(bgr[0] + bgr[1] + bgr[2] + 6);
  const auto step = [scale](int value) {
    return std::min(static_cast<int>(static_cast<float>(value + 2) * scale), kSteps - 1);
  };
  return step(bgr[2]) * kSteps + step(bgr[1]);
}

/// Relative frequency of every colour, blurred over neighbouring bins so that rare colours are no
/// surprise.
class ColourHistogram {
 public:
  ColourHistogram() : counts_(kBins, 0.0F) {}
  void Add(int bin) {
    counts_[bin] += 1;
    total_ += 1;
  }
  float Total() const { return total_; }
  void Smooth() {
    for (int time = 0; time < 2; ++time) {
      SmoothAlong<1>();
      SmoothAlong<kSteps>();
    }
  }
  float LogLikelihood(int bin) const {
    return std::log((counts_[bin] + 0.02F) / (total_ + 0.02F * kBins));
  }

 private:
  template <int kStride>
  void SmoothAlong() {
    std::vector<float> blurred(kBins);
    for (int bin = 0; bin < kBins; ++bin) {
      const int place = bin / kStride % kSteps;
      const float low = place > 0 ? counts_[bin - kStride] : counts_[bin];
      const float high = place < kSteps - 1 ? counts_[bin + kStride] : counts_[bin];
      blurred[bin] = 0.25F * low + 0.5F * counts_[bin] + 0.25F * high;
    }
    counts_ = std::move(blurred);
  }
  std::vector<float> counts_;
  float total_ = 0;
};

/// Distance to the outline, px of the full image, positive inside.
cv::Mat SignedDistance(const cv::Mat& mask) {
  cv::Mat inside, outside;
  cv::distanceTransform(mask, inside, cv::DIST_L2, 3);
  cv::distanceTransform(255 - mask, outside, cv::DIST_L2, 3);
  return (inside - outside) * kShrink;
}

/// Takes away what is not connected and smaller than this share of the largest component.
void DropIslands(cv::Mat* mask, double share) {
  Components parts = ComponentsOf(*mask, 4);
  std::vector<int>& area = parts.area;
  area[0] = 0;
  const int largest = *std::max_element(area.begin(), area.end());
  std::vector<std::uint8_t> kept(area.size(), 255);
  for (std::size_t label = 1; label < area.size(); ++label)
    if (area[label] < share * largest) kept[label] = 0;
  for (int y = 0; y < mask->rows; ++y) {
    const int* label = parts.labels.ptr<int>(y);
    std::uint8_t* pixel = mask->ptr<std::uint8_t>(y);
    for (int x = 0; x < mask->cols; ++x) pixel[x] &= kept[label[x]];
  }
}

}  // namespace

Image OrganMask(const Frame& frame, const Image& model_mask) {
  if (!frame.image || frame.image->channels != 3) return model_mask;
  if (model_mask.width != frame.image->width || model_mask.height != frame.image->height ||
      model_mask.channels != 1)
    throw InputError("organ mask", "", "its size is not the frame's");
  const cv::Mat bgr = ViewOf(*frame.image);
  const cv::Size small_size(bgr.cols / kShrink, bgr.rows / kShrink);
  cv::Mat small, model, instruments;
  Shrink(bgr, small_size, &small);
  cv::resize(ViewOf(model_mask), model, small_size, 0, 0, cv::INTER_NEAREST);
  cv::threshold(model, model, 0, 255, cv::THRESH_BINARY);
  cv::resize(FindInstruments(bgr), instruments, small_size, 0, 0, cv::INTER_NEAREST);

  cv::Mat bins(small.size(), CV_32S);
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) bins.at<int>(y, x) = BinOf(small.at<cv::Vec3b>(y, x));
  const cv::Mat distance = SignedDistance(model);
  ColourHistogram organ, background;
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) {
      if (instruments.at<std::uint8_t>(y, x) != 0) continue;
      const float d = distance.at<float>(y, x);
      if (d > kCertain_px) organ.Add(bins.at<int>(y, x));
      // The neighbourhood counts, not the far corners of the image.
      if (d < -kCertain_px && d > -4 * kReach_px) background.Add(bins.at<int>(y, x));
    }
  if (organ.Total() < 300 || background.Total() < 300) return model_mask;
  organ.Smooth();
  background.Smooth();
  std::vector<float> ratio(kBins);
  for (int bin = 0; bin < kBins; ++bin)
    ratio[bin] = std::clamp(organ.LogLikelihood(bin) - background.LogLikelihood(bin), -3.0F, 3.0F);

  cv::Mat evidence(small.size(), CV_32F);
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) evidence.at<float>(y, x) = ratio[bins.at<int>(y, x)];
  cv::GaussianBlur(evidence, evidence, {7, 7}, 1.4);
  cv::Mat mask(small.size(), CV_8U);
  for (int y = 0; y < small.rows; ++y)
    for (int x = 0; x < small.cols; ++x) {
      const float d = distance.at<float>(y, x);
      const float prior = 0.5F * std::clamp(d / kFade_px, -2.0F, 2.0F);
      const bool is_organ = d > -kReach_px && evidence.at<float>(y, x) + prior > 0;
      mask.at<std::uint8_t>(y, x) = is_organ ? 255 : 0;
    }
  cv::morphologyEx(mask, mask, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5}));
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}));
  // Specks are colours that occur on either side; an opened cut is a large hole or reaches the
  // outline.
  DropIslands(&mask, 0.05);
  cv::bitwise_not(mask, mask);
  DropIslands(&mask, 0.005);
  cv::bitwise_not(mask, mask);
  cv::Mat full, hidden;
  cv::resize(mask, full, bgr.size(), 0, 0, cv::INTER_LINEAR);
  cv::threshold(full, full, 127, 255, cv::THRESH_BINARY);
  // A tool's rim and its shadow belong to it.
  if (cv::countNonZero(instruments) > 0) {
    cv::dilate(instruments, instruments, cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}));
    cv::resize(instruments, hidden, bgr.size(), 0, 0, cv::INTER_NEAREST);
    full.setTo(OrganSegmenter::kHidden, hidden);
  }
  return ToImage(full);
}

}  // namespace kerf
