#include "Planning/qKerfSavePanel.h"

#include <QFileDialog>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QVBoxLayout>

#include "Common/qKerfPaths.h"
#include "Common/qKerfTheme.h"
#include "Planning/PanelParts.h"

using namespace kerf_panel;

qKerfSavePanel::qKerfSavePanel(QWidget* parent)
    : QWidget(parent),
      list_(Value("checklist")),
      saved_(Value("savedText")),
      folder_(new QLineEdit) {
  folder_->setObjectName("caseFolderEdit");
  folder_->setPlaceholderText(tr("folder of the case"));
  auto* choose = Button(tr("Choose…"), "chooseFolderButton");
  save_ = Primary(tr("Save the case"), "saveButton");
  go_on_ = Button(tr("Continue in the operating room"), "continueButton");
  auto* column = Column(this);
  column->addWidget(Heading(tr("Checklist")));
  column->addWidget(list_);
  column->addWidget(Heading(tr("Case folder")));
  auto* row = new QHBoxLayout;
  row->addWidget(folder_, 1);
  row->addWidget(choose);
  column->addLayout(row);
  column->addWidget(save_);
  column->addWidget(saved_);
  column->addWidget(go_on_);
  column->addWidget(
      Hint(tr("No patient name is written. An older case in this folder is "
              "replaced; its recorded sessions stay.")));
  column->addStretch(1);
  connect(choose, &QPushButton::clicked, this, [this] {
    const QString folder =
        QFileDialog::getSaveFileName(this, tr("Folder for the case"), Folder(), tr("Folder (*)"));
    if (!folder.isEmpty()) SetFolder(folder);
  });
  connect(folder_, &QLineEdit::textChanged, this,
          [this] { save_->setEnabled(can_save_ && !folder_->text().trimmed().isEmpty()); });
  connect(save_, &QPushButton::clicked, this, [this] { emit SaveWanted(Folder()); });
  connect(folder_, &QLineEdit::returnPressed, save_, &QPushButton::click);
  connect(go_on_, &QPushButton::clicked, this, &qKerfSavePanel::ContinueWanted);
}

QString qKerfSavePanel::Folder() const { return qKerfLongPath(folder_->text().trimmed()); }
void qKerfSavePanel::SetFolder(const QString& folder) { folder_->setText(qKerfShortPath(folder)); }

void qKerfSavePanel::Show(const kerf::PlanningSession& session) {
  const qKerfTheme& t = qKerfTheme::Current();
  QString rows;
  for (const kerf::ChecklistItem& item : session.Checklist()) {
    const bool done = item.state == kerf::StepState::Done;
    const bool bad = item.state == kerf::StepState::Problem || (item.required && !done);
    rows += QStringLiteral(
                "<tr><td width=18 style='color:%1'><b>%2</b></td><td style='color:%3'>%4</td></tr>")
                .arg((done  ? t.good
                      : bad ? t.warning
                            : t.faint)
                         .name(),
                     done  ? QStringLiteral("✓")
                     : bad ? QStringLiteral("!")
                           : QStringLiteral("○"),
                     (done || bad ? t.text : t.faint).name(),
                     QString::fromStdString(item.text).toHtmlEscaped());
  }
  list_->setText("<table cellspacing=3>" + rows + "</table>");
  can_save_ = session.CanSave();
  save_->setEnabled(can_save_ && !Folder().isEmpty());
  const bool saved = !session.CaseFolderPath().empty() && !session.IsDirty();
  saved_->setText(
      saved
          ? tr("Saved in %1").arg(qKerfShortPath(QString::fromStdString(session.CaseFolderPath())))
          : QString());
  SetRole(saved_, "good");
  saved_->setVisible(saved);
  go_on_->setVisible(saved);
}
