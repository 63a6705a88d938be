#pragma once

#include <QString>
#include <QStringList>
#include <QVector>

class QObject;
class qKerfModule;

/// A module that was found.
struct qKerfPlugin {
  QString path, name, title, version;
  int order = 0;                  ///< place in the switcher
  qKerfModule* module = nullptr;  ///< owned by Qt's plugin system, alive until the process ends
};

/// What a search found, in the order of the switcher, and what it refused.
struct qKerfPluginSearch {
  struct Refused {
    QString path, why;
  };
  QVector<qKerfPlugin> plugins;
  QVector<Refused> refused;
};

/// Loads every plugin of these folders (a missing folder is empty). Refused, with the reason: no Qt
/// plugin, another interface version, metadata without name, a name that is taken. One broken
/// plugin never keeps the others from loading.
qKerfPluginSearch FindKerfPlugins(const QStringList& folders);

/// Beside the program (build: bin/plugins; installed: lib/kerf/plugins), and the folders of
/// KERF_PLUGIN_PATH before them.
QStringList KerfPluginFolders();
