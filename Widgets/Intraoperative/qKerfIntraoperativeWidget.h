#pragma once

#include <QPolygonF>
#include <QTimer>
#include <QWidget>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>

#include "Adapters/Rendering/OverlayScene.h"
#include "Pipelines/IntraoperativeDesk.h"
#include "Session/RateMeter.h"

class QAction;
class QLabel;
class QListWidget;
class QPushButton;
class QSplitter;
class QStackedWidget;
class qKerfCheckInPanel;
class qKerfExposurePanel;
class qKerfOverlayLook;
class qKerfReviewPanel;
class qKerfRunPanel;
class qKerfTimeline;
class qKerfVideoView;

namespace kerf {
class OverlayPainter;
class SessionPlayback;
}  // namespace kerf

/// The Intraoperative module's page: check-in, exposure, run, close, and a look back at recorded
/// sessions, beside the picture. Long work
/// (reading a case, exporting) goes through `Services::run`; everything else answers at once.
class qKerfIntraoperativeWidget : public QWidget {
  Q_OBJECT
 public:
  /// What the host does for the page. Defaults work without a host.
  struct Services {
    /// Runs `work` off the GUI thread, then `done` or `failed` on it (without a word where it was
    /// cancelled).
    std::function<void(const QString& title, std::function<void(kerf::Progress&)> work,
                       std::function<void()> done, std::function<void(const QString&)> failed)>
        run;
    std::function<void(const QString& problem)> say_problem;
    std::function<void(const QString& text)> say;
    std::function<void(const QString& id, QAction* action)> add_shortcut;
  };
  explicit qKerfIntraoperativeWidget(Services services = {}, QWidget* parent = nullptr);
  ~qKerfIntraoperativeWidget() override;

  enum Step { CheckIn, Exposure, Run, Close, Review };
  Step CurrentStep() const;
  void OpenCase(const QString& folder);
  void OpenSource(const QString& path);
  void UseCamera(const QString& file);
  /// Check-in and exposure without hands: the pose of the camera file is accepted (soak, scripts).
  void StartWithGivenPose();
  /// Completes the recording and waits for it: the window is about to close.
  void StopNow();
  /// Plays a recorded session of the case that is open.
  void OpenRecorded(const QString& session);
  kerf::IntraoperativeDesk& Desk() { return desk_; }
  /// Null but in Review.
  kerf::SessionPlayback* Playback() { return playback_.get(); }
  /// What is shown; null before the first picture.
  std::shared_ptr<const kerf::IntraoperativeSnapshot> Shown() const { return shown_; }
  /// Pictures shown with the overlay in the last second.
  double ShownPerSecond() const;
  /// Capture to shown, ms, of the last picture.
  double Latency_ms() const { return latency_ms_; }
  qKerfVideoView* View() { return view_; }
  qKerfVideoView* RawView() { return raw_; }
  qKerfVideoView* BeforeView() { return before_; }
  void SetRawBeside(bool beside);
  void SetFullScreen(bool full);
  bool OverlayOn() const { return overlay_on_; }
  /// Whether sessions are recorded; on unless said otherwise.
  void SetRecording(bool record) { record_ = record; }
  /// Of a frame, ms; 0: none, so that results hang on no clock (tests).
  void SetDeadline(double ms) { deadline_ms_ = ms; }

 signals:
  void StepChanged(int step);
  void CaseOpened(const QString& folder);

 protected:
  void showEvent(QShowEvent* event) override;
  void hideEvent(QHideEvent* event) override;

 private:
  void MakeLayout();
  void MakeKeys();
  void ConnectCheckIn();
  void ConnectExposure();
  void ConnectRun();
  void ConnectReview();
  void ConnectLook();
  void ShowStep(Step step);
  void Try(const std::function<void()>& work);

