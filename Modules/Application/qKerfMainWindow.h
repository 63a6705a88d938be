#pragma once

#include <QMainWindow>
#include <QMap>

#include "Framework/qKerfPluginLoader.h"

class QAction;
class QButtonGroup;
class QDockWidget;
class QLabel;
class QMenu;
class QProgressBar;
class QPushButton;
class QStackedWidget;
class QVBoxLayout;
class qKerfApplicationHost;
class qKerfCaseBrowserWidget;
class qKerfLogPanel;
class qKerfMessageBar;

/// The window: module switcher on the left, the page, one message bar above it, progress with
/// cancel and the notice below.
class qKerfMainWindow : public QMainWindow {
  Q_OBJECT
 public:
  /// @param settings_file empty = the user's; @param plugin_folders see FindKerfPlugins
  qKerfMainWindow(const QString& settings_file, const QStringList& plugin_folders,
                  QWidget* parent = nullptr);
  ~qKerfMainWindow() override;

  qKerfApplicationHost* Host() const { return host_; }
  const QVector<qKerfPlugin>& Plugins() const { return search_.plugins; }
  /// Opens a case folder in every module. Problems are said in the message bar.
  bool OpenCase(const QString& folder);
  /// A case folder, or what a module takes: a CT. As dropping it onto the window does.
  void Open(const QString& path);
  bool ShowPage(const QString& name);
  void SetLogShown(bool shown);

 protected:
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;
  void changeEvent(QEvent* event) override;

 private:
  void MakeMenus();
  void MakeStatusBar();
  void AddPage(const QString& name, const QString& title, const QIcon& icon, QWidget* page);
  void LoadModules(const QStringList& folders);
  void RefreshRecent();
  void RefreshUndo();
  void ShowAbout();
  void ShowSettings();

  qKerfApplicationHost* host_;
  qKerfPluginSearch search_;
  QMap<QString, int> pages_;
  QStackedWidget* stack_;
  QVBoxLayout* switcher_;
  QButtonGroup* buttons_;
  qKerfCaseBrowserWidget* browser_;
  qKerfMessageBar* message_;
  qKerfLogPanel* log_;
  QDockWidget* log_dock_;
  QProgressBar* progress_;
  QLabel* progress_text_;
  QPushButton* cancel_;
  QAction *undo_, *redo_, *dark_, *show_log_, *full_ = nullptr;
  QMenu *recent_, *module_menu_;
  QString problem_;  ///< that was said last, if the last word was one
};
