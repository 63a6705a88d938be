#include "qKerfSettingsDialog.h"

#include <QAction>
#include <QComboBox>
#include <QDialogButtonBox>
#include <QFormLayout>
#include <QHeaderView>
#include <QKeySequenceEdit>
#include <QLabel>
#include <QTableWidget>
#include <QVBoxLayout>
#include <QVariant>

#include "qKerfApplicationHost.h"

qKerfSettingsDialog::qKerfSettingsDialog(qKerfApplicationHost* host, QWidget* parent)
    : QDialog(parent) {
  setWindowTitle(tr("Settings"));
  resize(560, 600);
  auto* theme = new QComboBox;
  theme->setObjectName("themeChoice");
  theme->addItems({tr("Dark"), tr("Light")});
  theme->setCurrentIndex(host->IsDark() ? 0 : 1);
  connect(theme, QOverload<int>::of(&QComboBox::currentIndexChanged), host,
          [host](int index) { host->SetDark(index == 0); });
  auto* form = new QFormLayout;
  form->addRow(tr("Theme"), theme);

  const auto& shortcuts = host->Shortcuts();
  auto* table = new QTableWidget(shortcuts.size(), 2);
  table->setHorizontalHeaderLabels({tr("Action"), tr("Key")});
  table->horizontalHeader()->setSectionResizeMode(0, QHeaderView::Stretch);
  table->setColumnWidth(1, 180);
  table->verticalHeader()->hide();
  for (int i = 0; i < shortcuts.size(); ++i) {
    QAction* action = shortcuts[i].action;
    auto* item = new QTableWidgetItem(action ? action->text().remove('&') : shortcuts[i].id);
    item->setFlags(Qt::ItemIsEnabled);
    table->setItem(i, 0, item);
    auto* edit = new QKeySequenceEdit(action ? action->shortcut() : QKeySequence());
    connect(edit, &QKeySequenceEdit::editingFinished, host,
            [host, i, edit] { host->SetShortcut(i, edit->keySequence().toString()); });
    table->setCellWidget(i, 1, edit);
  }
  auto* hint = new QLabel(tr("Click a key and press the new one."));
  hint->setProperty("role", "faint");
  auto* close = new QDialogButtonBox(QDialogButtonBox::Close);
  connect(close, &QDialogButtonBox::rejected, this, &QDialog::reject);
  auto* column = new QVBoxLayout(this);
  column->addLayout(form);
  column->addWidget(new QLabel(tr("Keyboard shortcuts")));
  column->addWidget(table, 1);
  column->addWidget(hint);
  column->addWidget(close);
}
