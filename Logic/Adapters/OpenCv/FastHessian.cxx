#include <dlib/array2d.h>
#include <dlib/image_keypoint/hessian_pyramid.h>
#include <dlib/image_transforms/integral_image.h>

#include "Adapters/OpenCv/FeatureDetection.h"

namespace kerf {

std::vector<InterestPoint> FastHessianPoints(const cv::Mat& grey, double threshold) {
  CV_Assert(grey.type() == CV_8UC1);
  dlib::array2d<unsigned char> image(grey.rows, grey.cols);
  for (int y = 0; y < grey.rows; ++y) {
    const unsigned char* row = grey.ptr<unsigned char>(y);
    std::copy(row, row + grey.cols, &image[y][0]);
  }
  dlib::integral_image integral;
  integral.load(image);
  dlib::hessian_pyramid pyramid;
  // Two octaves and a step of one pixel: small blobs, densely; large ones are located worse and
  // tracked no better.
  pyramid.build_pyramid(integral, 2, 4, 1);
  std::vector<dlib::interest_point> found;
  dlib::get_interest_points(pyramid, threshold, found);
  std::vector<InterestPoint> points;
  points.reserve(found.size());
  for (const dlib::interest_point& p : found)
    points.push_back({static_cast<float>(p.center.x()), static_cast<float>(p.center.y()),
                      static_cast<float>(p.score)});
  return points;
}

}  // namespace kerf
