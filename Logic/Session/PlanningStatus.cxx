#include <cstdio>

#include "Session/PlanningSession.h"

/// What the steps and the checklist say.
namespace kerf {
namespace {

std::string Text(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

}  // namespace

StepStatus PlanningSession::Status(PlanningStep step) const {
  switch (step) {
    case PlanningStep::Import:
      if (!ct_) return {StepState::ToDo, "Open a CT: a DICOM folder, NIfTI or NRRD."};
      if (!import_warnings_.empty()) return {StepState::Problem, "Read the warnings; then go on."};
      return {StepState::Done, "The CT is open."};
    case PlanningStep::Segment: {
      if (!ct_) return {StepState::ToDo, "First open a CT."};
      if (editor_.Count(1) == 0)
        return {StepState::ToDo, "Choose a preset, place seeds, press Segment."};
      if (findings_state_ == labels_state_ && !findings_.empty())
        return {StepState::Problem, findings_.front().sentence};
      return {StepState::Done,
              "Organ " + Text("%.0f ml",
                              editor_.Volume_ml(1) + editor_.Volume_ml(2) + editor_.Volume_ml(3))};
    }
    case PlanningStep::Mesh:
      if (editor_.Count(1) == 0) return {StepState::ToDo, "First segment the organ."};
      if (!model_) return {StepState::ToDo, "Press Make the mesh."};
      if (ModelIsStale())
        return {StepState::Problem, "The labels were changed since: make the mesh again."};
      if (!model_->quality.manifold_boundary || model_->quality.smallest_dihedral_deg < 3)
        return {StepState::Problem,
                "The mesh is poor: try another number of tetrahedra, or smooth the labels."};
      return {StepState::Done, std::to_string(model_->quality.tets) + " tetrahedra"};
    case PlanningStep::Plan:
      if (!model_) return {StepState::ToDo, "First make the mesh."};
      if (plan_.line.rows() < 2)
        return {StepState::ToDo, "Draw the resection line on the organ (optional)."};
      if (!measures_) return {StepState::ToDo, "Press Measure."};
      if (!measures_->divides) return {StepState::Problem, measures_->note};
      if (measures_->to_tumour_mm >= 0 && !measures_->margin_kept)
        return {StepState::Problem, "The sheet comes as near as " +
                                        Text("%.1f mm", measures_->to_tumour_mm) +
                                        " to the tumour: less than the margin."};
      return {StepState::Done, "Remnant " + Text("%.0f %%", measures_->remnant_percent)};
    case PlanningStep::Camera:
      if (!model_) return {StepState::ToDo, "First make the mesh."};
      if (!camera_) return {StepState::ToDo, "Open the calibration of the laparoscope."};
      if (landmarks_.empty()) return {StepState::Done, "Camera is there; landmarks are optional."};
      if (landmarks_.size() < 4)
        return {StepState::Problem, "Landmarks are of use from four on: place more."};
      return {StepState::Done, std::to_string(landmarks_.size()) + " landmarks"};
    case PlanningStep::Save:
      if (!folder_.empty() && !dirty_) return {StepState::Done, "The case is saved."};
      if (!CanSave()) return {StepState::ToDo, "Go through the steps above first."};
      return {StepState::ToDo, "Choose a folder and save the case."};
  }
  return {};
}

std::vector<ChecklistItem> PlanningSession::Checklist() const {
  std::vector<ChecklistItem> list;
  const auto add = [&list](bool done, bool required, bool problem, const std::string& text) {
    list.push_back({done      ? StepState::Done
                    : problem ? StepState::Problem
                              : StepState::ToDo,
                    required, text});
  };
  add(ct_.has_value(), true, false, ct_ ? "CT is open" : "Open a CT (step 1)");
  if (ct_ && !import_warnings_.empty())
    add(false, false, true,
        std::to_string(import_warnings_.size()) + " warning(s) about the CT: read them (step 1)");
  const bool organ = editor_.Count(1) > 0;
  add(organ, true, false, organ ? "Organ is segmented" : "Segment the organ (step 2)");
  const bool checked = findings_state_ == labels_state_;
  if (!editor_.Empty())
    add(checked && findings_.empty(), false, checked && !findings_.empty(),
        !checked            ? "Press Check in step 2: holes, islands, border"
        : findings_.empty() ? "Labels have no holes and islands"
                            : findings_.front().sentence);
  const bool mesh_ok = model_ && !ModelIsStale();
  add(mesh_ok, true, model_ && !mesh_ok,
      mesh_ok  ? "Mesh belongs to the labels"
      : model_ ? "The labels were changed: make the mesh again (step 3)"
               : "Make the mesh (step 3)");
  if (model_) {
    const bool inside = model_->farthest_outside_mm <= 2;
    add(inside, false, !inside,
        inside ? "Inner structures lie in the mesh"
               : "Inner structures reach " + Text("%.1f mm", model_->farthest_outside_mm) +
                     " out of the mesh: more tetrahedra (step 3)");
  }
  const bool planned = measures_ && measures_->divides;
  const bool near = planned && measures_->to_tumour_mm >= 0 && !measures_->margin_kept;
  add(planned && !near, false, near,
      near      ? "The planned cut is nearer to the tumour than the margin (step 4)"
      : planned ? "Resection is planned and measured"
                : "No resection is planned (step 4, optional)");
  add(camera_.has_value(), false, false,
      camera_ ? "Camera calibration is there" : "No camera yet (step 5): it can be added later");
  add(landmarks_.size() >= 4, false, !landmarks_.empty() && landmarks_.size() < 4,
      landmarks_.size() >= 4 ? std::to_string(landmarks_.size()) + " landmarks"
      : landmarks_.empty()   ? "No landmarks (step 5, optional)"
                             : "Fewer than four landmarks: place more or remove them (step 5)");
  return list;
}

bool PlanningSession::CanSave() const {
  for (const ChecklistItem& item : Checklist())
    if (item.required && item.state != StepState::Done) return false;
  return true;
}

}  // namespace kerf
