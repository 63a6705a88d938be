#pragma once

#include <QMap>
#include <QPointer>
#include <QSettings>
#include <QVector>

#include "Framework/qKerfHost.h"
#include "Framework/qKerfJobRunner.h"
#include "Session/UndoStack.h"

class QAction;

/// The host's services; the main window shows what they say.
class qKerfApplicationHost : public qKerfHost {
  Q_OBJECT
 public:
  struct Shortcut {
    QString id;
    QPointer<QAction> action;
    QString standard;  ///< the key it came with
  };

  /// @param settings_file .ini; empty = the user's
  explicit qKerfApplicationHost(const QString& settings_file, QObject* parent = nullptr);

  kerf::UndoStack& Undo() override { return undo_; }
  qKerfJobRunner& Jobs() override { return jobs_; }
  QSettings& Settings() override { return *settings_; }
  void Log(Severity severity, const QString& text) override;
  void Say(Severity severity, const QString& text) override;
  void ShowStatus(const QString& text, int milliseconds) override;
  QString CurrentCase() const override { return case_; }
  void SetCurrentCase(const QString& folder) override;
  bool ShowModule(const QString& name) override;
  QString ShownModule() const override { return shown_; }
  void AddShortcut(const QString& id, QAction* action) override;
  QString WorkFolder(const QString& module) const override;
  bool IsDark() const override;

  void SetDark(bool dark);
  void SetShown(const QString& name);
  const QVector<Shortcut>& Shortcuts() const { return shortcuts_; }
  void SetShortcut(int index, const QString& key);
  QStringList RecentCases() const;
  void ForgetCase(const QString& folder);

 signals:
  void Logged(int severity, const QString& text);
  void Said(int severity, const QString& text);
  void StatusWanted(const QString& text, int milliseconds);
  /// Answered by setting *shown.
  void ModuleWanted(const QString& name, bool* shown);
  void RecentChanged();

 private:
  QSettings* settings_;
  kerf::UndoStack undo_;
  qKerfJobRunner jobs_;
  QString case_, shown_;
  QVector<Shortcut> shortcuts_;
};
