#include "Planning/qKerfSegmentPanel.h"

#include <QButtonGroup>
#include <QCheckBox>
#include <QColorDialog>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QGridLayout>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QSlider>
#include <QSpinBox>
#include <QStackedWidget>
#include <QTableWidget>
#include <QToolButton>
#include <QVBoxLayout>

#include "Common/qKerfIcons.h"
#include "Planning/PanelParts.h"

using namespace kerf_panel;

namespace {

constexpr int kRow_px = 24;

/// A row of the panel: as tall as what is in it, nothing around it.
QHBoxLayout* Row(std::initializer_list<QWidget*> parts, int stretched = -1) {
  auto* row = new QHBoxLayout;
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(4);
  int at = 0;
  for (QWidget* part : parts) row->addWidget(part, at++ == stretched ? 1 : 0);
  return row;
}

/// The label's colour, in a selected row too.
QIcon Swatch(const QColor& color) {
  QPixmap pixmap(16, 16);
  pixmap.fill(color);
  QIcon icon(pixmap);
  icon.addPixmap(pixmap, QIcon::Selected);
  return icon;
}

QPushButton* Compact(const QString& text, const QString& object_name) {
  QPushButton* button = Button(text, object_name);
  button->setProperty("compact", true);
  return button;
}

}  // namespace

// Everything is seen at 1280 × 800 without scrolling: each tool shows its own options alone.
qKerfSegmentPanel::qKerfSegmentPanel(QWidget* parent) : QWidget(parent) {
  auto* column = Column(this);
  column->setContentsMargins(2, 0, 8, 0);
  column->setSpacing(5);
  MakePreset(column);
  MakeLabelList(column);
  MakeTools(column);
  MakeCleaning(column);
  MakeRange(column);
  column->addStretch(1);
}

void qKerfSegmentPanel::MakePreset(QVBoxLayout* column) {
  preset_ = new QComboBox;
  preset_->setObjectName("presetChoice");
  preset_->addItem(tr("The only organ"), "");
  preset_->addItem(tr("Liver"), "liver");
  preset_->addItem(tr("Kidney"), "kidney");
  preset_->setToolTip(
      tr("What is looked for: the one organ that fills this CT, or an organ among "
         "others"));
  segment_ = Primary(tr("Segment"), "segmentButton");
  segment_->setToolTip(tr("Find organ, tumour and inner structures"));
  seeds_ = Hint({});
  seeds_->setObjectName("seedText");
  clear_seeds_ = Compact(tr("Remove seeds"), "clearSeedsButton");
  warnings_ = Value("segmentationWarnings");
  SetRole(warnings_, "warning");
  column->addLayout(Row({Heading(tr("Preset")), preset_, segment_}, 1));
  column->addLayout(Row({seeds_, clear_seeds_}, 0));
  column->addWidget(warnings_);
  connect(segment_, &QPushButton::clicked, this, &qKerfSegmentPanel::SegmentWanted);
  connect(clear_seeds_, &QPushButton::clicked, this, &qKerfSegmentPanel::ClearSeedsWanted);
}

