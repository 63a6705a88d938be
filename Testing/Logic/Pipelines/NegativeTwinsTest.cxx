/// What looks like a cut and is none, from the picture on: no cut is found, and the gate does not
/// stay green over what the picture no longer tells.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Logic/OpenCv/SyntheticVideo.h"
#include "Pipelines/RegistrationParts.h"
#include "Registration/OrganMask.h"
#include "Session/RegistrationSession.h"
#include "Support/TestCameras.h"
#include "Support/TestMeshes.h"

namespace kerf {
namespace {

constexpr int kWidth = 320, kHeight = 240, kFrames = 60;

CameraModel Camera() { return testing::Pinhole(kWidth, kHeight, 400, Vec3(0, 0, 150)); }

/// A block of tissue on a cloth. @param stretch along x; @param shift_px of the camera's picture
cv::Mat Picture(double stretch, double shift_px, int frame) {
  static const cv::Mat tissue = test::Tissue(kWidth, kHeight, 4);
  static const cv::Mat mask = [] {
    const TetMesh block = testing::BoxMesh(Vec3(70, 40, 12), 7, 4, 2);
    return ViewOf(ProjectedMask(BoundarySurface(block, block.rest), Camera())).clone();
  }();
  const double narrowing = 1.0 / std::sqrt(stretch);
  const cv::Matx23d warp(stretch, 0, 159.5 * (1 - stretch) + shift_px, 0, narrowing,
                         119.5 * (1 - narrowing));
  cv::Mat moved, organ, picture(kHeight, kWidth, CV_8UC3, cv::Scalar(60, 110, 40));
  cv::warpAffine(tissue, moved, warp, tissue.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  cv::warpAffine(mask, organ, warp, mask.size(), cv::INTER_NEAREST);
  moved.copyTo(picture, organ);
  cv::Mat noise(kHeight, kWidth, CV_16SC3), noisy;
  cv::RNG(100 + frame).fill(noise, cv::RNG::NORMAL, 0, 2);
  picture.convertTo(noisy, CV_16SC3);
  noisy += noise;
  noisy.convertTo(picture, CV_8UC3);
  return picture;
}

double StretchAt(int frame) { return 1.0 + 0.1 * std::clamp((frame - 5) / 50.0, 0.0, 1.0); }

struct Outcome {
  int cuts = 0;
  std::vector<Reliability> gate;  ///< of each frame
  bool EverBelowGreen(int from, int to) const {
    return std::any_of(gate.begin() + from, gate.begin() + to,
                       [](const Reliability& r) { return r.state != GateState::Green; });
  }
  bool AlwaysGreen(int from, int to) const { return !EverBelowGreen(from, to); }
};

/// @param every so many pictures of the 25 a second one is registered
Outcome Watch(const std::function<cv::Mat(int)>& picture, int every = 1) {
  MethodOptions options;
  options.wanted_features = 120;
  RegistrationSession session(testing::BoxMesh(Vec3(70, 40, 12), 14, 8, 2), {}, Camera(), options,
                              MakeFeatureTracker({}), MakeVideoOrganSegmenter());
  Outcome outcome;
  for (int i = 0; i < kFrames; i += every)
    outcome.gate.push_back(session.Process(test::MakeFrame(i, picture(i))).reliability);
  outcome.cuts = static_cast<int>(session.State().cuts.size());
  return outcome;
}

/// Frames 20 to 45 of the usual motion, spoilt.
Outcome WatchSpoilt(const std::function<void(int, cv::Mat*)>& spoil) {
  return Watch([&](int frame) {
    cv::Mat picture = Picture(StretchAt(frame), 0.0, frame);
    if (frame >= 20 && frame < 45) spoil(frame, &picture);
    return picture;
  });
}

TEST(NegativeTwins, TheUsualMotionIsGreen) {
  const Outcome outcome = WatchSpoilt([](int, cv::Mat*) {});
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.AlwaysGreen(0, kFrames));
}

/// The twin of a cut that grows between two pictures: nothing in them is wrong.
TEST(NegativeTwins, FewPicturesOfTheUsualMotionAreNotGreen) {
  const auto picture = [](int frame) { return Picture(StretchAt(frame), 0.0, frame); };
  const Outcome enough = Watch(picture, 6), few = Watch(picture, 12);
  EXPECT_TRUE(enough.AlwaysGreen(0, static_cast<int>(enough.gate.size())));
  EXPECT_EQ(few.cuts, 0);
  EXPECT_EQ(few.gate.back().state, GateState::Amber);
  EXPECT_EQ(few.gate.back().reason, "2 pictures a second registered: cuts may be missed");
}

TEST(NegativeTwins, AStrongStretchIsNoCut) {
  const Outcome outcome = Watch([](int frame) {
    return Picture(1.0 + 0.4 * std::clamp((frame - 5) / 50.0, 0.0, 1.0), 0.0, frame);
  });
  EXPECT_EQ(outcome.cuts, 0);
}

TEST(NegativeTwins, AToolBeforeTheOrganIsNoCut) {
  const Outcome outcome = WatchSpoilt([](int frame, cv::Mat* picture) {
    const int right = 60 + std::min(20 * (frame - 20), 160);  // comes in from the left, and stays
    cv::rectangle(*picture, {0, 0}, {right, kHeight}, cv::Scalar(90, 90, 90), cv::FILLED);
  });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.EverBelowGreen(25, 45));
}

TEST(NegativeTwins, ABurstOfHighlightsIsNoCut) {
  const Outcome outcome = WatchSpoilt([](int frame, cv::Mat* picture) {
    cv::RNG random(7 * frame);
    for (int i = 0; i < 120; ++i) {
      const double turned_deg = random.uniform(0, 180);
      const cv::Size size{random.uniform(3, 9), random.uniform(2, 6)};
      const cv::Point middle{random.uniform(60, 260), random.uniform(60, 180)};
      cv::ellipse(*picture, middle, size, turned_deg, 0, 360, cv::Scalar(255, 255, 255),
                  cv::FILLED);
    }
  });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.EverBelowGreen(22, 50));
}

TEST(NegativeTwins, SmokeIsNoCut) {
  const Outcome outcome =
      WatchSpoilt([](int, cv::Mat* picture) { picture->convertTo(*picture, -1, 0.06, 190); });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.EverBelowGreen(20, 22));  // until the features are recognized through it
  EXPECT_LT(outcome.gate[40].residual_mm, 0.5);
}

TEST(NegativeTwins, AFrozenPictureIsNoCut) {
  cv::Mat last;
  const Outcome outcome = Watch([&](int frame) {
    if (frame < 20 || frame >= 45) last = Picture(StretchAt(frame), 0.0, frame);
    return last;
  });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.AlwaysGreen(0, 20));
  EXPECT_TRUE(outcome.EverBelowGreen(35, 45));
  EXPECT_EQ(outcome.gate[44].reason, "the picture stands still");
}

TEST(NegativeTwins, ACameraThatJumpsIsNoCut) {
  const Outcome outcome =
      Watch([](int frame) { return Picture(StretchAt(frame), frame < 20 ? 0.0 : 45.0, frame); });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.EverBelowGreen(20, kFrames));
}

}  // namespace
}  // namespace kerf
