#include "Session/PlanningSession.h"

#include <utility>

#include "Session/UndoStack.h"

namespace kerf {

PlanningSession::PlanningSession(UndoStack& undo) : undo_(undo) {}

void PlanningSession::Tell(PlanningChange change) {
  if (listener_) listener_(change);
}

void PlanningSession::Touch(PlanningChange change) {
  dirty_ = true;
  ++changes_;
  Tell(change);
}

void PlanningSession::SetVolume(Volume ct, const std::string& path, const std::string& series,
                                std::vector<std::string> warnings, const CountedLabels* labels) {
  undo_.Clear();
  ct_ = std::move(ct);
  ct_path_ = path;
  series_ = series;
  folder_.clear();
  import_warnings_ = std::move(warnings);
  segmentation_warnings_.clear();
  if (labels)
    editor_.Reset(*labels);
  else
    editor_.Reset(ct_->grid, ct_->source);
  infos_ = StandardLabels();
  seeds_.clear();
  landmarks_.clear();
  findings_.clear();
  labels_state_ = next_state_++;
  findings_state_ = 0;
  model_.reset();
  plan_ = ResectionPlan();
  measures_.reset();
  within_margin_ml_ = 0;
  camera_.reset();
  camera_path_.clear();
  dirty_ = false;
  for (const auto change :
       {PlanningChange::Volume, PlanningChange::LabelList, PlanningChange::Labels,
        PlanningChange::Seeds, PlanningChange::Model, PlanningChange::Plan, PlanningChange::Camera,
        PlanningChange::Landmarks})
    Tell(change);
}

void PlanningSession::PushLabels(const std::string& name, LabelDelta delta) {
  const std::uint64_t before = labels_state_, after = next_state_++;
  labels_state_ = after;
  auto shared = std::make_shared<const LabelDelta>(std::move(delta));
  UndoCommand command;
  command.name = name;
  command.bytes = shared->Bytes();
  command.undo = [this, shared, before] {
    editor_.Apply(*shared, false);
    labels_state_ = before;
    Touch(PlanningChange::Labels);
  };
  command.redo = [this, shared, after] {
    editor_.Apply(*shared, true);
    labels_state_ = after;
    Touch(PlanningChange::Labels);
  };
  undo_.Push(std::move(command));
  Touch(PlanningChange::Labels);
}

bool PlanningSession::ApplyEdit(const std::string& name, const LabelEdit& edit) {
  LabelDelta delta = editor_.Replace(edit);
  if (delta.Empty()) return false;
  PushLabels(name, std::move(delta));
  return true;
}

void PlanningSession::Dab(const LabelEditor::Brush& brush, const Vec3& center_index) {
  editor_.Dab(brush, center_index, ct_ ? &*ct_ : nullptr);
  Tell(PlanningChange::Labels);
}

bool PlanningSession::EndStroke(const std::string& name) {
  LabelDelta delta = editor_.EndStroke();
  if (delta.Empty()) return false;
  PushLabels(name, std::move(delta));
  return true;
}

void PlanningSession::ChangePoints(const std::string& name,
                                   std::vector<MarkupPoint> PlanningSession::*points,
                                   std::vector<MarkupPoint> now, PlanningChange change) {
  const std::vector<MarkupPoint> before = this->*points;
  this->*points = now;
  UndoCommand command;
  command.name = name;
  command.undo = [this, points, before, change] {
    this->*points = before;
    Touch(change);
  };
  command.redo = [this, points, now, change] {
    this->*points = now;
    Touch(change);
  };
  undo_.Push(std::move(command));
  Touch(change);
}

void PlanningSession::AddSeed(const std::string& kind, const Vec3& position_mm) {
  auto now = seeds_;
  now.push_back({kind, position_mm});
  ChangePoints("place " + kind + " seed", &PlanningSession::seeds_, now, PlanningChange::Seeds);
}

void PlanningSession::ClearSeeds() {
  if (!seeds_.empty())
    ChangePoints("remove all seeds", &PlanningSession::seeds_, {}, PlanningChange::Seeds);
}

void PlanningSession::SetFindings(std::vector<LabelFinding> findings) {
  findings_ = std::move(findings);
  findings_state_ = labels_state_;
  Tell(PlanningChange::LabelList);
}

void PlanningSession::SetModel(std::shared_ptr<const PlanningModel> model, std::uint64_t revision) {
  model_ = std::move(model);
  model_revision_ = revision;
  measures_.reset();
  Touch(PlanningChange::Model);
}

void PlanningSession::ChangePlan(const std::string& name, ResectionPlan now) {
  if (now.follows_surface && model_ && now.line.rows() > 0)
    now.direction = SuggestDirection(model_->organ_surface, now.line);
  const ResectionPlan before = plan_;
  const auto set = [this](const ResectionPlan& plan) {
    plan_ = plan;
    measures_.reset();
    Touch(PlanningChange::Plan);
  };
  UndoCommand command;
  command.name = name;
  command.undo = [set, before] { set(before); };
  command.redo = [set, now] { set(now); };
  undo_.Push(std::move(command));
  set(now);
}

void PlanningSession::SetMargin(double margin_mm) {
  if (plan_.margin_mm == margin_mm) return;
  ResectionPlan now = plan_;
  now.margin_mm = margin_mm;
  ChangePlan("change margin", now);
}

void PlanningSession::AddLinePoint(const Vec3& position_mm) {
  ResectionPlan now = plan_;
  now.line.conservativeResize(plan_.line.rows() + 1, 3);
  now.line.row(plan_.line.rows()) = position_mm.transpose();
  ChangePlan("add point to the resection line", now);
}

void PlanningSession::MoveLinePoint(int index, const Vec3& position_mm) {
  if (index < 0 || index >= plan_.line.rows()) return;
  ResectionPlan now = plan_;
  now.line.row(index) = position_mm.transpose();
  ChangePlan("move point of the resection line", now);
}

void PlanningSession::ClearLine() {
  if (plan_.line.rows() == 0) return;
  ResectionPlan now = plan_;
  now.line.resize(0, 3);
  ChangePlan("remove the resection line", now);
}

void PlanningSession::SetDirection(const Vec3& direction) {
  if (direction.norm() < 1e-9 || (plan_.direction - direction.normalized()).norm() < 1e-9) return;
  ResectionPlan now = plan_;
  now.direction = direction.normalized();
  now.follows_surface = false;
  ChangePlan("turn the resection sheet", now);
}

void PlanningSession::FollowSurface() {
  if (plan_.follows_surface) return;
  ResectionPlan now = plan_;
  now.follows_surface = true;
  ChangePlan("turn the resection sheet into the surface", now);
}

void PlanningSession::SetDepth(double depth_mm) {
  if (plan_.depth_mm == depth_mm) return;
  ResectionPlan now = plan_;
  now.depth_mm = depth_mm;
  ChangePlan("change depth of the resection", now);
}

void PlanningSession::SetMeasures(ResectionMeasures measures, double within_margin_ml) {
  measures_ = std::move(measures);
  within_margin_ml_ = within_margin_ml;
  Tell(PlanningChange::Plan);
}

void PlanningSession::SetCamera(const CameraModel& camera, const std::string& path) {
  const auto set = [this](const std::optional<CameraModel>& now, const std::string& from) {
    camera_ = now;
    camera_path_ = from;
    Touch(PlanningChange::Camera);
  };
  UndoCommand command;
  command.name = "open the camera file";
  command.undo = [set, before = camera_, from = camera_path_] { set(before, from); };
  command.redo = [set, camera, path] { set(camera, path); };
  undo_.Push(std::move(command));
  set(camera, path);
}

void PlanningSession::AddLandmark(const Vec3& position_mm, const std::string& name) {
  auto now = landmarks_;
  now.push_back({name.empty() ? "landmark-" + std::to_string(now.size() + 1) : name, position_mm});
  ChangePoints("place landmark", &PlanningSession::landmarks_, now, PlanningChange::Landmarks);
}

void PlanningSession::RenameLandmark(int index, const std::string& name) {
  if (index < 0 || index >= static_cast<int>(landmarks_.size()) || name.empty()) return;
  if (landmarks_[index].label == name) return;
  auto now = landmarks_;
  now[index].label = name;
  ChangePoints("rename landmark", &PlanningSession::landmarks_, now, PlanningChange::Landmarks);
}

void PlanningSession::RemoveLandmark(int index) {
  if (index < 0 || index >= static_cast<int>(landmarks_.size())) return;
  auto now = landmarks_;
  now.erase(now.begin() + index);
  ChangePoints("remove landmark", &PlanningSession::landmarks_, now, PlanningChange::Landmarks);
}

void PlanningSession::SetLandmarks(std::vector<MarkupPoint> landmarks) {
  ChangePoints("read landmarks", &PlanningSession::landmarks_, std::move(landmarks),
               PlanningChange::Landmarks);
}

void PlanningSession::SetSaved(const std::string& folder) {
  folder_ = folder;
  dirty_ = false;
  Tell(PlanningChange::Saved);
}

void PlanningSession::Restore(const CountedLabels& labels, const Restored& rest) {
  undo_.Clear();
  editor_.Reset(labels);
  labels_state_ = next_state_++;
  seeds_ = rest.seeds;
  landmarks_ = rest.landmarks;
  plan_ = rest.plan;
  measures_.reset();
  camera_ = rest.camera;
  camera_path_ = rest.camera_path;
  folder_ = rest.folder;
  dirty_ = rest.dirty;
  for (const auto change : {PlanningChange::Labels, PlanningChange::Seeds, PlanningChange::Plan,
                            PlanningChange::Camera, PlanningChange::Landmarks})
    Tell(change);
}

}  // namespace kerf
