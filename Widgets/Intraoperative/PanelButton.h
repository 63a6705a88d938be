#pragma once

#include <QPushButton>

namespace kerf {

/// A button of the operating room's panels: large, and keys stay with the picture.
inline QPushButton* PanelButton(const QString& text, const char* name, const QString& tip) {
  auto* button = new QPushButton(text);
  button->setObjectName(name);
  button->setToolTip(tip);
  button->setFocusPolicy(Qt::NoFocus);
  button->setMinimumHeight(36);
  return button;
}

}  // namespace kerf
