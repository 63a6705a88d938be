#include "qKerfMainWindow.h"

#include <QAction>
#include <QButtonGroup>
#include <QCloseEvent>
#include <QDir>
#include <QDockWidget>
#include <QDragEnterEvent>
#include <QFileDialog>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QMenuBar>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QPushButton>
#include <QStackedWidget>
#include <QStatusBar>
#include <QToolButton>
#include <QVBoxLayout>
#include <QVariant>

#include "CaseIO/CaseFolder.h"
#include "Common/qKerfCaseBrowserWidget.h"
#include "Common/qKerfIcons.h"
#include "Common/qKerfLogPanel.h"
#include "Common/qKerfMessageBar.h"
#include "Common/qKerfPaths.h"
#include "Framework/qKerfModule.h"
#include "Session/CaseBrowser.h"
#include "qKerfApplicationHost.h"
#include "qKerfSettingsDialog.h"

qKerfMainWindow::qKerfMainWindow(const QString& settings_file, const QStringList& plugin_folders,
                                 QWidget* parent)
    : QMainWindow(parent),
      host_(new qKerfApplicationHost(settings_file, this)),
      stack_(new QStackedWidget),
      switcher_(new QVBoxLayout),
      buttons_(new QButtonGroup(this)),
      browser_(new qKerfCaseBrowserWidget),
      message_(new qKerfMessageBar),
      log_(new qKerfLogPanel),
      log_dock_(new QDockWidget(tr("Log"))) {
  setObjectName("mainWindow");
  setAcceptDrops(true);
  host_->SetDark(host_->IsDark());

  auto* bar = new QWidget;
  bar->setFixedWidth(84);
  switcher_->setContentsMargins(0, 6, 0, 6);
  switcher_->setSpacing(2);
  switcher_->addStretch(1);
  bar->setLayout(switcher_);
  auto* right = new QVBoxLayout;
  right->setContentsMargins(0, 0, 0, 0);
  right->setSpacing(0);
  right->addWidget(message_);
  right->addWidget(stack_, 1);
  auto* central = new QWidget;
  auto* row = new QHBoxLayout(central);
  row->setContentsMargins(0, 0, 0, 0);
  row->setSpacing(0);
  row->addWidget(bar);
  row->addLayout(right, 1);
  setCentralWidget(central);

  log_dock_->setObjectName("logDock");
  log_dock_->setWidget(log_);
  addDockWidget(Qt::BottomDockWidgetArea, log_dock_);
  log_dock_->hide();
  connect(host_, &qKerfApplicationHost::Logged, this, [this](int severity, const QString& text) {
    log_->Add(static_cast<qKerfLogPanel::Level>(severity), text);
  });
  connect(host_, &qKerfApplicationHost::Said, this, [this](int severity, const QString& text) {
    message_->Show(static_cast<qKerfMessageBar::Level>(severity), text);
    problem_ = severity == qKerfHost::Problem ? text : QString();
  });

  MakeMenus();
  MakeStatusBar();
  buttons_->setExclusive(true);
  AddPage("cases", tr("Cases"), qKerfIcon("cases"), browser_);
  connect(browser_, &qKerfCaseBrowserWidget::CaseChosen, this, &qKerfMainWindow::OpenCase);
  connect(browser_, &qKerfCaseBrowserWidget::NewCaseWanted, this, [this] { ShowPage("planning"); });
  connect(browser_, &qKerfCaseBrowserWidget::ForgetWanted, host_,
          &qKerfApplicationHost::ForgetCase);
  connect(host_, &qKerfApplicationHost::RecentChanged, this, &qKerfMainWindow::RefreshRecent);
  connect(host_, &qKerfApplicationHost::UndoChanged, this, &qKerfMainWindow::RefreshUndo);
  connect(host_, &qKerfApplicationHost::ModuleWanted, this,
          [this](const QString& name, bool* shown) { *shown = ShowPage(name); });
  connect(host_, &qKerfApplicationHost::CaseChanged, this, [this](const QString& folder) {
    setWindowTitle(folder.isEmpty() ? tr("Kerf") : tr("%1 – Kerf").arg(QDir(folder).dirName()));
  });
  LoadModules(plugin_folders);
  RefreshRecent();
  RefreshUndo();
  ShowPage("cases");
  setWindowTitle(tr("Kerf"));
  resize(1280, 800);
  restoreGeometry(host_->Settings().value("application/geometry").toByteArray());
  host_->Log(
      qKerfHost::Info,
      tr("Kerf %1. Research use only, not a medical device.").arg(QStringLiteral(KERF_VERSION)));
}

