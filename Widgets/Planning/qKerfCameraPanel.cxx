#include "Planning/qKerfCameraPanel.h"

#include <QFileDialog>
#include <QFileInfo>
#include <QLabel>
#include <QListWidget>
#include <QPushButton>
#include <QVBoxLayout>

#include "Planning/PanelParts.h"

using namespace kerf_panel;

qKerfCameraPanel::qKerfCameraPanel(QWidget* parent)
    : QWidget(parent), camera_(Value("cameraInfo")), list_(new QListWidget) {
  auto* open = Primary(tr("Open the camera file…"), "openCameraButton");
  place_ = Button(tr("Place landmarks on the organ"), "placeLandmarksButton");
  place_->setCheckable(true);
  remove_ = Button(tr("Remove"), "removeLandmarkButton");
  auto* read = Button(tr("Read from a file…"), "readLandmarksButton");
  list_->setObjectName("landmarkList");
  list_->setMinimumHeight(110);
  // Takes what is left, so that the panel needs no scrolling.
  list_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Ignored);
  auto* row = new QHBoxLayout;
  row->addWidget(remove_);
  row->addWidget(read);
  auto* column = Column(this);
  column->addWidget(Heading(tr("Laparoscope")));
  column->addWidget(open);
  column->addWidget(camera_);
  column->addWidget(Hint(tr("camera.yml, as kerf calibrate writes it.")));
  column->addWidget(Heading(tr("Landmarks")));
  column->addWidget(
      Hint(tr("Spots that are found again on the video: four or more, spread over "
              "the side that the camera sees. Double click renames.")));
  column->addWidget(place_);
  column->addWidget(list_, 1);
  column->addLayout(row);
  connect(open, &QPushButton::clicked, this, [this] {
    const QString path = QFileDialog::getOpenFileName(this, tr("Open a camera file"), {},
                                                      tr("Camera (*.yml *.yaml);;All (*)"));
    if (!path.isEmpty()) emit CameraWanted(path);
  });
  connect(read, &QPushButton::clicked, this, [this] {
    const QString path = QFileDialog::getOpenFileName(this, tr("Read landmarks"), {},
                                                      tr("Landmarks (*.mrk.json *.csv);;All (*)"));
    if (!path.isEmpty()) emit ReadLandmarksWanted(path);
  });
  connect(place_, &QPushButton::toggled, this, [this](bool on) {
    place_->setText(on ? tr("Finish placing") : tr("Place landmarks on the organ"));
    emit PlacingToggled(on);
  });
  connect(remove_, &QPushButton::clicked, this, [this] { emit RemoveWanted(list_->currentRow()); });
  connect(list_, &QListWidget::itemChanged, this,
          [this](QListWidgetItem* item) { emit RenameWanted(list_->row(item), item->text()); });
}

bool qKerfCameraPanel::IsPlacing() const { return place_->isChecked(); }
void qKerfCameraPanel::StopPlacing() { place_->setChecked(false); }

void qKerfCameraPanel::Show(const kerf::PlanningSession& session) {
  if (session.Camera()) {
    const kerf::CameraModel& c = *session.Camera();
    camera_->setText(tr("<b>%1</b><br>%2 × %3 px, focal length %4 px")
                         .arg(QFileInfo(QString::fromStdString(session.CameraPath())).fileName())
                         .arg(c.width)
                         .arg(c.height)
                         .arg(c.fx, 0, 'f', 0));
  } else {
    camera_->setText(tr("No camera yet."));
  }
  const QSignalBlocker blocker(list_);
  const int row = list_->currentRow();
  list_->clear();
  for (const kerf::MarkupPoint& p : session.Landmarks()) {
    auto* item = new QListWidgetItem(QString::fromStdString(p.label), list_);
    item->setFlags(item->flags() | Qt::ItemIsEditable);
  }
  list_->setCurrentRow(std::min(std::max(0, row), list_->count() - 1));
  place_->setEnabled(session.Model() != nullptr);
  remove_->setEnabled(list_->count() > 0);
}
