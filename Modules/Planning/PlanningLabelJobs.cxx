// The jobs of PlanningJobs that make and check labels.
#include <array>
#include <map>
#include <mutex>

#include "Adapters/Itk/Segmentation.h"
#include "Adapters/Itk/VolumeFiles.h"
#include "Core/Errors.h"
#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Planning/qKerfLabelImportDialog.h"
#include "PlanningContour.h"
#include "PlanningJobs.h"

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
    kerf::LabelEdit edit;    ///< when the work is over
  };
  auto shared = std::make_shared<Shared>();
  // A look at the progress is a look at the contour; drawn is one that has moved.
  const QMetaObject::Connection watching =
      connect(&host_->Jobs(), &qKerfJobRunner::Progressed, this,
              [this, shared, seen = std::shared_ptr<const kerf::LabelVoxels>()]() mutable {
                std::unique_lock<std::mutex> lock(shared->mutex);
                const kerf::LabelMap contour = shared->contour;
                lock.unlock();
                if (contour.voxels == seen) return;
                seen = contour.voxels;
                emit ContourMoved(contour);
              });
  const std::uint64_t state = session_.LabelsState();
  const auto finish = [this, watching, shared, state] {
    disconnect(watching);
    emit ContourMoved({});
    if (shared->edit.after && session_.LabelsState() == state)
      session_.ApplyEdit("snap to edges", shared->edit);
  };
  qKerfJobRunner::Job job;
  job.title = tr("Active contour (Esc stops it and keeps the result)");
  job.work = [ct = *session_.Ct(), labels = session_.Labels().Snapshot(), label,
              shared](kerf::Progress& progress) {
    kerf::LabelVoxels voxels;
    const auto show = [&] {
      auto mask = std::make_shared<kerf::LabelVoxels>(voxels.size());
      for (std::size_t v = 0; v < mask->size(); ++v) (*mask)[v] = voxels[v] == label;
      const std::lock_guard<std::mutex> lock(shared->mutex);
      shared->contour.grid = labels.grid;
      shared->contour.voxels = std::move(mask);
    };
    // Stopped by hand, it is kept as far as it has come.
    const auto keep = [&] {
      if (!voxels.empty()) shared->edit = kerf::CompareLabels(labels, std::move(voxels));
    };
    try {
      kerf::EvolveContour(ct, labels, label, &voxels, show, progress);
    } catch (const kerf::Cancelled&) {
      keep();
      throw;
    }
    keep();
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
