#include <QLabel>
#include <QObject>

#include "Framework/qKerfModule.h"

class TestPlugin : public QObject, public qKerfModule {
  Q_OBJECT
#if defined(KERF_TEST_PLUGIN_Good)
  Q_PLUGIN_METADATA(IID kKerfModuleIid FILE "good.json")
#elif defined(KERF_TEST_PLUGIN_Old)
  Q_PLUGIN_METADATA(IID "org.kerf.Module/0" FILE "good.json")
#else
  Q_PLUGIN_METADATA(IID kKerfModuleIid FILE "nameless.json")
#endif
  Q_INTERFACES(qKerfModule)
 public:
  QString Name() const override { return "good"; }
  QString Title() const override { return "Good"; }
  QIcon Icon() const override { return {}; }
  QWidget* CreateWidget(qKerfHost*, QWidget* parent) override { return new QLabel("good", parent); }
  bool OpenCase(const QString&) override { return true; }
  bool CanClose() override { return true; }
};

#include "TestPlugin.moc"
