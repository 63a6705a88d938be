#include "qKerfIntraoperativeModule.h"

#include <QIcon>
#include <QMessageBox>

#include "Common/qKerfIcons.h"
#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"

QIcon qKerfIntraoperativeModule::Icon() const { return qKerfIcon("surgery"); }

QWidget* qKerfIntraoperativeModule::CreateWidget(qKerfHost* host, QWidget* parent) {
  host_ = host;
  qKerfIntraoperativeWidget::Services services;
  services.run = [host](const QString& title, auto work, auto done, auto failed) {
    const auto cancelled = [failed] {
      if (failed) failed(QString());
    };
    host->Jobs().Run({title, std::move(work), std::move(done), failed, cancelled});
  };
  services.say_problem = [host](const QString& text) { host->Say(qKerfHost::Problem, text); };
  services.say = [host](const QString& text) {
    host->Log(qKerfHost::Info, text);
    host->ShowStatus(text);
  };
  services.add_shortcut = [host](const QString& id, QAction* action) {
    host->AddShortcut(id, action);
  };
  page_ = new qKerfIntraoperativeWidget(std::move(services), parent);
  return page_;
}

bool qKerfIntraoperativeModule::SessionRuns(const QString& what_to_do) {
  if (!page_->Desk().Running()) return false;
  host_->Say(qKerfHost::Warning, tr("A session is running: %1").arg(what_to_do));
  return true;
}

bool qKerfIntraoperativeModule::OpenCase(const QString& folder) {
  if (!CanLeaveCase()) return false;
  page_->OpenCase(folder);
  return true;
}

bool qKerfIntraoperativeModule::CanTakeDrop() {
  return !SessionRuns(tr("end it before something else is opened."));
}

bool qKerfIntraoperativeModule::CanLeaveCase() {
  return !SessionRuns(tr("end it before another case is opened."));
}

bool qKerfIntraoperativeModule::CanClose() {
  if (!page_ || !page_->Desk().Running()) return true;
  const auto answer = QMessageBox::question(
      page_, tr("A session is running"),
      tr("The recording is completed before the window closes. End the session?"));
  if (answer != QMessageBox::Yes) return false;
  page_->StopNow();
  return true;
}