void qKerfSegmentPanel::MakeLabelList(QVBoxLayout* column) {
  labels_ = new QTableWidget(3, 3);
  labels_->setObjectName("labelList");
  labels_->setToolTip(tr("Tools work on the selected label"));
  labels_->horizontalHeader()->hide();
  labels_->verticalHeader()->hide();
  labels_->horizontalHeader()->setSectionResizeMode(1, QHeaderView::Stretch);
  labels_->setColumnWidth(0, 52);
  labels_->setColumnWidth(2, 74);
  labels_->verticalHeader()->setMinimumSectionSize(kRow_px);
  labels_->verticalHeader()->setDefaultSectionSize(kRow_px);
  labels_->setFixedHeight(3 * kRow_px + 2);
  labels_->setSelectionBehavior(QAbstractItemView::SelectRows);
  labels_->setSelectionMode(QAbstractItemView::SingleSelection);
  labels_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  labels_->setShowGrid(false);
  fill_ = new QSlider(Qt::Horizontal);
  fill_->setObjectName("fillSlider");
  fill_->setRange(0, 100);
  fill_->setValue(25);
  fill_->setToolTip(tr("How strongly labels are filled in the slices"));
  auto* import = Compact(tr("Import labels…"), "importLabelsButton");
  import->setToolTip(tr("A finished label map: .seg.nrrd, NRRD, NIfTI"));
  column->addLayout(Row({Heading(tr("Labels")), new QLabel(tr("fill")), fill_, import}, 2));
  column->addWidget(labels_);
  connect(fill_, &QSlider::valueChanged, this, [this](int v) { emit FillChanged(v / 100.0); });
  connect(labels_, &QTableWidget::itemChanged, this, [this](QTableWidgetItem* item) {
    if (!filling_ && item->column() == 0)
      emit VisibilityChanged(item->row() + 1, item->checkState() == Qt::Checked);
  });
  connect(labels_, &QTableWidget::itemActivated, this, [this](QTableWidgetItem* item) {
    const QColor now = labels_->item(item->row(), 0)->data(Qt::UserRole).value<QColor>();
    const QColor color = QColorDialog::getColor(now, this, tr("Colour"));
    if (color.isValid()) emit ColorChanged(item->row() + 1, color);
  });
  connect(import, &QPushButton::clicked, this, [this] {
    const QString path = QFileDialog::getOpenFileName(
        this, tr("Import a label map"), {},
        tr("Label maps (*.seg.nrrd *.nrrd *.nii *.nii.gz *.mha);;All (*)"));
    if (!path.isEmpty()) emit ImportLabelsWanted(path);
  });
}

void qKerfSegmentPanel::MakeTools(QVBoxLayout* column) {
  struct Entry {
    Tool tool;
    const char *icon, *text, *key, *tip;
  };
  const Entry entries[] = {
      {Tool::Look, "cursor", "Look", "1", "Move the crosshair"},
      {Tool::Seed, "seed", "Seed", "2", "Click to tell the preset what is where"},
      {Tool::Paint, "brush", "Paint", "3", "Paint the selected label"},
      {Tool::Erase, "eraser", "Erase", "4", "Erase the selected label"},
      {Tool::Grow, "grow", "Grow", "5", "Click: everything connected of like brightness"}};
  tools_ = new QButtonGroup(this);
  auto* row = new QHBoxLayout;
  row->setSpacing(2);
  for (const Entry& e : entries) {
    auto* button = new QToolButton;
    button->setObjectName(QStringLiteral("tool%1").arg(e.text));
    button->setIcon(qKerfIcon(e.icon));
    button->setIconSize(QSize(22, 22));
    button->setText(tr(e.text));
    button->setToolTip(QStringLiteral("%1 (%2)").arg(tr(e.tip), e.key));
    button->setToolButtonStyle(Qt::ToolButtonTextUnderIcon);
    button->setCheckable(true);
    button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    tools_->addButton(button, static_cast<int>(e.tool));
    row->addWidget(button);
  }
  tools_->button(0)->setChecked(true);
  column->addLayout(row);
  MakeToolOptions(column);
  connect(tools_, &QButtonGroup::idClicked, this, &qKerfSegmentPanel::ShowTool);
}

void qKerfSegmentPanel::MakeToolOptions(QVBoxLayout* column) {
  seed_kind_ = new QComboBox;
  seed_kind_->setObjectName("seedKind");
  seed_kind_->addItem(tr("organ"), "organ");
  seed_kind_->addItem(tr("tumour"), "tumour");
  seed_kind_->addItem(tr("vessel, calyx"), "internal");
  seed_kind_->addItem(tr("background"), "background");
  radius_ = new QSlider(Qt::Horizontal);
  radius_->setObjectName("radiusSlider");
  radius_->setRange(1, 30);
  radius_->setValue(5);
  radius_text_ = new QLabel(tr("5 mm"));
  radius_text_->setMinimumWidth(44);
  sphere_ = new QCheckBox(tr("ball"));
  sphere_->setObjectName("sphereCheck");
  sphere_->setToolTip(tr("Paint in 3-D instead of in this slice only"));
  tolerance_ = new QSpinBox;
  tolerance_->setObjectName("toleranceSpin");
  tolerance_->setRange(1, 500);
  tolerance_->setValue(40);
  tolerance_->setSuffix(tr(" HU"));
  options_ = new QStackedWidget;
  options_->setSizePolicy(QSizePolicy::Preferred, QSizePolicy::Fixed);
  const auto page = [this](QHBoxLayout* row) {
    auto* widget = new QWidget;
    widget->setLayout(row);
    return options_->addWidget(widget);
  };
  const int look = page(Row({Hint(tr("Tools work on the label selected above."))}, 0));
  const int seed = page(Row({new QLabel(tr("The place clicked is")), seed_kind_}, 1));
  const int brush = page(Row({new QLabel(tr("Brush")), radius_, radius_text_, sphere_}, 1));
  const int grow = page(Row({new QLabel(tr("As bright as the place clicked ±")), tolerance_}, 1));
  option_page_ = {look, seed, brush, brush, grow};
  column->addWidget(options_);
  connect(radius_, &QSlider::valueChanged, this, [this](int v) {
    radius_text_->setText(tr("%1 mm").arg(v));
    emit ToolChanged();
  });
}

