#include "Phantom/PhantomAnatomy.h"

#include <algorithm>
#include <cmath>

#include "Phantom/ImplicitMesher.h"
#include "Phantom/PhantomShape.h"

namespace kerf {
namespace {

/// Appends `part` with its marks; `flip` turns its triangles round.
void Append(const SurfaceMesh& part, int cut, int region, bool flip, PhantomAnatomy* out) {
  SurfaceMesh& to = out->organ;
  const Index base = static_cast<Index>(to.points.rows());
  to.points.conservativeResize(base + part.points.rows(), 3);
  to.points.bottomRows(part.points.rows()) = part.points;
  Triangles moved = part.triangles.array() + base;
  if (flip) moved.col(1).swap(moved.col(2));
  to.triangles.conservativeResize(to.triangles.rows() + moved.rows(), 3);
  to.triangles.bottomRows(moved.rows()) = moved;
  out->organ_cut.insert(out->organ_cut.end(), part.points.rows(), static_cast<std::int8_t>(cut));
  out->organ_region.insert(out->organ_region.end(), part.points.rows(),
                           static_cast<std::int8_t>(region));
}

/// Both faces of the sheet of a cut. @param section normals towards +x
void AppendFaces(const SurfaceMesh& section, int cut, PhantomAnatomy* out) {
  Append(section, cut + 1, cut, false, out);
  Append(section, cut + 1, cut + 1, true, out);
}

/// A rectangle of quads, each split in two: corner + i·u/nu + j·v/nv, normal u × v.
SurfaceMesh Panel(const Vec3& corner, const Vec3& u, const Vec3& v, double cell_mm) {
  const int nu = std::max(1, static_cast<int>(std::round(u.norm() / cell_mm)));
  const int nv = std::max(1, static_cast<int>(std::round(v.norm() / cell_mm)));
  SurfaceMesh mesh;
  mesh.points.resize((nu + 1) * (nv + 1), 3);
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i)
      mesh.points.row(j * (nu + 1) + i) =
          (corner + u * (double(i) / nu) + v * (double(j) / nv)).transpose();
  mesh.triangles.resize(2 * nu * nv, 3);
  Index n = 0;
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const Index a = j * (nu + 1) + i, b = a + 1, c = a + nu + 1, d = c + 1;
      mesh.triangles.row(n++) << a, b, d;
      mesh.triangles.row(n++) << a, d, c;
    }
  return mesh;
}

/// Joins points that coincide, so that a box of panels becomes one closed surface.
SurfaceMesh Welded(const std::vector<SurfaceMesh>& parts) {
  SurfaceMesh all;
  std::vector<Vec3> points;
  std::vector<std::array<Index, 3>> triangles;
  for (const SurfaceMesh& part : parts) {
    std::vector<Index> of(part.points.rows());
    for (Index i = 0; i < part.points.rows(); ++i) {
      const Vec3 p = part.points.row(i);
      const auto it = std::find_if(points.begin(), points.end(),
                                   [&](const Vec3& q) { return (p - q).squaredNorm() < 1e-12; });
      of[i] = static_cast<Index>(it - points.begin());
      if (it == points.end()) points.push_back(p);
    }
    for (Index t = 0; t < part.triangles.rows(); ++t)
      triangles.push_back(
          {of[part.triangles(t, 0)], of[part.triangles(t, 1)], of[part.triangles(t, 2)]});
  }
  all.points.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) all.points.row(i) = points[i].transpose();
  all.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t i = 0; i < triangles.size(); ++i)
    all.triangles.row(i) << triangles[i][0], triangles[i][1], triangles[i][2];
  return all;
}

constexpr double kBandCell_mm = 1.25;