  void Tick();
  void TickEnd();
  void TickCheckIn();
  void TickRun();
  void ShowNewest();
  bool Bare() const { return !overlay_on_ || !overlay_problem_.empty(); }
  void NoteShown(std::chrono::steady_clock::time_point captured);
  void SayWhatStopped(const kerf::IntraoperativeSnapshot& latest);
  void TickReview();
  void PaintExposure();
  void Draw(std::shared_ptr<const kerf::IntraoperativeSnapshot> snapshot,
            const kerf::CameraModel& camera);
  void MakePainter(const kerf::CameraModel& camera);
  void TakePainted();
  void Present(std::shared_ptr<const kerf::IntraoperativeSnapshot> snapshot);
  void DrawAgain();
  void DrawAnew();
  void ShowBefore();
  void ArrangeViews();
  void OverlayFails(const std::string& why);
  void SeekTo(int frame);
  void SetPlaying(bool playing);
  void SetBefore(bool before);
  void ChangeLook(const std::function<void(kerf::OverlayOptions*)>& change);
  void ShowLamp(const kerf::IntraoperativeSnapshot& snapshot);
  int StripText_px() const;
  void ArrangeStrip();
  void ShowFigures(const kerf::SourceState& source, double registered_fps,
                   bool not_recorded = false);
  void BeginExposure(bool fresh);
  void FitOutline();
  void Accept();
  /// Completes the recording in a thread of its own, then goes on with `then`.
  void EndRun(std::function<void()> then);
  void EndSession();
  void ShowEnd();
  void ExportAll();
  void Post(kerf::IntraoperativeDecision::Kind kind, int cut = -1);
  void DecideOnCut(bool accept);
  void SetPreset(kerf::OverlayPreset preset);
  void SetOverlay(bool on);
  void SetDrawing(bool drawing);
  void KeepSnapshot();
  void SetClamp(bool closed);
  void ShowClamp();

  Services services_;
  kerf::IntraoperativeDesk desk_;
  std::unique_ptr<kerf::OverlayPainter> painter_;
  QString painter_problem_;

  qKerfCheckInPanel* check_in_;
  qKerfExposurePanel* exposure_;
  qKerfRunPanel* run_;
  qKerfReviewPanel* review_;
  qKerfOverlayLook* look_;
  qKerfTimeline* timeline_;
  QWidget* close_;
  QListWidget* exported_;
  QPushButton *export_, *play_session_;
  QLabel *close_text_, *lamp_, *margin_, *figures_;
  QPushButton* steps_[4];
  QStackedWidget* pages_;
  QWidget* side_;
  QSplitter* views_;
  qKerfVideoView *view_, *raw_, *before_;
  QTimer timer_;

  Step step_ = CheckIn;
  std::future<void> ending_;  ///< while the recording is being completed
  std::function<void()> after_end_;
  bool fitting_ = false;  ///< the outline is being fitted
  double deadline_ms_ = kerf::IntraoperativeDesk::RunOptions().deadline_ms;
  bool record_ = true, overlay_on_ = true, drawing_ = false, exposure_changed_ = true,
       full_ = false, was_full_screen_ = false;
  double contour_fit_ = 0.0, latency_ms_ = 0.0;
  QPolygonF stroke_;
  std::optional<std::chrono::steady_clock::time_point> clamped_at_;
  std::chrono::steady_clock::duration clamped_before_{};       ///< and opened again
  std::shared_ptr<const kerf::IntraoperativeSnapshot> drawn_,  ///< the last that was to be drawn
      shown_, before_shown_;
  kerf::OverlayOptions look_options_;
  std::string overlay_problem_, stopped_, not_recorded_;  ///< already said
  std::string alarm_case_;  ///< whose planned margin the alarm began with
  std::unique_ptr<kerf::SessionPlayback> playback_;
  double review_time_s_ = 0.0;
  int review_frame_ = 0;
  bool playing_ = false, before_on_ = false;
  std::chrono::steady_clock::time_point played_at_;
  std::chrono::steady_clock::time_point shown_picture_, newest_shown_, figures_at_;
  kerf::RateMeter shown_at_;
};
