#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>

#include "Adapters/OpenCv/CvMats.h"
#include "Adapters/OpenCv/ImageSequence.h"
#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Support/CasesFolder.h"

using namespace kerf;
namespace fs = std::filesystem;

/// The tracker on the studies, against their exact image positions. The table in
/// docs/reference/tracking.md is what this prints. The exact positions start the tracks and judge
/// them; nothing in between sees them.
namespace {

constexpr double kWrong_px = 3.0;
/// Points nearer to the organ's outline than where the detector would look are left out, px.
constexpr float kOutlineMargin_px = 4.0F;

struct Exact {
  Vec2 pixel;
  bool visible;
};
using ExactTracks = std::map<int, std::map<int, Exact>>;  ///< frame, id

ExactTracks ReadExact(const std::string& path) {
  ExactTracks tracks;
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    int frame = 0, id = 0, visible = 0;
    double u = 0, v = 0;
    if (std::sscanf(line.c_str(), "%d,%d,%lf,%lf,%d", &frame, &id, &u, &v, &visible) == 5)
      tracks[frame][id] = {Vec2(u, v), visible != 0};
  }
  return tracks;
}

/// The organ's silhouette while it is still at rest.
cv::Mat RestSilhouette(const fs::path& study) {
  const auto image = ReadImageFile((study / "truth/frame_00020_mask.png").string());
  if (!image) return {};
  cv::Mat grey;
  cv::cvtColor(ViewOf(*image), grey, cv::COLOR_BGR2GRAY);
  return grey > 200;
}

struct FrameScore {
  int followed = 0, visible = 0, tracked = 0, lost = 0, occluded = 0, wrong = 0;
  double median_px = 0, p95_px = 0, max_px = 0;
};

FrameScore ScoreOf(const FeatureSet& features, const std::map<int, Exact>& exact) {
  FrameScore score;
  std::vector<double> errors;
  for (Index i = 0; i < features.Size(); ++i) {
    const Exact& truth = exact.at(features.id[i]);
    ++score.followed;
    score.visible += truth.visible ? 1 : 0;
    score.lost += features.status[i] == FeatureStatus::Lost ? 1 : 0;
    score.occluded += features.status[i] == FeatureStatus::Occluded ? 1 : 0;
    if (features.status[i] != FeatureStatus::Tracked) continue;
    const double error = (features.pixels.row(i).transpose() - truth.pixel).norm();
    score.wrong += error > kWrong_px ? 1 : 0;
    if (!truth.visible) continue;
    ++score.tracked;
    errors.push_back(error);
  }
  std::sort(errors.begin(), errors.end());
  if (errors.empty()) return score;
  score.median_px = errors[errors.size() / 2];
  score.p95_px = errors[errors.size() * 95 / 100];
  score.max_px = errors.back();
  return score;
}

class StudyTracking : public ::testing::TestWithParam<std::string> {};

TEST_P(StudyTracking, FollowsTheExactPositions) {
  const fs::path study = kerf::testing::CasesFolder() / GetParam();
  if (!fs::exists(study / "video.mp4"))
    GTEST_SKIP() << "no study at " << study << " (set KERF_CASES)";
  const ExactTracks exact = ReadExact((study / "features_2d.csv").string());
  const cv::Mat silhouette = RestSilhouette(study);
  if (silhouette.empty()) GTEST_SKIP() << "no truth in " << study;
  cv::Mat depth;
  cv::distanceTransform(silhouette, depth, cv::DIST_L2, 5);

  FeatureSet features;
  std::vector<Vec2> pixels;
  for (const auto& [id, start] : exact.at(0)) {
    const cv::Point at(cvRound(start.pixel.x()), cvRound(start.pixel.y()));
    if (depth.at<float>(at) < kOutlineMargin_px) continue;
    features.id.push_back(id);
    pixels.push_back(start.pixel);
  }
  features.pixels.resize(static_cast<Index>(pixels.size()), 2);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    features.pixels.row(static_cast<Index>(i)) = pixels[i];

  const auto tracker = MakeFeatureTracker();
  const auto video = OpenVideo((study / "video.mp4").string());
  long wrong = 0, tracked = 0, visible = 0;
  while (const auto frame = video->Next()) {
    if (frame->index == 0)
      tracker->Adopt(*frame, ToImage(silhouette), &features);
    else
      tracker->Track(*frame, &features);
    const FrameScore score = ScoreOf(features, exact.at(frame->index));
    wrong += score.wrong;
    tracked += score.tracked;
    visible += score.visible;
    if (frame->index != 50 && frame->index != 100 && frame->index != 149) continue;
    std::printf("| %s | %d | %d | %.1f | %d | %d | %.2f | %.2f | %.2f | %d |\n", GetParam().c_str(),
                frame->index, score.followed, 100.0 * score.tracked / score.visible, score.lost,
                score.occluded, score.median_px, score.p95_px, score.max_px, score.wrong);
    EXPECT_LT(score.median_px, 0.3);
    EXPECT_LT(score.p95_px, 1.8);
  }
  const double tracked_percent =
      100.0 * static_cast<double>(tracked) / static_cast<double>(visible);
  const double wrong_percent = 100.0 * static_cast<double>(wrong) / static_cast<double>(tracked);
  std::printf("| %s | all | %d | %.1f | | | | | | %.2f %% |\n", GetParam().c_str(), features.Size(),
              tracked_percent, wrong_percent);
  EXPECT_GT(tracked_percent, 85.0);
  EXPECT_LT(wrong_percent, 0.6);
}
INSTANTIATE_TEST_SUITE_P(Studies, StudyTracking,
                         ::testing::Values("kidney-1", "kidney-2", "kidney-nocut", "liver-1",
                                           "silicone-left", "silicone-middle", "silicone-nocut"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
