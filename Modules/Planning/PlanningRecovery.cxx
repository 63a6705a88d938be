#include "PlanningRecovery.h"

#include <QCoreApplication>
#include <QDateTime>
#include <QFile>
#include <QFileInfo>
#include <QTimer>

#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Session/PlanningAutosave.h"

namespace {
constexpr int kDelay_ms = 2000;
}

PlanningRecovery::PlanningRecovery(qKerfHost* host, kerf::PlanningSession& session, QObject* parent)
    : QObject(parent),
      host_(host),
      session_(session),
      quiet_(new qKerfJobRunner(this)),
      timer_(new QTimer(this)),
      lock_(host->WorkFolder("planning") + "/lock"),
      file_(host->WorkFolder("planning") + "/autosave.kerfwork") {
  lock_.setStaleLockTime(0);  // a lock goes with its process, not with time
  if (!lock_.tryLock())
    file_ = host->WorkFolder("planning") +
            QStringLiteral("/autosave-%1.kerfwork").arg(QCoreApplication::applicationPid());
  timer_->setSingleShot(true);
  timer_->setInterval(kDelay_ms);
  connect(timer_, &QTimer::timeout, this, &PlanningRecovery::Save);
}

bool PlanningRecovery::IsPending() const { return timer_->isActive() || quiet_->IsBusy(); }

void PlanningRecovery::Touched() {
  // Not restarted by every change: an hour of painting must not be one autosave.
  if (session_.IsDirty() && !timer_->isActive()) timer_->start();
}

void PlanningRecovery::Save() {
  if (!session_.IsDirty() || !session_.Ct()) return;
  if (quiet_->IsBusy()) {
    timer_->start();
    return;
  }
  qKerfJobRunner::Job job;
  job.work = [work = kerf::TakeWork(session_), file = file_.toStdString()](kerf::Progress&) {
    kerf::SaveWork(work, file);
  };
  job.failed = [this](const QString& sentence) {
    host_->Say(qKerfHost::Problem,
               tr("The work could not be saved for a crash: %1. Save the case soon, or make room "
                  "on the disk.")
                   .arg(sentence));
  };
  job.done = [this] {
    // Saved or closed in the meantime: there is nothing to recover.
    if (!session_.IsDirty()) QFile::remove(file_);
  };
  quiet_->Run(std::move(job));
}

void PlanningRecovery::Forget() {
  timer_->stop();
  QFile::remove(file_);
}

bool PlanningRecovery::HasLeftWork(QString* text) const {
  const QFileInfo info(file_);
  if (!info.exists()) return false;
  *text =
      tr("Kerf ended at %1 without saving.").arg(info.lastModified().toString("d MMM, hh:mm:ss"));
  return true;
}
