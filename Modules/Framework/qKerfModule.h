#pragma once

#include <QIcon>
#include <QString>
#include <QtPlugin>

class QWidget;
class qKerfHost;

/// A module of the application: the root object of a Qt plugin. The plugin's metadata (a JSON file
/// named in Q_PLUGIN_METADATA) holds "name", "title", "version" and "order" (place in the
/// switcher).
///
///     class qKerfPlanningModule : public QObject, public qKerfModule {
///       Q_OBJECT
///       Q_PLUGIN_METADATA(IID kKerfModuleIid FILE "planning.json")
///       Q_INTERFACES(qKerfModule)
///
/// Everything is called on the GUI thread.
class qKerfModule {
 public:
  virtual ~qKerfModule() = default;

  /// Key in settings and on the command line, lower case: "planning".
  virtual QString Name() const = 0;
  /// For people: "Planning".
  virtual QString Title() const = 0;
  virtual QIcon Icon() const = 0;
  /// The module's page. Called once; the parent owns it. `host` outlives it.
  virtual QWidget* CreateWidget(qKerfHost* host, QWidget* parent) = 0;
  /// Shows a case folder. Called only after CreateWidget. Problems are said through
  /// qKerfHost::Say. @return false when the case was not taken
  virtual bool OpenCase(const QString& folder) = 0;
  /// Something that is no case was dropped onto the window: a CT's file or folder. The first module
  /// that takes it shows its page.
  virtual bool OpenData(const QString& path) {
    Q_UNUSED(path);
    return false;
  }
  /// May what is dropped onto the window bring another page to the front? A module whose picture is
  /// needed now says why not.
  virtual bool CanTakeDrop() { return true; }
  /// May another case take the place of what is shown? A module with unsaved work asks here. When
  /// one module says no, the case is opened in none.
  virtual bool CanLeaveCase() { return true; }
  /// May the window close now? A module with unsaved work asks here, and stops its own threads when
  /// the answer is yes.
  virtual bool CanClose() = 0;
};

// A macro, because Q_PLUGIN_METADATA takes no constant. The number is the interface's version: a
// plugin made for another one is refused with its reason.
#define kKerfModuleIid "org.kerf.Module/3"
Q_DECLARE_INTERFACE(qKerfModule, kKerfModuleIid)
