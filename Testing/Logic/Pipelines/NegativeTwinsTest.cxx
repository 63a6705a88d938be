/// What looks like a cut and is none, from the picture on: no cut is found, and the gate does not
/// stay green over what the picture no longer tells. The motion is known, so is the error.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

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

/// Where the picture has what it had at a place at rest, px. @param stretch along x; @param
/// shift_px of the camera's picture
cv::Matx23d Motion(double stretch, double shift_px = 0.0) {
  const double narrowing = 1.0 / std::sqrt(stretch);
  return {stretch, 0, 159.5 * (1 - stretch) + shift_px, 0, narrowing, 119.5 * (1 - narrowing)};
}

/// Of a block of tissue on a cloth.
cv::Mat Picture(const cv::Matx23d& motion, int frame) {
  static const cv::Mat tissue = test::Tissue(kWidth, kHeight, 4);
  static const cv::Mat mask = [] {
    const TetMesh block = testing::BoxMesh(Vec3(70, 40, 12), 7, 4, 2);
    return ViewOf(ProjectedMask(BoundarySurface(block, block.rest), Camera())).clone();
  }();
  cv::Mat moved, organ, picture(kHeight, kWidth, CV_8UC3, cv::Scalar(60, 110, 40));
  cv::warpAffine(tissue, moved, motion, tissue.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  cv::warpAffine(mask, organ, motion, mask.size(), cv::INTER_NEAREST);
  moved.copyTo(picture, organ);
  cv::Mat noise(kHeight, kWidth, CV_16SC3), noisy;
  cv::RNG(100 + frame).fill(noise, cv::RNG::NORMAL, 0, 2);
  picture.convertTo(noisy, CV_16SC3);
  noisy += noise;
  noisy.convertTo(picture, CV_8UC3);
  return picture;
}

using MotionOf = std::function<cv::Matx23d(int)>;
cv::Matx23d UsualMotion(int frame) {
  return Motion(1.0 + 0.1 * std::clamp((frame - 5) / 50.0, 0.0, 1.0));
}

/// Distance of the model's features, seen or not, from where the tissue is, across the line of
/// sight, mm.
struct Lateral {
  double mean_mm = 0.0, max_mm = 0.0;
};
Lateral Compare(const RegistrationState& state, const cv::Matx23d& motion) {
  const CameraModel camera = Camera();
  const Points now = state.bound.embedding.Positions(state.positions, state.mesh.tets);
  Lateral out;
  int count = 0;
  for (Index i = 0; i < now.rows(); ++i) {
    if (!state.bound.on_surface[i]) continue;
    const Vec3 p = now.row(i).transpose();
    const Vec2 rest = camera.Project(state.bound.rest.row(i).transpose());
    const cv::Vec2d real = motion * cv::Vec3d(rest.x(), rest.y(), 1.0);
    const double off_px = (camera.Project(p) - Vec2(real[0], real[1])).norm();
    const double off_mm = off_px * camera.Depth(p) / camera.fx;
    out.mean_mm += off_mm;
    out.max_mm = std::max(out.max_mm, off_mm);
    ++count;
  }
  out.mean_mm /= count;
  return out;
}

struct Outcome {
  int cuts = 0;
  std::vector<Reliability> gate;  ///< of each frame
  std::vector<Lateral> lateral;   ///< the same
  /// Share of the frames from–to in which the gate leaves green and says this.
  double Warned(int from, int to, const std::string& reason = "") const {
    const auto warned =
        std::count_if(gate.begin() + from, gate.begin() + to, [&](const Reliability& r) {
          return r.state != GateState::Green && r.reason.find(reason) != std::string::npos;
        });
    return double(warned) / (to - from);
  }
  bool AlwaysGreen(int from, int to) const { return Warned(from, to) == 0.0; }
};

/// Whatever was done to the picture: what the gate lets through green is true, what is wrong is
/// off.
void ExpectHonest(const Outcome& outcome) {
  for (std::size_t i = 0; i < outcome.gate.size(); ++i) {
    const GateState state = outcome.gate[i].state;
    const double mean_mm = outcome.lateral[i].mean_mm;
    if (state == GateState::Green) {
      EXPECT_LT(mean_mm, 2.0) << "frame " << i << " is green";
      EXPECT_LT(outcome.lateral[i].max_mm, 3.0) << "frame " << i << " is green";
    }
    if (mean_mm > 5.0) {
      EXPECT_EQ(state, GateState::Off) << "frame " << i;
    }
  }
}

/// @param motion the truth; @param every so many pictures of the 25 a second one is registered
Outcome Watch(const MotionOf& motion, const std::function<cv::Mat(int)>& picture, int every = 1) {
  MethodOptions options;
  options.wanted_features = 120;
  RegistrationSession session(testing::BoxMesh(Vec3(70, 40, 12), 14, 8, 2), {}, Camera(), options,
                              MakeFeatureTracker({}), MakeVideoOrganSegmenter());
  Outcome outcome;
  for (int i = 0; i < kFrames; i += every) {
    outcome.gate.push_back(session.Process(test::MakeFrame(i, picture(i))).reliability);
    outcome.lateral.push_back(Compare(session.State(), motion(i)));
  }
  outcome.cuts = static_cast<int>(session.State().cuts.size());
  ExpectHonest(outcome);
  return outcome;
}

Outcome WatchClear(const MotionOf& motion, int every = 1) {
  return Watch(
      motion, [&](int frame) { return Picture(motion(frame), frame); }, every);
}

/// Frames 20 to 45 of the usual motion, spoilt.
Outcome WatchSpoilt(const std::function<void(int, cv::Mat*)>& spoil) {
  return Watch(UsualMotion, [&](int frame) {
    cv::Mat picture = Picture(UsualMotion(frame), frame);
    if (frame >= 20 && frame < 45) spoil(frame, &picture);
    return picture;
  });
}

/// A fifth of a second after the picture is clear again.
void ExpectRecovered(const Outcome& outcome) {
  EXPECT_TRUE(outcome.AlwaysGreen(50, kFrames));
  EXPECT_LT(outcome.lateral[50].max_mm, 2.0);
}

TEST(NegativeTwins, TheUsualMotionIsGreen) {
  const Outcome outcome = WatchSpoilt([](int, cv::Mat*) {});
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.AlwaysGreen(0, kFrames));
  for (const Lateral& lateral : outcome.lateral) EXPECT_LT(lateral.max_mm, 1.0);
}