qKerfMainWindow::~qKerfMainWindow() {
  // The pages go while the host that they know is still there.
  host_->Jobs().Cancel();
  delete takeCentralWidget();
}

void qKerfMainWindow::MakeMenus() {
  QMenu* file = menuBar()->addMenu(tr("&File"));
  QAction* open = file->addAction(tr("&Open case…"));
  open->setShortcut(QKeySequence::Open);
  connect(open, &QAction::triggered, this, [this] {
    const QString folder = QFileDialog::getExistingDirectory(this, tr("Open a case folder"));
    if (!folder.isEmpty()) OpenCase(folder);
  });
  recent_ = file->addMenu(tr("&Recent cases"));
  file->addSeparator();
  QAction* quit = file->addAction(tr("&Quit"));
  quit->setShortcut(QKeySequence("Ctrl+Q"));
  connect(quit, &QAction::triggered, this, &QWidget::close);

  QMenu* edit = menuBar()->addMenu(tr("&Edit"));
  undo_ = edit->addAction(tr("&Undo"));
  undo_->setObjectName("undoAction");
  undo_->setShortcut(QKeySequence("Ctrl+Z"));
  redo_ = edit->addAction(tr("&Redo"));
  redo_->setObjectName("redoAction");
  redo_->setShortcut(QKeySequence("Ctrl+Shift+Z"));
  connect(undo_, &QAction::triggered, this, [this] {
    const QString name = QString::fromStdString(host_->Undo().UndoName());
    if (host_->Undo().Undo()) host_->ShowStatus(tr("Undone: %1").arg(name), 4000);
  });
  connect(redo_, &QAction::triggered, this, [this] {
    const QString name = QString::fromStdString(host_->Undo().RedoName());
    if (host_->Undo().Redo()) host_->ShowStatus(tr("Done again: %1").arg(name), 4000);
  });
  edit->addSeparator();
  QAction* settings = edit->addAction(tr("&Settings…"));
  settings->setShortcut(QKeySequence("Ctrl+,"));
  connect(settings, &QAction::triggered, this, &qKerfMainWindow::ShowSettings);

  QMenu* view = menuBar()->addMenu(tr("&View"));
  module_menu_ = view->addMenu(tr("&Module"));
  show_log_ = view->addAction(tr("&Log"));
  show_log_->setCheckable(true);
  show_log_->setShortcut(QKeySequence("Ctrl+L"));
  connect(show_log_, &QAction::toggled, log_dock_, &QWidget::setVisible);
  connect(log_dock_, &QDockWidget::visibilityChanged, this, [this] {
    const QSignalBlocker blocker(show_log_);
    show_log_->setChecked(!log_dock_->isHidden());
  });
  dark_ = view->addAction(tr("&Dark theme"));
  dark_->setObjectName("darkAction");
  dark_->setCheckable(true);
  dark_->setChecked(host_->IsDark());
  dark_->setShortcut(QKeySequence("Ctrl+D"));
  connect(dark_, &QAction::toggled, host_, &qKerfApplicationHost::SetDark);
  full_ = view->addAction(tr("&Full screen"));
  full_->setObjectName("fullScreenAction");
  full_->setCheckable(true);
  full_->setShortcut(QKeySequence("F11"));
  // A window that was maximized is so again afterwards.
  connect(full_, &QAction::triggered, this, [this](bool on) {
    setWindowState(on ? windowState() | Qt::WindowFullScreen
                      : windowState() & ~Qt::WindowFullScreen);
  });

  QMenu* help = menuBar()->addMenu(tr("&Help"));
  QAction* shortcuts = help->addAction(tr("&Keyboard shortcuts"));
  shortcuts->setShortcut(QKeySequence("F1"));
  connect(shortcuts, &QAction::triggered, this, &qKerfMainWindow::ShowSettings);
  connect(help->addAction(tr("&About Kerf")), &QAction::triggered, this,
          &qKerfMainWindow::ShowAbout);

  host_->AddShortcut("application/open", open);
  host_->AddShortcut("application/undo", undo_);
  host_->AddShortcut("application/redo", redo_);
  host_->AddShortcut("application/log", show_log_);
  host_->AddShortcut("application/dark", dark_);
  host_->AddShortcut("application/full-screen", full_);
}

