#include "qKerfPlanningModule.h"

#include "Common/qKerfIcons.h"
#include "qKerfPlanningPage.h"

QIcon qKerfPlanningModule::Icon() const { return qKerfIcon("planning"); }

QWidget* qKerfPlanningModule::CreateWidget(qKerfHost* host, QWidget* parent) {
  page_ = new qKerfPlanningPage(host, parent);
  return page_;
}

bool qKerfPlanningModule::OpenCase(const QString& folder) { return page_->OpenCase(folder); }

bool qKerfPlanningModule::OpenData(const QString& path) {
  page_->OpenCt(path);
  return true;
}

bool qKerfPlanningModule::CanLeaveCase() { return page_->CanLeaveCase(); }

bool qKerfPlanningModule::CanClose() { return page_->CanClose(); }
