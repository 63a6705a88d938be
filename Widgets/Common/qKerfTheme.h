#pragma once

#include <QColor>

class QApplication;

/// Colours that a palette has no role for. Chosen for a contrast of at least 4.5 : 1 with the
/// background that they stand on.
struct qKerfTheme {
  bool dark = true;
  QColor window, panel, raised, border, text, faint, accent, on_accent, good, warning, problem;
  /// Behind CT slices and 3-D scenes.
  QColor view, view_top;

  static qKerfTheme Light();
  static qKerfTheme Dark();
  /// The one that was applied last.
  static const qKerfTheme& Current();
  /// Fusion style, palette and style sheet for the whole application.
  static void Apply(QApplication& app, bool dark);
};
