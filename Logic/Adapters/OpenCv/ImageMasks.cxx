#include "Adapters/OpenCv/ImageMasks.h"

#include <opencv2/imgproc.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/Masks.h"

namespace kerf {
namespace {

/// The mask is made at a quarter of the size: tools are large, and it is made for every frame.
constexpr int kShrink = 4;

}  // namespace

Components ComponentsOf(const cv::Mat& mask, int connectivity) {
  Components parts;
  parts.area.assign(cv::connectedComponents(mask, parts.labels, connectivity), 0);
  for (int y = 0; y < mask.rows; ++y) {
    const int* label = parts.labels.ptr<int>(y);
    for (int x = 0; x < mask.cols; ++x) ++parts.area[label[x]];
  }
  return parts;
}

cv::Mat FindInstruments(const cv::Mat& bgr) {
  const cv::Size small_size((bgr.cols + kShrink - 1) / kShrink, (bgr.rows + kShrink - 1) / kShrink);
  cv::Mat small, grey_pixels(small_size, CV_8U, cv::Scalar(0));
  cv::resize(bgr, small, small_size, 0, 0, cv::INTER_LINEAR);
  for (int y = 0; y < small.rows; ++y) {
    const cv::Vec3b* row = small.ptr<cv::Vec3b>(y);
    std::uint8_t* out = grey_pixels.ptr<std::uint8_t>(y);
    for (int x = 0; x < small.cols; ++x) {
      const int b = row[x][0], g = row[x][1], r = row[x][2];
      const int low = std::min({b, g, r}), high = std::max({b, g, r});
      // Grey by ratio; nearly black pixels have no colour to judge; nearly white ones are
      // highlights.
      const bool grey = (high - low) * 100 < 30 * high;
      // Tissue is never bluer than red; steel and black plastic reflect blue at least as well.
      if (grey && high >= 12 && low < 225 && b + 8 >= r) out[x] = 255;
    }
  }
  cv::morphologyEx(grey_pixels, grey_pixels, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  const auto [labels, areas] = ComponentsOf(grey_pixels, 8);
  std::vector<char> at_border(areas.size(), 0);
  for (int x = 0; x < small.cols; ++x)
    at_border[labels.at<int>(0, x)] = at_border[labels.at<int>(small.rows - 1, x)] = 1;
  for (int y = 0; y < small.rows; ++y)
    at_border[labels.at<int>(y, 0)] = at_border[labels.at<int>(y, small.cols - 1)] = 1;
  // Tools come in from the border; clamps and clips lie free, but are larger than a dark spot on
  // tissue. A background that is grey itself covers most of the border; a tool never covers half
  // the image.
  enum : std::uint8_t { kNothing, kTool, kFree };
  std::vector<std::uint8_t> kind(areas.size(), kNothing);
  const int image_area = small.rows * small.cols;
  for (std::size_t label = 1; label < areas.size(); ++label) {
    const int area = areas[label];
    if (area > image_area / 2 || area < image_area / 600) continue;
    if (at_border[label])
      kind[label] = kTool;
    else if (area >= image_area / 300)
      kind[label] = kFree;
  }
  cv::Mat tools(small_size, CV_8U), free_lying(small_size, CV_8U);
  for (int y = 0; y < small.rows; ++y) {
    const int* label = labels.ptr<int>(y);
    std::uint8_t* tool = tools.ptr<std::uint8_t>(y);
    std::uint8_t* free = free_lying.ptr<std::uint8_t>(y);
    for (int x = 0; x < small.cols; ++x) {
      tool[x] = kind[label[x]] == kTool ? 255 : 0;
      free[x] = kind[label[x]] == kFree ? 255 : 0;
    }
  }
  // A clamp touches the tissue it holds: thin outgrowths along dark spots are not part of it.
  cv::morphologyEx(free_lying, free_lying, cv::MORPH_OPEN,
                   cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
  cv::bitwise_or(tools, free_lying, grey_pixels);
  cv::Mat full;
  cv::resize(grey_pixels, full, bgr.size(), 0, 0, cv::INTER_LINEAR);
  cv::threshold(full, full, 100, 255, cv::THRESH_BINARY);
  return full;
}

cv::Mat FindHighlights(const cv::Mat& bgr) {
  cv::Mat mask;
  cv::inRange(bgr, cv::Scalar(205, 205, 205), cv::Scalar(255, 255, 255), mask);
  cv::dilate(mask, mask, cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
  return mask;
}

Image InstrumentMask(const Frame& frame) {
  if (!frame.image) return Image{0, 0, 1, {}};
  return ToImage(FindInstruments(ViewOf(*frame.image)));
}

Image SpecularMask(const Frame& frame) {
  if (!frame.image) return Image{0, 0, 1, {}};
  return ToImage(FindHighlights(ViewOf(*frame.image)));
}

}  // namespace kerf