/// The twin of a cut that grows between two pictures: nothing in them is wrong.
TEST(NegativeTwins, FewPicturesOfTheUsualMotionAreNotGreen) {
  const Outcome enough = WatchClear(UsualMotion, 6), few = WatchClear(UsualMotion, 12);
  EXPECT_TRUE(enough.AlwaysGreen(0, static_cast<int>(enough.gate.size())));
  EXPECT_EQ(few.cuts, 0);
  EXPECT_EQ(few.gate.back().state, GateState::Amber);
  EXPECT_EQ(few.gate.back().reason, "2 pictures a second registered: cuts may be missed");
}

/// It is followed, so green is right; where it were not, the gate would have to say so.
TEST(NegativeTwins, AStrongStretchIsNoCut) {
  const Outcome outcome = WatchClear(
      [](int frame) { return Motion(1.0 + 0.4 * std::clamp((frame - 5) / 50.0, 0.0, 1.0)); });
  EXPECT_EQ(outcome.cuts, 0);
  for (int i = 0; i < kFrames; ++i)
    if (outcome.gate[i].state == GateState::Green) {
      EXPECT_LT(outcome.lateral[i].mean_mm, 1.0) << "frame " << i;
      EXPECT_LT(outcome.lateral[i].max_mm, 2.5) << "frame " << i;
    }
}

TEST(NegativeTwins, AToolBeforeTheOrganIsNoCut) {
  const Outcome outcome = WatchSpoilt([](int frame, cv::Mat* picture) {
    const int right = 60 + std::min(20 * (frame - 20), 160);  // comes in from the left, and stays
    cv::rectangle(*picture, {0, 0}, {right, kHeight}, cv::Scalar(90, 90, 90), cv::FILLED);
  });
  EXPECT_EQ(outcome.cuts, 0);
  // Once it hides half of the organ; off when it has come to rest over four fifths.
  EXPECT_GE(outcome.Warned(25, 45), 0.9);
  EXPECT_GE(outcome.Warned(25, 28, "features were lost in a part of the organ"), 0.6);
  EXPECT_GE(outcome.Warned(30, 45, "too few features agree with the model"), 0.9);
  EXPECT_GT(outcome.lateral[44].max_mm, 5.0) << "there was something to warn of";
  ExpectRecovered(outcome);
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
  EXPECT_GE(outcome.Warned(20, 45), 0.9);
  EXPECT_GE(outcome.Warned(20, 45, "too few features agree with the model"), 0.85);
  ExpectRecovered(outcome);
}

/// Warned of until the features are recognized through it: then the overlay is true, and green.
TEST(NegativeTwins, SmokeIsNoCut) {
  const Outcome outcome =
      WatchSpoilt([](int, cv::Mat* picture) { picture->convertTo(*picture, -1, 0.06, 190); });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_EQ(outcome.gate[20].state, GateState::Off);
  EXPECT_EQ(outcome.gate[20].reason, "too few features agree with the model");
  for (int i = 20; i < 45; ++i) EXPECT_LT(outcome.lateral[i].max_mm, 2.0) << "frame " << i;
  EXPECT_TRUE(outcome.AlwaysGreen(30, 45));
  ExpectRecovered(outcome);
}

TEST(NegativeTwins, SmokeThatHidesTheOrganIsNoCut) {
  const Outcome outcome =
      WatchSpoilt([](int, cv::Mat* picture) { picture->convertTo(*picture, -1, 0.01, 190); });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_GE(outcome.Warned(20, 45, "no feature is tracked"), 0.9);
  ExpectRecovered(outcome);
}

TEST(NegativeTwins, AFrozenPictureIsNoCut) {
  cv::Mat last;
  const Outcome outcome = Watch(UsualMotion, [&](int frame) {
    if (frame < 20 || frame >= 45) last = Picture(UsualMotion(frame), frame);
    return last;
  });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.AlwaysGreen(0, 20));
  // It needs half a second to tell.
  EXPECT_EQ(outcome.Warned(33, 45, "the picture stands still"), 1.0);
  ExpectRecovered(outcome);
}

TEST(NegativeTwins, ACameraThatJumpsIsNoCut) {
  const Outcome outcome = WatchClear([](int frame) {
    cv::Matx23d motion = UsualMotion(frame);
    if (frame >= 20) motion(0, 2) += 45.0;
    return motion;
  });
  EXPECT_EQ(outcome.cuts, 0);
  EXPECT_TRUE(outcome.AlwaysGreen(0, 20));
  // For a second, although features and outline are found again where they have gone.
  EXPECT_EQ(outcome.Warned(20, 44, "everything leapt: has the camera moved?"), 1.0);
  ExpectRecovered(outcome);
}

}  // namespace
}  // namespace kerf
