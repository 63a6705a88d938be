#include "PlanningJobs.h"

#include <QFileInfo>
#include <QImage>
#include <filesystem>
#include <mutex>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/CameraFile.h"
#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"
#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Pipelines/PlanPipeline.h"
#include "PlanningFiles.h"
#include "Session/PlanningAutosave.h"

namespace {

/// Passes on and keeps the warnings.
class KeepWarnings : public kerf::Progress {
 public:
  explicit KeepWarnings(kerf::Progress& to) : to_(to) {}
  void Report(double fraction, const std::string& what) override { to_.Report(fraction, what); }
  void Warn(const std::string& message) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    kept_.push_back(message);
    to_.Warn(message);
  }
  bool IsCancelled() const override { return to_.IsCancelled(); }
  std::vector<std::string> Take() { return std::move(kept_); }

 private:
  kerf::Progress& to_;
  std::mutex mutex_;
  std::vector<std::string> kept_;
};

/// Messages name the path first; in the window the path was just chosen. Of a file in a folder its
/// name stays.
std::vector<std::string> WithoutPath(std::vector<std::string> warnings, const std::string& path) {
  for (std::string& w : warnings) {
    if (w.rfind(path + '/', 0) == 0) w = w.substr(path.size() + 1);
    if (w.rfind(path + ": ", 0) != 0) continue;
    w = w.substr(path.size() + 2);
    if (!w.empty()) w[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(w[0])));
  }
  return warnings;
}

}  // namespace

PlanningJobs::PlanningJobs(qKerfHost* host, kerf::PlanningSession& session, QObject* parent)
    : QObject(parent), host_(host), session_(session) {}

