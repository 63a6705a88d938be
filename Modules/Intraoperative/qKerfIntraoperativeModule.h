#pragma once

#include <QObject>
#include <QPointer>

#include "Framework/qKerfModule.h"

class qKerfIntraoperativeWidget;

/// The Intraoperative module as a plugin: wires the page to the host, decides nothing.
class qKerfIntraoperativeModule : public QObject, public qKerfModule {
  Q_OBJECT
  Q_PLUGIN_METADATA(IID kKerfModuleIid FILE "intraoperative.json")
  Q_INTERFACES(qKerfModule)

 public:
  QString Name() const override { return "intraoperative"; }
  QString Title() const override { return tr("Surgery"); }
  QIcon Icon() const override;
  QWidget* CreateWidget(qKerfHost* host, QWidget* parent) override;
  bool OpenCase(const QString& folder) override;
  bool CanTakeDrop() override;
  bool CanLeaveCase() override;
  bool CanClose() override;

 private:
  /// Says so, with what to do.
  bool SessionRuns(const QString& what_to_do);

  qKerfHost* host_ = nullptr;
  QPointer<qKerfIntraoperativeWidget> page_;
};
