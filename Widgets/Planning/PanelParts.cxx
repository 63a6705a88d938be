#include "Planning/PanelParts.h"

#include <QLabel>
#include <QPushButton>
#include <QStyle>
#include <QVBoxLayout>
#include <QVariant>

namespace kerf_panel {

QLabel* Heading(const QString& text) {
  auto* label = new QLabel(text);
  label->setProperty("role", "heading");
  return label;
}

QLabel* Hint(const QString& text) {
  auto* label = new QLabel(text);
  label->setProperty("role", "faint");
  label->setWordWrap(true);
  return label;
}

QLabel* Value(const QString& object_name) {
  auto* label = new QLabel;
  label->setObjectName(object_name);
  label->setWordWrap(true);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

QPushButton* Primary(const QString& text, const QString& object_name) {
  QPushButton* button = Button(text, object_name);
  button->setProperty("primary", true);
  return button;
}

QPushButton* Button(const QString& text, const QString& object_name) {
  auto* button = new QPushButton(text);
  button->setObjectName(object_name);
  return button;
}

void SetRole(QLabel* label, const QString& role) {
  label->setProperty("role", role);
  label->style()->unpolish(label);
  label->style()->polish(label);
}

QVBoxLayout* Column(QWidget* panel) {
  auto* column = new QVBoxLayout(panel);
  column->setContentsMargins(2, 2, 8, 8);
  column->setSpacing(7);
  return column;
}

}  // namespace kerf_panel