/// Box from x0 to x1 without the ends that `open_low`/`open_high` leave out.
SurfaceMesh BandPart(const Vec3& size, double x0, double x1, bool open_low, bool open_high) {
  const Vec3 a(x0, -0.5 * size.y(), -0.5 * size.z());
  const Vec3 x(x1 - x0, 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  std::vector<SurfaceMesh> parts{Panel(a + z, x, y, kBandCell_mm), Panel(a, y, x, kBandCell_mm),
                                 Panel(a, x, z, kBandCell_mm), Panel(a + y, z, x, kBandCell_mm)};
  if (!open_low) parts.push_back(Panel(a, z, y, kBandCell_mm));
  if (!open_high) parts.push_back(Panel(a + x, y, z, kBandCell_mm));
  return Welded(parts);
}

void BuildBand(const PhantomSetup& setup, PhantomAnatomy* out) {
  const Vec3& size = setup.band_size_mm;
  const auto& cuts = setup.motion.cuts;
  double from = -0.5 * size.x();
  for (std::size_t k = 0; k <= cuts.size(); ++k) {
    const bool last = k == cuts.size();
    const double to = last ? 0.5 * size.x() : cuts[k].sheet_x_mm;
    Append(BandPart(size, from, to, k > 0, !last), 0, static_cast<int>(k), false, out);
    from = to;
  }
  for (int k = 0; k < static_cast<int>(cuts.size()); ++k)
    AppendFaces(Panel(Vec3(cuts[k].sheet_x_mm, -0.5 * size.y(), -0.5 * size.z()),
                      Vec3(0, size.y(), 0), Vec3(0, 0, size.z()), kBandCell_mm),
                k, out);
}

}  // namespace

PhantomAnatomy BuildPhantomAnatomy(const PhantomSetup& setup) {
  PhantomAnatomy anatomy;
  if (!setup.is_kidney) {
    BuildBand(setup, &anatomy);
    return anatomy;
  }
  const PhantomMotion motion(setup.motion);
  ImplicitMeshRequest organ{KidneyOrgan, Vec3(-58, -36, -32), Vec3(58, 38, 32), 2.4, {}, {}};
  for (int k = 0; k < motion.CutCount(); ++k)
    organ.sheets.push_back(static_cast<int>(std::lround(
        (setup.motion.cuts[k].sheet_x_mm - setup.motion.cuts[0].sheet_x_mm) / organ.cell_mm)));
  organ.sheet_x = [&](double y) { return motion.SheetX_mm(y, 0); };
  const ImplicitMesh mesh = MeshImplicit(organ);
  for (std::size_t k = 0; k < mesh.pieces.size(); ++k)
    Append(mesh.pieces[k], 0, static_cast<int>(k), false, &anatomy);
  for (std::size_t k = 0; k < mesh.sections.size(); ++k)
    AppendFaces(mesh.sections[k], static_cast<int>(k), &anatomy);
  anatomy.internal =
      MeshImplicit({KidneyCalyces, Vec3(-34, -18, -12), Vec3(34, 20, 12), 1.3, {}, {}}).pieces[0];
  anatomy.tumour =
      MeshImplicit({KidneyTumour, Vec3(16, -26, 3), Vec3(38, -5, 24), 1.5, {}, {}}).pieces[0];
  return anatomy;
}

PhantomSurfaceAtFrame OrganAtFrame(const PhantomAnatomy& anatomy, const PhantomMotion& motion,
                                   double frame) {
  const SurfaceMesh& rest = anatomy.organ;
  std::vector<Index> kept;
  for (Index t = 0; t < rest.triangles.rows(); ++t) {
    if (const int cut = anatomy.organ_cut[rest.triangles(t, 0)] - 1; cut >= 0) {
      Vec3 centre = Vec3::Zero();
      for (int k = 0; k < 3; ++k) centre += rest.points.row(rest.triangles(t, k)).transpose() / 3.0;
      if (motion.Depth_mm(centre, cut) >= motion.TipDepth_mm(frame, cut)) continue;
    }
    kept.push_back(t);
  }
  PhantomSurfaceAtFrame out;
  std::vector<Index> at(rest.points.rows(), -1);
  for (Index t : kept)
    for (int k = 0; k < 3; ++k) at[rest.triangles(t, k)] = 0;
  for (Index p = 0; p < rest.points.rows(); ++p)
    if (at[p] == 0) {
      at[p] = static_cast<Index>(out.pid.size());
      out.pid.push_back(p);
    }
  out.mesh.points.resize(static_cast<Eigen::Index>(out.pid.size()), 3);
  for (std::size_t i = 0; i < out.pid.size(); ++i)
    out.mesh.points.row(i) =
        motion.Position(rest.points.row(out.pid[i]), anatomy.organ_region[out.pid[i]], frame)
            .transpose();
  out.mesh.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i)
    for (int k = 0; k < 3; ++k) out.mesh.triangles(i, k) = at[rest.triangles(kept[i], k)];
  return out;
}

