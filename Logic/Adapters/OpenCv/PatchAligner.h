#pragma once

#include <Eigen/Dense>
#include <memory>
#include <opencv2/core.hpp>

/// Inside this component only: a reference patch and its alignment with the current image.
namespace kerf {

/// x_image = A · x_patch + t, x_patch relative to the patch's centre, so t is where the feature is,
/// px.
struct AffineWarp {
  Eigen::Matrix2f A = Eigen::Matrix2f::Identity();
  Eigen::Vector2f t = Eigen::Vector2f::Zero();
};

struct Alignment {
  bool valid = false;  ///< stayed inside the image, enough of it usable, a plausible warp
  float correlation =
      0;  ///< normalized cross-correlation of patch and warped image over the pixels used, −1..1
  float used = 0;  ///< share of the patch's weight that was not excluded, 0..1
};

/// Appearance of a feature in the frame where it was taken, and what inverse-compositional
/// Lucas–Kanade needs of it. Gain and offset of the brightness are projected out, so that both may
/// change freely. Images are 32-bit float; `excluded` is an 8-bit mask of pixels that are not to be
/// believed, or empty.
class Patch {
 public:
  /// @return false where the patch leaves the image, is mostly excluded, or has no texture in some
  /// direction
  bool Take(const cv::Mat& grey, const cv::Mat& excluded, const Eigen::Vector2f& center,
            int half_px);
  bool Empty() const { return system_ == nullptr; }
  /// Moves `warp` to where the patch is seen in `grey`, starting from where it is; no iterations:
  /// compares only.
  Alignment Align(const cv::Mat& grey, const cv::Mat& excluded, int iterations,
                  AffineWarp* warp) const;
  /// Smaller eigenvalue of the structure tensor, grey levels² per px²: how well it can be located.
  float Texture() const { return texture_; }

 private:
  /// The patch's normal equations for one choice of weights.
  struct Appearance;
  struct System;
  /// @return false where the reference has no contrast under these weights
  bool MakeAppearance(const Eigen::VectorXf& weights, Appearance* out) const;
  std::shared_ptr<const System> MakeSystem(const Eigen::VectorXf& weights) const;
  bool Sample(const cv::Mat& grey, const AffineWarp& warp, Eigen::VectorXf* values) const;
  /// Weights without the pixels excluded under `warp`; returns the share of the weight that
  /// remains.
  float UsableWeights(const cv::Mat& excluded, const AffineWarp& warp,
                      Eigen::VectorXf* weights) const;

  int half_ = 0;
  float texture_ = 0;
  Eigen::VectorXf values_, weights_, gradient_x_, gradient_y_;
  std::shared_ptr<const System> system_;
};

}  // namespace kerf
