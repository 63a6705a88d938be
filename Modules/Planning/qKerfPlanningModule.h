#pragma once

#include <QObject>

#include "Framework/qKerfModule.h"

class qKerfPlanningPage;

/// Planning as a plugin: CT → segmentation → mesh → plan → case folder.
class qKerfPlanningModule : public QObject, public qKerfModule {
  Q_OBJECT
  Q_PLUGIN_METADATA(IID kKerfModuleIid FILE "planning.json")
  Q_INTERFACES(qKerfModule)
 public:
  QString Name() const override { return QStringLiteral("planning"); }
  QString Title() const override { return tr("Planning"); }
  QIcon Icon() const override;
  QWidget* CreateWidget(qKerfHost* host, QWidget* parent) override;
  bool OpenCase(const QString& folder) override;
  bool OpenData(const QString& path) override;
  bool CanLeaveCase() override;
  bool CanClose() override;

 private:
  qKerfPlanningPage* page_ = nullptr;
};
