#include "Planning/qKerfImportPanel.h"

#include <QFileDialog>
#include <QFileInfo>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

#include "Planning/PanelParts.h"

using namespace kerf_panel;

qKerfImportPanel::qKerfImportPanel(QWidget* parent) : QWidget(parent), info_(Value("importInfo")) {
  auto* folder = Primary(tr("Open a DICOM folder…"), "openFolderButton");
  auto* file = Button(tr("Open a NIfTI or NRRD file…"), "openFileButton");
  series_hint_ =
      Hint(tr("This folder holds several series. Choose the one to plan on in the table "
              "on the right."));
  warnings_ = Value("importWarnings");
  SetRole(warnings_, "warning");
  auto* column = Column(this);
  column->addWidget(folder);
  column->addWidget(file);
  column->addWidget(Hint(tr("Or drop a folder or file onto the window.")));
  column->addWidget(series_hint_);
  column->addWidget(info_);
  column->addWidget(warnings_);
  column->addStretch(1);
  SetChoosing(false);

  connect(folder, &QPushButton::clicked, this, [this] {
    const QString path = QFileDialog::getExistingDirectory(this, tr("Open a DICOM folder"));
    if (!path.isEmpty()) emit OpenWanted(path, {});
  });
  connect(file, &QPushButton::clicked, this, [this] {
    const QString path = QFileDialog::getOpenFileName(
        this, tr("Open a CT"), {}, tr("CT (*.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd);;All (*)"));
    if (!path.isEmpty()) emit OpenWanted(path, {});
  });
}

void qKerfImportPanel::SetChoosing(bool choosing) { series_hint_->setVisible(choosing); }

void qKerfImportPanel::Show(const kerf::PlanningSession& session) {
  QString text, warnings;
  if (session.Ct()) {
    const kerf::GridGeometry& g = session.Ct()->grid;
    text = tr("<b>%1</b><br>%2 × %3 × %4 voxels<br>%5 × %6 × %7 mm")
               .arg(QFileInfo(QString::fromStdString(session.CtPath())).fileName().toHtmlEscaped())
               .arg(g.size[0])
               .arg(g.size[1])
               .arg(g.size[2])
               .arg(g.spacing_mm[0], 0, 'f', 2)
               .arg(g.spacing_mm[1], 0, 'f', 2)
               .arg(g.spacing_mm[2], 0, 'f', 2);
    for (const auto& [key, value] : session.Ct()->metadata)
      text += QStringLiteral("<br>%1: %2")
                  .arg(QString::fromStdString(key).toHtmlEscaped(),
                       QString::fromStdString(value).toHtmlEscaped());
    for (const std::string& w : session.ImportWarnings())
      warnings += (warnings.isEmpty() ? "" : "\n") + QString::fromStdString(w);
  }
  info_->setText(text);
  warnings_->setText(warnings);
  warnings_->setVisible(!warnings.isEmpty());
}
