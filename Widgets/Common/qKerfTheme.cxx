#include "Common/qKerfTheme.h"

#include <QApplication>
#include <QPalette>
#include <QVariant>

#include "Common/qKerfStyle.h"

namespace {

// Kept by the application object: every plugin has its own copy of this file's variables.
constexpr char kDarkProperty[] = "kerfDark";

QPalette PaletteOf(const qKerfTheme& t) {
  QPalette p;
  p.setColor(QPalette::Window, t.window);
  p.setColor(QPalette::WindowText, t.text);
  p.setColor(QPalette::Base, t.panel);
  p.setColor(QPalette::AlternateBase, t.window);
  p.setColor(QPalette::Text, t.text);
  p.setColor(QPalette::Button, t.raised);
  p.setColor(QPalette::ButtonText, t.text);
  p.setColor(QPalette::BrightText, t.problem);
  p.setColor(QPalette::Highlight, t.accent);
  p.setColor(QPalette::HighlightedText, t.on_accent);
  p.setColor(QPalette::ToolTipBase, t.raised);
  p.setColor(QPalette::ToolTipText, t.text);
  p.setColor(QPalette::PlaceholderText, t.faint);
  p.setColor(QPalette::Link, t.accent);
  p.setColor(QPalette::Mid, t.border);
  p.setColor(QPalette::Dark, t.border);
  for (const auto role : {QPalette::WindowText, QPalette::Text, QPalette::ButtonText})
    p.setColor(QPalette::Disabled, role, t.faint);
  p.setColor(QPalette::Disabled, QPalette::Highlight, t.border);
  return p;
}

const char* const kSheet = R"(
QToolTip { border: 1px solid %border; padding: 3px; color: %text; background: %raised; }
QPushButton { background: %raised; border: 1px solid %border; border-radius: 4px; padding: 5px 10px; }
QPushButton:hover, QToolButton:hover { border-color: %accent; }
QPushButton:focus, QToolButton:focus { border: 1px solid %accent; }
QPushButton:pressed { background: %border; }
QPushButton:checked { background: %accent; color: %on_accent; border-color: %accent; }
QPushButton:disabled { color: %faint; background: %window; }
QPushButton[compact="true"] { padding: 4px 3px; }
QPushButton[primary="true"] { background: %accent; color: %on_accent; border-color: %accent; font-weight: bold; }
QPushButton[primary="true"]:disabled { background: %window; color: %faint; border-color: %border; }
QToolButton { border: 1px solid transparent; border-radius: 4px; padding: 4px; }
QToolButton:checked { background: %accent; color: %on_accent; }
QToolButton#moduleButton { padding: 8px 2px; border-radius: 0; }
QToolButton#moduleButton:checked { background: %accent; color: %on_accent; }
QLineEdit { border: 1px solid %border; border-radius: 4px; padding: 3px 5px; background: %panel; min-height: 20px; }
QLineEdit:focus { border-color: %accent; }
QComboBox QLineEdit, QAbstractSpinBox QLineEdit { border: 0; padding: 0; min-height: 0; }
QListWidget, QTreeWidget, QTableWidget, QPlainTextEdit { border: 1px solid %border; border-radius: 4px; background: %panel; }
QHeaderView::section { background: %raised; border: 0; border-right: 1px solid %border; padding: 4px; }
QLabel[role="title"] { font-size: 15pt; font-weight: bold; }
QLabel[role="heading"] { font-weight: bold; }
QLabel[role="faint"] { color: %faint; }
QLabel[role="good"] { color: %good; }
QLabel[role="warning"] { color: %warning; }
QLabel[role="problem"] { color: %problem; }
QFrame[role="panel"] { background: %panel; border: 1px solid %border; border-radius: 6px; }
QFrame[role="line"] { background: %border; max-height: 1px; border: 0; }
QProgressBar { border: 1px solid %border; border-radius: 4px; background: %panel; text-align: center; max-height: 16px; }
QProgressBar::chunk { background: %accent; border-radius: 3px; }
QMenuBar { background: %window; } QMenuBar::item { padding: 4px 8px; } QMenuBar::item:selected { background: %raised; }
QMenu { background: %raised; border: 1px solid %border; } QMenu::item:selected { background: %accent; color: %on_accent; }
QStatusBar::item { border: 0; }
QSplitter::handle { background: %border; }
QScrollArea { border: 0; background: transparent; }
)";

}  // namespace

qKerfTheme qKerfTheme::Light() {
  qKerfTheme t;
  t.dark = false;
  t.window = "#eef0f3";
  t.panel = "#ffffff";
  t.raised = "#f6f7f9";
  t.border = "#c3c8d0";
  t.text = "#16191d";
  t.faint = "#5c6470";
  t.accent = "#0b62a8";
  t.on_accent = "#ffffff";
  t.good = "#196b2c";
  t.warning = "#8a4b00";
  t.problem = "#b3171f";
  t.view = "#dfe4ea";
  t.view_top = "#f4f6f9";
  return t;
}

qKerfTheme qKerfTheme::Dark() {
  qKerfTheme t;
  t.window = "#1d2126";
  t.panel = "#15181c";
  t.raised = "#2a3038";
  t.border = "#414a55";
  t.text = "#e8ebee";
  t.faint = "#9aa5b1";
  t.accent = "#4aa3e8";
  t.on_accent = "#081019";
  t.good = "#5fcf7c";
  t.warning = "#f0b04a";
  t.problem = "#ff7b78";
  t.view = "#0d1014";
  t.view_top = "#252c36";
  return t;
}

const qKerfTheme& qKerfTheme::Current() {
  static const qKerfTheme light = Light(), dark = Dark();
  const QVariant now = qApp ? qApp->property(kDarkProperty) : QVariant();
  return now.isValid() && !now.toBool() ? light : dark;
}

void qKerfTheme::Apply(QApplication& app, bool dark) {
  app.setProperty(kDarkProperty, dark);
  const qKerfTheme& t = Current();
  app.setStyle(new qKerfStyle);
  app.setPalette(PaletteOf(t));
  QString sheet = kSheet;
  // Longer names first: %on_accent holds %accent.
  sheet.replace("%on_accent", t.on_accent.name())
      .replace("%accent", t.accent.name())
      .replace("%window", t.window.name())
      .replace("%raised", t.raised.name())
      .replace("%border", t.border.name())
      .replace("%panel", t.panel.name())
      .replace("%faint", t.faint.name())
      .replace("%text", t.text.name())
      .replace("%good", t.good.name())
      .replace("%warning", t.warning.name())
      .replace("%problem", t.problem.name());
  app.setStyleSheet(sheet);
}
