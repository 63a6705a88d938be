#include "Pipelines/IntraoperativeDesk.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Adapters/Rendering/ImageEncoding.h"
#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"
#include "Pipelines/CasePlan.h"
#include "Pipelines/ExportPipeline.h"
#include "Pipelines/RegistrationParts.h"
#include "Pipelines/SessionRecorder.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

using Level = CheckInItem::Level;
constexpr int kOldCalibration_days = 30;

std::string Now() {
  const std::time_t now = std::time(nullptr);
  char text[32];
  std::strftime(text, sizeof text, "%Y%m%d-%H%M%S", std::localtime(&now));
  return text;
}

/// Decisions that draw the cuts of a session again.
std::vector<IntraoperativeDecision> DrawAgain(const std::vector<CutRecord>& cuts,
                                              const Vec3& direction) {
  std::vector<IntraoperativeDecision> out;
  for (const CutRecord& cut : cuts) {
    IntraoperativeDecision again;
    again.kind = IntraoperativeDecision::Kind::DrawCut;
    again.line = cut.polyline_rest;
    again.direction = direction;
    again.depth_mm = cut.depth_mm;
    if (again.line.rows() > 1) out.push_back(again);
  }
  return out;
}

}  // namespace

IntraoperativeDesk::IntraoperativeDesk() = default;
IntraoperativeDesk::~IntraoperativeDesk() { Stop(); }

std::shared_ptr<const PlannedCase> IntraoperativeDesk::ReadPlanned(const std::string& folder) {
  return std::make_shared<PlannedCase>(ReadCase(folder));
}

void IntraoperativeDesk::OpenCase(const std::string& folder,
                                  std::shared_ptr<const PlannedCase> planned) {
  Stop();
  const auto opened = kerf::CaseFolder::Open(folder, false);
  case_folder_ = folder;
  pseudonym_ = opened.Manifest().pseudonym;
  planned_ = std::move(planned);
  exposure_.reset();
  resumed_.clear();
  last_cuts_.reset();
  session_path_.clear();
  intrinsics_.reset();
  given_pose_.reset();
  camera_file_.clear();
  calibrated_.clear();
  planned_margin_mm_ = std::numeric_limits<double>::quiet_NaN();
  if (opened.Has("camera")) UseCamera(opened.Path("camera"));
}

void IntraoperativeDesk::UseCamera(const std::string& file) {
  CameraModel camera = ReadCameraIntrinsics(file);
  const std::string calibrated = ReadCalibrationTime(file);
  given_pose_.reset();
  if (CameraFileHasPose(file)) given_pose_ = ReadCameraFile(file).camera_from_world;
  camera.camera_from_world = Eigen::Isometry3d::Identity();
  intrinsics_ = camera;
  camera_file_ = file;
  calibrated_ = calibrated;
  exposure_.reset();
}

bool IntraoperativeDesk::IsLive() const {
  return source_path_.find("://") != std::string::npos || source_path_.rfind("/dev/", 0) == 0;
}

bool IntraoperativeDesk::IsVideoFile() const {
  std::error_code error;
  return !opener_ && !IsLive() && fs::is_regular_file(source_path_, error);
}

void IntraoperativeDesk::OpenSource(const std::string& path) {
  Stop();
  capture_.reset();
  exposure_.reset();
  source_path_ = path;
  CaptureOptions options;
  if (capture_options_) options = *capture_options_;
  if (opener_) {
    capture_ = std::make_shared<IntraoperativeCapture>(
        [path, open = opener_] { return open(path); }, options);
    return;
  }
  options.live = IsLive();
  options.hold = !options.live;
  VideoOptions video;
  video.minimum_frames = options.live ? 1 : 2;
  capture_ = std::make_shared<IntraoperativeCapture>(
      [path, video]() -> std::unique_ptr<FrameSource> { return OpenVideo(path, video); }, options);
}

void IntraoperativeDesk::SetSourceOpener(SourceOpener opener, const CaptureOptions& options) {
  opener_ = std::move(opener);
  capture_options_ = options;
}

SourceState IntraoperativeDesk::Source() const {
  if (capture_) return capture_->State();
  SourceState none;
  none.message = "No source is chosen.";
  return none;
}

std::optional<CapturedFrame> IntraoperativeDesk::Newest() const {
  return capture_ ? capture_->Newest() : std::nullopt;
}

