#pragma once

#include <QString>

class QLabel;
class QPushButton;
class QVBoxLayout;
class QWidget;

/// What all panels of the planning steps are made of.
namespace kerf_panel {

QLabel* Heading(const QString& text);
/// Small, wrapped, in the faint colour.
QLabel* Hint(const QString& text);
QLabel* Value(const QString& object_name);
QPushButton* Primary(const QString& text, const QString& object_name);
QPushButton* Button(const QString& text, const QString& object_name);
/// A label's colour: "good", "warning", "problem", "faint" or "" for the normal one.
void SetRole(QLabel* label, const QString& role);
/// A column with the panels' margins and spacing.
QVBoxLayout* Column(QWidget* panel);

}  // namespace kerf_panel
