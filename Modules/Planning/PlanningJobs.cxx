#include "PlanningJobs.h"

#include <QFileInfo>
#include <QImage>
#include <array>
#include <filesystem>
#include <map>
#include <mutex>

#include "Adapters/Itk/Segmentation.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "CaseIO/CaseFolder.h"
#include "Core/Errors.h"
#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Pipelines/PlanPipeline.h"
#include "Planning/qKerfLabelImportDialog.h"
#include "PlanningContour.h"
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

/// Messages name the path first; in the window the path was just chosen.
std::vector<std::string> WithoutPath(std::vector<std::string> warnings, const std::string& path) {
  for (std::string& w : warnings) {
    const std::string prefix = path + ": ";
    if (w.rfind(prefix, 0) == 0) w = w.substr(prefix.size());
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
  };
  job.done = [this, result, file, uid, path, then] {
    series_ = result->series;
    emit SeriesFound(series_.empty() ? QString() : path);
    if (!series_.empty()) {
      host_->Say(qKerfHost::Info,
                 tr("This folder holds %1 series: choose one in the list.").arg(series_.size()));
      return;
    }
    planned_.reset();
    session_.SetVolume(std::move(result->ct), file, uid, result->warnings);
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
  job.done = [this, result, folder] {
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
    host_->Say(qKerfHost::Problem, tr("The work cannot be recovered: %1").arg(sentence));
  };
  job.done = [this, result, then] {
    Open(QString::fromStdString(result->work.ct_path), QString::fromStdString(result->work.series),
         [this, result, then] {
           if (!result->labels.labels.grid.SameAs(session_.Ct()->grid)) {
             host_->Say(qKerfHost::Problem,
                        tr("The CT was changed since: the work does not fit it."));
             return;
           }
           session_.Restore(result->labels, result->work.rest);
           then();
         });
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Segment(const QString& preset) {
  if (!session_.Ct()) {
    host_->Say(qKerfHost::Problem, tr("Open a CT first (step 1)."));
    return;
  }
  if (preset.isEmpty() && !session_.Seeds().empty()) {
    host_->Say(qKerfHost::Problem, tr("Seeds need to know the organ: choose the preset Liver or "
                                      "Kidney, or remove the seeds."));
    return;
  }
  struct Result {
    kerf::LabelEdit edit;
    kerf::SegmentationReport report;
  };
  auto result = std::make_shared<Result>();
  kerf::SegmentationRequest request;
  for (const kerf::MarkupPoint& p : session_.Seeds()) {
    const auto kind = p.label == "tumour"       ? kerf::SeedKind::Tumour
                      : p.label == "internal"   ? kerf::SeedKind::Internal
                      : p.label == "background" ? kerf::SeedKind::Background
                                                : kerf::SeedKind::Organ;
    request.seeds.push_back({kind, p.position_mm, p.label});
  }
  request.seeds_source = "your seeds";
  const bool by_itself = preset.isEmpty();
  if (!preset.isEmpty()) request.preset = kerf::ParseOrganPreset(preset.toStdString());
  qKerfJobRunner::Job job;
  job.title = preset.isEmpty() ? tr("Segmenting the organ") : tr("Segmenting the %1").arg(preset);
  job.advice = by_itself
                   ? tr("Choose the preset Liver or Kidney and click once into the organ with "
                        "Seed (key 2), or paint it.")
                   : tr("Place the seeds anew with Seed (key 2), choose another preset, or "
                        "paint the organ.");
  job.work = [ct = *session_.Ct(), labels = session_.Labels().Snapshot(), request, by_itself,
              result](kerf::Progress& progress) {
    const kerf::LabelMap found = by_itself
                                     ? kerf::SegmentStudyCt(ct, progress, &result->report)
                                     : kerf::SegmentCt(ct, request, progress, &result->report);
    result->edit = kerf::CompareLabels(labels, *found.voxels);
  };
  job.done = [this, result, state = session_.LabelsState(), title = job.title] {
    if (LabelsChangedSince(state, title)) return;
    session_.SetSegmentationWarnings(result->report.warnings);
    if (!session_.ApplyEdit("segment " + result->report.preset, result->edit))
      host_->ShowStatus(tr("Segmented: nothing is different from before."));
    session_.LabelListChanged();
    Check();
  };
  host_->Jobs().Run(std::move(job));
}

bool PlanningJobs::LabelsChangedSince(std::uint64_t state, const QString& title) {
  if (session_.LabelsState() == state) return false;
  host_->Say(qKerfHost::Warning,
             tr("%1: the labels were changed meanwhile, so the result was dropped. Try again.")
                 .arg(title));
  return true;
}

void PlanningJobs::RunTool(
    const QString& title, const std::string& undo_name,
    std::function<kerf::LabelVoxels(const kerf::LabelMap&, kerf::Progress&)> tool) {
  if (!session_.Ct()) {
    host_->Say(qKerfHost::Problem, tr("Open a CT first (step 1)."));
    return;
  }
  auto edit = std::make_shared<kerf::LabelEdit>();
  const std::uint64_t state = session_.LabelsState();
  qKerfJobRunner::Job job;
  job.title = title;
  job.work = [labels = session_.Labels().Snapshot(), tool = std::move(tool),
              edit](kerf::Progress& progress) {
    *edit = kerf::CompareLabels(labels, tool(labels, progress));
  };
  job.done = [this, edit, undo_name, state, title] {
    if (LabelsChangedSince(state, title)) return;
    if (!session_.ApplyEdit(undo_name, *edit))
      host_->ShowStatus(tr("%1: nothing was changed.").arg(title));
    if (!session_.Findings().empty()) Check();
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Evolve(int label) {
  if (!session_.Ct()) {
    host_->Say(qKerfHost::Problem, tr("Open a CT first (step 1)."));
    return;
  }
  struct Shared {
    std::mutex mutex;
    kerf::LabelMap contour;  ///< the label alone, as it is now
    std::shared_ptr<const kerf::LabelEdit> edit;
  };
  auto shared = std::make_shared<Shared>();
  const auto look = [shared] {
    const std::lock_guard<std::mutex> lock(shared->mutex);
    return std::pair(shared->contour, shared->edit);
  };
  // Each look at the progress is a look at the contour.
  const QMetaObject::Connection watching =
      connect(&host_->Jobs(), &qKerfJobRunner::Progressed, this, [this, look] {
        const kerf::LabelMap contour = look().first;
        if (contour.voxels) emit ContourMoved(contour);
      });
  const std::uint64_t state = session_.LabelsState();
  const auto finish = [this, watching, look, state] {
    disconnect(watching);
    emit ContourMoved({});
    const auto edit = look().second;
    if (edit && session_.LabelsState() == state) session_.ApplyEdit("snap to edges", *edit);
  };
  qKerfJobRunner::Job job;
  job.title = tr("Active contour (Esc stops it and keeps the result)");
  job.work = [ct = *session_.Ct(), labels = session_.Labels().Snapshot(), label,
              shared](kerf::Progress& progress) {
    kerf::EvolveContour(
        ct, labels, label,
        [&](const kerf::LabelVoxels& voxels) {
          auto mask = std::make_shared<kerf::LabelVoxels>(voxels.size());
          for (std::size_t v = 0; v < mask->size(); ++v) (*mask)[v] = voxels[v] == label;
          auto edit = std::make_shared<const kerf::LabelEdit>(kerf::CompareLabels(labels, voxels));
          const std::lock_guard<std::mutex> lock(shared->mutex);
          shared->contour.grid = labels.grid;
          shared->contour.voxels = std::move(mask);
          shared->edit = std::move(edit);
        },
        progress);
  };
  job.done = finish;
  job.cancelled = finish;
  job.failed = [watching](const QString&) { disconnect(watching); };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::ImportLabels(const QString& path, QWidget* window) {
  if (!session_.Ct()) {
    host_->Say(qKerfHost::Problem, tr("Open the CT of these labels first (step 1)."));
    return;
  }
  struct Result {
    kerf::LabelMap labels;
    QVector<qKerfLabelImportDialog::Row> rows;
  };
  auto result = std::make_shared<Result>();
  qKerfJobRunner::Job job;
  job.title = tr("Reading labels");
  job.advice = tr("Choose a label map (.seg.nrrd, NRRD, NIfTI) that was made on this CT.");
  job.work = [file = path.toStdString(), result](kerf::Progress&) {
    result->labels = kerf::ReadLabelMap(file);
    std::array<std::size_t, 256> counts{};
    for (const std::uint8_t v : *result->labels.voxels) ++counts[v];
    for (int v = 1; v < 256; ++v) {
      if (counts[v] == 0) continue;
      const auto name = result->labels.names.find(v);
      result->rows.push_back(
          {v, name == result->labels.names.end() ? QString() : QString::fromStdString(name->second),
           double(counts[v]) * result->labels.grid.VoxelVolume_mm3() / 1000.0});
    }
    if (result->rows.isEmpty()) throw kerf::InputError(file, "labels", "there is no label in it");
  };
  job.done = [this, result, window] {
    std::map<int, int> roles{{1, 1}, {2, 2}, {3, 3}};
    // Kerf's own numbers need no question.
    if (result->rows.back().value > 3) {
      qKerfLabelImportDialog dialog(result->rows, window);
      if (dialog.exec() != QDialog::Accepted) return;
      roles = dialog.Roles();
    }
    RunTool(tr("Importing labels"), "import labels",
            [result, roles, grid = session_.Ct()->grid](const kerf::LabelMap&,
                                                        kerf::Progress& progress) {
              return kerf::MapLabels(result->labels, roles, grid, progress);
            });
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Check() {
  if (!session_.Ct()) return;
  auto findings = std::make_shared<std::vector<kerf::LabelFinding>>();
  const std::uint64_t state = session_.LabelsState();
  qKerfJobRunner::Job job;
  job.title = tr("Checking the labels");
  job.work = [labels = session_.Labels().Snapshot(), findings](kerf::Progress& progress) {
    *findings = kerf::CheckLabels(labels, progress);
  };
  job.done = [this, findings, state] {
    if (session_.LabelsState() != state) return;
    session_.SetFindings(*findings);
    host_->ShowStatus(findings->empty() ? tr("The labels are in order.")
                                        : QString::fromStdString(findings->front().sentence));
  };
  host_->Jobs().Run(std::move(job));
}

void PlanningJobs::Mesh(int tetrahedra) {
  struct Result {
    std::shared_ptr<const kerf::PlannedCase> planned;
    std::shared_ptr<const kerf::PlanningModel> model;
  };
  auto result = std::make_shared<Result>();
  const std::uint64_t state = session_.LabelsState();
  qKerfJobRunner::Job job;
  job.title = tr("Making the mesh");
  job.advice = tr("Check the labels (step 2), or choose another number of tetrahedra.");
  job.work = [labels = session_.Labels().Snapshot(), tetrahedra, result](kerf::Progress& progress) {
    result->planned = kerf::MeshLabels(labels, tetrahedra, progress);
    result->model = kerf::ModelOf(*result->planned);
  };
  job.done = [this, result, state] {
    planned_ = result->planned;
    session_.SetModel(result->model, state);
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
