#pragma once

#include <QDialog>

class qKerfApplicationHost;

/// Theme and every shortcut; changes take effect at once.
class qKerfSettingsDialog : public QDialog {
  Q_OBJECT
 public:
  explicit qKerfSettingsDialog(qKerfApplicationHost* host, QWidget* parent = nullptr);
};
