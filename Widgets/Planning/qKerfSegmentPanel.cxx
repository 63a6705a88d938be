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
#include <QTableWidget>
#include <QToolButton>
#include <QVBoxLayout>

#include "Common/qKerfIcons.h"
#include "Planning/PanelParts.h"

using namespace kerf_panel;

qKerfSegmentPanel::qKerfSegmentPanel(QWidget* parent) : QWidget(parent) {
  auto* column = Column(this);
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
  preset_->addItem(tr("The one organ of this CT"), "");
  preset_->addItem(tr("Liver"), "liver");
  preset_->addItem(tr("Kidney"), "kidney");
  segment_ = Primary(tr("Segment"), "segmentButton");
  segment_->setToolTip(tr("Find organ, tumour and inner structures"));
  seeds_ = Hint({});
  seeds_->setObjectName("seedText");
  clear_seeds_ = Button(tr("Remove seeds"), "clearSeedsButton");
  warnings_ = Value("segmentationWarnings");
  SetRole(warnings_, "warning");
  auto* row = new QHBoxLayout;
  row->addWidget(preset_, 1);
  row->addWidget(segment_);
  auto* second = new QHBoxLayout;
  second->addWidget(seeds_, 1);
  second->addWidget(clear_seeds_);
  column->addWidget(Heading(tr("Preset")));
  column->addLayout(row);
  column->addLayout(second);
  column->addWidget(warnings_);
  connect(segment_, &QPushButton::clicked, this, &qKerfSegmentPanel::SegmentWanted);
  connect(clear_seeds_, &QPushButton::clicked, this, &qKerfSegmentPanel::ClearSeedsWanted);
}