SurfaceMesh StructureAtFrame(const SurfaceMesh& rest, const PhantomMotion& motion, double frame) {
  SurfaceMesh out;
  out.points.resize(rest.points.rows(), 3);
  for (Index p = 0; p < rest.points.rows(); ++p)
    out.points.row(p) = motion.Position(rest.points.row(p), 0, frame).transpose();
  std::vector<Index> kept;
  for (Index t = 0; t < rest.triangles.rows(); ++t) {
    bool crossed = false;
    for (int k = 0; k < 3 && !crossed; ++k)
      for (int cut = 0; cut < motion.CutCount() && !crossed; ++cut) {
        const Vec3 a = rest.points.row(rest.triangles(t, k)),
                   b = rest.points.row(rest.triangles(t, (k + 1) % 3));
        const double sa = motion.SheetDistance_mm(a, cut), sb = motion.SheetDistance_mm(b, cut);
        if ((sa < 0.0) == (sb < 0.0)) continue;
        const double tip = motion.TipDepth_mm(frame, cut);
        crossed = tip > 0.0 && motion.Depth_mm(a + sa / (sa - sb) * (b - a), cut) < tip;
      }
    if (!crossed) kept.push_back(t);
  }
  out.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i) out.triangles.row(i) = rest.triangles.row(kept[i]);
  return out;
}

SurfaceMesh OpenedSheet(const PhantomAnatomy& anatomy, const PhantomMotion& motion, int cut,
                        double frame, std::vector<float>* depth_mm) {
  PhantomAnatomy face = anatomy;
  const Triangles& all = anatomy.organ.triangles;
  Index n = 0;
  for (Index t = 0; t < all.rows(); ++t)
    if (anatomy.organ_cut[all(t, 0)] == cut + 1 && anatomy.organ_region[all(t, 0)] == cut)
      face.organ.triangles.row(n++) = all.row(t);
  face.organ.triangles.conservativeResize(n, 3);
  PhantomSurfaceAtFrame opened = OrganAtFrame(face, motion, frame);
  depth_mm->clear();
  for (std::size_t i = 0; i < opened.pid.size(); ++i) {
    opened.mesh.points.row(i) = anatomy.organ.points.row(opened.pid[i]);
    depth_mm->push_back(static_cast<float>(motion.Depth_mm(opened.mesh.points.row(i), cut)));
  }
  return opened.mesh;
}

Points CutLine(const PhantomSetup& setup, const PhantomMotion& motion, int cut, double depth_mm) {
  if (depth_mm <= 0.0) return Points(0, 3);
  if (!setup.is_kidney) depth_mm = std::min(depth_mm, setup.band_size_mm.y());
  const int count = 1 + static_cast<int>(std::ceil(depth_mm / 0.75));
  Points line(count, 3);
  for (int i = 0; i < count; ++i) {
    const PhantomCutParameters& c = motion.Parameters().cuts[cut];
    const double y = c.entry_y_mm + c.into * std::max(1e-3, depth_mm * i / (count - 1));
    const double x = motion.SheetX_mm(y, cut);
    double z = 0.5 * setup.band_size_mm.z();
    if (setup.is_kidney) {
      double outside = 40.0, inside = -40.0;  // the highest crossing: start from above
      while (outside > -40.0 && KidneyOrgan({x, y, outside}) > 0.0) outside -= 0.05;
      if (outside <= -40.0) return line.topRows(i).eval();  // beyond the organ
      inside = outside;
      outside += 0.05;
      for (int step = 0; step < 30; ++step) {
        const double middle = 0.5 * (inside + outside);
        (KidneyOrgan({x, y, middle}) > 0.0 ? outside : inside) = middle;
      }
      z = 0.5 * (inside + outside);
    }
    line.row(i) << x, y, z;
  }
  return line;
}

Points ToWorld(const Points& points, const Eigen::Isometry3d& world_from_organ) {
  return ((points * world_from_organ.linear().transpose()).rowwise() +
          world_from_organ.translation().transpose())
      .eval();
}

}  // namespace kerf
