#pragma once

#include <QIcon>
#include <QString>

/// Line icons, painted in the theme's text colour: sharp at every size, legible on light and dark.
/// Names: cases, planning, surgery, settings, log, brush, eraser, sphere, threshold, grow, contour,
/// islands, smooth, boolean, cursor, seed, line, landmark, eye, play, stop. An unknown name gives a
/// dot.
QIcon qKerfIcon(const QString& name);
