#pragma once

#include <QString>

/// Paths as people write them: the home folder is ~.
QString qKerfShortPath(const QString& path);
QString qKerfLongPath(const QString& path);
