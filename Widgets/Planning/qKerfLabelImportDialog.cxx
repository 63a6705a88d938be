#include "Planning/qKerfLabelImportDialog.h"

#include <QComboBox>
#include <QDialogButtonBox>
#include <QHeaderView>
#include <QLabel>
#include <QPushButton>
#include <QTableWidget>
#include <QVBoxLayout>
#include <QVariant>

namespace {

/// A first guess from the name; 1, 2, 3 mean what they mean in Kerf's own files.
int Guess(const qKerfLabelImportDialog::Row& row) {
  const QString name = row.name.toLower();
  for (const char* word : {"tumour", "tumor", "lesion", "cyst"})
    if (name.contains(word)) return 2;
  for (const char* word : {"vessel", "vein", "artery", "calyx", "calyces", "internal", "pelvis"})
    if (name.contains(word)) return 3;
  if (name == "organ") return 1;
  return name.isEmpty() && row.value <= 3 ? row.value : 0;
}

}  // namespace

qKerfLabelImportDialog::qKerfLabelImportDialog(const QVector<Row>& rows, QWidget* parent)
    : QDialog(parent), rows_(rows) {
  setObjectName("labelImportDialog");
  setWindowTitle(tr("Import labels"));
  resize(460, 420);
  auto* explain =
      new QLabel(tr("Say which of these labels are the organ, the tumour and the "
                    "vessels or calyces. The others are left out."));
  explain->setWordWrap(true);
  auto* table = new QTableWidget(rows.size(), 3);
  table->setHorizontalHeaderLabels({tr("Label"), tr("Volume"), tr("is")});
  table->horizontalHeader()->setSectionResizeMode(0, QHeaderView::Stretch);
  table->setColumnWidth(2, 150);
  table->verticalHeader()->hide();
  table->setEditTriggers(QAbstractItemView::NoEditTriggers);
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel);
  const auto check = [this, buttons] {
    bool organ = false;
    for (const QComboBox* role : roles_) organ |= role->currentIndex() == 1;
    buttons->button(QDialogButtonBox::Ok)->setEnabled(organ);
  };
  for (int i = 0; i < rows.size(); ++i) {
    const QString number = QString::number(rows[i].value);
    table->setItem(i, 0,
                   new QTableWidgetItem(rows[i].name.isEmpty()
                                            ? number
                                            : number + QStringLiteral(" – ") + rows[i].name));
    table->setItem(i, 1, new QTableWidgetItem(tr("%1 ml").arg(rows[i].volume_ml, 0, 'f', 1)));
    auto* role = new QComboBox;
    role->setObjectName(QStringLiteral("role%1").arg(rows[i].value));
    role->addItems({tr("left out"), tr("organ"), tr("tumour"), tr("vessels, calyces")});
    role->setCurrentIndex(Guess(rows[i]));
    connect(role, QOverload<int>::of(&QComboBox::currentIndexChanged), this, check);
    roles_.push_back(role);
    table->setCellWidget(i, 2, role);
  }
  connect(buttons, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  auto* column = new QVBoxLayout(this);
  column->addWidget(explain);
  column->addWidget(table, 1);
  column->addWidget(buttons);
  check();
}

std::map<int, int> qKerfLabelImportDialog::Roles() const {
  std::map<int, int> roles;
  for (int i = 0; i < rows_.size(); ++i) roles[rows_[i].value] = roles_[i]->currentIndex();
  return roles;
}
