#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Core/Errors.h"
#include "SyntheticVideo.h"

using namespace kerf;
using kerf::test::FullMask;
using kerf::test::MakeFrame;
using kerf::test::Tissue;

namespace {

constexpr int kWidth = 400, kHeight = 300;

/// A video of one picture that an affine map moves a little further in every frame; the truth is
/// the map.
class Motion {
 public:
  Motion(const cv::Mat& picture, double stretch_x, double stretch_y, double turn_deg,
         double move_px, int frames)
      : picture_(picture),
        stretch_x_(stretch_x),
        stretch_y_(stretch_y),
        turn_deg_(turn_deg),
        move_px_(move_px),
        frames_(frames) {}
  cv::Matx23d Map(int index) const {
    const double s = static_cast<double>(index) / (frames_ - 1);
    const double a = turn_deg_ * s * CV_PI / 180;
    const double x = 1 + (stretch_x_ - 1) * s, y = 1 + (stretch_y_ - 1) * s;
    const cv::Matx22d m =
        cv::Matx22d(std::cos(a), -std::sin(a), std::sin(a), std::cos(a)) * cv::Matx22d(x, 0, 0, y);
    const cv::Vec2d center(picture_.cols / 2.0, picture_.rows / 2.0);
    const cv::Vec2d t = center - m * center + cv::Vec2d(move_px_ * s, 0.4 * move_px_ * s);
    return {m(0, 0), m(0, 1), t[0], m(1, 0), m(1, 1), t[1]};
  }
  cv::Mat Picture(int index) const {
    cv::Mat out;
    cv::warpAffine(picture_, out, Map(index), picture_.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
    return out;
  }
  Vec2 Moved(const Vec2& p, int index) const {
    const cv::Matx23d m = Map(index);
    return {m(0, 0) * p.x() + m(0, 1) * p.y() + m(0, 2),
            m(1, 0) * p.x() + m(1, 1) * p.y() + m(1, 2)};
  }

 private:
  cv::Mat picture_;
  double stretch_x_, stretch_y_, turn_deg_, move_px_;
  int frames_;
};

struct Score {
  double median_px = 0, worst_px = 0, tracked = 0;
};

Score ScoreOf(const FeatureSet& features, const Pixels& start, const Motion& motion, int index) {
  std::vector<double> errors;
  for (Index i = 0; i < features.Size(); ++i)
    if (features.status[i] == FeatureStatus::Tracked)
      errors.push_back(
          (features.pixels.row(i).transpose() - motion.Moved(start.row(i), index)).norm());
  std::sort(errors.begin(), errors.end());
  Score score;
  if (errors.empty()) return score;
  score.median_px = errors[errors.size() / 2];
  score.worst_px = errors.back();
  score.tracked = static_cast<double>(errors.size()) / static_cast<double>(features.Size());
  return score;
}

class Detectors : public ::testing::TestWithParam<std::string> {};

TEST_P(Detectors, FindDistinctPointsInsideTheMaskOnly) {
  TrackerOptions options;
  options.detector = GetParam();
  const auto tracker = MakeFeatureTracker(options);
  const Image mask = FullMask(kWidth, kHeight, 60);
  const FeatureSet features = tracker->Detect(MakeFrame(0, Tissue(kWidth, kHeight, 1)), mask, 80);
  ASSERT_GE(features.Size(), 60);
  ASSERT_LE(features.Size(), 80);
  std::set<int> ids(features.id.begin(), features.id.end());
  EXPECT_EQ(static_cast<Index>(ids.size()), features.Size());
  bool sub_pixel = false;
  for (Index i = 0; i < features.Size(); ++i) {
    const double u = features.pixels(i, 0), v = features.pixels(i, 1);
    EXPECT_GE(u, 60);
    EXPECT_GE(v, 60);
    EXPECT_LE(u, kWidth - 60);
    EXPECT_LE(v, kHeight - 60);
    EXPECT_EQ(features.status[i], FeatureStatus::Tracked);
    sub_pixel = sub_pixel || std::abs(u - std::round(u)) > 0.01;
    for (Index j = 0; j < i; ++j)
      EXPECT_GT((features.pixels.row(i) - features.pixels.row(j)).norm(), 1.9);
  }
  if (GetParam() != "orb" && GetParam() != "brisk") {
    EXPECT_TRUE(sub_pixel);
  }
}
INSTANTIATE_TEST_SUITE_P(All, Detectors,
                         ::testing::Values("fast-hessian", "gftt", "akaze", "orb", "brisk",
                                           "sift"));

TEST(Detection, SpreadsOverTheWholeMask) {
  const auto tracker = MakeFeatureTracker();
  const FeatureSet features =
      tracker->Detect(MakeFrame(0, Tissue(kWidth, kHeight, 2)), FullMask(kWidth, kHeight, 20), 150);
  int cells[6][8] = {};
  for (Index i = 0; i < features.Size(); ++i)
    ++cells[static_cast<int>(features.pixels(i, 1)) * 6 / kHeight]
           [static_cast<int>(features.pixels(i, 0)) * 8 / kWidth];
  for (int y = 1; y < 5; ++y)
    for (int x = 1; x < 7; ++x) EXPECT_GE(cells[y][x], 1) << x << "," << y;
}

TEST(Detection, LeavesOutHighlightsAndInstruments) {
  cv::Mat picture = Tissue(kWidth, kHeight, 3);
  cv::RNG random(5);
  // A textured highlight and a textured steel bar from the border.
  for (int y = 60; y < 110; ++y)
    for (int x = 60; x < 130; ++x) {
      const auto light = static_cast<std::uint8_t>(random.uniform(225, 256));
      picture.at<cv::Vec3b>(y, x) = {light, light, light};
    }
  for (int y = 180; y < 210; ++y)
    for (int x = 150; x < kWidth; ++x) {
      const int grey = random.uniform(90, 150);
      picture.at<cv::Vec3b>(y, x) = cv::Vec3b(cv::saturate_cast<std::uint8_t>(grey + 6),
                                              cv::saturate_cast<std::uint8_t>(grey + 2),
                                              cv::saturate_cast<std::uint8_t>(grey));
    }
  const auto tracker = MakeFeatureTracker();
  const FeatureSet features =
      tracker->Detect(MakeFrame(0, picture), FullMask(kWidth, kHeight), 200);
  ASSERT_GT(features.Size(), 80);
  for (Index i = 0; i < features.Size(); ++i) {
    const double u = features.pixels(i, 0), v = features.pixels(i, 1);
    EXPECT_FALSE(u > 60 && u < 130 && v > 60 && v < 110) << u << "," << v;
    EXPECT_FALSE(u > 150 && v > 180 && v < 210) << u << "," << v;
  }
}

TEST(Detection, UniformPictureHasNoFeatures) {
  const auto tracker = MakeFeatureTracker();
  const cv::Mat flat(kHeight, kWidth, CV_8UC3, cv::Scalar(60, 60, 140));
  EXPECT_EQ(tracker->Detect(MakeFrame(0, flat), FullMask(kWidth, kHeight), 100).Size(), 0);
  const Image none = FullMask(kWidth, kHeight, kHeight / 2);
  EXPECT_EQ(tracker->Detect(MakeFrame(0, Tissue(kWidth, kHeight, 1)), none, 100).Size(), 0);
}

TEST(Tracking, TranslationToAFewHundredthsOfAPixel) {
  const Motion motion(Tissue(kWidth, kHeight, 4), 1, 1, 0, 23.7, 20);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features =
      tracker->Detect(MakeFrame(0, motion.Picture(0)), FullMask(kWidth, kHeight, 50), 120);
  const Pixels start = features.pixels;
  for (int i = 1; i < 20; ++i) tracker->Track(MakeFrame(i, motion.Picture(i)), &features);
  const Score score = ScoreOf(features, start, motion, 19);
  EXPECT_GT(score.tracked, 0.97);
  EXPECT_LT(score.median_px, 0.07);
  EXPECT_LT(score.worst_px, 0.6);
}

TEST(Tracking, StretchTurnAndLightDoNotAddUpToDrift) {
  const Motion motion(Tissue(kWidth, kHeight, 5), 1.6, 0.8, 15, 10, 80);
  const auto run = [&](bool reanchor) {
    TrackerOptions options;
    options.reanchor = reanchor;
    const auto tracker = MakeFeatureTracker(options);
    FeatureSet features =
        tracker->Detect(MakeFrame(0, motion.Picture(0)), FullMask(kWidth, kHeight, 90), 80);
    const Pixels start = features.pixels;
    cv::RNG random(9);
    for (int i = 1; i < 80; ++i) {
      cv::Mat picture = motion.Picture(i), noise(kHeight, kWidth, CV_8UC3);
      picture.convertTo(picture, -1, 1.0 - 0.003 * i,
                        0.1 * i);  // the lamp fades, the black level rises
      random.fill(noise, cv::RNG::NORMAL, 8, 3);
      picture = picture + noise - cv::Scalar::all(8);
      tracker->Track(MakeFrame(i, picture), &features);
    }
    return ScoreOf(features, start, motion, 79);
  };
  const Score anchored = run(true), drifting = run(false);
  EXPECT_GT(anchored.tracked, 0.9);
  EXPECT_LT(anchored.median_px, 0.2);
  EXPECT_LT(anchored.worst_px, 2.0);
  EXPECT_LT(anchored.median_px, 0.6 * drifting.median_px);
}

TEST(Tracking, SameBitsForEveryThreadCount) {
  const Motion motion(Tissue(kWidth, kHeight, 6), 1.2, 0.9, 10, 15, 12);
  const int usual_threads = cv::getNumThreads();
  const auto run = [&](int threads) {
    cv::setNumThreads(threads);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto tracker = MakeFeatureTracker();
    FeatureSet features =
        tracker->Detect(MakeFrame(0, motion.Picture(0)), FullMask(kWidth, kHeight, 30), 200);
    for (int i = 1; i < 12; ++i) tracker->Track(MakeFrame(i, motion.Picture(i)), &features);
    return features;
  };
  const FeatureSet one = run(1), two = run(2), four = run(4);
  cv::setNumThreads(usual_threads);
  ASSERT_EQ(one.Size(), two.Size());
  EXPECT_TRUE(one.pixels == two.pixels);
  EXPECT_TRUE(one.pixels == four.pixels);
  EXPECT_EQ(one.status, two.status);
  EXPECT_EQ(one.id, two.id);
}

/// A steel bar slides in, stays and leaves again while the tissue moves.
TEST(Tracking, HiddenFeaturesAreSaidToBeSoAndComeBack) {
  const int frames = 40;
  const Motion motion(Tissue(kWidth, kHeight, 7), 1.05, 1, 3, 12, frames);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features =
      tracker->Detect(MakeFrame(0, motion.Picture(0)), FullMask(kWidth, kHeight, 30), 150);
  const Pixels start = features.pixels;
  int hidden_most = 0;
  for (int i = 1; i < frames; ++i) {
    cv::Mat picture = motion.Picture(i);
    const int reach = i < 10 ? 20 * i : i < 22 ? 200 : std::max(0, 200 - 20 * (i - 22));
    const cv::Rect bar(kWidth - reach, 120, reach, 50);
    if (reach > 0) picture(bar).setTo(cv::Scalar(128, 122, 118));
    tracker->Track(MakeFrame(i, picture), &features);
    int hidden = 0;
    for (Index k = 0; k < features.Size(); ++k) {
      const Vec2 truth = motion.Moved(start.row(k), i);
      // Clearly behind the bar: its edge is known to a few pixels.
      const bool covered =
          truth.x() > bar.x + 4 && truth.y() > bar.y + 4 && truth.y() < bar.y + bar.height - 4;
      hidden += features.status[k] == FeatureStatus::Occluded ? 1 : 0;
      if (covered) {
        EXPECT_NE(features.status[k], FeatureStatus::Tracked) << "frame " << i;
      }
      if (features.status[k] == FeatureStatus::Tracked) {
        EXPECT_LT((features.pixels.row(k).transpose() - truth).norm(), 2.0) << "frame " << i;
      }
    }
    hidden_most = std::max(hidden_most, hidden);
  }
  EXPECT_GE(hidden_most, 8);
  const Score score = ScoreOf(features, start, motion, frames - 1);
  EXPECT_GT(score.tracked, 0.95);
  EXPECT_LT(score.worst_px, 1.0);
}

/// A second of smoke: contrast falls to a third under a white veil with noise, and clears again.
TEST(Tracking, SmokeHidesButDoesNotMislead) {
  const int frames = 45;
  const Motion motion(Tissue(kWidth, kHeight, 21), 1.1, 1, 4, 12, frames);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features =
      tracker->Detect(MakeFrame(0, motion.Picture(0)), FullMask(kWidth, kHeight, 60), 120);
  const Pixels start = features.pixels;
  cv::RNG random(22);
  for (int i = 1; i < frames; ++i) {
    cv::Mat picture = motion.Picture(i), noise(kHeight, kWidth, CV_8UC3);
    const double veil =
        i < 10 || i > 34 ? 0.0 : 0.65 * std::min(1.0, std::min(i - 9, 35 - i) / 4.0);
    picture.convertTo(picture, -1, 1 - veil, 130 * veil);
    random.fill(noise, cv::RNG::NORMAL, 8, 2.5);
    picture = picture + noise - cv::Scalar::all(8);
    tracker->Track(MakeFrame(i, picture), &features);
    EXPECT_LT(ScoreOf(features, start, motion, i).worst_px, 3.0) << "frame " << i;
  }
  EXPECT_GT(ScoreOf(features, start, motion, frames - 1).tracked, 0.9);
}

/// The camera jumps by more than tissue ever moves: what is still called tracked has to be right.
TEST(Tracking, AJumpIsFollowedOrLostButNeverGuessed) {
  const cv::Mat picture = Tissue(kWidth, kHeight, 23);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features = tracker->Detect(MakeFrame(0, picture), FullMask(kWidth, kHeight, 60), 120);
  const Pixels start = features.pixels;
  cv::Mat moved;
  cv::warpAffine(picture, moved, cv::Matx23d(1, 0, 31, 0, 1, -17), picture.size(), cv::INTER_LINEAR,
                 cv::BORDER_REFLECT);
  for (int i = 1; i < 4; ++i) tracker->Track(MakeFrame(i, moved), &features);
  int wrong = 0;
  for (Index k = 0; k < features.Size(); ++k)
    if (features.status[k] == FeatureStatus::Tracked &&
        (features.pixels.row(k) - start.row(k) - Eigen::RowVector2d(31, -17)).norm() > 1)
      ++wrong;
  EXPECT_LE(wrong, 1);
}

/// The picture parts along a line: features on either side go on, in their own direction, and none
/// is a loner.
TEST(Tracking, ACutIsNoReasonToLoseTheSides) {
  const cv::Mat picture = Tissue(kWidth, kHeight, 8);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features = tracker->Detect(MakeFrame(0, picture), FullMask(kWidth, kHeight, 40), 150);
  const Pixels start = features.pixels;
  const int frames = 25;
  for (int i = 1; i < frames; ++i) {
    cv::Mat opened(kHeight, kWidth, CV_8UC3, cv::Scalar(30, 30, 60));
    const int half = i;
    picture.colRange(half, kWidth / 2).copyTo(opened.colRange(0, kWidth / 2 - half));
    picture.colRange(kWidth / 2, kWidth - half).copyTo(opened.colRange(kWidth / 2 + half, kWidth));
    tracker->Track(MakeFrame(i, opened), &features);
  }
  int tracked = 0, away_from_lips = 0;
  for (Index k = 0; k < features.Size(); ++k) {
    const double from_line = start(k, 0) - kWidth / 2.0;
    const double expected = start(k, 0) + (from_line > 0 ? frames - 1 : 1 - frames);
    if (std::abs(from_line) > 12) ++away_from_lips;
    if (features.status[k] != FeatureStatus::Tracked) continue;
    if (std::abs(from_line) > 12) ++tracked;
    EXPECT_NEAR(features.pixels(k, 0), expected, 1.5) << from_line;
  }
  EXPECT_GT(tracked, 0.95 * away_from_lips);
}

TEST(Tracking, AnotherPictureLosesAllAndTracksNothingWrongly) {
  const auto tracker = MakeFeatureTracker();
  FeatureSet features = tracker->Detect(MakeFrame(0, Tissue(kWidth, kHeight, 10)),
                                        FullMask(kWidth, kHeight, 30), 100);
  for (int i = 1; i < 8; ++i) tracker->Track(MakeFrame(i, Tissue(kWidth, kHeight, 11)), &features);
  int tracked = 0;
  for (const FeatureStatus status : features.status)
    tracked += status == FeatureStatus::Tracked ? 1 : 0;
  EXPECT_LE(tracked, 2);
}

TEST(Tracking, PredictionBringsLostFeaturesBackAfterAJump) {
  const cv::Mat picture = Tissue(kWidth, kHeight, 12);
  cv::Mat moved;
  cv::warpAffine(picture, moved, cv::Matx23d(1, 0, 90, 0, 1, 55), picture.size(), cv::INTER_LINEAR,
                 cv::BORDER_REFLECT);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features = tracker->Detect(MakeFrame(0, picture), FullMask(kWidth, kHeight, 110), 40);
  const Pixels start = features.pixels;
  for (int i = 1; i < 8; ++i) {
    Pixels predicted = start.rowwise() + Eigen::RowVector2d(92, 53);
    tracker->Predict(predicted);
    tracker->Track(MakeFrame(i, moved), &features);
  }
  int right = 0;
  for (Index k = 0; k < features.Size(); ++k)
    if (features.status[k] == FeatureStatus::Tracked) {
      EXPECT_LT((features.pixels.row(k) - start.row(k) - Eigen::RowVector2d(90, 55)).norm(), 0.5);
      ++right;
    }
  EXPECT_GT(right, 0.9 * features.Size());
}

TEST(Tracking, WhatAnInstrumentHidBesideAnOpeningIsFoundAgain) {
  // Both halves part while their lips are hidden. The model is not cut: it expects them in the
  // middle, and on each side the neighbours know better.
  const cv::Mat picture = Tissue(kWidth, kHeight, 9);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features = tracker->Detect(MakeFrame(0, picture), FullMask(kWidth, kHeight, 40), 150);
  const Pixels start = features.pixels;
  const cv::Rect hidden(kWidth / 2 - 45, 90, 90, 120);
  constexpr int kParted = 24, kSeenAgain = 22, kFrames = 60;
  int lost = 0;
  for (int i = 1; i < kFrames; ++i) {
    cv::Mat opened(kHeight, kWidth, CV_8UC3, cv::Scalar(30, 30, 60));
    const int half = std::min(i, kParted);
    picture.colRange(half, kWidth / 2).copyTo(opened.colRange(0, kWidth / 2 - half));
    picture.colRange(kWidth / 2, kWidth - half).copyTo(opened.colRange(kWidth / 2 + half, kWidth));
    if (i < kSeenAgain) opened(hidden).setTo(cv::Scalar(40, 50, 90));
    tracker->Predict(start);
    tracker->Track(MakeFrame(i, opened), &features);
    if (i == kSeenAgain - 1)
      lost = static_cast<int>(
          std::count_if(features.status.begin(), features.status.end(),
                        [](FeatureStatus status) { return status != FeatureStatus::Tracked; }));
  }
  int back = 0;
  for (Index k = 0; k < features.Size(); ++k) {
    if (features.status[k] != FeatureStatus::Tracked) continue;
    const double side = start(k, 0) > kWidth / 2.0 ? 1 : -1;
    EXPECT_NEAR(features.pixels(k, 0), start(k, 0) + side * kParted, 1.5) << start.row(k);
    ++back;
  }
  EXPECT_GT(lost, 12);
  EXPECT_GT(back, features.Size() - lost / 2);
}

TEST(Tracking, ReplenishFillsNewSurfaceAndKeepsRows) {
  const cv::Mat picture = Tissue(kWidth, kHeight, 13);
  const auto tracker = MakeFeatureTracker();
  Image half = FullMask(kWidth, kHeight, 30);
  for (int y = 0; y < kHeight; ++y)
    std::fill_n(half.data.begin() + y * kWidth + kWidth / 2, kWidth / 2, 0);
  FeatureSet features = tracker->Detect(MakeFrame(0, picture), half, 60);
  tracker->Track(MakeFrame(1, picture), &features);
  const FeatureSet before = features;
  const int added = tracker->Replenish(FullMask(kWidth, kHeight, 30), 40, &features);
  EXPECT_GT(added, 25);
  ASSERT_EQ(features.Size(), before.Size() + added);
  EXPECT_TRUE(features.pixels.topRows(before.Size()) == before.pixels);
  int right = 0;
  for (Index i = before.Size(); i < features.Size(); ++i)
    right += features.pixels(i, 0) > kWidth / 2 - 10 ? 1 : 0;
  EXPECT_GT(right, 0.5 * added);
  tracker->Track(MakeFrame(2, picture), &features);
  for (const FeatureStatus status : features.status) EXPECT_EQ(status, FeatureStatus::Tracked);
}

TEST(Tracking, WrongUseIsRefused) {
  TrackerOptions options;
  options.detector = "surf";
  EXPECT_THROW(MakeFeatureTracker(options), UsageError);
  options = {};
  options.window_px = 1;
  EXPECT_THROW(MakeFeatureTracker(options), UsageError);
  const auto tracker = MakeFeatureTracker();
  FeatureSet features =
      tracker->Detect(MakeFrame(0, Tissue(kWidth, kHeight, 1)), FullMask(kWidth, kHeight), 30);
  features.id.push_back(99);
  EXPECT_THROW(tracker->Track(MakeFrame(1, Tissue(kWidth, kHeight, 1)), &features), UsageError);
  EXPECT_THROW(tracker->Detect(MakeFrame(0, Tissue(kWidth, kHeight, 1)), FullMask(10, 10), 30),
               InputError);
  EXPECT_THROW(tracker->Detect(Frame{}, FullMask(10, 10), 30), InputError);
}

}  // namespace
