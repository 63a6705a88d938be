/// What `tumour_u95_mm` promises, on simulated studies: nineteen of twenty times the tumour's
/// middle lies within it of where it is shown; and it is not much wider than that takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/ResultsFiles.h"
#include "CaseIO/StudyFolder.h"
#include "Logic/CaseIO/TemporaryFolder.h"
#include "Pipelines/ReplayPipeline.h"
#include "Support/CasesFolder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// Of the surface, so that it does not depend on how finely it is meshed.
Vec3 Centroid(const SurfaceMesh& surface) {
  Vec3 sum = Vec3::Zero();
  double area = 0.0;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const Vec3 a = surface.points.row(surface.triangles(t, 0)).transpose(),
               b = surface.points.row(surface.triangles(t, 1)).transpose(),
               c = surface.points.row(surface.triangles(t, 2)).transpose();
    const double weight = (b - a).cross(c - a).norm();
    sum += weight / 3.0 * (a + b + c);
    area += weight;
  }
  return sum / area;
}

/// What was judged: distances between where the tumour is shown and where it is, and the bounds.
struct Judged {
  std::vector<double> error_mm, bound_mm;
  double Within(double share_of_bound) const {
    int within = 0;
    for (std::size_t i = 0; i < error_mm.size(); ++i)
      within += error_mm[i] <= share_of_bound * bound_mm[i];
    return double(within) / double(error_mm.size());
  }
};

/// Replays the study from its video with the defaults and adds its evaluated frames.
void Judge(const fs::path& study, Judged* judged) {
  const testing::TemporaryFolder results;
  ReplayRequest request;
  request.study = study.string();
  request.results = results.Path();
  request.drawing = ReplayRequest::Drawing::None;
  Progress silent;
  Replay(request, silent);
  const std::vector<int> frames = OpenStudy(study.string()).eval_frames;
  for (const ReliabilityRow& row : ReadReliabilityFile(results / "reliability.csv")) {
    if (!std::binary_search(frames.begin(), frames.end(), row.frame)) continue;
    const std::string name = FrameFileName(row.frame, "tumour", "vtp");
    const Vec3 shown = Centroid(ReadSurface(results / name)),
               real = Centroid(ReadSurface((study / "truth" / name).string()));
    judged->error_mm.push_back((shown - real).norm());
    judged->bound_mm.push_back(row.tumour_u95_mm);
  }
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(TumourBound, CoversTheTruthAndIsNotVacuous) {
  Judged judged;
  for (const char* name : {"kidney-1", "kidney-2", "kidney-nocut", "liver-1"}) {
    const fs::path study = testing::CasesFolder() / name;
    if (!fs::exists(study / "truth")) GTEST_SKIP() << "no study " << study << " (set KERF_CASES)";
    Judge(study, &judged);
  }
  ASSERT_GE(judged.error_mm.size(), 100u);
  RecordProperty("within_percent", std::to_string(100 * judged.Within(1.0)));
  // 90 % are asked for: frames of a study follow each other, so its misses come together.
  EXPECT_GE(judged.Within(1.0), 0.9);
  EXPECT_LT(judged.Within(0.5), 0.95) << "half of the bound would do";
  EXPECT_LE(Median(judged.bound_mm), 3.0);
  EXPECT_LE(*std::max_element(judged.bound_mm.begin(), judged.bound_mm.end()), 8.0);
}

}  // namespace
}  // namespace kerf