void qKerfSegmentPanel::ShowTool() {
  options_->setCurrentIndex(option_page_[tools_->checkedId()]);
  emit ToolChanged();
}

void qKerfSegmentPanel::MakeCleaning(QVBoxLayout* column) {
  auto* grid = new QGridLayout;
  grid->setSpacing(4);
  const struct {
    const char *text, *operation, *tip;
  } entries[] = {{"Keep largest", "largest", "Only the largest part of the selected label stays"},
                 {"Remove islands", "islands", "Parts below 1 ml of the selected label go"},
                 {"Fill holes", "holes", "What the selected label encloses becomes part of it"},
                 {"Smooth", "smooth", "Rounds the selected label, with the volume kept"}};
  int at = 0;
  const auto add = [grid, &at](QPushButton* button) {
    grid->addWidget(button, at / 3, at % 3);
    ++at;
  };
  for (const auto& e : entries) {
    auto* button = Compact(tr(e.text), QStringLiteral("clean-%1").arg(e.operation));
    button->setToolTip(tr(e.tip));
    const QString operation = e.operation;
    connect(button, &QPushButton::clicked, this,
            [this, operation] { emit CleanWanted(operation); });
    add(button);
  }
  auto* evolve = Compact(tr("Snap to edges"), "evolveButton");
  evolve->setToolTip(tr(
      "Active contour: the boundary moves onto the CT's edges and is seen moving; Esc stops it"));
  connect(evolve, &QPushButton::clicked, this, &qKerfSegmentPanel::EvolveWanted);
  add(evolve);
  auto* check = Compact(tr("Check labels"), "checkButton");
  check->setToolTip(tr("Holes, islands and labels at the CT's border, each with its repair"));
  add(check);
  column->addWidget(Heading(tr("Correct the selected label")));
  column->addLayout(grid);
  findings_ = Value("findings");
  repair_holes_ = Button(tr("Repair: fill holes"), "repairHoles");
  repair_islands_ = Button(tr("Repair: keep largest"), "repairIslands");
  column->addWidget(findings_);
  column->addLayout(Row({repair_holes_, repair_islands_}));
  connect(check, &QPushButton::clicked, this, &qKerfSegmentPanel::CheckWanted);
  connect(repair_holes_, &QPushButton::clicked, this, [this] { emit CleanWanted("repair-holes"); });
  connect(repair_islands_, &QPushButton::clicked, this,
          [this] { emit CleanWanted("repair-islands"); });
}

void qKerfSegmentPanel::MakeRange(QVBoxLayout* column) {
  low_ = new QSpinBox;
  low_->setObjectName("thresholdLow");
  high_ = new QSpinBox;
  high_->setObjectName("thresholdHigh");
  for (QSpinBox* s : {low_, high_}) s->setRange(-2000, 4000);
  low_->setValue(100);
  high_->setValue(300);
  auto* apply = Compact(tr("Apply"), "thresholdButton");
  apply->setToolTip(
      tr("Everything between becomes the selected label; inner structures are looked "
         "for within the organ only"));
  column->addLayout(Row(
      {Heading(tr("Threshold")), low_, new QLabel(tr("to")), high_, new QLabel(tr("HU")), apply},
      1));
  connect(apply, &QPushButton::clicked, this,
          [this] { emit ThresholdWanted(low_->value(), high_->value()); });

  other_ = new QComboBox;
  other_->setObjectName("booleanOther");
  operation_ = new QComboBox;
  operation_->setObjectName("booleanOperation");
  operation_->addItems({tr("add"), tr("subtract"), tr("only near")});
  for (const kerf::LabelInfo& info : kerf::StandardLabels())
    other_->addItem(QString::fromStdString(info.title).section(',', 0, 0), info.value);
  other_->setCurrentIndex(1);
  reach_ = new QDoubleSpinBox;
  reach_->setObjectName("booleanReach");
  reach_->setRange(0, 50);
  reach_->setDecimals(1);
  reach_->setSuffix(tr(" mm"));
  reach_->setToolTip(tr("The other label is widened by this first"));
  auto* combine = Compact(tr("Apply"), "booleanButton");
  column->addWidget(Heading(tr("Combine it with another label")));
  column->addLayout(Row({operation_, other_, reach_, combine}, 1));
  connect(combine, &QPushButton::clicked, this, [this] {
    emit BooleanWanted(other_->currentData().toInt(), operation_->currentIndex(), reach_->value());
  });
}