void qKerfMainWindow::MakeStatusBar() {
  progress_ = new QProgressBar;
  progress_->setObjectName("jobProgress");
  progress_->setFixedWidth(180);
  progress_text_ = new QLabel;
  progress_text_->setObjectName("jobText");
  cancel_ = new QPushButton(tr("Cancel"));
  cancel_->setObjectName("jobCancel");
  cancel_->setToolTip(tr("Stop what is running (Esc)"));
  auto* notice = new QLabel(tr("Research use only – not a medical device"));
  notice->setProperty("role", "faint");
  statusBar()->addPermanentWidget(progress_text_);
  statusBar()->addPermanentWidget(progress_);
  statusBar()->addPermanentWidget(cancel_);
  statusBar()->addPermanentWidget(notice);
  const auto show = [this](bool shown) {
    progress_->setVisible(shown);
    progress_text_->setVisible(shown);
    cancel_->setVisible(shown);
  };
  show(false);
  qKerfJobRunner* jobs = &host_->Jobs();
  connect(jobs, &qKerfJobRunner::Started, this, [this, show](const QString& title) {
    // What went wrong before does not stand over new work.
    if (!problem_.isEmpty() && message_->Text() == problem_) message_->Close();
    problem_.clear();
    progress_->setRange(0, 0);
    progress_text_->setText(title);
    cancel_->setEnabled(true);
    cancel_->setText(tr("Cancel"));
    show(true);
  });
  connect(jobs, &qKerfJobRunner::Progressed, this, [this](double fraction, const QString& what) {
    progress_->setRange(0, 100);
    progress_->setValue(static_cast<int>(100.0 * fraction));
    const QString text = host_->Jobs().Title() + (what.isEmpty() ? QString() : ": " + what);
    progress_text_->setText(text.size() > 70 ? text.left(68) + QStringLiteral("…") : text);
  });
  connect(jobs, &qKerfJobRunner::Finished, this, [show] { show(false); });
  const auto stop = [this] {
    cancel_->setEnabled(false);
    cancel_->setText(tr("Stopping…"));
    host_->Jobs().Cancel();
  };
  connect(cancel_, &QPushButton::clicked, this, stop);
  auto* escape = new QAction(tr("Cancel what is running"), this);
  escape->setShortcut(QKeySequence("Esc"));
  connect(escape, &QAction::triggered, this, [this, stop] {
    if (host_->Jobs().IsBusy()) stop();
  });
  addAction(escape);
  host_->AddShortcut("application/cancel", escape);
  connect(host_, &qKerfApplicationHost::StatusWanted, this,
          [this](const QString& text, int ms) { statusBar()->showMessage(text, ms); });
}

void qKerfMainWindow::AddPage(const QString& name, const QString& title, const QIcon& icon,
                              QWidget* page) {
  const int index = stack_->addWidget(page);
  pages_[name] = index;
  auto* button = new QToolButton;
  button->setObjectName("moduleButton");
  button->setProperty("module", name);
  button->setToolButtonStyle(Qt::ToolButtonTextUnderIcon);
  button->setIcon(icon);
  button->setIconSize(QSize(28, 28));
  button->setText(title);
  button->setCheckable(true);
  button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  buttons_->addButton(button, index);
  switcher_->insertWidget(index, button);
  QAction* action = module_menu_->addAction(title);
  action->setShortcut(QKeySequence(QStringLiteral("Ctrl+%1").arg(index + 1)));
  connect(action, &QAction::triggered, this, [this, name] { ShowPage(name); });
  connect(button, &QToolButton::clicked, this, [this, name] { ShowPage(name); });
  host_->AddShortcut("application/show-" + name, action);
}

void qKerfMainWindow::LoadModules(const QStringList& folders) {
  search_ = FindKerfPlugins(folders);
  for (const qKerfPlugin& plugin : search_.plugins) {
    AddPage(plugin.name, plugin.title, plugin.module->Icon(),
            plugin.module->CreateWidget(host_, stack_));
    host_->Log(qKerfHost::Info, tr("Module %1 %2").arg(plugin.title, plugin.version));
  }
  for (const auto& refused : search_.refused) {
    host_->Log(qKerfHost::Warning,
               tr("%1 was not loaded: %2").arg(QDir(refused.path).dirName(), refused.why));
  }
  if (search_.plugins.isEmpty()) {
    host_->Say(qKerfHost::Problem,
               tr("No module was found in %1. Install Kerf again, or name the folder with the "
                  "modules in KERF_PLUGIN_PATH.")
                   .arg(folders.join(tr(" or "))));
  }
}

bool qKerfMainWindow::ShowPage(const QString& name) {
  const auto page = pages_.constFind(name);
  if (page == pages_.constEnd()) return false;
  stack_->setCurrentIndex(*page);
  buttons_->button(*page)->setChecked(true);
  if (host_->ShownModule() != name) host_->SetShown(name);
  return true;
}