void PlanningJobs::Open(const QString& path, const QString& series, std::function<void()> then) {
  struct Result {
    kerf::Volume ct;
    kerf::CountedLabels no_labels;
    std::vector<std::string> warnings;
    std::vector<kerf::SeriesInfo> series;
  };
  const std::string file = QFileInfo(path).absoluteFilePath().toStdString();
  const std::string uid = series.toStdString();
  auto result = std::make_shared<Result>();
  qKerfJobRunner::Job job;
  job.title = tr("Opening %1").arg(QFileInfo(path).fileName());
  job.advice =
      tr("Open a CT as a DICOM folder, NIfTI or NRRD; where a file is damaged or cut off, "
         "export it again.");
  job.work = [file, uid, result](kerf::Progress& progress) {
    KeepWarnings keep(progress);
    if (std::filesystem::is_directory(file)) {
      const std::string format = kerf::FolderFormat(file);
      if (format == "kerf-case")
        throw kerf::UsageError(
            "This folder is a case. Open it from the Cases page (Ctrl+1) or with File, Open case.");
      if (uid.empty()) {
        auto found = kerf::ListSeries(file, progress);
        if (found.size() > 1) {
          result->series = std::move(found);
          return;
        }
      }
    }
    kerf::VolumeReadOptions options;
    options.series = uid;
    result->ct = kerf::ReadVolume(file, options, keep);
    result->warnings = WithoutPath(keep.Take(), file);
    result->no_labels = kerf::NoLabels(result->ct.grid, result->ct.source);
  };
  job.done = [this, result, file, uid, path, then] {
    series_ = result->series;
    emit SeriesFound(series_.empty() ? QString() : path);
    if (!series_.empty()) {
      host_->Say(qKerfHost::Info,
                 tr("This folder holds %1 series: choose one in the list.").arg(series_.size()));
      return;
    }
    if (!may_replace_(tr("Open this CT without saving them?"))) return;
    planned_.reset();
    session_.SetVolume(std::move(result->ct), file, uid, result->warnings, &result->no_labels);
    if (!result->warnings.empty())
      host_->Say(qKerfHost::Warning,
                 tr("The CT is open, but: %1").arg(QString::fromStdString(result->warnings[0])));
    else
      host_->Say(qKerfHost::Info, {});
    if (then) then();
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::OpenCase(const QString& folder) {
  auto result = std::make_shared<kerf::OpenedCase>();
  qKerfJobRunner::Job job;
  job.title = tr("Opening the case");
  job.work = [result, folder = folder.toStdString()](kerf::Progress& progress) {
    *result = kerf::ReadCaseForPlanning(folder, progress);
  };
  job.done = [this, result, folder, changes = session_.Changes()] {
    if (session_.Changes() != changes &&
        !may_replace_(tr("Work was done while the case was read. Open it without saving them?"))) {
      host_->Say(qKerfHost::Warning,
                 tr("Planning keeps its work: save it, then open the case again."));
      return;
    }
    const std::string path = folder.toStdString() + "/ct.nrrd";
    session_.SetVolume(std::move(result->ct), path, {}, {}, &result->labels);
    session_.Restore(result->labels, result->rest);
    planned_ = result->planned;
    session_.SetModel(result->model, session_.LabelsState());
    session_.SetSaved(folder.toStdString());
    emit CaseOpened(folder);
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Recover(const QString& file, std::function<void()> then) {
  struct Result {
    kerf::PlanningWork work;
    kerf::CountedLabels labels;
  };
  auto result = std::make_shared<Result>();
  qKerfJobRunner::Job job;
  job.title = RecoverTitle();
  job.work = [result, file = file.toStdString()](kerf::Progress&) {
    result->work = kerf::LoadWork(file);
    result->labels = kerf::CountLabels(result->work.labels);
  };
  job.failed = [this](const QString& sentence) {
    host_->Say(
        qKerfHost::Problem,
        tr("The work cannot be recovered: %1. Discard it, and begin with its CT.").arg(sentence));
  };
  job.done = [this, result, then] {
    Open(QString::fromStdString(result->work.ct_path), QString::fromStdString(result->work.series),
         [this, result, then] {
           if (!result->labels.labels.grid.SameAs(session_.Ct()->grid)) {
             host_->Say(qKerfHost::Problem,
                        tr("The CT was changed since: the work does not fit it. Put the CT of then "
                           "back to %1 and try again.")
                            .arg(QString::fromStdString(session_.CtPath())));
             return;
           }
           session_.Restore(result->labels, result->work.rest);
           then();
         });
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Mesh(int tetrahedra) {
  if (session_.Labels().Count(1) == 0) {
    host_->Say(qKerfHost::Problem, tr("There is no organ yet: segment it by a preset, or paint it "
                                      "around what is labelled (step 2)."));
    return;
  }
  struct Result {
    std::shared_ptr<const kerf::PlannedCase> planned;
    std::shared_ptr<const kerf::PlanningModel> model;
    std::vector<std::string> warnings;
  };
  auto result = std::make_shared<Result>();
  const std::uint64_t state = session_.LabelsState();
  qKerfJobRunner::Job job;
  job.title = tr("Making the mesh");
  job.advice = tr("Check the labels (step 2), or choose another number of tetrahedra.");
  job.work = [labels = session_.Labels().Snapshot(), tetrahedra, result](kerf::Progress& progress) {
    KeepWarnings keep(progress);
    result->planned = kerf::MeshLabels(labels, tetrahedra, keep);
    result->model = kerf::ModelOf(*result->planned);
    result->warnings = WithoutPath(keep.Take(), labels.source);
  };
  job.done = [this, result, state] {
    planned_ = result->planned;
    session_.SetModel(result->model, state);
    host_->Say(result->warnings.empty() ? qKerfHost::Info : qKerfHost::Warning,
               result->warnings.empty()
                   ? QString()
                   : tr("The mesh is there, but: %1. Where that is not meant, check the labels "
                        "(step 2).")
                         .arg(QString::fromStdString(result->warnings[0])));
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Measure() {
  if (!session_.Model()) {
    host_->Say(qKerfHost::Problem, tr("Make the mesh first (step 3)."));
    return;
  }
  struct Result {
    kerf::ResectionMeasures measures;
    double within_ml = 0;
  };
  auto result = std::make_shared<Result>();
  qKerfJobRunner::Job job;
  job.title = tr("Measuring the resection");
  job.advice = tr("Draw the line again, across the organ's whole width.");
  job.work = [model = session_.Model(), plan = session_.Plan(), result](kerf::Progress& progress) {
    result->measures = kerf::MeasureResection(*model, plan, progress);
    result->within_ml = kerf::TissueWithinMargin_ml(*model, plan.margin_mm, progress);
  };
  job.done = [this, result] {
    session_.SetMeasures(std::move(result->measures), result->within_ml);
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::OpenCamera(const QString& path) {
  auto camera = std::make_shared<kerf::CameraModel>();
  qKerfJobRunner::Job job;
  job.title = tr("Reading the camera file");
  job.advice =
      tr("This camera file cannot be used. Choose the camera.yml that kerf calibrate wrote.");
  job.work = [file = path.toStdString(), camera](kerf::Progress&) {
    *camera = kerf::CameraFileHasPose(file) ? kerf::ReadCameraFile(file)
                                            : kerf::ReadCameraIntrinsics(file);
  };
  job.done = [this, camera, path] { session_.SetCamera(*camera, path.toStdString()); };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::ReadLandmarks(const QString& path) {
  auto landmarks = std::make_shared<std::vector<kerf::MarkupPoint>>();
  qKerfJobRunner::Job job;
  job.title = tr("Reading landmarks");
  job.advice =
      tr("These landmarks cannot be read. Choose a Slicer markups file (.mrk.json), or "
         "place them on the organ.");
  job.work = [file = path.toStdString(), landmarks](kerf::Progress&) {
    *landmarks = kerf::ReadCaseLandmarks(file);
  };
  job.done = [this, landmarks] { session_.SetLandmarks(*landmarks); };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Save(const QString& folder, const QImage& preview) {
  if (!session_.CanSave() || !planned_) {
    host_->Say(qKerfHost::Problem,
               tr("The case cannot be saved yet: the checklist says what is missing."));
    return;
  }
  kerf::CaseToSave what;
  what.planned = planned_;
  what.ct = *session_.Ct();
  what.labels = session_.Labels().Snapshot();
  what.ct_path = session_.CtPath();
  what.seeds = session_.Seeds();
  what.landmarks = session_.Landmarks();
  what.camera = session_.Camera();
  what.camera_path = session_.CameraPath();
  what.plan = session_.Plan();
  what.preview = preview;
  const std::string path = QFileInfo(folder).absoluteFilePath().toStdString();
  qKerfJobRunner::Job job;
  job.title = tr("Saving the case");
  job.advice = tr("Choose another folder, or make room on the disk.");
  job.work = [what = std::move(what), path](kerf::Progress& progress) {
    kerf::SaveCase(what, path, progress);
  };
  job.done = [this, path] {
    session_.SetSaved(path);
    emit Saved(QString::fromStdString(path));
  };
  host_->Jobs().Run(std::move(job));
}
