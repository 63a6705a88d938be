#include "Pipelines/ReplayPipeline.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "Adapters/Itk/Segmentation.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/LandmarkRegistration.h"
#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/CaseFolder.h"
#include "CaseIO/StudyFolder.h"
#include "Core/Errors.h"
#include "Pipelines/InitialRegistration.h"
#include "Pipelines/OverlayRecorder.h"
#include "Pipelines/PlanPipeline.h"
#include "Pipelines/RegistrationParts.h"
#include "Pipelines/Report.h"
#include "Pipelines/ResultsWriter.h"
#include "Pipelines/SessionFolder.h"
#include "Pipelines/SessionReplay.h"
#include "Session/RegistrationSession.h"
#include "Session/TableTracker.h"

namespace kerf {
namespace {

using Clock = std::chrono::steady_clock;
double Since_ms(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// The study's suggestions, for the reference method, where the user gave nothing.
void ApplySuggestions(const Study& study, const std::set<std::string>& given,
                      MethodOptions* method) {
  const auto take = [&](const char* name, const auto& value, auto* option) {
    if (value && !given.count(name)) *option = *value;
  };
  const SuggestedParameters& s = study.suggested;
  take("young", s.young_kPa, &method->material.young_kPa);
  take("poisson", s.poisson, &method->material.poisson);
  take("neighbour-radius", s.neighbour_radius_mm, &method->neighbour_radius_mm);
  take("tau", s.tau, &method->tau);
  take("outliers", s.outliers, &method->outliers);
  take("cut-radius", s.cut_radius_mm, &method->cut_radius_mm);
  if (study.extrusion_hint && !given.count("extrusion")) method->extrusion = study.extrusion_hint;
}

PlannedCase PlanStudy(const ReplayRequest& request, const Study& study, const CameraModel& camera,
                      Progress& progress) {
  if (request.case_folder) return ReadCase(*request.case_folder);
  MeshingOptions meshing;
  if (request.tetrahedra) meshing.tetrahedra = *request.tetrahedra;
  using Labels = ReplayRequest::Labels;
  PlannedCase planned;
  std::string source;
  if (request.labels == Labels::Given && study.labels.empty() && study.organ_surface.empty())
    throw InputError(study.root, "labels.nii.gz", "--labels given, but the study has no label map");
  if (request.labels != Labels::Segment && !study.labels.empty()) {
    source = study.labels;
    planned = PlanFromLabels(ReadLabelMap(study.labels), meshing, progress);
  } else if (!study.ct.empty()) {
    source = study.ct;
    SubProgress segmenting(progress, 0.0, 0.5), meshing_part(progress, 0.5, 1.0);
    const Volume ct = ReadVolume(study.ct, {}, segmenting);
    planned = PlanFromLabels(SegmentStudyCt(ct, segmenting), meshing, meshing_part);
  } else if (!study.organ_surface.empty()) {
    source = study.organ_surface;
    planned =
        PlanFromSurface(ReadSurface(study.organ_surface), study.organ_surface, meshing, progress);
  } else {
    throw InputError(study.root, "ct.nii.gz", "no CT to segment");
  }
  planned.camera = camera;
  if (!study.landmarks.empty()) planned.landmarks = ReadCaseLandmarks(study.landmarks);
  WriteCase(planned, request.results + "/case",
            {{"input", std::filesystem::path(source).filename().string()},
             {"input_sha256", Sha256OfFile(source)}});
  return planned;
}

/// Frames for runs with perfect tracks and no video: index and time only.
class BlankSource : public FrameSource {
 public:
  BlankSource(const Study& study, int frames) : study_(study), frames_(frames) {}
  std::optional<Frame> Next() override {
    if (next_ >= frames_) return std::nullopt;
    Frame frame;
    frame.index = next_++;
    frame.time_s = frame.index / study_.frames_per_second;
    return frame;
  }
  int Width() const override { return study_.width; }
  int Height() const override { return study_.height; }
  double FramesPerSecond() const override { return study_.frames_per_second; }
  int FrameCount() const override { return frames_; }

 private:
  const Study& study_;
  int frames_, next_ = 0;
};

JournalData Parameters(const ReplayRequest& request) {
  const MethodOptions& m = request.method;
  JournalData data{{"method", m.method == Method::Reference ? "reference" : "kerf"},
                   {"cutting", m.cutting},
                   {"young_kPa", m.material.young_kPa},
                   {"poisson", m.material.poisson},
                   {"tumour_stiffness_factor", m.material.tumour_stiffness_factor},
                   {"spring_g_s2", m.SpringStiffness_g_s2()},
                   {"neighbour_radius_mm", m.neighbour_radius_mm},
                   {"tau", m.tau},
                   {"outliers", m.outliers},
                   {"cut_radius_mm", m.cut_radius_mm},
                   {"steps_per_frame", m.steps_per_frame},
                   {"grips", m.grips},
                   {"outline", request.outline},
                   {"tracks", request.tracks ? "table" : "video"}};
  if (m.extrusion)
    data.push_back({"extrusion_lps",
                    std::vector<double>{m.extrusion->x(), m.extrusion->y(), m.extrusion->z()}});
  if (m.cut_depth_mm) data.push_back({"cut_depth_mm", *m.cut_depth_mm});
  return data;
}

/// SHA-256 of everything that the run reads.
JournalData InputHashes(const ReplayRequest& request, const Study& study) {
  JournalData data;
  const auto add = [&](const std::string& path) {
    if (!path.empty() && std::filesystem::is_regular_file(path))
      data.push_back({std::filesystem::path(path).filename().string(), Sha256OfFile(path)});
  };
  add(study.camera);
  add(request.tracks ? *request.tracks : study.video);
  add(study.labels.empty() ? study.organ_surface : study.labels);
  add(study.ct);
  if (request.registration == ReplayRequest::InitialPose::Landmarks) add(study.landmarks);
  return data;
}

void Percentiles(std::vector<double> totals, ReplayResult* result) {
  if (totals.empty()) return;
  std::sort(totals.begin(), totals.end());
  result->median_ms = totals[totals.size() / 2];
  result->p99_ms = totals[std::min(totals.size() - 1, totals.size() * 99 / 100)];
}

constexpr int kLongestStream = 1000000;  // frames, where a source does not say how many it has

constexpr int kReportSnapshots = 5;  // from rest to the end

/// Frames whose overlay goes into the report, evenly from the first to the last.
bool IsSnapshot(int frame, int frame_count) {
  if (frame_count < kReportSnapshots) return true;
  for (int k = 0; k < kReportSnapshots; ++k)
    if (frame == (frame_count - 1) * k / (kReportSnapshots - 1)) return true;
  return false;
}

std::string Text(const JournalValue& value) {
  struct Visitor {
    std::string operator()(bool v) const { return v ? "on" : "off"; }
    std::string operator()(std::int64_t v) const { return std::to_string(v); }
    std::string operator()(double v) const { return fmt::format("{:g}", v); }
    std::string operator()(const std::string& v) const { return v; }
    std::string operator()(const std::vector<double>& v) const {
      return fmt::format("{:.4g}", fmt::join(v, ", "));
    }
    std::string operator()(const std::vector<std::string>& v) const {
      return fmt::format("{}", fmt::join(v, ", "));
    }
  };
  return std::visit(Visitor(), value.value);
}

ReportData ReplayReport(const ReplayRequest& request, const Study& study,
                        const ResultsWriter& results, const OverlayRecorder* recorder,
                        const MeshQuality& planned, const RegistrationState& state,
                        const ReplayResult& result) {
  ReportData data;
  data.study = study.name;
  data.method = request.method.method == Method::Reference ? "reference" : "kerf";
  data.cutting = request.method.cutting;
  if (result.broken) data.warnings.push_back(*result.broken);
  if (recorder)
    for (const auto& snapshot : recorder->Snapshots())
      data.snapshots.push_back({snapshot.frame, snapshot.time_s, snapshot.image});
  data.timing = results.Timing();
  data.reliability = results.ReliabilityRows();
  data.fit = results.Fit();
  data.cuts = results.Cuts();
  data.planned_mesh = planned;
  data.final_mesh = MeasureQuality(state.mesh, state.positions);
  for (const auto& [name, value] : Parameters(request))
    data.parameters.push_back({name, Text(value)});
  data.versions = {{"kerf", KERF_VERSION}, {"instruction set", KERF_BASELINE}};
  return data;
}

}  // namespace

ReplayResult Replay(const ReplayRequest& original, Progress& progress) {
  ReplayRequest request = original;
  if (request.case_folder &&
      (request.labels != ReplayRequest::Labels::Automatic || request.tetrahedra))
    throw UsageError("--case together with --labels or --tetrahedra: the case is planned already");
  std::unique_ptr<tbb::global_control> limit;
  if (request.threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  request.threads);
  if (IsSessionFolder(request.study)) return ReplaySession(request, progress);
  const Study study = OpenStudy(request.study);
  if (request.method.method == Method::Reference)
    ApplySuggestions(study, request.given, &request.method);
  request.method.wanted_features =
      study.feature_count > 0 ? study.feature_count : request.method.wanted_features;
  request.method.Validate();

  // Everything that can be wrong with the inputs is found before the planning takes its time.
  ReplayResult result;
  JournalData accepted;
  CameraModel camera = InitialCamera(request, study, progress, &accepted, &result.landmarks);
  std::unique_ptr<FeatureTracker> tracker;
  std::unique_ptr<FrameSource> source;
  VideoSource* video = nullptr;
  int track_frames = 0;
  if (request.tracks) {
    auto table = std::make_unique<TableTracker>(ReadTracks(*request.tracks, study.features_rest));
    track_frames = table->FrameCount();
    tracker = std::move(table);
  } else {
    tracker = MakeFeatureTracker({});
    if (study.video.empty()) throw InputError(study.root, "video.mp4", "the study has no video");
  }
  if (!study.video.empty() &&
      (request.drawing != ReplayRequest::Drawing::None || !request.tracks)) {
    auto opened = OpenVideo(study.video);
    CheckVideoSize(opened->Width(), opened->Height(), study.video, camera, study.camera);
    video = opened.get();
    source = std::move(opened);
  } else {
    source = std::make_unique<BlankSource>(study, track_frames);
  }

  SubProgress planning(progress, 0.0, 0.2);
  PlannedCase planned = PlanStudy(request, study, camera, planning);

  if (video && !request.tracks && request.method.method == Method::Kerf && request.outline)
    RefineByOutline(study.video, planned.mesh, progress, &camera, &accepted);
  ResultsWriter results(request.results, camera, planned.organ_surface);
  Journal& journal = results.GetJournal();
  journal.Write(0.0, 0, "start",
                {{"program", "kerf"},
                 {"version", KERF_VERSION},
                 {"baseline", KERF_BASELINE},
                 {"notice", "research use, not a medical device"}});
  journal.Write(0.0, 0, "inputs", InputHashes(request, study));
  journal.Write(0.0, 0, "parameters", Parameters(request));
  journal.Write(0.0, 0, "registration accepted", accepted);

  std::unique_ptr<OverlayRecorder> recorder;
  if (video) recorder = OverlayRecorder::Make(request, camera, source->FramesPerSecond(), progress);

  const MeshQuality planned_quality = MeasureQuality(planned.mesh, planned.mesh.rest);
  RegistrationSession session(std::move(planned.mesh), std::move(planned.structures), camera,
                              request.method, std::move(tracker),
                              request.tracks ? nullptr : MakeVideoOrganSegmenter());
  std::vector<double> totals;
  const int frame_count = source->FrameCount();
  const std::vector<int> to_write =
      study.FramesToWrite(frame_count > 0 ? frame_count : kLongestStream);
  int last_written = -1;
  std::optional<SessionFrame> last;
  while (true) {
    progress.ThrowIfCancelled();
    const auto start = Clock::now();
    std::optional<Frame> frame;
    try {
      frame = source->Next();
    } catch (const InputError& error) {  // what was done up to here is kept
      if (result.frames == 0) throw;
      result.broken = error.what();
    }
    if (!frame) break;
    const double capture_ms = Since_ms(start);
    // Perfect tracks stand in for the picture, which is drawn on alone then.
    Frame seen = *frame;
    if (request.tracks) seen.image = nullptr;
    last = session.Process(seen);
    double render_ms = 0.0;
    if (recorder) {
      const auto render_start = Clock::now();
      const auto& cuts = last->step.cuts;
      const bool new_cut =
          std::any_of(cuts.begin(), cuts.end(), [](const CutEvent& e) { return e.first; });
      recorder->Add(*frame, *last, session.State(),
                    new_cut || IsSnapshot(result.frames, frame_count), &results);
      render_ms = Since_ms(render_start);
    }
    results.AddFrame(*last, session.State(), capture_ms, render_ms);
    totals.push_back(last->times.Sum());
    if (std::binary_search(to_write.begin(), to_write.end(), last->frame)) {
      results.WriteMeshes(*last, session.State());
      last_written = last->frame;
    }
    ++result.frames;
    progress.Report(
        0.2 + 0.8 * result.frames / std::max(frame_count, result.frames),
        "frame " + std::to_string(result.frames) + " of " + std::to_string(frame_count));
  }
  if (!last) throw InputError(study.video, "frame 0", "no frame can be read");
  if (video && video->Broken()) result.broken = video->BreakReport();
  if (result.broken) {
    progress.Warn(*result.broken + "; what was done up to there is kept");
    journal.Write(last->time_s, last->frame, "source broken", {{"reason", *result.broken}});
  }
  // A source may end sooner than announced: the last frame is written all the same.
  if ((result.broken || study.eval_frames.empty()) && last_written != last->frame)
    results.WriteMeshes(*last, session.State());
  const RegistrationState& state = session.State();
  results.Finish(state);
  result.cuts =
      static_cast<int>(std::count_if(state.cuts.begin(), state.cuts.end(), [](const ModelCut& cut) {
        return cut.surface.triangles.rows() > 0;
      }));
  result.final_gate = last->reliability.state;
  result.final_reason = last->reliability.reason;
  Percentiles(totals, &result);
  journal.Write(
      last->time_s, last->frame, "end",
      {{"frames", result.frames}, {"cuts", result.cuts}, {"gate", ToString(result.final_gate)}});
  if (recorder) recorder->Finish();
  result.report = std::make_shared<ReportData>(
      ReplayReport(request, study, results, recorder.get(), planned_quality, state, result));
  WriteReport(request.results + "/report.html", *result.report);
  return result;
}

}  // namespace kerf