qKerfSegmentPanel::Tool qKerfSegmentPanel::CurrentTool() const {
  return static_cast<Tool>(tools_->checkedId());
}

void qKerfSegmentPanel::SetTool(Tool tool) {
  tools_->button(static_cast<int>(tool))->setChecked(true);
  ShowTool();
}

int qKerfSegmentPanel::ActiveLabel() const { return std::max(0, labels_->currentRow()) + 1; }
QString qKerfSegmentPanel::SeedKind() const { return seed_kind_->currentData().toString(); }
double qKerfSegmentPanel::Radius_mm() const { return radius_->value(); }
bool qKerfSegmentPanel::IsFlat() const { return !sphere_->isChecked(); }
double qKerfSegmentPanel::Tolerance_hu() const { return tolerance_->value(); }
QString qKerfSegmentPanel::Preset() const { return preset_->currentData().toString(); }

void qKerfSegmentPanel::Show(const kerf::PlanningSession& session) {
  filling_ = true;
  const int row = std::max(0, labels_->currentRow());
  for (int i = 0; i < 3; ++i) {
    const kerf::LabelInfo& info = session.LabelInfos()[i];
    for (int c = 0; c < 3; ++c)
      if (!labels_->item(i, c)) labels_->setItem(i, c, new QTableWidgetItem);
    QTableWidgetItem* eye = labels_->item(i, 0);
    eye->setFlags(Qt::ItemIsEnabled | Qt::ItemIsSelectable | Qt::ItemIsUserCheckable);
    eye->setCheckState(info.visible ? Qt::Checked : Qt::Unchecked);
    const QColor color(info.color[0], info.color[1], info.color[2]);
    eye->setData(Qt::UserRole, color);
    eye->setIcon(Swatch(color));
    eye->setToolTip(tr("Shown or not (Space); double click or Enter for the colour"));
    labels_->item(i, 1)->setText(QString::fromStdString(info.title));
    labels_->item(i, 2)->setText(
        session.Ct() ? tr("%1 ml").arg(session.Labels().Volume_ml(info.value), 0, 'f', 1)
                     : QString());
    labels_->item(i, 2)->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
  }
  labels_->setCurrentCell(row, 1);
  filling_ = false;

  const int seeds = static_cast<int>(session.Seeds().size());
  seeds_->setText(seeds == 0 ? tr("No seeds. A kidney in an abdomen needs one.")
                             : tr("%n seed(s)", "", seeds).replace("(s)", seeds == 1 ? "" : "s"));
  clear_seeds_->setVisible(seeds > 0);
  segment_->setEnabled(session.Ct().has_value());
  QString warnings;
  for (const std::string& w : session.SegmentationWarnings())
    warnings += (warnings.isEmpty() ? "" : "\n") + QString::fromStdString(w);
  warnings_->setText(warnings);
  warnings_->setVisible(!warnings.isEmpty());

  QString text;
  bool holes = false, islands = false;
  for (const kerf::LabelFinding& f : session.Findings()) {
    text += (text.isEmpty() ? "" : "\n") + QString::fromStdString(f.sentence);
    holes |= f.kind == kerf::LabelFinding::Kind::Holes;
    islands |= f.kind == kerf::LabelFinding::Kind::Islands;
  }
  findings_->setText(text);
  SetRole(findings_, "warning");
  findings_->setVisible(!text.isEmpty());
  repair_holes_->setVisible(holes);
  repair_islands_->setVisible(islands);
}
