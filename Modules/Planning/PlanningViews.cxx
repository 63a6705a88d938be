#include "PlanningViews.h"

#include <QGridLayout>
#include <QTimer>
#include <QWidget>

#include "Adapters/Vtk/LabelSurface.h"
#include "Common/qKerfTheme.h"
#include "Framework/qKerfJobRunner.h"
#include "Meshing/LabelField.h"
#include "Views/qKerfSceneView.h"
#include "Views/qKerfSliceView.h"

namespace {

const char* const kNames[4] = {"", "organ", "tumour", "internal"};

const QColor kLineColor("#ff4fa3");

QColor SeedColor(const std::string& kind) {
  if (kind == "organ") return QColor("#ff8f70");
  if (kind == "tumour") return QColor("#f2c94c");
  if (kind == "internal") return QColor("#56a0ec");
  return QColor("#c0c0c0");
}

kerf::Points RowsOf(const std::vector<kerf::MarkupPoint>& points) {
  kerf::Points rows(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = points[i].position_mm.transpose();
  return rows;
}

std::vector<std::string> NamesOf(const std::vector<kerf::MarkupPoint>& points) {
  std::vector<std::string> names;
  for (const auto& p : points) names.push_back(p.label);
  return names;
}

/// Smallest dihedral angle of the tetrahedron behind each boundary triangle.
std::vector<double> QualityOf(const kerf::TetMesh& mesh) {
  std::vector<kerf::Index> tet_of_face;
  kerf::BoundaryFaces(mesh.tets, &tet_of_face);
  std::vector<double> angles;
  for (const kerf::Index t : tet_of_face) {
    const auto corner = [&](int c) -> kerf::Vec3 {
      return mesh.rest.row(mesh.tets(t, c)).transpose();
    };
    angles.push_back(kerf::SmallestDihedral_deg(corner(0), corner(1), corner(2), corner(3)));
  }
  return angles;
}

}  // namespace

PlanningViews::PlanningViews(kerf::PlanningSession& session, QObject* parent)
    : QObject(parent),
      session_(session),
      widget_(new QWidget),
      scene_(new qKerfSceneView),
      grid_(new QGridLayout(widget_)),
      previews_(new qKerfJobRunner(this)) {
  grid_->setContentsMargins(0, 0, 0, 0);
  grid_->setSpacing(2);
  const kerf::SlicePlane planes[3] = {kerf::SlicePlane::Axial, kerf::SlicePlane::Coronal,
                                      kerf::SlicePlane::Sagittal};
  for (int s = 0; s < 3; ++s) {
    qKerfSliceView* view = slices_[s] = new qKerfSliceView(planes[s]);
    connect(view, &qKerfSliceView::CrosshairMoved, this, &PlanningViews::SetCrosshair);
    connect(view, &qKerfSliceView::WindowLevelChanged, this, [this](double w, double l) {
      SetWindowLevel(w, l);
      emit WindowLevelChanged(w, l);
    });
    connect(view, &qKerfSliceView::ToolPressed, this,
            [this, s](const kerf::Vec3& index) { emit ToolPressed(s, index); });
    connect(view, &qKerfSliceView::ToolMoved, this,
            [this, s](const kerf::Vec3& index) { emit ToolMoved(s, index); });
    connect(view, &qKerfSliceView::ToolReleased, this, &PlanningViews::ToolReleased);
    connect(view, &qKerfSliceView::SpotChosen, this, &PlanningViews::SpotChosen);
    connect(view, &qKerfSliceView::WholePageWanted, this, [this, view] { Toggle(view); });
  }
  scene_->SetHint(tr("The organ is shown here\nonce it is segmented."));
  connect(scene_, &qKerfSceneView::WholePageWanted, this, [this] { Toggle(scene_); });
  grid_->addWidget(slices_[0], 0, 0);
  grid_->addWidget(scene_, 0, 1);
  grid_->addWidget(slices_[1], 1, 0);
  grid_->addWidget(slices_[2], 1, 1);
  for (int i = 0; i < 2; ++i) {
    grid_->setRowStretch(i, 1);
    grid_->setColumnStretch(i, 1);
  }
}

void PlanningViews::Toggle(QWidget* view) {
  whole_ = whole_ ? nullptr : view;
  for (QWidget* v : {static_cast<QWidget*>(slices_[0]), static_cast<QWidget*>(slices_[1]),
                     static_cast<QWidget*>(slices_[2]), static_cast<QWidget*>(scene_)})
    v->setVisible(!whole_ || v == whole_);
}

void PlanningViews::ShowVolume() {
  ShowMargin(false);
  const kerf::Volume* ct = session_.Ct() ? &*session_.Ct() : nullptr;
  for (qKerfSliceView* view : slices_) view->SetSources(ct, &session_.Labels().Labels());
  scene_->Clear();
  ShowLabelList();
  ShowMarkers();
}

void PlanningViews::SetCrosshair(const kerf::Vec3& position_mm) {
  for (qKerfSliceView* view : slices_) view->SetCrosshair(position_mm);
}

void PlanningViews::SetWindowLevel(double window_hu, double level_hu) {
  for (qKerfSliceView* view : slices_) view->SetWindowLevel(window_hu, level_hu);
}

void PlanningViews::SetFill(double fill) {
  for (qKerfSliceView* view : slices_) view->SetFill(fill);
}

void PlanningViews::SetTool(bool active, double radius_mm) {
  for (qKerfSliceView* view : slices_) view->SetTool(active, radius_mm);
}

QColor PlanningViews::ColorOf(int label) const {
  for (const kerf::LabelInfo& info : session_.LabelInfos())
    if (info.value == label) return QColor(info.color[0], info.color[1], info.color[2]);
  return Qt::gray;
}

void PlanningViews::ShowLabelList() {
  std::array<std::uint32_t, 256> colors{};
  for (const kerf::LabelInfo& info : session_.LabelInfos())
    if (info.visible) colors[info.value] = ColorOf(info.value).rgba();
  for (qKerfSliceView* view : slices_) view->SetLabelColors(colors);
  preview_state_ = 0;
  ShowLabels();
}

void PlanningViews::ShowLabels() {
  for (qKerfSliceView* view : slices_) view->Refresh();
  // The 3-D preview follows when the hand rests.
  if (preview_waits_) return;
  preview_waits_ = true;
  QTimer::singleShot(400, this, [this] {
    preview_waits_ = false;
    StartPreview();
  });
}

void PlanningViews::StartPreview() {
  // A mesh that belongs to the labels is shown instead.
  if (!session_.Ct() || (session_.Model() && !session_.ModelIsStale())) return;
  const std::uint64_t state = session_.LabelsState();
  if (state == preview_state_) return;
  if (previews_->IsBusy()) {
    ShowLabels();
    return;
  }
  preview_state_ = state;
  auto surfaces = std::make_shared<std::array<kerf::SurfaceMesh, 4>>();
  qKerfJobRunner::Job job;
  job.work = [labels = session_.Labels().Snapshot(), surfaces](kerf::Progress& progress) {
    std::vector<std::uint8_t> mask(labels.voxels->size());
    for (int label = 1; label <= 3; ++label) {
      progress.ThrowIfCancelled();
      // The organ's skin covers what lies in it.
      for (std::size_t v = 0; v < mask.size(); ++v) {
        const std::uint8_t value = (*labels.voxels)[v];
        mask[v] = label == 1 ? value >= 1 && value <= 3 : value == label;
      }
      const kerf::LabelField field = kerf::SmoothMask(labels.grid, mask);
      if (!field.Empty()) (*surfaces)[label] = kerf::SurfaceOfField(field, labels.source, 8000);
    }
  };
  job.done = [this, surfaces] {
    if (session_.Model() && !session_.ModelIsStale()) return;
    for (int label = 1; label <= 3; ++label) {
      const kerf::LabelInfo& info = session_.LabelInfos()[label - 1];
      if (info.visible && !(*surfaces)[label].Empty())
        scene_->SetSurface(kNames[label], (*surfaces)[label], ColorOf(label),
                           label == 1 ? 0.5 : 1.0);
      else
        scene_->Remove(kNames[label]);
    }
  };
  previews_->Run(std::move(job));
}

void PlanningViews::ShowMarkers() {
  QVector<qKerfSliceView::Marker> markers;
  for (const kerf::MarkupPoint& p : session_.Seeds())
    markers.push_back({p.position_mm, SeedColor(p.label), QString::fromStdString(p.label)});
  for (const kerf::MarkupPoint& p : session_.Landmarks())
    markers.push_back({p.position_mm, QColor("#7ee081"), QString::fromStdString(p.label)});
  for (const auto& p : session_.Plan().line.rowwise())
    markers.push_back({p.transpose(), kLineColor, {}});
  for (qKerfSliceView* view : slices_) view->SetMarkers(markers);
  scene_->SetPoints("landmarks", RowsOf(session_.Landmarks()), NamesOf(session_.Landmarks()),
                    QColor("#7ee081"), 1.6);
}

void PlanningViews::ShowModel(bool quality, bool sheet_colored, bool organ_colored) {
  const auto& model = session_.Model();
  for (const char* name : {"organ", "tumour", "internal", "sheet", "line", "points", "margin"})
    scene_->Remove(name);
  if (!model || session_.ModelIsStale()) {
    preview_state_ = 0;
    ShowLabels();
    return;
  }
  const kerf::SurfaceMesh* tumour = model->Find("tumour");
  const std::vector<double>& to_tumour_mm = model->organ_to_tumour_mm;
  const double margin = session_.Plan().margin_mm;
  const auto visible = [this](int label) { return session_.LabelInfos()[label - 1].visible; };
  if (quality)
    scene_->SetColoredSurface("organ", model->organ_surface, QualityOf(model->mesh), 8, 60,
                              tr("degrees"), 1);
  else if (organ_colored && tumour)
    scene_->SetColoredSurface("organ", model->organ_surface, to_tumour_mm, 0,
                              4 * std::max(margin, 5.0), tr("mm"), 1);
  else if (visible(1))
    scene_->SetSurface("organ", model->organ_surface, ColorOf(1), 0.5);
  for (const int label : {2, 3})
    if (const kerf::SurfaceMesh* s = model->Find(kNames[label]))
      if (visible(label)) scene_->SetSurface(kNames[label], *s, ColorOf(label), 1);
  if (tumour && margin > 0)
    scene_->SetIsoline("margin", model->organ_surface, to_tumour_mm, margin, QColor("#ffffff"));
  const kerf::Points& control = session_.Plan().line;
  if (control.rows() > 0) {
    scene_->SetPoints("points", control, {}, kLineColor, 1.4);
    scene_->SetLine("line", kerf::LineOnSurface(model->organ_surface, control), kLineColor, 4);
  }
  const auto& measures = session_.Measures();
  const kerf::CutSurface sheet =
      measures ? measures->sheet : kerf::ResectionSheet(model->organ_surface, session_.Plan());
  if (sheet.triangles.rows() > 0) {
    const kerf::SurfaceMesh mesh{sheet.points, sheet.triangles};
    if (sheet_colored && measures && !measures->sheet_to_tumour_mm.empty())
      scene_->SetColoredSurface("sheet", mesh, measures->sheet_to_tumour_mm, 0,
                                4 * std::max(margin, 5.0), tr("mm"), 0.9);
    else
      scene_->SetSurface("sheet", mesh, kLineColor, 0.45);
  }
}

void PlanningViews::ShowMoved(const std::optional<kerf::Vec3>& point_mm) {
  if (point_mm)
    scene_->SetPoints("moved", point_mm->transpose(), {}, Qt::white, 1.8);
  else
    scene_->Remove("moved");
}

void PlanningViews::ShowContour(const kerf::LabelMap& contour) {
  margin_ = contour;
  for (qKerfSliceView* view : slices_)
    view->SetMask(margin_.voxels ? &margin_ : nullptr, QColor("#7ee081"));
}

void PlanningViews::ShowMargin(bool shown) {
  margin_shown_ = shown && session_.Ct() && session_.Labels().Count(2) > 0;
  if (!margin_shown_) {
    margin_ = kerf::LabelMap();
    for (qKerfSliceView* view : slices_) view->SetMask(nullptr, {});
    return;
  }
  auto mask = std::make_shared<kerf::LabelMap>();
  qKerfJobRunner::Job job;
  job.work = [labels = session_.Labels().Snapshot(), mask,
              margin = session_.Plan().margin_mm](kerf::Progress& progress) {
    mask->grid = labels.grid;
    mask->voxels = std::make_shared<const std::vector<std::uint8_t>>(
        kerf::MarginVoxels(labels, 2, margin, progress));
  };
  job.done = [this, mask] {
    if (!margin_shown_) return;
    margin_ = *mask;
    for (qKerfSliceView* view : slices_) view->SetMask(&margin_, Qt::white);
  };
  previews_->Run(std::move(job));
}