std::vector<CheckInItem> IntraoperativeDesk::CheckIn(const std::string& confirmed) const {
  std::vector<CheckInItem> list;
  const auto say = [&](Level level, const std::string& text) { list.push_back({level, text}); };
  if (!planned_) {
    say(Level::Stop, "No case is open.");
    return list;
  }
  say(Level::Ok, fmt::format("Case {}: files complete and unchanged, {} tetrahedra.", pseudonym_,
                             planned_->mesh.TetCount()));
  if (confirmed.empty())
    say(Level::Stop, "Read the case number off the patient's papers and enter it.");
  else if (confirmed != pseudonym_)
    say(Level::Stop, fmt::format("\"{}\" is not this case ({}): the wrong case is open.", confirmed,
                                 pseudonym_));
  else
    say(Level::Ok, "The case number agrees with the patient's papers.");
  const SourceState source = Source();
  const bool picture = source.width > 0;
  if (!picture)
    say(Level::Stop, source.message.empty() ? "Waiting for the first picture." : source.message);
  else if (!source.Usable())
    say(Level::Stop, source.message);
  else
    say(Level::Ok, fmt::format("Pictures {}×{} at {:.3g} per second.", source.width, source.height,
                               source.nominal_fps));
  if (!intrinsics_) {
    say(Level::Stop, "No camera file: choose the calibration of this laparoscope.");
  } else {
    const std::string name = fs::path(camera_file_).filename().string();
    const auto days = CalibrationAge_days(calibrated_, std::time(nullptr));
    if (!days)
      say(Level::Warning,
          fmt::format("Calibration {}: the file does not say how old it is.", name));
    else if (*days < 0)
      say(Level::Warning,
          fmt::format("Calibration {} is dated in the future ({}).", name, calibrated_));
    else
      say(*days > kOldCalibration_days ? Level::Warning : Level::Ok,
          fmt::format("Calibration {}, {} day{} old.", name, *days, *days == 1 ? "" : "s"));
    if (picture && (source.width != intrinsics_->width || source.height != intrinsics_->height))
      say(Level::Stop,
          fmt::format("The camera file is for {}×{}, the pictures are {}×{}: it is the "
                      "wrong camera file or another video format.",
                      intrinsics_->width, intrinsics_->height, source.width, source.height));
  }
  return list;
}

bool IntraoperativeDesk::MayRegister(const std::string& confirmed) const {
  const auto list = CheckIn(confirmed);
  return std::none_of(list.begin(), list.end(),
                      [](const CheckInItem& item) { return item.level == Level::Stop; });
}

void IntraoperativeDesk::BeginExposure() {
  if (!planned_) throw InputError("case", "", "no case is open");
  if (!intrinsics_) throw InputError(case_folder_, "camera", "no camera file is chosen");
  const auto newest = Newest();
  if (!newest) throw InputError(source_path_, "", "no picture has come yet");
  CheckVideoSize(newest->frame.image->width, newest->frame.image->height, source_path_,
                 *intrinsics_, camera_file_);
  exposure_frame_ = newest->frame;
  const std::optional<Eigen::Isometry3d> start =
      exposure_ ? std::optional(exposure_->Camera().camera_from_world) : given_pose_;
  exposure_ = std::make_unique<ExposureRegistration>(*intrinsics_, planned_->mesh,
                                                     planned_->landmarks, start);
}

int IntraoperativeDesk::Resume(const std::string& session) {
  const CameraModel camera = ReadCameraFile((fs::path(session) / "camera.yml").string());
  const fs::path cuts = fs::path(session) / "cuts.json";
  resumed_.clear();
  if (fs::exists(cuts)) resumed_ = DrawAgain(ReadCutsFile(cuts.string()), camera.ViewDirection());
  given_pose_ = camera.camera_from_world;
  exposure_.reset();
  BeginExposure();
  return static_cast<int>(resumed_.size());
}

void IntraoperativeDesk::KeepCutsForNextRun() {
  if (last_cuts_) resumed_ = DrawAgain(*last_cuts_, camera_.ViewDirection());
}

void IntraoperativeDesk::Accept(const RunOptions& options) {
  if (!exposure_) throw InputError("registration", "", "there is none to accept");
  Stop();
  camera_ = exposure_->Camera();
  MethodOptions method;
  method.hold_cuts = options.hold_cuts;
  method.wanted_features = options.wanted_features;
  IntraoperativeWorker::Parts parts;
  parts.session = std::make_unique<RegistrationSession>(
      planned_->mesh, planned_->structures, camera_, method,
      make_tracker_ ? make_tracker_() : MakeFeatureTracker({}), MakeVideoOrganSegmenter());
  parts.uncut = planned_->organ_surface;
  parts.plan = ReadCasePlan(case_folder_, planned_->organ_surface);
  planned_margin_mm_ = parts.plan.margin_mm;
  parts.capture = capture_;
  parts.first = resumed_;
  parts.deadline_ms = options.deadline_ms;
  parts.on_snapshot = options.on_snapshot;
  session_path_.clear();
  recording_problem_.clear();
  if (options.record) {
    // Surgery does not wait for a disk: without a recording the session runs all the same.
    try {
      parts.sink = StartRecording(options);
    } catch (const std::exception& error) {
      parts.recording_problem = error.what();
    }
  }
  worker_ = std::make_unique<IntraoperativeWorker>(std::move(parts));
  capture_->Resume();
}

