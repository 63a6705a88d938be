#include "qKerfPlanningModule.h"

#include <QFileInfo>
#include <QMimeDatabase>

#include "Common/qKerfIcons.h"
#include "qKerfPlanningPage.h"

QIcon qKerfPlanningModule::Icon() const { return qKerfIcon("planning"); }

QWidget* qKerfPlanningModule::CreateWidget(qKerfHost* host, QWidget* parent) {
  page_ = new qKerfPlanningPage(host, parent);
  return page_;
}

bool qKerfPlanningModule::OpenCase(const QString& folder) { return page_->OpenCase(folder); }

bool qKerfPlanningModule::OpenData(const QString& path) {
  // Everything else may be a CT that is damaged or misnamed: reading it says what is wrong.
  if (QFileInfo(path).isFile()) {
    const QString type =
        QMimeDatabase().mimeTypeForFile(path, QMimeDatabase::MatchExtension).name();
    for (const char* other : {"video/", "audio/", "image/"})
      if (type.startsWith(other)) return false;
  }
  page_->OpenCt(path);
  return true;
}

bool qKerfPlanningModule::CanLeaveCase() { return page_->CanLeaveCase(); }

bool qKerfPlanningModule::CanClose() { return page_->CanClose(); }
