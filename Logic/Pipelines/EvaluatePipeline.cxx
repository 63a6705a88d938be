#include "Pipelines/EvaluatePipeline.h"

#include <tbb/parallel_for.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <thread>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/ImageSequence.h"
#include "CaseIO/Csv.h"
#include "CaseIO/ResultsFiles.h"
#include "CaseIO/Space.h"
#include "Core/Errors.h"
#include "Evaluation/FeatureError.h"
#include "Evaluation/Silhouette.h"
#include "Pipelines/TruthFiles.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

constexpr int kOrganSamples = 3000, kStructureSamples = 1500;

/// The features of one frame of a results folder.
struct ResultFeatures {
  std::vector<int> id;
  std::vector<Vec3> current, rest;  ///< LPS; `rest` is empty where the file has none
};

struct Results {
  std::string folder;
  CameraModel camera;
  std::vector<DetectedCut> cuts;
  std::map<int, ResultFeatures> features;  ///< by frame
};

std::string In(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

std::map<int, ResultFeatures> ReadFeatures(const std::string& file, Space space) {
  const CsvTable t = CsvTable::Read(file);
  const int frame = t.Column("frame"), id = t.Column("id"), x = t.Column("x_mm"),
            y = t.Column("y_mm"), z = t.Column("z_mm");
  const bool has_rest = t.HasColumn("x0_mm");
  const int x0 = has_rest ? t.Column("x0_mm") : 0, y0 = has_rest ? t.Column("y0_mm") : 0,
            z0 = has_rest ? t.Column("z0_mm") : 0;
  auto point = [&](std::size_t r, int a, int b, int c) {
    const Vec3 p(t.Number(r, a), t.Number(r, b), t.Number(r, c));
    return space == Space::RAS ? FlipSpace(p) : p;
  };
  std::map<int, ResultFeatures> features;
  for (std::size_t r = 0; r < t.Rows(); ++r) {
    ResultFeatures& f = features[t.Integer(r, frame)];
    f.id.push_back(t.Integer(r, id));
    f.current.push_back(point(r, x, y, z));
    if (has_rest) f.rest.push_back(point(r, x0, y0, z0));
  }
  return features;
}

Results OpenResults(const std::string& folder, const Study& study) {
  if (!fs::is_directory(folder)) throw InputError(folder, "", "is no folder");
  Results results;
  results.folder = folder;
  const std::string camera = In(folder, "camera.yml"), cuts = In(folder, "cuts.json"),
                    features = In(folder, "features.csv");
  results.camera = ReadCameraFile(fs::exists(camera) ? camera : study.camera);
  Space space = Space::LPS;  // features.csv has no tag of its own: it is in the space of cuts.json
  if (fs::exists(cuts))
    for (auto& cut : ReadCutsFile(cuts, &space))
      results.cuts.push_back({cut.detected_frame == kNoFrame
                                  ? std::nullopt
                                  : std::optional<double>(cut.detected_frame),
                              std::move(cut.polyline_rest)});
  if (fs::exists(features)) results.features = ReadFeatures(features, space);
  return results;
}

Image ReadMask(const std::string& path) {
  const auto colour = ReadImageFile(path);
  if (!colour) throw InputError(path, "", "cannot be read");
  Image mask{colour->width, colour->height, 1, {}};
  const std::size_t count = std::size_t(mask.width) * mask.height;
  mask.data.resize(count);
  for (std::size_t i = 0; i < count; ++i)
    for (int c = 0; c < colour->channels; ++c)
      if (colour->data[i * colour->channels + c]) mask.data[i] = 255;
  return mask;
}

void AddDice(const Results& results, const Truth& truth, const SurfaceMesh& organ,
             FrameScores* scores) {
  char name[40];
  std::snprintf(name, sizeof name, "frame_%05d_mask.png", scores->frame);
  const std::string true_path = In(truth.folder, name), own = In(results.folder, name);
  if (!fs::exists(true_path)) return;
  const Image true_mask = ReadMask(true_path);
  const Image mask = fs::exists(own) ? ReadMask(own) : Silhouette(results.camera, organ);
  if (mask.width != true_mask.width || mask.height != true_mask.height)
    throw InputError(fs::exists(own) ? own : In(results.folder, "camera.yml"), "image size",
                     "is " + std::to_string(mask.width) + "x" + std::to_string(mask.height) +
                         ", the study's is " + std::to_string(true_mask.width) + "x" +
                         std::to_string(true_mask.height));
  scores->values["dice"] = Dice(true_mask, mask);
}

void AddDistance(const SurfaceMesh& model, const SurfaceMesh& truth, const std::string& name,
                 int samples, FrameScores* scores) {
  const auto distance = SampledHausdorff(model, truth, samples);
  if (!distance) return;
  scores->values[name + "_mean"] = distance->mean_mm;
  scores->values[name + "_max"] = distance->max_mm;
}

Points Stacked(const std::vector<Vec3>& points) {
  Points out(static_cast<Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) out.row(i) = points[i].transpose();
  return out;
}

/// Where the model carries the truth's own points; by features.csv where its surface has no rest
/// positions.
void AddFeatureErrors(const Results& results, const Truth& truth, const FrameSurface* organ,
                      FrameScores* scores) {
  const auto frame = truth.tracks.current.find(scores->frame);
  Points model, real;
  if (organ && organ->rest_position && !organ->surface.Empty()) {
    if (frame == truth.tracks.current.end()) return;
    std::vector<Vec3> rest, current;
    for (const auto& [id, feature] : truth.tracks.rest) {
      const auto at = frame->second.find(id);
      if (!feature.use || at == frame->second.end()) continue;
      rest.push_back(feature.rest);
      current.push_back(at->second);
    }
    model = CarriedPoints({*organ->rest_position, organ->surface.triangles}, organ->surface.points,
                          Stacked(rest));
    real = Stacked(current);
  } else {
    const auto own = results.features.find(scores->frame);
    if (own == results.features.end()) return;
    model = Stacked(own->second.current);
    if (!own->second.rest.empty()) {
      real = TruePositionsAt(truth, scores->frame, Stacked(own->second.rest));
    } else {
      if (frame == truth.tracks.current.end()) return;
      std::vector<Vec3> current;
      for (int id : own->second.id) {
        const auto at = frame->second.find(id);
        if (at == frame->second.end())
          throw InputError(In(results.folder, "features.csv"), "id " + std::to_string(id),
                           "is not in the study, and the file has no rest positions (x0_mm …)");
        current.push_back(at->second);
      }
      real = Stacked(current);
    }
  }
  const auto errors = CompareFeatures(model, real, truth.eye);
  if (!errors) return;
  scores->values["lateral_mean"] = errors->lateral_mean_mm;
  scores->values["lateral_max"] = errors->lateral_max_mm;
  scores->values["feature_mean"] = errors->mean_mm;
  scores->values["feature_max"] = errors->max_mm;
  scores->feature_count = errors->count;
}

FrameScores ScoreFrame(const Results& results, const Truth& truth, int frame) {
  FrameScores scores;
  scores.frame = frame;
  std::optional<FrameSurface> organ;
  const std::string path = FindFrameMesh(results.folder, frame, "organ");
  if (!path.empty()) {
    organ = ReadFrameSurface(path);
    AddDice(results, truth, organ->surface, &scores);
    const std::string true_path = FindFrameMesh(truth.folder, frame, "organ");
    if (true_path.empty())
      throw InputError(In(truth.folder, FrameFileName(frame, "organ", "vtp")), "", "is missing");
    AddDistance(organ->surface, ReadFrameSurface(true_path).surface, "organ", kOrganSamples,
                &scores);
  }
  for (const std::string what : {"internal", "tumour"}) {
    const std::string own = FindFrameMesh(results.folder, frame, what);
    const std::string real = FindFrameMesh(truth.folder, frame, what);
    if (!own.empty() && !real.empty())
      AddDistance(ReadFrameStructure(own), ReadFrameStructure(real), what, kStructureSamples,
                  &scores);
  }
  AddFeatureErrors(results, truth, organ ? &*organ : nullptr, &scores);
  return scores;
}

}  // namespace

