#include "Adapters/OpenCv/FeatureDetection.h"

#include <algorithm>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "Core/Errors.h"

namespace kerf {
namespace {

std::vector<InterestPoint> MinEigenvaluePoints(const cv::Mat& grey, const cv::Mat& mask) {
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, 0, 0.003, 3.0, mask, 5);
  if (corners.empty()) return {};
  cv::cornerSubPix(grey, corners, {3, 3}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01});
  std::vector<InterestPoint> points;
  // They come in the order of their quality.
  for (std::size_t i = 0; i < corners.size(); ++i)
    points.push_back({corners[i].x, corners[i].y, static_cast<float>(corners.size() - i)});
  return points;
}

std::vector<InterestPoint> FromKeyPoints(cv::Feature2D& detector, const cv::Mat& grey,
                                         const cv::Mat& mask) {
  std::vector<cv::KeyPoint> keys;
  detector.detect(grey, keys, mask);
  std::vector<InterestPoint> points;
  for (const cv::KeyPoint& key : keys) points.push_back({key.pt.x, key.pt.y, key.response});
  return points;
}

/// Greedy choice at one distance, strongest first. `cells` is a grid whose cells are as wide as the
/// distance.
class Spreader {
 public:
  Spreader(cv::Size size, float distance)
      : distance_(distance),
        columns_(static_cast<int>(size.width / distance) + 1),
        rows_(static_cast<int>(size.height / distance) + 1),
        cells_(static_cast<std::size_t>(columns_) * rows_) {}
  bool Add(float u, float v) {
    const int x = std::clamp(static_cast<int>(u / distance_), 0, columns_ - 1);
    const int y = std::clamp(static_cast<int>(v / distance_), 0, rows_ - 1);
    for (int j = std::max(0, y - 1); j <= std::min(rows_ - 1, y + 1); ++j)
      for (int i = std::max(0, x - 1); i <= std::min(columns_ - 1, x + 1); ++i)
        for (const cv::Point2f& p : cells_[static_cast<std::size_t>(j) * columns_ + i])
          if ((p.x - u) * (p.x - u) + (p.y - v) * (p.y - v) < distance_ * distance_) return false;
    cells_[static_cast<std::size_t>(y) * columns_ + x].push_back({u, v});
    return true;
  }

 private:
  float distance_;
  int columns_, rows_;
  std::vector<std::vector<cv::Point2f>> cells_;
};

std::vector<InterestPoint> Choose(const std::vector<InterestPoint>& sorted, int wanted,
                                  const std::vector<cv::Point2f>& taken, cv::Size size,
                                  float distance) {
  Spreader spreader(size, distance);
  for (const cv::Point2f& p : taken) spreader.Add(p.x, p.y);
  std::vector<InterestPoint> chosen;
  for (const InterestPoint& p : sorted) {
    if (static_cast<int>(chosen.size()) == wanted) break;
    if (spreader.Add(p.u, p.v)) chosen.push_back(p);
  }
  return chosen;
}

/// At most `wanted` points, spread evenly: the largest distance is sought at which the strongest
/// points, each keeping that distance from the stronger ones and from `taken`, still are `wanted`.
/// Ties are decided by place.
std::vector<InterestPoint> SpreadEvenly(std::vector<InterestPoint> points, int wanted,
                                        const std::vector<cv::Point2f>& taken,
                                        cv::Size image_size) {
  if (wanted <= 0 || points.empty()) return {};
  std::sort(points.begin(), points.end(), [](const InterestPoint& a, const InterestPoint& b) {
    return std::make_tuple(-a.score, a.v, a.u) < std::make_tuple(-b.score, b.v, b.u);
  });
  float low = 2.0F, high = static_cast<float>(std::max(image_size.width, image_size.height));
  std::vector<InterestPoint> best = Choose(points, wanted, taken, image_size, low);
  for (int step = 0; step < 14 && high - low > 0.25F; ++step) {
    const float middle = 0.5F * (low + high);
    std::vector<InterestPoint> chosen = Choose(points, wanted, taken, image_size, middle);
    if (static_cast<int>(chosen.size()) == wanted) {
      low = middle;
      best = std::move(chosen);
    } else {
      high = middle;
    }
  }
  return best;
}

}  // namespace

std::vector<InterestPoint> DetectInterestPoints(const cv::Mat& grey, const cv::Mat& mask,
                                                const std::string& detector) {
  std::vector<InterestPoint> points;
  if (detector == "fast-hessian") {
    // The box filters need a border of their own; outside the mask nothing is wanted.
    cv::Rect box = cv::boundingRect(mask);
    if (box.empty()) return {};
    const int margin = 48;
    box =
        cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect(0, 0, grey.cols, grey.rows);
    points = FastHessianPoints(grey(box), 1.0);
    for (InterestPoint& p : points) {
      p.u += static_cast<float>(box.x);
      p.v += static_cast<float>(box.y);
    }
  } else if (detector == "gftt") {
    points = MinEigenvaluePoints(grey, mask);
  } else if (detector == "akaze") {
    cv::Ptr<cv::AKAZE> akaze = cv::AKAZE::create();
    akaze->setThreshold(2e-4);
    points = FromKeyPoints(*akaze, grey, mask);
  } else if (detector == "orb") {
    points = FromKeyPoints(*cv::ORB::create(5000, 1.2F, 4, 15, 0, 2, cv::ORB::HARRIS_SCORE, 15, 8),
                           grey, mask);
  } else if (detector == "brisk") {
    points = FromKeyPoints(*cv::BRISK::create(15), grey, mask);
  } else if (detector == "sift") {
    points = FromKeyPoints(*cv::SIFT::create(0, 3, 0.02), grey, mask);
  } else {
    throw UsageError("unknown feature detector '" + detector +
                     "'; known: fast-hessian, gftt, akaze, orb, brisk, sift");
  }
  const auto outside = [&](const InterestPoint& p) {
    const int x = cvRound(p.u), y = cvRound(p.v);
    return x < 0 || y < 0 || x >= mask.cols || y >= mask.rows || mask.at<std::uint8_t>(y, x) == 0;
  };
  points.erase(std::remove_if(points.begin(), points.end(), outside), points.end());
  return points;
}

std::vector<InterestPoint> StartingPoints(const cv::Mat& grey, const cv::Mat& excluded,
                                          const std::string& detector, int wanted,
                                          const std::vector<cv::Point2f>& taken) {
  // A feature's centre keeps away from everything that is not plain tissue; its patch may reach
  // there.
  cv::Mat allowed;
  cv::erode(excluded == 0, allowed, cv::getStructuringElement(cv::MORPH_ELLIPSE, {9, 9}), {-1, -1},
            1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat texture;
  cv::cornerMinEigenVal(grey, texture, 7, 3);
  allowed.setTo(0, texture < 2e-5);
  std::vector<InterestPoint> points = DetectInterestPoints(grey, allowed, detector);
  // Too few to choose from would mean clusters: corners fill in, after the detector's own points.
  if (static_cast<int>(points.size()) < 3 * wanted && detector != "gftt") {
    float weakest = 0;
    for (const InterestPoint& point : points) weakest = std::min(weakest, point.score);
    std::vector<InterestPoint> corners = DetectInterestPoints(grey, allowed, "gftt");
    for (InterestPoint& corner : corners) {
      corner.score += weakest - 1e7F;
      points.push_back(corner);
    }
  }
  return SpreadEvenly(std::move(points), wanted, taken, grey.size());
}

}  // namespace kerf
