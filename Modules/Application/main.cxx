#include <QVTKOpenGLNativeWidget.h>

#include <QApplication>
#include <QCommandLineParser>
#include <QFileInfo>
#include <QSurfaceFormat>
#include <cstdio>
#include <cstring>

#include "Framework/qKerfPluginLoader.h"
#include "StartWorkers.h"
#include "qKerfMainWindow.h"

namespace {

/// Help and version need no display; the window says in words that it does.
bool MayStart(int argc, char** argv) {
  for (const char* variable : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"})
    if (!qEnvironmentVariableIsEmpty(variable)) return true;
  for (int i = 1; i < argc; ++i)
    for (const char* text : {"--help", "-h", "--version", "-v"})
      if (std::strcmp(argv[i], text) == 0) return qputenv("QT_QPA_PLATFORM", "offscreen");
  std::fprintf(stderr,
               "KerfApp: there is no display. Start it from a desktop, over ssh -X, or with "
               "xvfb-run.\n");
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  if (!MayStart(argc, argv)) return 3;
  QSurfaceFormat format = QVTKOpenGLNativeWidget::defaultFormat();
  format.setSamples(0);  // multisampling costs twice the time in software
  QSurfaceFormat::setDefaultFormat(format);
  StartWorkers();
  QApplication app(argc, argv);
  QApplication::setApplicationName("kerf");
  QApplication::setApplicationDisplayName("Kerf");
  QApplication::setApplicationVersion(KERF_VERSION);
  setlocale(LC_NUMERIC, "C");  // Qt set the user's; files have points

  QCommandLineParser parser;
  parser.setApplicationDescription(
      "The window of Kerf: planning and the operating room.\n"
      "Research software, not a medical device.");
  parser.addHelpOption();
  parser.addVersionOption();
  parser.addPositionalArgument("case", "case folder to open", "[CASE]");
  const QCommandLineOption settings("settings", "settings file to use instead of the user's",
                                    "FILE");
  const QCommandLineOption module("module", "module to show first: cases, planning, …", "NAME");
  parser.addOptions({settings, module});
  parser.process(app);

  qKerfMainWindow window(parser.value(settings), KerfPluginFolders());
  window.show();
  if (!parser.positionalArguments().isEmpty())
    window.OpenCase(QFileInfo(parser.positionalArguments().constFirst()).absoluteFilePath());
  if (parser.isSet(module) && !window.ShowPage(parser.value(module))) {
    std::fprintf(stderr, "KerfApp: there is no module %s\n", qPrintable(parser.value(module)));
    return 2;
  }
  return QApplication::exec();
}
