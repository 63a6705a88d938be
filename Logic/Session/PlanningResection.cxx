#include "Session/PlanningResection.h"

#include <algorithm>
#include <cmath>

#include "Cutting/ExtrudePolyline.h"
#include "Cutting/TetCutter.h"
#include "Geometry/SurfaceTree.h"

namespace kerf {
namespace {

constexpr double kAbove_mm = 6, kCell_mm = 2.5;

Points Rows(const std::vector<Vec3>& points) {
  Points rows(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  return rows;
}

/// Smallest distance between the sheet's part inside the organ and a structure; 0 when they meet.
double SmallestDistance(const CutSurface& sheet, const std::vector<char>& inside,
                        const SurfaceMesh& structure) {
  const SurfaceTree tree(structure);
  double smallest = -1;
  const auto take = [&smallest](double d) { smallest = smallest < 0 ? d : std::min(smallest, d); };
  for (Eigen::Index p = 0; p < sheet.points.rows(); ++p) {
    if (!inside[p]) continue;
    const Vec3 point = sheet.points.row(p).transpose();
    take(tree.Inside(point) ? 0.0 : tree.Closest(point).distance_mm);
  }
  if (smallest <= 0) return smallest;
  // The structure's own points against the sheet: between the sheet's points it may come nearer.
  SurfaceMesh within{sheet.points, Triangles(0, 3)};
  std::vector<Index> kept;
  for (Eigen::Index t = 0; t < sheet.triangles.rows(); ++t)
    if (inside[sheet.triangles(t, 0)] && inside[sheet.triangles(t, 1)] &&
        inside[sheet.triangles(t, 2)])
      kept.push_back(static_cast<Index>(t));
  within.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t t = 0; t < kept.size(); ++t)
    within.triangles.row(static_cast<Eigen::Index>(t)) = sheet.triangles.row(kept[t]);
  if (within.triangles.rows() == 0) return smallest;
  const SurfaceTree sheet_tree(within);
  for (Eigen::Index p = 0; p < structure.points.rows(); ++p)
    take(sheet_tree.Closest(structure.points.row(p).transpose()).distance_mm);
  return smallest;
}

/// Volume fraction of a tetrahedron where a linear function of corner values is ≤ 0.
double FractionBelow(std::array<double, 4> f) {
  std::sort(f.begin(), f.end());
  if (f[3] <= 0) return 1;
  if (f[0] > 0) return 0;
  const auto corner = [](double a, double b, double c, double d) {
    // Part cut off around the corner with value a, whose sign differs from the others'.
    return a * a * a / ((a - b) * (a - c) * (a - d));
  };
  if (f[1] > 0) return corner(f[0], f[1], f[2], f[3]);
  if (f[2] <= 0) return 1 - corner(f[3], f[0], f[1], f[2]);
  // Two and two: the difference of two truncated corners.
  const double a = f[0], b = f[1], c = f[2], d = f[3];
  if (a == b) {
    // Equal corners: the limit, by a step that does not matter in millilitres.
    return FractionBelow({a, b + 1e-9 * (1 + std::abs(b)), c, d});
  }
  const auto cube = [](double x) { return x * x * x; };
  return cube(-a) / ((b - a) * (c - a) * (d - a)) - cube(-b) / ((b - a) * (c - b) * (d - b));
}

}  // namespace

const SurfaceMesh* PlanningModel::Find(const std::string& name) const {
  for (const Structure& s : structures)
    if (s.name == name) return &s.rest;
  return nullptr;
}

Points LineOnSurface(const SurfaceMesh& organ, const Points& control, double step_mm) {
  if (control.rows() < 2 || organ.Empty()) return control;
  const SurfaceTree tree(organ);
  std::vector<Vec3> line;
  for (Eigen::Index c = 0; c + 1 < control.rows(); ++c) {
    const Vec3 a = control.row(c).transpose(), b = control.row(c + 1).transpose();
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm() / step_mm)));
    for (int i = 0; i < pieces; ++i)
      line.push_back(tree.Closest(a + (b - a) * (double(i) / pieces)).point);
  }
  line.push_back(tree.Closest(control.row(control.rows() - 1).transpose()).point);
  return Rows(line);
}

