#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "CaseIO/Markups.h"
#include "Core/Camera.h"
#include "Session/PlanningLabels.h"
#include "Session/PlanningResection.h"
#include "Session/PlanningTools.h"

namespace kerf {

class UndoStack;

enum class PlanningStep { Import, Segment, Mesh, Plan, Camera, Save };
constexpr int kPlanningSteps = 6;
enum class StepState { ToDo, Done, Problem };

struct StepStatus {
  StepState state = StepState::ToDo;
  std::string sentence;  ///< what is there, or what to do next
};

/// One line of the checklist before saving.
struct ChecklistItem {
  StepState state = StepState::ToDo;
  bool required = false;  ///< without it the case cannot be saved
  std::string text;       ///< with what to do where it is not done
};

/// What changed, for views.
enum class PlanningChange {
  Volume,
  Labels,
  LabelList,
  Seeds,
  Model,
  Plan,
  Camera,
  Landmarks,
  Saved
};

/// The state of planning and everything that changes it, without a toolkit: windows show it and
/// call it, on one thread. Long work happens elsewhere on snapshots (Labels(), shared volumes) and
/// comes back through Set… and Apply…
class PlanningSession {
 public:
  explicit PlanningSession(UndoStack& undo);

  void SetListener(std::function<void(PlanningChange)> listener) {
    listener_ = std::move(listener);
  }

  // Import
  /// Everything that was made from an older CT is forgotten, the undo stack too.
  /// @param path as it was given; @param series of a DICOM folder, may be empty
  /// @param labels on the CT's grid; null for none yet
  void SetVolume(Volume ct, const std::string& path, const std::string& series,
                 std::vector<std::string> warnings, const CountedLabels* labels = nullptr);
  const std::optional<Volume>& Ct() const { return ct_; }
  const std::string& CtPath() const { return ct_path_; }
  const std::string& Series() const { return series_; }
  const std::vector<std::string>& ImportWarnings() const { return import_warnings_; }

  // Segment
  const LabelEditor& Labels() const { return editor_; }
  std::vector<LabelInfo>& LabelInfos() { return infos_; }
  const std::vector<LabelInfo>& LabelInfos() const { return infos_; }
  /// After the caller changed a colour or visibility.
  void LabelListChanged() { Tell(PlanningChange::LabelList); }
  /// The result of a tool as one step that can be undone. @return false when it changed nothing
  bool ApplyEdit(const std::string& name, const LabelEdit& edit);
  void BeginStroke() { editor_.BeginStroke(); }
  void Dab(const LabelEditor::Brush& brush, const Vec3& center_index);
  bool EndStroke(const std::string& name);
  const std::vector<MarkupPoint>& Seeds() const { return seeds_; }
  /// @param kind organ, tumour, internal, background
  void AddSeed(const std::string& kind, const Vec3& position_mm);
  void ClearSeeds();
  void SetFindings(std::vector<LabelFinding> findings);
  const std::vector<LabelFinding>& Findings() const { return findings_; }
  /// Warnings of the last segmentation.
  void SetSegmentationWarnings(std::vector<std::string> w) {
    segmentation_warnings_ = std::move(w);
  }
  const std::vector<std::string>& SegmentationWarnings() const { return segmentation_warnings_; }

  // Mesh
  /// @param revision of the labels that it was made from
  void SetModel(std::shared_ptr<const PlanningModel> model, std::uint64_t revision);
  const std::shared_ptr<const PlanningModel>& Model() const { return model_; }
  /// The labels were changed since.
  bool ModelIsStale() const { return model_ && model_revision_ != LabelsState(); }
  /// Changes with every edit and comes back when the edit is undone.
  std::uint64_t LabelsState() const { return labels_state_; }

  // Plan
  const ResectionPlan& Plan() const { return plan_; }
  void SetMargin(double margin_mm);
  void AddLinePoint(const Vec3& position_mm);
  void MoveLinePoint(int index, const Vec3& position_mm);
  void ClearLine();
  /// A direction of one's own; or the one into the surface, which follows the line.
  void SetDirection(const Vec3& direction);
  void FollowSurface();
  void SetDepth(double depth_mm);
  /// Measures belong to the plan of this moment; they go with its next change.
  void SetMeasures(ResectionMeasures measures, double within_margin_ml);
  const std::optional<ResectionMeasures>& Measures() const { return measures_; }
  double WithinMargin_ml() const { return within_margin_ml_; }

  // Camera and landmarks
  void SetCamera(const CameraModel& camera, const std::string& path);
  const std::optional<CameraModel>& Camera() const { return camera_; }
  const std::string& CameraPath() const { return camera_path_; }
  const std::vector<MarkupPoint>& Landmarks() const { return landmarks_; }
  void AddLandmark(const Vec3& position_mm, const std::string& name = "");
  void RenameLandmark(int index, const std::string& name);
  void RemoveLandmark(int index);
  void SetLandmarks(std::vector<MarkupPoint> landmarks);

  // Check and save
  StepStatus Status(PlanningStep step) const;
  std::vector<ChecklistItem> Checklist() const;
  bool CanSave() const;
  void SetSaved(const std::string& folder);
  const std::string& CaseFolderPath() const { return folder_; }
  /// Is there work that no saved case holds?
  bool IsDirty() const { return dirty_; }
  /// Counts the changes that make it so, undone and done again ones, too.
  std::uint64_t Changes() const { return changes_; }

  /// Everything that an autosave or a saved case restores, in one go. Forgets the undo stack.
  struct Restored {
    std::vector<MarkupPoint> seeds, landmarks;
    ResectionPlan plan;
    std::optional<CameraModel> camera;
    std::string camera_path, folder;
    bool dirty = true;
  };
  void Restore(const CountedLabels& labels, const Restored& rest);

 private:
  void Tell(PlanningChange change);
  void Touch(PlanningChange change);
  void PushLabels(const std::string& name, LabelDelta delta);
  void ChangePlan(const std::string& name, ResectionPlan now);
  void ChangePoints(const std::string& name, std::vector<MarkupPoint> PlanningSession::*points,
                    std::vector<MarkupPoint> now, PlanningChange change);

  UndoStack& undo_;
  std::function<void(PlanningChange)> listener_;
  std::optional<Volume> ct_;
  std::string ct_path_, series_, folder_, camera_path_;
  std::vector<std::string> import_warnings_, segmentation_warnings_;
  LabelEditor editor_;
  std::vector<LabelInfo> infos_ = StandardLabels();
  std::vector<MarkupPoint> seeds_, landmarks_;
  std::vector<LabelFinding> findings_;
  std::uint64_t labels_state_ = 0, next_state_ = 1, model_revision_ = 0, findings_state_ = 0,
                changes_ = 0;
  std::shared_ptr<const PlanningModel> model_;
  ResectionPlan plan_;
  std::optional<ResectionMeasures> measures_;
  double within_margin_ml_ = 0;
  std::optional<CameraModel> camera_;
  bool dirty_ = false;
};

}  // namespace kerf
