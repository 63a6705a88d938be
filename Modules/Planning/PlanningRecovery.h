#pragma once

#include <QLockFile>
#include <QObject>
#include <QString>
#include <QStringList>
#include <memory>

#include "Session/PlanningSession.h"

class QTimer;
class qKerfHost;
class qKerfJobRunner;

/// Autosave of unsaved work, and what a crash left. Work that was left lies in files of its own,
/// so that nothing that is done before somebody recovers it writes over it.
class PlanningRecovery : public QObject {
  Q_OBJECT
 public:
  PlanningRecovery(qKerfHost* host, kerf::PlanningSession& session, QObject* parent);
  /// Something changed: saves within seconds, off the GUI thread.
  void Touched();
  /// Saved, or nothing worth keeping any more.
  void Forget();

  /// Is there work that an earlier run left behind? The newest comes first.
  /// @param text says of which CT and when
  bool HasLeftWork(QString* text) const;
  /// Of the work that is offered; empty where there is none.
  QString LeftFile() const { return left_.value(0); }
  /// The offered work is not wanted: its file goes.
  void Discard();
  /// The offered work is in the session: its file goes as soon as the session's own autosave holds
  /// it.
  void Recovered();
  bool IsPending() const;

 private:
  void Save();
  void TakeSlot();
  void GatherLeft();
  qKerfHost* host_;
  kerf::PlanningSession& session_;
  qKerfJobRunner* quiet_;
  QTimer* timer_;
  QString folder_, file_;
  std::unique_ptr<QLockFile> lock_;  ///< a second window keeps its work apart
  QStringList left_, recovered_;
};