Vec3 SuggestDirection(const SurfaceMesh& organ, const Points& line) {
  Vec3 sum = Vec3::Zero();
  if (organ.Empty()) return Vec3::UnitZ();
  const SurfaceTree tree(organ);
  for (Eigen::Index p = 0; p < line.rows(); ++p) {
    const Index t = tree.Closest(line.row(p).transpose()).triangle;
    const auto corner = [&](int c) -> Vec3 {
      return organ.points.row(organ.triangles(t, c)).transpose();
    };
    sum -= (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
  }
  return sum.norm() > 1e-9 ? sum.normalized() : Vec3::UnitZ();
}

CutSurface ResectionSheet(const SurfaceMesh& organ, const ResectionPlan& plan, double beyond_mm) {
  const Points on_surface = LineOnSurface(organ, plan.line);
  if (on_surface.rows() < 2) return {};
  // The first and last few millimetres tell where the line would go on.
  const auto outwards = [&on_surface](Eigen::Index end, Eigen::Index step) -> Vec3 {
    const Eigen::Index back = std::min<Eigen::Index>(3, on_surface.rows() - 1) * step + end;
    return (on_surface.row(end) - on_surface.row(back)).transpose().normalized();
  };
  const Eigen::Index last = on_surface.rows() - 1;
  CutPolyline line;
  line.points.resize(on_surface.rows() + 2, 3);
  line.points.middleRows(1, on_surface.rows()) = on_surface;
  line.points.row(0) = on_surface.row(0) + beyond_mm * outwards(0, 1).transpose();
  line.points.row(last + 2) = on_surface.row(last) + beyond_mm * outwards(last, -1).transpose();
  return ExtrudePolyline(line, plan.direction, kAbove_mm, plan.depth_mm, kCell_mm);
}

std::vector<double> DistancesTo(const SurfaceMesh& surface, const Points& points) {
  const SurfaceTree tree(surface);
  std::vector<double> distances(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index p = 0; p < points.rows(); ++p)
    distances[p] = tree.Closest(points.row(p).transpose()).distance_mm;
  return distances;
}

std::string ResectionNote(const CutReport& report, bool divides) {
  if (!report.done)
    return "The model could not be cut along this sheet (" + report.reason +
           "). Move the line a little.";
  std::string note;
  if (report.partial)
    note = "The model could not be cut along the whole sheet (" + report.reason +
           "): the figures are of what was cut. Move the line a little.";
  if (!divides)
    note += std::string(note.empty() ? "" : " ") +
            "The sheet does not divide the organ: draw the line across its whole width, or make "
            "the sheet deeper.";
  return note;
}

ResectionMeasures MeasureResection(const PlanningModel& model, const ResectionPlan& plan,
                                   Progress& progress) {
  ResectionMeasures m;
  m.organ_ml = model.quality.volume_mm3 / 1000.0;
  m.sheet = ResectionSheet(model.organ_surface, plan);
  if (m.sheet.triangles.rows() == 0) {
    m.note = "Draw a line on the organ with two or more points.";
    return m;
  }
  progress.Report(0.1, "distances of the sheet");
  const SurfaceTree organ(model.organ_surface);
  std::vector<char> inside(static_cast<std::size_t>(m.sheet.points.rows()));
  for (Eigen::Index p = 0; p < m.sheet.points.rows(); ++p)
    inside[p] = organ.Inside(m.sheet.points.row(p).transpose());
  if (const SurfaceMesh* tumour = model.Find("tumour")) {
    m.sheet_to_tumour_mm = DistancesTo(*tumour, m.sheet.points);
    m.to_tumour_mm = SmallestDistance(m.sheet, inside, *tumour);
    m.margin_kept = m.to_tumour_mm >= plan.margin_mm;
  }
  if (const SurfaceMesh* internal = model.Find("internal"))
    m.to_internal_mm = SmallestDistance(m.sheet, inside, *internal);
  progress.ThrowIfCancelled();

  progress.Report(0.4, "cutting the model along the sheet");
  CutReport report;
  const TopologyChange cut = TetCutter().Cut(model.mesh, m.sheet, &report);
  progress.ThrowIfCancelled();
  if (!cut.changed) {
    m.note = ResectionNote(report, false);
    return m;
  }
  std::vector<Index> component;
  const int count = TetComponents(cut.mesh.tets, &component);
  std::vector<double> volume(count, 0.0), tumour(count, 0.0);
  for (Index t = 0; t < cut.mesh.TetCount(); ++t) {
    const double v = TetVolume(cut.mesh.rest, cut.mesh.tets, t);
    volume[component[t]] += v;
    if (cut.mesh.region[t] == static_cast<std::uint8_t>(Label::Tumour)) tumour[component[t]] += v;
  }
  m.divides = count > 1;
  m.note = ResectionNote(report, m.divides);
  if (!m.divides) return m;
  // The remnant is the largest piece that holds less than half of the tumour; all else goes.
  double all_tumour = 0;
  for (const double t : tumour) all_tumour += t;
  int remnant = -1;
  for (int c = 0; c < count; ++c)
    if ((all_tumour == 0 || tumour[c] < 0.5 * all_tumour) &&
        (remnant < 0 || volume[c] > volume[remnant]))
      remnant = c;
  m.remnant_ml = volume[remnant] / 1000.0;
  m.tumour_left_ml = tumour[remnant] / 1000.0;
  double whole = 0;
  for (const double v : volume) whole += v;
  m.removed_ml = whole / 1000.0 - m.remnant_ml;
  m.remnant_percent = 100.0 * volume[remnant] / whole;
  progress.Report(1.0, "measured");
  return m;
}

double TissueWithinMargin_ml(const PlanningModel& model, double margin_mm, Progress& progress) {
  const SurfaceMesh* tumour = model.Find("tumour");
  if (!tumour) return 0;
  const SurfaceTree tree(*tumour);
  std::vector<double> beyond(static_cast<std::size_t>(model.mesh.VertexCount()));
  for (Index v = 0; v < model.mesh.VertexCount(); ++v) {
    if (v % 4096 == 0) progress.ThrowIfCancelled();
    const Vec3 p = model.mesh.rest.row(v).transpose();
    const double d = tree.Closest(p).distance_mm;
    beyond[v] = (tree.Inside(p) ? -d : d) - margin_mm;
  }
  double volume = 0;
  for (Index t = 0; t < model.mesh.TetCount(); ++t) {
    std::array<double, 4> f;
    for (int c = 0; c < 4; ++c) f[c] = beyond[model.mesh.tets(t, c)];
    volume += TetVolume(model.mesh.rest, model.mesh.tets, t) * FractionBelow(f);
  }
  return volume / 1000.0;
}

}  // namespace kerf
