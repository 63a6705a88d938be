#include "Framework/qKerfPluginLoader.h"

#include <QCoreApplication>
#include <QDir>
#include <QJsonObject>
#include <QLibrary>
#include <QPluginLoader>
#include <algorithm>

#include "Framework/qKerfModule.h"

namespace {

/// Reads the metadata before any code of the plugin runs. @return empty when it may be loaded
QString WhyNot(const QJsonObject& header, const QVector<qKerfPlugin>& taken) {
  const QString iid = header.value("IID").toString();
  if (iid.isEmpty()) return QStringLiteral("it is no Qt plugin");
  if (iid != QLatin1String(kKerfModuleIid)) {
    return QStringLiteral("it was made for the interface %1; this program has %2")
        .arg(iid, QStringLiteral(kKerfModuleIid));
  }
  const QString name = header.value("MetaData").toObject().value("name").toString();
  if (name.isEmpty()) return QStringLiteral("its metadata has no name");
  for (const qKerfPlugin& other : taken)
    if (other.name == name) return QStringLiteral("%1 is already there").arg(name);
  return {};
}

}  // namespace

qKerfPluginSearch FindKerfPlugins(const QStringList& folders) {
  qKerfPluginSearch search;
  for (const QString& folder : folders) {
    for (const QFileInfo& file : QDir(folder).entryInfoList(QDir::Files, QDir::Name)) {
      const QString path = file.absoluteFilePath();
      if (!QLibrary::isLibrary(path)) continue;
      QPluginLoader loader(path);
      QString why = WhyNot(loader.metaData(), search.plugins);
      if (why.isEmpty()) {
        qKerfPlugin plugin;
        plugin.module = qobject_cast<qKerfModule*>(loader.instance());
        if (plugin.module) {
          const QJsonObject data = loader.metaData().value("MetaData").toObject();
          plugin.path = path;
          plugin.name = data.value("name").toString();
          plugin.title = data.value("title").toString(plugin.name);
          plugin.version = data.value("version").toString();
          plugin.order = data.value("order").toInt();
          search.plugins.push_back(plugin);
          continue;
        }
        why = loader.errorString();
      }
      search.refused.push_back({path, why});
    }
  }
  std::stable_sort(search.plugins.begin(), search.plugins.end(),
                   [](const qKerfPlugin& a, const qKerfPlugin& b) { return a.order < b.order; });
  return search;
}

QStringList KerfPluginFolders() {
  QStringList folders =
      qEnvironmentVariable("KERF_PLUGIN_PATH").split(QDir::listSeparator(), Qt::SkipEmptyParts);
  const QDir program(QCoreApplication::applicationDirPath());
  folders << program.filePath("plugins")
          << QDir::cleanPath(program.filePath("../lib/kerf/plugins"));
  return folders;
}
