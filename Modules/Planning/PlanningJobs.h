#pragma once

#include <QObject>
#include <functional>
#include <memory>

#include "Adapters/Itk/VolumeFiles.h"
#include "Session/PlanningSession.h"

class QWidget;
class qKerfHost;

namespace kerf {
struct PlannedCase;
struct OpenedCase;
}  // namespace kerf

/// The long work of planning: takes a snapshot, runs off the GUI thread, brings the result into the
/// session. Failures are said by the host.
class PlanningJobs : public QObject {
  Q_OBJECT
 public:
  PlanningJobs(qKerfHost* host, kerf::PlanningSession& session, QObject* parent);

  /// Called, with the question, before something takes the place of work in the session; false
  /// keeps that.
  void AskBeforeReplacing(std::function<bool(const QString&)> may) {
    may_replace_ = std::move(may);
  }
  /// @param then called when the CT is in the session
  void Open(const QString& path, const QString& series, std::function<void()> then = {});
  /// Whoever calls it has asked; it asks again where there is more work when the case is read.
  void OpenCase(const QString& folder);
  /// Unsaved work of before: its CT is opened, too.
  void Recover(const QString& file, std::function<void()> then);
  static QString RecoverTitle() { return tr("Reading the work"); }
  void Segment(const QString& preset);
  /// A tool of Session/PlanningTools.h on the labels of now.
  void RunTool(const QString& title, const std::string& undo_name,
               std::function<kerf::LabelVoxels(const kerf::LabelMap&, kerf::Progress&)> tool);
  /// Active contour on a label: seen moving; cancelling keeps what it has reached.
  void Evolve(int label);
  /// @param window over which foreign label numbers are asked about
  void ImportLabels(const QString& path, QWidget* window);
  void Check();
  void Mesh(int tetrahedra);
  void Measure();
  void OpenCamera(const QString& path);
  void ReadLandmarks(const QString& path);
  void Save(const QString& folder, const QImage& preview);

 signals:
  /// A DICOM folder holds several series; one has to be chosen.
  void SeriesFound(const QString& folder);
  /// The contour as it is now, while it evolves; an empty map when it is over.
  void ContourMoved(const kerf::LabelMap& contour);
  void CaseOpened(const QString& folder);
  void Saved(const QString& folder);

 public:
  const std::vector<kerf::SeriesInfo>& Series() const { return series_; }

 private:
  /// Says so: a result for labels of before is dropped.
  bool LabelsChangedSince(std::uint64_t state, const QString& title);
  qKerfHost* host_;
  kerf::PlanningSession& session_;
  std::shared_ptr<const kerf::PlannedCase> planned_;
  std::vector<kerf::SeriesInfo> series_;
  std::function<bool(const QString&)> may_replace_ = [](const QString&) { return true; };
};
