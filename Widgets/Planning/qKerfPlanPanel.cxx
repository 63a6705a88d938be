#include "Planning/qKerfPlanPanel.h"

#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QGridLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

#include "Planning/PanelParts.h"

using namespace kerf_panel;

namespace {

QDoubleSpinBox* Millimetres(const QString& name, double low, double high) {
  auto* spin = new QDoubleSpinBox;
  spin->setObjectName(name);
  spin->setRange(low, high);
  spin->setDecimals(1);
  spin->setSuffix(QStringLiteral(" mm"));
  // A value is one step for undo: when it is finished, not at every key.
  spin->setKeyboardTracking(false);
  return spin;
}

QString Row(const QString& what, const QString& value) {
  return QStringLiteral("<tr><td>%1&nbsp;&nbsp;</td><td align=right><b>%2</b></td></tr>")
      .arg(what, value);
}

}  // namespace

qKerfPlanPanel::qKerfPlanPanel(QWidget* parent) : QWidget(parent) {
  margin_ = Millimetres("marginSpin", 0, 50);
  depth_ = Millimetres("depthSpin", 1, 200);
  draw_ = Primary(tr("Draw the resection line"), "drawLineButton");
  draw_->setCheckable(true);
  clear_ = Button(tr("Remove line"), "clearLineButton");
  from_surface_ = Button(tr("Into the surface"), "directionSurfaceButton");
  from_view_ = Button(tr("Along the view"), "directionViewButton");
  measure_ = Primary(tr("Measure"), "measureButton");
  line_ = Hint({});
  line_->setObjectName("lineText");
  measures_ = Value("measures");
  note_ = Value("measureNote");
  sheet_color_ = new QCheckBox(tr("on the sheet"));
  sheet_color_->setObjectName("sheetColorCheck");
  sheet_color_->setChecked(true);
  organ_color_ = new QCheckBox(tr("on the organ"));
  organ_color_->setObjectName("organColorCheck");
  auto* grid = new QGridLayout;
  grid->addWidget(new QLabel(tr("Safety margin")), 0, 0);
  grid->addWidget(margin_, 0, 1);
  grid->addWidget(new QLabel(tr("Depth of the sheet")), 1, 0);
  grid->addWidget(depth_, 1, 1);
  auto* direction = new QHBoxLayout;
  direction->addWidget(from_surface_);
  direction->addWidget(from_view_);
  auto* column = Column(this);
  column->addLayout(grid);
  auto* line = new QHBoxLayout;
  line->addWidget(draw_, 1);
  line->addWidget(clear_);
  column->addLayout(line);
  column->addWidget(line_);
  column->addWidget(Heading(tr("Direction of the sheet")));
  column->addLayout(direction);
  column->addWidget(measure_);
  column->addWidget(note_);
  column->addWidget(measures_);
  column->addWidget(Heading(tr("Colours: distance to the tumour")));
  auto* colors = new QHBoxLayout;
  colors->addWidget(sheet_color_);
  colors->addWidget(organ_color_);
  column->addLayout(colors);
  column->addStretch(1);
  const auto changed = QOverload<double>::of(&QDoubleSpinBox::valueChanged);
  connect(margin_, changed, this, &qKerfPlanPanel::MarginChanged);
  connect(depth_, changed, this, &qKerfPlanPanel::DepthChanged);
  connect(draw_, &QPushButton::toggled, this, [this](bool on) {
    draw_->setText(on ? tr("Finish the line") : tr("Draw the resection line"));
    emit DrawingToggled(on);
  });
  connect(clear_, &QPushButton::clicked, this, &qKerfPlanPanel::ClearLineWanted);
  connect(from_surface_, &QPushButton::clicked, this, &qKerfPlanPanel::DirectionFromSurfaceWanted);
  connect(from_view_, &QPushButton::clicked, this, &qKerfPlanPanel::DirectionFromViewWanted);
  connect(measure_, &QPushButton::clicked, this, &qKerfPlanPanel::MeasureWanted);
  connect(sheet_color_, &QCheckBox::toggled, this, &qKerfPlanPanel::ColorsToggled);
  connect(organ_color_, &QCheckBox::toggled, this, &qKerfPlanPanel::ColorsToggled);
}

bool qKerfPlanPanel::IsDrawing() const { return draw_->isChecked(); }
void qKerfPlanPanel::StopDrawing() { draw_->setChecked(false); }
bool qKerfPlanPanel::SheetColored() const { return sheet_color_->isChecked(); }
bool qKerfPlanPanel::OrganColored() const { return organ_color_->isChecked(); }

void qKerfPlanPanel::Show(const kerf::PlanningSession& session) {
  const QSignalBlocker a(margin_), b(depth_);
  margin_->setValue(session.Plan().margin_mm);
  depth_->setValue(session.Plan().depth_mm);
  const bool model = session.Model() != nullptr;
  const int points = static_cast<int>(session.Plan().line.rows());
  draw_->setEnabled(model);
  clear_->setEnabled(points > 0);
  measure_->setEnabled(model && points >= 2);
  from_surface_->setEnabled(model && points >= 1);
  from_view_->setEnabled(model && points >= 1);
  line_->setText(points == 0   ? tr("Click points on the organ in the 3-D view, across its whole "
                                      "width.")
                 : points == 1 ? tr("1 point on the organ: click the next one.")
                               : tr("%1 points on the organ").arg(points));
  const auto& m = session.Measures();
  QString rows;
  if (session.WithinMargin_ml() > 0)
    rows +=
        Row(tr("Tissue within the margin"), tr("%1 ml").arg(session.WithinMargin_ml(), 0, 'f', 1));
  if (m && m->divides) {
    rows += Row(tr("Removed"), tr("%1 ml").arg(m->removed_ml, 0, 'f', 1));
    rows +=
        Row(tr("Remnant"),
            tr("%1 ml (%2 %)").arg(m->remnant_ml, 0, 'f', 1).arg(m->remnant_percent, 0, 'f', 0));
    rows += Row(tr("Tumour left behind"), tr("%1 ml").arg(m->tumour_left_ml, 0, 'f', 2));
  }
  if (m && m->to_tumour_mm >= 0)
    rows += Row(tr("Sheet to tumour"), tr("%1 mm").arg(m->to_tumour_mm, 0, 'f', 1));
  if (m && m->to_internal_mm >= 0)
    rows += Row(tr("Sheet to vessels, calyces"), tr("%1 mm").arg(m->to_internal_mm, 0, 'f', 1));
  measures_->setText(rows.isEmpty() ? QString() : "<table cellspacing=2>" + rows + "</table>");
  QString note = m ? QString::fromStdString(m->note) : QString();
  if (m && m->to_internal_mm == 0)
    note += (note.isEmpty() ? "" : " ") + tr("The sheet goes through vessels or calyces.");
  if (m && m->to_tumour_mm >= 0 && !m->margin_kept)
    note += (note.isEmpty() ? "" : " ") +
            tr("The margin of %1 mm is not kept: move the line.").arg(session.Plan().margin_mm);
  note_->setText(note);
  SetRole(note_, "warning");
  note_->setVisible(!note.isEmpty());
}
