#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "Core/Progress.h"
#include "Pipelines/ExposureRegistration.h"
#include "Pipelines/PlanPipeline.h"
#include "Pipelines/SessionFolder.h"
#include "Session/IntraoperativeWorker.h"

namespace kerf {

/// A line of the check-in list.
struct CheckInItem {
  enum class Level { Ok, Warning, Stop } level = Level::Ok;
  std::string text;
};

/// The Intraoperative module without its window: check-in → exposure → run → close. Used from one
/// thread; the worker and the capture have their own.
class IntraoperativeDesk {
 public:
  IntraoperativeDesk();
  ~IntraoperativeDesk();  ///< closes the session

  // Check-in
  /// Reads a planned case; may run on another thread. @throws InputError
  static std::shared_ptr<const PlannedCase> ReadPlanned(const std::string& folder);
  /// @throws InputError when the folder is no case
  void OpenCase(const std::string& folder, std::shared_ptr<const PlannedCase> planned);
  bool HasCase() const { return planned_ != nullptr; }
  const std::string& CaseFolder() const { return case_folder_; }
  const std::string& Pseudonym() const { return pseudonym_; }
  const PlannedCase& Planned() const { return *planned_; }
  /// Calibration, and a pose where the file has one. @throws InputError
  void UseCamera(const std::string& file);
  const std::string& CameraFile() const { return camera_file_; }
  /// Starts to read a video file, image folder or pattern, device or URL. Never throws: what is
  /// wrong is in Source().
  void OpenSource(const std::string& path);
  const std::string& SourcePath() const { return source_path_; }
  SourceState Source() const;
  /// Newest picture, also while nothing is registered.
  std::optional<CapturedFrame> Newest() const;
  /// @param confirmed the pseudonym as the person at the table read it
  std::vector<CheckInItem> CheckIn(const std::string& confirmed) const;
  bool MayRegister(const std::string& confirmed) const;

  // Exposure
  /// The picture that is registered; the source holds (a file) or runs on (live).
  /// @throws InputError when there is no case, camera or picture yet
  void BeginExposure();
  ExposureRegistration* Exposure() { return exposure_.get(); }
  const Frame& ExposureFrame() const { return exposure_frame_; }
  /// Sessions that a crash ended, newest first.
  std::vector<std::string> Unfinished() const { return UnfinishedSessions(case_folder_); }
  /// Takes over pose and cuts of an unfinished session. @return how many cuts; @throws InputError
  int Resume(const std::string& session);

  /// After Stop(), to register anew: the cuts of that run, recorded or not, are drawn again after
  /// the next acceptance.
  void KeepCutsForNextRun();

  /// Cuts of the next run, drawn after its first frame, as those of a session that is resumed.
  void GiveCuts(std::vector<IntraoperativeDecision> cuts) { resumed_ = std::move(cuts); }

  // Run
  struct RunOptions {
    bool hold_cuts = false;
    bool record = true;
    int wanted_features = 225;
    double deadline_ms = 40.0;          ///< of a frame; 0: results that hang on no clock (tests)
    std::function<void()> on_snapshot;  ///< from the worker's thread
  };
  /// The surgeon accepts the registration: the session begins. Where it cannot be recorded it runs
  /// without, and the snapshots say why. @throws InputError
  void Accept(const RunOptions& options);
  bool Running() const { return worker_ != nullptr; }
  std::shared_ptr<const IntraoperativeSnapshot> Latest() const;
  /// What is to be shown now: the same, or the newest picture where registration is behind.
  std::shared_ptr<const IntraoperativeSnapshot> Current() const;
  const CameraModel& Camera() const { return camera_; }
  /// Wanted between tumour and cut, as the accepted session's plan says; NaN: no plan.
  double PlannedMargin_mm() const { return planned_margin_mm_; }
  void Post(IntraoperativeDecision decision);
  void Mark(const std::string& text);
  /// The artery is clamped, or open again: for the journal.
  void Clamp(bool closed);
  /// Keeps a picture in the session. @param frame its number as registered, −1: by its time
  /// @return its path; empty where nothing is recorded; @throws InputError where it cannot be kept
  std::string KeepPicture(const Image& image, int frame,
                          std::chrono::steady_clock::time_point captured);
  /// Ends the run; the recording is complete afterwards.
  void Stop();
  /// The part of Stop() that takes long; may run on another thread. Stop() follows on this one.
  void FinishRun() {
    if (worker_) worker_->Stop();
  }
  /// Why the last session's recording ended early; empty where all was written. After Stop().
  const std::string& RecordingProblem() const { return recording_problem_; }
  /// Recorded sessions of the case, newest first.
  std::vector<std::string> Recorded() const { return RecordedSessions(case_folder_); }
  /// Of the running or the last session; empty where nothing is recorded.
  const std::string& SessionPath() const { return session_path_; }

  /// All formats in both frames into the session's export folder. Only after Stop().
  /// @return the files; @throws InputError
  std::vector<std::string> ExportAll(Progress& progress) const;

  using SourceOpener = std::function<std::unique_ptr<FrameSource>(const std::string& path)>;
  /// Opens sources in another way than OpenCV does (tests, soak), and how they are captured;
  /// `hold` and `live` are taken as they are.
  void SetSourceOpener(SourceOpener opener, const CaptureOptions& options);
  using TrackerMaker = std::function<std::unique_ptr<FeatureTracker>()>;
  /// Tracks features in another way than by optical flow (tests, perfect tracks).
  void SetTrackerMaker(TrackerMaker maker) { make_tracker_ = std::move(maker); }
  /// How files are captured; default: at their own rate, newest frame.
  void SetCaptureOptions(const CaptureOptions& options) { capture_options_ = options; }

 private:
  bool IsLive() const;
  bool IsVideoFile() const;
  /// @throws InputError when the session's folder cannot be written
  std::unique_ptr<IntraoperativeSink> StartRecording(const RunOptions& options);

  std::string case_folder_, pseudonym_, camera_file_, calibrated_, source_path_, session_path_,
      recording_problem_;
  std::shared_ptr<const PlannedCase> planned_;
  std::optional<CameraModel> intrinsics_;
  std::optional<Eigen::Isometry3d> given_pose_;
  CameraModel camera_;
  double planned_margin_mm_ = std::numeric_limits<double>::quiet_NaN();
  std::optional<CaptureOptions> capture_options_;
  SourceOpener opener_;
  TrackerMaker make_tracker_;
  std::shared_ptr<IntraoperativeCapture> capture_;
  std::unique_ptr<ExposureRegistration> exposure_;
  Frame exposure_frame_;
  std::vector<IntraoperativeDecision> resumed_;
  std::optional<std::vector<CutRecord>> last_cuts_;  ///< of the last run
  std::unique_ptr<IntraoperativeWorker> worker_;
};

}  // namespace kerf
