#include "qKerfApplicationHost.h"

#include <QAction>
#include <QApplication>
#include <QDir>
#include <QFileInfo>
#include <QStandardPaths>

#include "Common/qKerfTheme.h"
#include "Session/CaseBrowser.h"

qKerfApplicationHost::qKerfApplicationHost(const QString& settings_file, QObject* parent)
    : qKerfHost(parent),
      settings_(
          settings_file.isEmpty()
              ? new QSettings(QSettings::IniFormat, QSettings::UserScope, "kerf", "kerf", this)
              : new QSettings(settings_file, QSettings::IniFormat, this)) {
  undo_.SetListener([this] { emit UndoChanged(); });
  connect(&jobs_, &qKerfJobRunner::Started, this, [this](const QString& t) { Log(Info, t); });
  connect(&jobs_, &qKerfJobRunner::Warned, this, [this](const QString& t) { Log(Warning, t); });
  connect(&jobs_, &qKerfJobRunner::Finished, this,
          [this](const QString& title, const QString& sentence, bool cancelled) {
            if (cancelled) {
              Log(Info, tr("%1: cancelled").arg(title));
            } else if (!sentence.isEmpty()) {
              Say(Problem, sentence);
            }
          });
}

void qKerfApplicationHost::Log(Severity severity, const QString& text) {
  emit Logged(severity, text);
}

void qKerfApplicationHost::Say(Severity severity, const QString& text) {
  if (!text.isEmpty()) Log(severity, text);
  emit Said(severity, text);
}

void qKerfApplicationHost::ShowStatus(const QString& text, int milliseconds) {
  emit StatusWanted(text, milliseconds);
}

QStringList qKerfApplicationHost::RecentCases() const {
  return settings_->value("application/cases").toStringList();
}

void qKerfApplicationHost::SetCurrentCase(const QString& folder) {
  case_ = folder;
  if (!folder.isEmpty()) {
    std::vector<std::string> folders;
    for (const QString& f : RecentCases()) folders.push_back(f.toStdString());
    kerf::RecentCases recent(folders);
    recent.Add(QFileInfo(folder).absoluteFilePath().toStdString());
    QStringList kept;
    for (const std::string& f : recent.Folders()) kept << QString::fromStdString(f);
    settings_->setValue("application/cases", kept);
    emit RecentChanged();
  }
  emit CaseChanged(folder);
}

void qKerfApplicationHost::ForgetCase(const QString& folder) {
  QStringList kept = RecentCases();
  kept.removeAll(folder);
  settings_->setValue("application/cases", kept);
  emit RecentChanged();
}

bool qKerfApplicationHost::ShowModule(const QString& name) {
  bool shown = false;
  emit ModuleWanted(name, &shown);
  return shown;
}

void qKerfApplicationHost::SetShown(const QString& name) {
  shown_ = name;
  emit ModuleShown(name);
}

void qKerfApplicationHost::AddShortcut(const QString& id, QAction* action) {
  const QString standard = action->shortcut().toString();
  const QVariant own = settings_->value("shortcuts/" + id);
  if (own.isValid()) action->setShortcut(QKeySequence(own.toString()));
  if (!action->shortcut().isEmpty()) {
    action->setToolTip(QStringLiteral("%1 (%2)").arg(
        action->toolTip().remove('&'), action->shortcut().toString(QKeySequence::NativeText)));
  }
  shortcuts_.push_back({id, action, standard});
}

void qKerfApplicationHost::SetShortcut(int index, const QString& key) {
  const Shortcut& s = shortcuts_[index];
  if (s.action) s.action->setShortcut(QKeySequence(key));
  if (key == s.standard) {
    settings_->remove("shortcuts/" + s.id);
  } else {
    settings_->setValue("shortcuts/" + s.id, key);
  }
}

QString qKerfApplicationHost::WorkFolder(const QString& module) const {
  // Beside the settings, so that a run with its own settings file has its own autosaves.
  const QDir folder(QFileInfo(settings_->fileName()).absoluteDir().filePath("work/" + module));
  QDir().mkpath(folder.path());
  return folder.path();
}

bool qKerfApplicationHost::IsDark() const {
  return settings_->value("application/dark", true).toBool();
}

void qKerfApplicationHost::SetDark(bool dark) {
  settings_->setValue("application/dark", dark);
  qKerfTheme::Apply(*qApp, dark);
  emit ThemeChanged(dark);
}
