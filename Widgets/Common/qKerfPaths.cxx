#include "Common/qKerfPaths.h"

#include <QDir>

QString qKerfShortPath(const QString& path) {
  const QString home = QDir::homePath();
  if (path == home) return QStringLiteral("~");
  return path.startsWith(home + '/') ? '~' + path.mid(home.size()) : path;
}

QString qKerfLongPath(const QString& path) {
  return path == "~" || path.startsWith("~/") ? QDir::homePath() + path.mid(1) : path;
}
