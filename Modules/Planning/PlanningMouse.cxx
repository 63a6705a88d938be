#include "PlanningMouse.h"

#include <cmath>

#include "Framework/qKerfHost.h"
#include "Planning/qKerfCameraPanel.h"
#include "Planning/qKerfPlanPanel.h"
#include "Planning/qKerfSegmentPanel.h"
#include "PlanningJobs.h"
#include "PlanningViews.h"
#include "Session/PlanningSlice.h"
#include "Views/qKerfSceneView.h"
#include "Views/qKerfSliceView.h"

using Tool = qKerfSegmentPanel::Tool;

namespace {

constexpr double kGrab_px = 7;   ///< a point of the line is under the pointer
constexpr double kNear_mm = 15;  ///< the crosshair means a place on the organ

}  // namespace

PlanningMouse::PlanningMouse(const On& on, QObject* parent) : QObject(parent), on_(on) {
  connect(on_.segment, &qKerfSegmentPanel::ToolChanged, this, &PlanningMouse::ToolChanged);
  connect(on_.views, &PlanningViews::ToolPressed, this, &PlanningMouse::Pressed);
  connect(on_.views, &PlanningViews::ToolMoved, this, &PlanningMouse::Dragged);
  connect(on_.views, &PlanningViews::ToolReleased, this, &PlanningMouse::Released);
  connect(on_.views, &PlanningViews::SpotChosen, this, &PlanningMouse::SpotChosen);
  // Where that ends a drag its point is not moved, and not shown as if it were.
  connect(on_.plan, &qKerfPlanPanel::DrawingToggled, this, [this] { on_.views->ShowMoved({}); });
  connect(on_.views->Scene(), &qKerfSceneView::Picked, this, &PlanningMouse::Picked);
  connect(on_.views->Scene(), &qKerfSceneView::Pressed, this, &PlanningMouse::Grabbed);
  connect(on_.views->Scene(), &qKerfSceneView::Dragged, this, &PlanningMouse::Moved);
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

const kerf::SurfaceTree* PlanningMouse::Tree() {
  const auto& model = on_.session->Model();
  if (model != tree_of_) {
    tree_of_ = model;
    tree_ = model ? std::make_unique<kerf::SurfaceTree>(model->organ_surface) : nullptr;
  }
  return tree_.get();
}

void PlanningMouse::Take(const kerf::Vec3& on_organ_mm) {
  if (on_.plan->IsDrawing()) on_.session->AddLinePoint(on_organ_mm);
  if (on_.camera->IsPlacing()) on_.session->AddLandmark(on_organ_mm);
}

void PlanningMouse::Picked(const kerf::Vec3& origin_mm, const kerf::Vec3& direction) {
  if (!Tree()) return;
  if (const auto hit = Tree()->FirstHit({origin_mm, direction}))
    Take(hit->point);
  else
    on_.host->ShowStatus(tr("There is no organ under the pointer."));
}

void PlanningMouse::SpotChosen(const kerf::Vec3& position_mm) {
  if (!Tree() || (!on_.plan->IsDrawing() && !on_.camera->IsPlacing())) return;
  const kerf::SurfaceHit nearest = Tree()->Closest(position_mm);
  if (nearest.distance_mm > kNear_mm)
    on_.host->ShowStatus(tr("The organ's surface is %1 mm away from the crosshair: move it there.")
                             .arg(nearest.distance_mm, 0, 'f', 0));
  else
    Take(nearest.point);
}

void PlanningMouse::Grabbed(const QPointF& at, bool* taken) {
  if (!on_.plan->IsDrawing()) return;
  const kerf::Points& line = on_.session->Plan().line;
  const kerf::Vec3 into = on_.views->Scene()->ViewDirection();
  grabbed_ = -1;
  moved_ = false;
  // Of those under the pointer the one in front.
  for (int p = 0; p < line.rows(); ++p) {
    const QPointF way = on_.views->Scene()->WidgetFromWorld(line.row(p).transpose()) - at;
    if (std::hypot(way.x(), way.y()) > kGrab_px) continue;
    if (grabbed_ < 0 || line.row(p).dot(into) < line.row(grabbed_).dot(into)) grabbed_ = p;
  }
  *taken = grabbed_ >= 0;
}

void PlanningMouse::Moved(const kerf::Vec3& origin_mm, const kerf::Vec3& direction, bool over) {
  const auto hit = Tree() ? Tree()->FirstHit({origin_mm, direction}) : std::nullopt;
  if (hit && !over) {
    moved_ = true;
    on_.views->ShowMoved(hit->point);
  }
  if (!over) return;
  on_.views->ShowMoved({});
  if (hit && moved_) on_.session->MoveLinePoint(grabbed_, hit->point);
  moved_ = false;
}