Scores EvaluateAgainstTruth(const std::string& results_folder, const std::string& study,
                            Progress& progress) {
  progress.Report(0.0, "reading the truth");
  const Truth truth = OpenTruth(study);
  const Results results = OpenResults(results_folder, truth.study);
  Scores scores;
  scores.study = truth.study.name;
  std::string missing;
  int present = 0;
  for (int frame : truth.frames) {
    if (!FindFrameMesh(results.folder, frame, "organ").empty())
      ++present;
    else
      missing += (missing.empty() ? "" : ", ") + std::to_string(frame);
  }
  if (present == 0 && results.features.empty())
    throw InputError(In(results.folder, FrameFileName(truth.frames.front(), "organ", "vtp")), "",
                     "is missing, and so is every other frame to be judged");
  if (!missing.empty()) progress.Warn("no organ surface for frames " + missing);

  // Frames are independent of each other and go to slots of their own: the order of work does not
  // matter.
  scores.frames.resize(truth.frames.size());
  std::atomic<int> done{0};
  std::atomic<bool> cancelled{false};
  const auto main_thread = std::this_thread::get_id();
  tbb::parallel_for(std::size_t(0), truth.frames.size(), [&](std::size_t i) {
    if (cancelled) return;
    scores.frames[i] = ScoreFrame(results, truth, truth.frames[i]);
    const double fraction = double(++done) / double(truth.frames.size());
    if (std::this_thread::get_id() != main_thread) return;
    progress.Report(fraction, "judging " + scores.study);
    if (progress.IsCancelled()) cancelled = true;
  });
  progress.ThrowIfCancelled();
  scores.cuts = CompareCuts(results.cuts, truth.cuts, truth.study.frames_per_second);
  Summarize(&scores);
  return scores;
}

}  // namespace kerf
