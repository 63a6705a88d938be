#include "PlanningRecovery.h"

#include <QDateTime>
#include <QDir>
#include <QFile>
#include <QFileInfo>
#include <QTimer>

#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Session/PlanningAutosave.h"

namespace {

constexpr int kDelay_ms = 2000, kMostWindows = 100;

/// The first window's files have the plain name.
QString SlotName(int slot) {
  return slot == 0 ? QStringLiteral("autosave") : QStringLiteral("autosave-%1").arg(slot);
}

/// A lock goes with its process, not with time.
std::unique_ptr<QLockFile> LockOf(const QString& folder, const QString& name) {
  auto lock = std::make_unique<QLockFile>(folder + '/' + name + ".lock");
  lock->setStaleLockTime(0);
  return lock->tryLock() ? std::move(lock) : nullptr;
}

}  // namespace

PlanningRecovery::PlanningRecovery(qKerfHost* host, kerf::PlanningSession& session, QObject* parent)
    : QObject(parent),
      host_(host),
      session_(session),
      quiet_(new qKerfJobRunner(this)),
      timer_(new QTimer(this)),
      folder_(host->WorkFolder("planning")) {
  TakeSlot();
  GatherLeft();
  timer_->setSingleShot(true);
  timer_->setInterval(kDelay_ms);
  connect(timer_, &QTimer::timeout, this, &PlanningRecovery::Save);
}

void PlanningRecovery::TakeSlot() {
  for (int slot = 0; slot < kMostWindows && !lock_; ++slot) {
    file_ = folder_ + '/' + SlotName(slot) + ".kerfwork";
    lock_ = LockOf(folder_, SlotName(slot));
  }
}

void PlanningRecovery::GatherLeft() {
  const QDir folder(folder_);
  // An autosave without a window that holds its lock was left by a crash.
  for (const QString& name : folder.entryList({"autosave*.kerfwork"}, QDir::Files, QDir::Name)) {
    const QFileInfo info(folder.filePath(name));
    std::unique_ptr<QLockFile> lock;
    if (info != QFileInfo(file_) && !(lock = LockOf(folder_, info.completeBaseName()))) continue;
    int number = 1;
    const auto left = [&] {
      return folder.filePath(QStringLiteral("left-%1.kerfwork").arg(number));
    };
    while (QFile::exists(left())) ++number;
    QFile::rename(info.filePath(), left());
  }
  // Several windows must not offer the same: the first one does.
  if (file_ != folder.filePath(SlotName(0) + ".kerfwork")) return;
  for (const QString& name : folder.entryList({"left-*.kerfwork"}, QDir::Files, QDir::Time))
    left_ << folder.filePath(name);
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
  job.done = [this, held = recovered_] {
    // Saved or closed in the meantime: there is nothing to recover.
    if (!session_.IsDirty()) QFile::remove(file_);
    // Not what was recovered since this job took its copy.
    for (const QString& file : held) {
      QFile::remove(file);
      recovered_.removeAll(file);
    }
  };
  quiet_->Run(std::move(job));
}

void PlanningRecovery::Forget() {
  timer_->stop();
  QFile::remove(file_);
  for (const QString& file : recovered_) QFile::remove(file);
  recovered_.clear();
}

bool PlanningRecovery::HasLeftWork(QString* text) const {
  if (left_.isEmpty()) return false;
  const QFileInfo info(left_[0]);
  const QString ct =
      QFileInfo(QString::fromStdString(kerf::CtOfWork(left_[0].toStdString()))).fileName();
  const QString when = info.lastModified().toString("d MMM, hh:mm:ss");
  *text = ct.isEmpty() ? tr("Kerf ended at %1 without saving.").arg(when)
                       : tr("Kerf ended at %1 without saving work on %2.").arg(when, ct);
  return true;
}

void PlanningRecovery::Discard() {
  if (!left_.isEmpty()) QFile::remove(left_.takeFirst());
}

void PlanningRecovery::Recovered() {
  if (!left_.isEmpty()) recovered_ << left_.takeFirst();
}