bool qKerfMainWindow::OpenCase(const QString& folder) {
  const kerf::CaseSummary summary = kerf::SummarizeCase(folder.toStdString());
  if (!summary.problem.empty()) {
    host_->Say(qKerfHost::Problem,
               tr("This case cannot be opened: %1").arg(QString::fromStdString(summary.problem)));
    return false;
  }
  for (const qKerfPlugin& plugin : search_.plugins)
    if (!plugin.module->CanLeaveCase()) return false;
  host_->Say(qKerfHost::Info, QString());
  host_->SetCurrentCase(QString::fromStdString(summary.folder));
  for (const qKerfPlugin& plugin : search_.plugins)
    plugin.module->OpenCase(QString::fromStdString(summary.folder));
  if (host_->ShownModule() == "cases") ShowPage("planning");
  return true;
}

void qKerfMainWindow::Open(const QString& path) {
  for (const qKerfPlugin& plugin : search_.plugins)
    if (!plugin.module->CanTakeDrop()) return;
  // A case that cannot be used is one, too: OpenCase says what is wrong with it.
  if (QFileInfo(path + "/case.json").exists() &&
      kerf::FolderFormat(path.toStdString()) != "kerf-study") {
    OpenCase(path);
    return;
  }
  for (const qKerfPlugin& plugin : search_.plugins)
    if (plugin.module->OpenData(path)) return;
  host_->Say(qKerfHost::Problem,
             tr("%1 is neither a case nor a CT: drop the folder of a case, or a "
                "CT as a DICOM folder, NIfTI or NRRD.")
                 .arg(QFileInfo(path).fileName()));
}

void qKerfMainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void qKerfMainWindow::dropEvent(QDropEvent* event) {
  const QList<QUrl> urls = event->mimeData()->urls();
  if (urls.isEmpty() || !urls[0].isLocalFile()) {
    host_->Say(qKerfHost::Problem, tr("Only files and folders of this machine can be opened: save "
                                      "it first, then drop it."));
    return;
  }
  event->acceptProposedAction();
  Open(urls[0].toLocalFile());
}

void qKerfMainWindow::SetLogShown(bool shown) { show_log_->setChecked(shown); }

void qKerfMainWindow::RefreshRecent() {
  const QStringList cases = host_->RecentCases();
  browser_->SetCases(cases);
  recent_->clear();
  for (const QString& folder : cases)
    connect(recent_->addAction(qKerfShortPath(folder)), &QAction::triggered, this,
            [this, folder] { OpenCase(folder); });
  recent_->setEnabled(!cases.isEmpty());
}

void qKerfMainWindow::RefreshUndo() {
  const kerf::UndoStack& stack = host_->Undo();
  const auto set = [](QAction* action, bool can, const QString& verb, const std::string& name) {
    action->setEnabled(can);
    action->setText(can ? verb + ": " + QString::fromStdString(name) : verb);
  };
  set(undo_, stack.CanUndo(), tr("&Undo"), stack.UndoName());
  set(redo_, stack.CanRedo(), tr("&Redo"), stack.RedoName());
}

void qKerfMainWindow::ShowSettings() {
  qKerfSettingsDialog dialog(host_, this);
  dialog.exec();
  const QSignalBlocker blocker(dark_);
  dark_->setChecked(host_->IsDark());
}

void qKerfMainWindow::ShowAbout() {
  QString modules;
  for (const qKerfPlugin& plugin : search_.plugins)
    modules += QStringLiteral("<br>%1 %2").arg(plugin.title, plugin.version);
  QMessageBox::about(
      this, tr("About Kerf"),
      tr("<h3>Kerf %1</h3><p>Surgical augmented reality that survives the cut.</p>"
         "<p><b>Research use only. Kerf is not a medical device and must not guide treatment.</b>"
         "</p><p>Modules:%2</p><p>GPL-3.0-or-later.</p>")
          .arg(QStringLiteral(KERF_VERSION), modules));
}

/// A page may have made the window fill the screen.
void qKerfMainWindow::changeEvent(QEvent* event) {
  if (event->type() == QEvent::WindowStateChange && full_) full_->setChecked(isFullScreen());
  QMainWindow::changeEvent(event);
}

void qKerfMainWindow::closeEvent(QCloseEvent* event) {
  for (const qKerfPlugin& plugin : search_.plugins) {
    if (plugin.module->CanClose()) continue;
    event->ignore();
    return;
  }
  host_->Settings().setValue("application/geometry", saveGeometry());
  event->accept();
}