void qKerfSegmentPanel::MakeLabelList(QVBoxLayout* column) {
  labels_ = new QTableWidget(3, 3);
  labels_->setObjectName("labelList");
  labels_->horizontalHeader()->hide();
  labels_->verticalHeader()->hide();
  labels_->horizontalHeader()->setSectionResizeMode(1, QHeaderView::Stretch);
  labels_->setColumnWidth(0, 52);
  labels_->setColumnWidth(2, 74);
  labels_->verticalHeader()->setDefaultSectionSize(26);
  labels_->setFixedHeight(3 * 26 + 2);
  labels_->setSelectionBehavior(QAbstractItemView::SelectRows);
  labels_->setSelectionMode(QAbstractItemView::SingleSelection);
  labels_->setEditTriggers(QAbstractItemView::NoEditTriggers);
  labels_->setShowGrid(false);
  fill_ = new QSlider(Qt::Horizontal);
  fill_->setObjectName("fillSlider");
  fill_->setRange(0, 100);
  fill_->setValue(25);
  fill_->setToolTip(tr("How strongly labels are filled in the slices"));
  column->addWidget(Heading(tr("Labels (the selected one is edited)")));
  column->addWidget(labels_);
  auto* row = new QHBoxLayout;
  row->addWidget(new QLabel(tr("Fill")));
  row->addWidget(fill_, 1);
  auto* import = Button(tr("Import labels…"), "importLabelsButton");
  row->addWidget(import);
  column->addLayout(row);
  connect(fill_, &QSlider::valueChanged, this, [this](int v) { emit FillChanged(v / 100.0); });
  connect(labels_, &QTableWidget::itemChanged, this, [this](QTableWidgetItem* item) {
    if (!filling_ && item->column() == 0)
      emit VisibilityChanged(item->row() + 1, item->checkState() == Qt::Checked);
  });
  connect(labels_, &QTableWidget::itemDoubleClicked, this, [this](QTableWidgetItem* item) {
    const QColor now = labels_->item(item->row(), 0)->data(Qt::DecorationRole).value<QColor>();
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
  column->addWidget(Heading(tr("Tools")));
  column->addLayout(row);

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
  auto* grid = new QGridLayout;
  grid->setVerticalSpacing(4);
  grid->addWidget(new QLabel(tr("Seed is")), 0, 0);
  grid->addWidget(seed_kind_, 0, 1, 1, 3);
  grid->addWidget(new QLabel(tr("Brush")), 1, 0);
  grid->addWidget(radius_, 1, 1);
  grid->addWidget(radius_text_, 1, 2);
  grid->addWidget(sphere_, 1, 3);
  grid->addWidget(new QLabel(tr("Grow within ±")), 2, 0);
  grid->addWidget(tolerance_, 2, 1, 1, 3);
  column->addLayout(grid);
  connect(tools_, &QButtonGroup::idClicked, this, &qKerfSegmentPanel::ToolChanged);
  connect(radius_, &QSlider::valueChanged, this, [this](int v) {
    radius_text_->setText(tr("%1 mm").arg(v));
    emit ToolChanged();
  });
}

void qKerfSegmentPanel::MakeRange(QVBoxLayout* column) {
  low_ = new QSpinBox;
  low_->setObjectName("thresholdLow");
  high_ = new QSpinBox;
  high_->setObjectName("thresholdHigh");
  for (QSpinBox* s : {low_, high_}) s->setRange(-2000, 4000);
  low_->setValue(100);
  high_->setValue(300);
  auto* apply = Button(tr("Apply"), "thresholdButton");
  auto* row = new QHBoxLayout;
  row->addWidget(low_, 1);
  row->addWidget(new QLabel(tr("to")));
  row->addWidget(high_, 1);
  row->addWidget(new QLabel(tr("HU")));
  row->addWidget(apply);
  column->addWidget(Heading(tr("Threshold")));
  column->addLayout(row);
  connect(apply, &QPushButton::clicked, this,
          [this] { emit ThresholdWanted(low_->value(), high_->value()); });

  other_ = new QComboBox;
  other_->setObjectName("booleanOther");
  operation_ = new QComboBox;
  operation_->setObjectName("booleanOperation");
  operation_->addItems({tr("add"), tr("subtract"), tr("keep only near")});
  for (const kerf::LabelInfo& info : kerf::StandardLabels())
    other_->addItem(QString::fromStdString(info.title).section(',', 0, 0), info.value);
  other_->setCurrentIndex(1);
  reach_ = new QDoubleSpinBox;
  reach_->setObjectName("booleanReach");
  reach_->setRange(0, 50);
  reach_->setSuffix(tr(" mm"));
  reach_->setToolTip(tr("The other label is widened by this first"));
  auto* combine = Button(tr("Apply"), "booleanButton");
  auto* grid = new QGridLayout;
  grid->addWidget(operation_, 0, 0);
  grid->addWidget(other_, 0, 1);
  grid->addWidget(reach_, 1, 0);
  grid->addWidget(combine, 1, 1);
  column->addWidget(Heading(tr("Combine the selected label with another")));
  column->addLayout(grid);
  connect(combine, &QPushButton::clicked, this, [this] {
    emit BooleanWanted(other_->currentData().toInt(), operation_->currentIndex(), reach_->value());
  });
}

void qKerfSegmentPanel::MakeCleaning(QVBoxLayout* column) {
  auto* grid = new QGridLayout;
  grid->setSpacing(4);
  const struct {
    const char *text, *operation;
  } entries[] = {{"Keep largest", "largest"},
                 {"Remove islands", "islands"},
                 {"Fill holes", "holes"},
                 {"Smooth", "smooth"}};
  int at = 0;
  for (const auto& e : entries) {
    auto* button = Button(tr(e.text), QStringLiteral("clean-%1").arg(e.operation));
    const QString operation = e.operation;
    connect(button, &QPushButton::clicked, this,
            [this, operation] { emit CleanWanted(operation); });
    grid->addWidget(button, at / 2, at % 2);
    ++at;
  }
  auto* evolve = Button(tr("Snap to edges"), "evolveButton");
  evolve->setToolTip(tr(
      "Active contour: the boundary moves onto the CT's edges and is seen moving; Esc stops it"));
  connect(evolve, &QPushButton::clicked, this, &qKerfSegmentPanel::EvolveWanted);
  grid->addWidget(evolve, 2, 0);
  auto* check = Button(tr("Check labels"), "checkButton");
  check->setToolTip(tr("Holes, islands and labels at the CT's border, each with its repair"));
  grid->addWidget(check, 2, 1);
  column->addWidget(Heading(tr("Correct")));
  column->addLayout(grid);
  findings_ = Value("findings");
  repair_holes_ = Button(tr("Repair: fill holes"), "repairHoles");
  repair_islands_ = Button(tr("Repair: keep largest"), "repairIslands");
  column->addWidget(findings_);
  column->addWidget(repair_holes_);
  column->addWidget(repair_islands_);
  connect(check, &QPushButton::clicked, this, &qKerfSegmentPanel::CheckWanted);
  connect(repair_holes_, &QPushButton::clicked, this, [this] { emit CleanWanted("repair-holes"); });
  connect(repair_islands_, &QPushButton::clicked, this,
          [this] { emit CleanWanted("repair-islands"); });
}

qKerfSegmentPanel::Tool qKerfSegmentPanel::CurrentTool() const {
  return static_cast<Tool>(tools_->checkedId());
}

void qKerfSegmentPanel::SetTool(Tool tool) {
  tools_->button(static_cast<int>(tool))->setChecked(true);
  emit ToolChanged();
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
    eye->setData(Qt::DecorationRole, QColor(info.color[0], info.color[1], info.color[2]));
    eye->setToolTip(tr("Shown or not; double click for the colour"));
    labels_->item(i, 1)->setText(QString::fromStdString(info.title));
    labels_->item(i, 2)->setText(
        session.Ct() ? tr("%1 ml").arg(session.Labels().Volume_ml(info.value), 0, 'f', 1)
                     : QString());
    labels_->item(i, 2)->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
  }
  labels_->setCurrentCell(row, 1);
  filling_ = false;

  const int seeds = static_cast<int>(session.Seeds().size());
  seeds_->setText(seeds == 0 ? tr("No seeds. A kidney in a whole abdomen needs one.")
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
