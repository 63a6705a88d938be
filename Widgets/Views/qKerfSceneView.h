#pragma once

#include <QColor>
#include <QWidget>
#include <memory>
#include <string>
#include <vector>

#include "Core/SurfaceMesh.h"

/// A 3-D view of named things: surfaces, coloured surfaces, lines, points. Left button turns,
/// middle moves, wheel zooms; while picking, a left click without a drag gives the ray under the
/// pointer. Needs an X display (VTK through Qt).
class qKerfSceneView : public QWidget {
  Q_OBJECT
 public:
  explicit qKerfSceneView(QWidget* parent = nullptr);
  ~qKerfSceneView() override;

  /// Adds or replaces. @param color with alpha 1; @param opacity 0..1
  void SetSurface(const std::string& name, const kerf::SurfaceMesh& surface, const QColor& color,
                  double opacity);
  /// Coloured by a number per point or per triangle, from `low` (red) to `high` (blue), with a bar
  /// that has this title.
  void SetColoredSurface(const std::string& name, const kerf::SurfaceMesh& surface,
                         const std::vector<double>& values, double low, double high,
                         const QString& title, double opacity);
  void SetLine(const std::string& name, const kerf::Points& points, const QColor& color,
               double width_px);
  /// Balls with names beside them.
  void SetPoints(const std::string& name, const kerf::Points& points,
                 const std::vector<std::string>& labels, const QColor& color, double radius_mm);
  /// Where the values of a surface's points equal `value`: the margin on the organ.
  void SetIsoline(const std::string& name, const kerf::SurfaceMesh& surface,
                  const std::vector<double>& values, double value, const QColor& color);
  void Remove(const std::string& name);
  void Clear();

  void SetPicking(bool picking);
  /// @param from one of L R A P S I: the side that the eye is on
  void LookFrom(char from);
  void ResetCamera();
  /// Unit vector into the screen, LPS.
  kerf::Vec3 ViewDirection() const;
  /// Widget pixel of a world point.
  QPointF WidgetFromWorld(const kerf::Vec3& world_mm) const;
  /// What is shown, for the case browser.
  QImage Picture();
  /// A sentence in the middle while nothing is shown; a new line stays one.
  void SetHint(const QString& text);
  void ApplyTheme();
  int Count() const;

 signals:
  /// See SceneInput.
  void Picked(const kerf::Vec3& origin_mm, const kerf::Vec3& direction);
  void Pressed(const QPointF& at, bool* taken);
  void Dragged(const kerf::Vec3& origin_mm, const kerf::Vec3& direction, bool over);
  void WholePageWanted();

 protected:
  void showEvent(QShowEvent* event) override;

 private:
  void Render();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
