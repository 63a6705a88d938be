#include "Common/qKerfLogPanel.h"

#include <QTime>

#include "Common/qKerfTheme.h"

qKerfLogPanel::qKerfLogPanel(QWidget* parent) : QPlainTextEdit(parent) {
  setObjectName("logPanel");
  setReadOnly(true);
  setMaximumBlockCount(5000);
}

void qKerfLogPanel::Add(Level level, const QString& text) {
  const qKerfTheme& t = qKerfTheme::Current();
  const QColor color = level == Info ? t.text : level == Warning ? t.warning : t.problem;
  appendHtml(QStringLiteral("<span style='color:%1'>%2 %3</span>&nbsp; %4")
                 .arg(color.name(), QTime::currentTime().toString("HH:mm:ss"),
                      level == Info      ? QStringLiteral("·")
                      : level == Warning ? tr("check")
                                         : tr("PROBLEM"),
                      text.toHtmlEscaped()));
}