std::unique_ptr<IntraoperativeSink> IntraoperativeDesk::StartRecording(const RunOptions& options) {
  SessionFolder session;
  session.root = MakeSessionFolder(case_folder_, Now());
  session.case_folder = case_folder_;
  session.source_name = fs::path(source_path_).filename().string();
  session.pseudonym = pseudonym_;
  session.frames_per_second = Source().nominal_fps > 0 ? Source().nominal_fps : 25.0;
  session.hold_cuts = options.hold_cuts;
  session.wanted_features = options.wanted_features;
  try {
    auto recorder = std::make_unique<SessionRecorder>(session, camera_, planned_->organ_surface,
                                                      IsVideoFile() ? source_path_ : "",
                                                      exposure_->Description());
    session_path_ = session.root;
    return recorder;
  } catch (...) {  // no half of a video, no session without a frame
    std::error_code ignored;
    fs::remove_all(session.root, ignored);
    throw;
  }
}

std::shared_ptr<const IntraoperativeSnapshot> IntraoperativeDesk::Latest() const {
  return worker_ ? worker_->Latest() : nullptr;
}

std::shared_ptr<const IntraoperativeSnapshot> IntraoperativeDesk::Current() const {
  return worker_ ? worker_->Current() : nullptr;
}

void IntraoperativeDesk::Post(IntraoperativeDecision decision) {
  if (worker_) worker_->Post(std::move(decision));
}

void IntraoperativeDesk::Clamp(bool closed) {
  if (worker_) worker_->Note(closed ? "clamp closed" : "clamp opened", {});
}

void IntraoperativeDesk::Mark(const std::string& text) {
  if (worker_) worker_->Note("mark", {{"text", text}});
}

std::string IntraoperativeDesk::KeepPicture(const Image& image, int frame,
                                            std::chrono::steady_clock::time_point captured) {
  if (session_path_.empty()) return {};
  const fs::path folder = fs::path(session_path_) / "snapshots";
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError(folder.string(), "", "cannot be made: " + error.message());
  const double time_s = worker_ ? std::max(0.0, worker_->Time_s(captured)) : 0.0;
  const std::string name =
      frame >= 0 ? fmt::format("frame_{:06d}", frame) : fmt::format("time_{:09.3f}", time_s);
  std::string path = (folder / (name + ".png")).string();
  // Of one frame there may be several: with and without the overlay, before and after a decision.
  for (int again = 2; fs::exists(path, error); ++again)
    path = (folder / fmt::format("{}-{}.png", name, again)).string();
  WritePicture(path, EncodePng(image, 1));  // the window waits for it
  if (worker_) worker_->Note("snapshot", {{"file", fs::path(path).filename().string()}});
  return path;
}

void IntraoperativeDesk::Stop() {
  if (!worker_) return;
  worker_->Stop();
  recording_problem_ = worker_->RecordingProblem();
  last_cuts_ = worker_->Cuts();
  worker_.reset();
}

std::vector<std::string> IntraoperativeDesk::ExportAll(Progress& progress) const {
  if (session_path_.empty()) throw InputError(case_folder_, "sessions", "nothing was recorded");
  std::vector<std::string> written;
  const char* formats[] = {"vtu", "vtp", "stl", "ply", "obj", "glb", "seg.nrrd"};
  const int total = 2 * static_cast<int>(std::size(formats));
  int done = 0;
  for (const bool ras : {false, true})
    for (const char* format : formats) {
      progress.ThrowIfCancelled();
      ExportRequest request;
      request.input = session_path_;
      request.format = format;
      request.ras = ras;
      request.output = (fs::path(session_path_) / "export" / (ras ? "ras" : "lps")).string();
      SubProgress part(progress, double(done) / total, double(done + 1) / total);
      ++done;
      for (std::string& file : Export(request, part)) written.push_back(std::move(file));
    }
  return written;
}

}  // namespace kerf
