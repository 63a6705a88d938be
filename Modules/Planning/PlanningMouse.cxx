#include "PlanningMouse.h"

#include <cmath>

#include "Framework/qKerfHost.h"
#include "Geometry/SurfaceTree.h"
#include "Planning/qKerfCameraPanel.h"
#include "Planning/qKerfPlanPanel.h"
#include "Planning/qKerfSegmentPanel.h"
#include "PlanningJobs.h"
#include "PlanningViews.h"
#include "Session/PlanningSlice.h"
#include "Views/qKerfSceneView.h"
#include "Views/qKerfSliceView.h"

using Tool = qKerfSegmentPanel::Tool;

PlanningMouse::PlanningMouse(const On& on, QObject* parent) : QObject(parent), on_(on) {
  connect(on_.segment, &qKerfSegmentPanel::ToolChanged, this, &PlanningMouse::ToolChanged);
  connect(on_.views, &PlanningViews::ToolPressed, this, &PlanningMouse::Pressed);
  connect(on_.views, &PlanningViews::ToolMoved, this, &PlanningMouse::Dragged);
  connect(on_.views, &PlanningViews::ToolReleased, this, &PlanningMouse::Released);
  connect(on_.views->Scene(), &qKerfSceneView::Picked, this, &PlanningMouse::Picked);
}

void PlanningMouse::ToolChanged() {
  const Tool tool = on_.segment->CurrentTool();
  const bool brush = tool == Tool::Paint || tool == Tool::Erase;
  on_.views->SetTool(tool != Tool::Look && on_.session->Ct(), brush ? on_.segment->Radius_mm() : 0);
}

void PlanningMouse::Pressed(int slice, const kerf::Vec3& index) {
  const kerf::GridGeometry& grid = on_.session->Ct()->grid;
  for (int a = 0; a < 3; ++a)
    if (index[a] < -0.5 || index[a] > grid.size[a] - 0.5) {
      on_.host->ShowStatus(tr("There is no CT under the pointer."));
      return;
    }
  const Tool tool = on_.segment->CurrentTool();
  const int label = on_.segment->ActiveLabel();
  if (tool == Tool::Seed) {
    on_.session->AddSeed(on_.segment->SeedKind().toStdString(), grid.WorldFromIndex(index));
  } else if (tool == Tool::Grow) {
    const Eigen::Vector3i seed = index.array().round().cast<int>();
    on_.jobs->RunTool(
        tr("Growing"), "grow",
        [ct = *on_.session->Ct(), label, seed, tolerance = on_.segment->Tolerance_hu()](
            const kerf::LabelMap& labels, kerf::Progress& progress) {
          return kerf::GrowTool(ct, labels, label, seed, tolerance, 150, progress);
        });
  } else if (tool == Tool::Paint || tool == Tool::Erase) {
    stroke_ = kerf::LabelEditor::Brush();
    stroke_.radius_mm = on_.segment->Radius_mm();
    stroke_.flat_axis = on_.segment->IsFlat() ? on_.views->Slices()[slice]->Frame().n_axis : -1;
    stroke_.paint = tool == Tool::Paint ? static_cast<std::uint8_t>(label) : 0;
    stroke_.only_over = tool == Tool::Erase ? label : -1;
    stroking_ = true;
    on_.session->BeginStroke();
    last_dab_ = index;
    on_.session->Dab(stroke_, index);
  }
}

void PlanningMouse::Dragged(int, const kerf::Vec3& index) {
  if (!stroking_) return;
  // Dabs close enough that a quick stroke has no gaps.
  const kerf::Vec3 spacing = on_.session->Ct()->grid.spacing_mm;
  const kerf::Vec3 way = index - last_dab_;
  const double step_mm = std::max(0.5, 0.5 * stroke_.radius_mm);
  const int dabs =
      std::max(1, static_cast<int>(std::ceil(way.cwiseProduct(spacing).norm() / step_mm)));
  for (int d = 1; d <= dabs; ++d) on_.session->Dab(stroke_, last_dab_ + way * (double(d) / dabs));
  last_dab_ = index;
}

void PlanningMouse::Released() {
  if (!stroking_) return;
  stroking_ = false;
  on_.session->EndStroke(stroke_.paint == 0 ? "erase" : "paint");
}

void PlanningMouse::Picked(const kerf::Vec3& origin_mm, const kerf::Vec3& direction) {
  const auto& model = on_.session->Model();
  if (!model) return;
  const auto hit = kerf::SurfaceTree(model->organ_surface).FirstHit({origin_mm, direction});
  if (!hit) {
    on_.host->ShowStatus(tr("There is no organ under the pointer."));
    return;
  }
  if (on_.plan->IsDrawing()) on_.session->AddLinePoint(hit->point);
  if (on_.camera->IsPlacing()) on_.session->AddLandmark(hit->point);
}
