#include "Common/qKerfCaseBrowserWidget.h"

#include <QFileDialog>
#include <QHBoxLayout>
#include <QLabel>
#include <QListWidget>
#include <QPainter>
#include <QPushButton>
#include <QVBoxLayout>
#include <QVariant>

#include "Common/qKerfIcons.h"
#include "Common/qKerfPaths.h"
#include "Common/qKerfTheme.h"
#include "Session/CaseBrowser.h"

namespace {

constexpr int kThumbnailWidth_px = 120, kThumbnailHeight_px = 80;

QIcon ThumbnailOf(const kerf::CaseSummary& summary) {
  QPixmap picture(QString::fromStdString(summary.thumbnail));
  if (!picture.isNull()) {
    picture = picture.scaled(kThumbnailWidth_px, kThumbnailHeight_px, Qt::KeepAspectRatio,
                             Qt::SmoothTransformation);
    QIcon icon(picture);
    icon.addPixmap(picture, QIcon::Selected);  // not tinted
    return icon;
  }
  QPixmap blank(kThumbnailWidth_px, kThumbnailHeight_px);
  blank.fill(qKerfTheme::Current().raised);
  QPainter painter(&blank);
  painter.drawPixmap((kThumbnailWidth_px - 40) / 2, (kThumbnailHeight_px - 40) / 2,
                     qKerfIcon("cases").pixmap(40, 40));
  return QIcon(blank);
}

}  // namespace

qKerfCaseBrowserWidget::qKerfCaseBrowserWidget(QWidget* parent)
    : QWidget(parent), list_(new QListWidget), empty_(new QLabel) {
  setObjectName("caseBrowser");
  auto* title = new QLabel(tr("Cases"));
  title->setProperty("role", "title");
  auto* explain = new QLabel(
      tr("A case is a folder: planned from a CT before surgery, used in the operating room."));
  explain->setProperty("role", "faint");
  explain->setWordWrap(true);
  auto* fresh = new QPushButton(tr("New case from a CT"));
  fresh->setObjectName("newCaseButton");
  fresh->setProperty("primary", true);
  auto* other = new QPushButton(tr("Open a case folder…"));
  open_ = new QPushButton(tr("Open"));
  open_->setObjectName("openCaseButton");
  forget_ = new QPushButton(tr("Take off this list"));
  list_->setObjectName("caseList");
  list_->setIconSize(QSize(kThumbnailWidth_px, kThumbnailHeight_px));
  list_->setSpacing(4);
  empty_->setText(
      tr("No case was opened here yet. Start with “New case from a CT”,\nor drop a CT or a case "
         "folder onto this window."));
  empty_->setAlignment(Qt::AlignCenter);
  empty_->setProperty("role", "faint");

  auto* top = new QHBoxLayout;
  top->addWidget(fresh);
  top->addWidget(other);
  top->addStretch(1);
  auto* bottom = new QHBoxLayout;
  bottom->addStretch(1);
  bottom->addWidget(forget_);
  bottom->addWidget(open_);
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(24, 20, 24, 16);
  column->setSpacing(10);
  column->addWidget(title);
  column->addWidget(explain);
  column->addLayout(top);
  column->addWidget(list_, 1);
  column->addWidget(empty_, 1);
  column->addLayout(bottom);

  connect(fresh, &QPushButton::clicked, this, &qKerfCaseBrowserWidget::NewCaseWanted);
  connect(other, &QPushButton::clicked, this, &qKerfCaseBrowserWidget::ChooseFolder);
  connect(open_, &QPushButton::clicked, this, [this] { emit CaseChosen(Selected()); });
  connect(forget_, &QPushButton::clicked, this, [this] { emit ForgetWanted(Selected()); });
  connect(list_, &QListWidget::itemActivated, this, [this] { emit CaseChosen(Selected()); });
  connect(list_, &QListWidget::currentRowChanged, this, [this](int row) {
    open_->setEnabled(row >= 0);
    forget_->setEnabled(row >= 0);
  });
  SetCases({});
}

QString qKerfCaseBrowserWidget::Selected() const {
  const QListWidgetItem* item = list_->currentItem();
  return item ? item->data(Qt::UserRole).toString() : QString();
}

void qKerfCaseBrowserWidget::SetCases(const QStringList& folders) {
  list_->clear();
  for (const QString& folder : folders) {
    const kerf::CaseSummary s = kerf::SummarizeCase(folder.toStdString());
    const QString second = s.problem.empty()
                               ? QStringLiteral("%1 · %2").arg(QString::fromStdString(s.pseudonym),
                                                               QString::fromStdString(s.state))
                               : tr("cannot be used: %1").arg(QString::fromStdString(s.problem));
    auto* item = new QListWidgetItem(
        ThumbnailOf(s),
        QString::fromStdString(s.name) + '\n' + second + '\n' + qKerfShortPath(folder), list_);
    item->setData(Qt::UserRole, folder);
  }
  list_->setVisible(!folders.isEmpty());
  empty_->setVisible(folders.isEmpty());
  open_->setEnabled(false);
  forget_->setEnabled(false);
  if (!folders.isEmpty()) list_->setCurrentRow(0);
}

void qKerfCaseBrowserWidget::ChooseFolder() {
  const QString folder = QFileDialog::getExistingDirectory(this, tr("Open a case folder"));
  if (!folder.isEmpty()) emit CaseChosen(folder);
}
