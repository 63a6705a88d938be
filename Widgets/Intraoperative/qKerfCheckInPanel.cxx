#include "Intraoperative/qKerfCheckInPanel.h"

#include <QComboBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QPushButton>
#include <QVBoxLayout>

#include "Common/qKerfPaths.h"
#include "Common/qKerfTheme.h"

namespace {

QLabel* Heading(const QString& text) {
  auto* label = new QLabel(text);
  label->setStyleSheet("font-weight: bold; margin-top: 6px;");
  return label;
}

}  // namespace

qKerfCheckInPanel::qKerfCheckInPanel(QWidget* parent) : QWidget(parent) {
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(Heading(tr("Case")));
  case_ = new QLabel(tr("No case is open. Choose one among the cases."));
  case_->setWordWrap(true);
  layout->addWidget(case_);
  confirmed_ = new QLineEdit;
  confirmed_->setObjectName("confirmed");
  confirmed_->setPlaceholderText(tr("Case number on the patient's papers"));
  layout->addWidget(confirmed_);

  layout->addWidget(Heading(tr("Pictures")));
  auto* source_row = new QHBoxLayout;
  source_ = new QLineEdit;
  source_->setObjectName("source");
  source_->setPlaceholderText(tr("Video file, image folder, /dev/video0 or rtsp://…"));
  auto* browse = new QPushButton(tr("File…"));
  source_row->addWidget(source_);
  source_row->addWidget(browse);
  layout->addLayout(source_row);

  layout->addWidget(Heading(tr("Camera file")));
  auto* camera_row = new QHBoxLayout;
  camera_ = new QLineEdit;
  camera_->setObjectName("camera");
  camera_->setPlaceholderText(tr("camera.yml of this laparoscope"));
  auto* browse_camera = new QPushButton(tr("File…"));
  camera_row->addWidget(camera_);
  camera_row->addWidget(browse_camera);
  layout->addLayout(camera_row);

  layout->addWidget(Heading(tr("Check")));
  items_ = new QListWidget;
  items_->setObjectName("checks");
  items_->setWordWrap(true);
  items_->setSelectionMode(QAbstractItemView::NoSelection);
  layout->addWidget(items_, 1);

  auto* recorded_row = new QHBoxLayout;
  recorded_ = new QComboBox;
  recorded_->setObjectName("recorded");
  recorded_->setToolTip(tr("Sessions of this case"));
  play_ = new QPushButton(tr("Play a session"));
  play_->setObjectName("play_recorded");
  recorded_row->addWidget(recorded_, 1);
  recorded_row->addWidget(play_);
  layout->addLayout(recorded_row);
  resume_ = new QPushButton;
  resume_->setObjectName("resume");
  resume_->hide();
  layout->addWidget(resume_);
  go_on_ = new QPushButton(tr("Register the organ"));
  go_on_->setObjectName("register");
  go_on_->setMinimumHeight(44);
  go_on_->setProperty("primary", true);
  go_on_->setEnabled(false);
  layout->addWidget(go_on_);

  connect(confirmed_, &QLineEdit::textChanged, this, &qKerfCheckInPanel::ConfirmedChanged);
  connect(source_, &QLineEdit::returnPressed, this,
          [this] { emit SourceWanted(qKerfLongPath(source_->text())); });
  connect(camera_, &QLineEdit::returnPressed, this,
          [this] { emit CameraWanted(qKerfLongPath(camera_->text())); });
  connect(browse, &QPushButton::clicked, this, [this] {
    const QString path = QFileDialog::getOpenFileName(this, tr("Video"), source_->text());
    if (!path.isEmpty()) emit SourceWanted(path);
  });
  connect(browse_camera, &QPushButton::clicked, this, [this] {
    const QString path = QFileDialog::getOpenFileName(this, tr("Camera file"), camera_->text(),
                                                      tr("Calibration (*.yml *.yaml *.xml)"));
    if (!path.isEmpty()) emit CameraWanted(path);
  });
  connect(go_on_, &QPushButton::clicked, this, &qKerfCheckInPanel::GoOn);
  connect(resume_, &QPushButton::clicked, this, [this] { emit ResumeWanted(resume_session_); });
  connect(play_, &QPushButton::clicked, this,
          [this] { emit PlayWanted(recorded_->currentData().toString()); });
  OfferRecorded({});
}

QString qKerfCheckInPanel::Confirmed() const { return confirmed_->text().trimmed(); }

void qKerfCheckInPanel::SetCase(const QString& folder, const QString& pseudonym) {
  case_->setText(
      tr("<b>%1</b><br>%2").arg(pseudonym.toHtmlEscaped(), qKerfShortPath(folder).toHtmlEscaped()));
  confirmed_->clear();
}

void qKerfCheckInPanel::SetCamera(const QString& file) { camera_->setText(qKerfShortPath(file)); }
void qKerfCheckInPanel::SetSource(const QString& path) { source_->setText(qKerfShortPath(path)); }

void qKerfCheckInPanel::SetItems(const std::vector<kerf::CheckInItem>& items, bool may_go_on) {
  go_on_->setEnabled(may_go_on);
  const bool same = items.size() == shown_.size() &&
                    std::equal(items.begin(), items.end(), shown_.begin(),
                               [](const auto& a, const auto& b) { return a.text == b.text; });
  if (same) return;
  shown_ = items;
  items_->clear();
  for (const kerf::CheckInItem& item : items) {
    using Level = kerf::CheckInItem::Level;
    const QString sign = item.level == Level::Ok        ? QString::fromUtf8("✓")
                         : item.level == Level::Warning ? QString::fromUtf8("⚠")
                                                        : QString::fromUtf8("✗");
    auto* row = new QListWidgetItem(sign + "  " + QString::fromStdString(item.text));
    row->setForeground(item.level == Level::Ok        ? qKerfTheme::Current().good
                       : item.level == Level::Warning ? qKerfTheme::Current().warning
                                                      : qKerfTheme::Current().problem);
    items_->addItem(row);
  }
}

void qKerfCheckInPanel::OfferResume(const std::vector<std::string>& sessions) {
  resume_->setVisible(!sessions.empty());
  if (sessions.empty()) return;
  resume_session_ = QString::fromStdString(sessions.front());
  resume_->setText(
      tr("Session %1 was broken off: take it up again").arg(QFileInfo(resume_session_).fileName()));
}

void qKerfCheckInPanel::OfferRecorded(const std::vector<std::string>& sessions) {
  recorded_->clear();
  for (const std::string& session : sessions) {
    const QString path = QString::fromStdString(session);
    recorded_->addItem(QFileInfo(path).fileName(), path);
  }
  recorded_->setVisible(!sessions.empty());
  play_->setVisible(!sessions.empty());
}
