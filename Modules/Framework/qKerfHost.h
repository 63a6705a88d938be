#pragma once

#include <QObject>
#include <QString>

class QAction;
class QSettings;
class qKerfJobRunner;

namespace kerf {
class UndoStack;
}

/// What the application offers to its modules. Lives on the GUI thread and is used from there;
/// longer than every module.
class qKerfHost : public QObject {
  Q_OBJECT
 public:
  enum Severity { Info, Warning, Problem };
  Q_ENUM(Severity)

  explicit qKerfHost(QObject* parent = nullptr);
  ~qKerfHost() override;

  /// The one undo/redo stack, shared by all modules; the Edit menu names its next steps.
  virtual kerf::UndoStack& Undo() = 0;
  /// Work that takes longer than 100 ms, with progress and cancel in the status bar.
  virtual qKerfJobRunner& Jobs() = 0;
  /// Keys start with the module's name: "planning/window".
  virtual QSettings& Settings() = 0;

  /// Into the log panel only.
  virtual void Log(Severity severity, const QString& text) = 0;
  /// A sentence that the user has to see: the message bar above the page, and the log. It says what
  /// to do. An empty text closes the bar.
  virtual void Say(Severity severity, const QString& text) = 0;
  /// The status bar, for a moment.
  virtual void ShowStatus(const QString& text, int milliseconds = 5000) = 0;

  /// Case folder that all modules work on; empty when there is none.
  virtual QString CurrentCase() const = 0;
  /// Remembers it among the recent cases and tells the modules by CaseChanged.
  virtual void SetCurrentCase(const QString& folder) = 0;
  /// Brings a module's page to the front. @return false when there is none of this name
  virtual bool ShowModule(const QString& name) = 0;
  /// Name of the page that is shown ("cases" is the case browser).
  virtual QString ShownModule() const = 0;
  /// Lists an action with its shortcut in the settings (where it can be changed) and in the help.
  /// @param id stable key, "planning/paint"; the action's text is what people read
  virtual void AddShortcut(const QString& id, QAction* action) = 0;
  /// A private folder of a module that outlives the run, for autosaved work. It exists.
  virtual QString WorkFolder(const QString& module) const = 0;
  virtual bool IsDark() const = 0;

 signals:
  void CaseChanged(const QString& folder);
  void ModuleShown(const QString& name);
  void ThemeChanged(bool dark);
  void UndoChanged();
};
