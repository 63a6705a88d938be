#pragma once

#include <QLockFile>
#include <QObject>
#include <QString>

#include "Session/PlanningSession.h"

class QTimer;
class qKerfHost;
class qKerfJobRunner;

/// Autosave of unsaved work, and what a crash left.
class PlanningRecovery : public QObject {
  Q_OBJECT
 public:
  PlanningRecovery(qKerfHost* host, kerf::PlanningSession& session, QObject* parent);
  /// Something changed: saves within seconds, off the GUI thread.
  void Touched();
  /// Saved, or nothing worth keeping any more.
  void Forget();
  /// Is there work that an earlier run left behind? @param text says which CT and when
  bool HasLeftWork(QString* text) const;
  QString File() const { return file_; }
  bool IsPending() const;

 private:
  void Save();
  qKerfHost* host_;
  kerf::PlanningSession& session_;
  qKerfJobRunner* quiet_;
  QTimer* timer_;
  QLockFile lock_;  ///< a second window keeps its work apart
  QString file_;
};
