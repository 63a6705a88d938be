#include "Support/TestMeshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "Support/Draws.h"

namespace kerf::testing {
namespace {

void OrientAndLabel(TetMesh* mesh) {
  for (Index t = 0; t < mesh->TetCount(); ++t)
    if (TetVolume(mesh->rest, mesh->tets, t) < 0) std::swap(mesh->tets(t, 2), mesh->tets(t, 3));
  mesh->region.assign(mesh->TetCount(), static_cast<std::uint8_t>(Label::Organ));
}

template <class Matrix, class Row>
void Assign(const std::vector<Row>& rows, Matrix* out) {
  out->resize(static_cast<Index>(rows.size()), rows.empty() ? out->cols() : rows[0].size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (int k = 0; k < static_cast<int>(rows[i].size()); ++k) (*out)(i, k) = rows[i][k];
}

struct Icosahedron {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> faces;
  Icosahedron() {
    const double g = (1 + std::sqrt(5.0)) / 2;
    for (double s : {-1.0, 1.0})
      for (double t : {-g, g}) {
        points.push_back(Vec3(0, s, t).normalized());
        points.push_back(Vec3(s, t, 0).normalized());
        points.push_back(Vec3(t, 0, s).normalized());
      }
    const double edge = 2.0 / std::sqrt(1 + g * g) * 1.01;
    auto near = [&](int a, int b) { return (points[a] - points[b]).norm() < edge; };
    for (int a = 0; a < 12; ++a)
      for (int b = a + 1; b < 12; ++b)
        for (int c = b + 1; c < 12; ++c)
          if (near(a, b) && near(b, c) && near(a, c)) faces.push_back({a, b, c});
  }
};

}  // namespace

TetMesh BoxMesh(const Vec3& size, int nx, int ny, int nz) {
  TetMesh mesh;
  auto id = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  mesh.rest.resize((nx + 1) * (ny + 1) * (nz + 1), 3);
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i)
        mesh.rest.row(id(i, j, k)) << size[0] * (double(i) / nx - 0.5),
            size[1] * (double(j) / ny - 0.5), size[2] * (double(k) / nz - 0.5);
  std::vector<std::array<Index, 4>> tets;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        std::array<int, 3> axes{0, 1, 2};
        do {  // one tetrahedron for each way from corner to corner along the axes
          std::array<int, 3> at{i, j, k};
          std::array<Index, 4> tet{id(i, j, k), 0, 0, 0};
          for (int s = 0; s < 3; ++s) {
            ++at[axes[s]];
            tet[s + 1] = id(at[0], at[1], at[2]);
          }
          tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  Assign(tets, &mesh.tets);
  OrientAndLabel(&mesh);
  return mesh;
}

TetMesh BandMesh(int tets) {
  const double h = std::cbrt(120.0 * 40.0 * 10.0 * 6.0 / tets);
  auto cells = [&](double length) { return std::max(1, int(std::lround(length / h))); };
  return BoxMesh({120, 40, 10}, cells(120), cells(40), cells(10));
}

TetMesh EllipsoidMesh(const Vec3& half_axes, int n) {
  const Icosahedron ico;
  TetMesh mesh;
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<Index, 4>> tets;
  std::map<std::array<std::array<int, 2>, 3>, Index> vertex_of;  // (corner, share) triples
  for (const auto& face : ico.faces) {
    // Freudenthal: lattice points n ≥ a ≥ b ≥ c ≥ 0; share of the centre is n − a, of the corners
    // a−b, b−c, c.
    auto vertex = [&](const std::array<int, 3>& at) {
      const int share[3] = {at[0] - at[1], at[1] - at[2], at[2]};
      std::array<std::array<int, 2>, 3> key{};
      int used = 0;
      Vec3 p = Vec3::Zero();
      for (int k = 0; k < 3; ++k)
        if (share[k] > 0) {
          key[used++] = {face[k] + 1, share[k]};
          p += share[k] * ico.points[face[k]];
        }
      const auto [it, fresh] = vertex_of.insert({key, static_cast<Index>(points.size())});
      if (fresh) {
        if (at[0] > 0) p *= double(at[0]) / n / p.norm();
        p = p.cwiseProduct(half_axes);
        points.push_back({p[0], p[1], p[2]});
      }
      return it->second;
    };
    for (int a = 0; a < n; ++a)
      for (int b = 0; b <= a; ++b)
        for (int c = 0; c <= b; ++c) {
          std::array<int, 3> axes{0, 1, 2};
          do {
            std::array<int, 3> at{a, b, c};
            bool inside = true;
            std::array<std::array<int, 3>, 4> corner;
            corner[0] = at;
            for (int s = 0; s < 3; ++s) {
              ++at[axes[s]];
              inside = inside && at[0] <= n && at[1] <= at[0] && at[2] <= at[1];
              corner[s + 1] = at;
            }
            if (!inside) continue;
            tets.push_back(
                {vertex(corner[0]), vertex(corner[1]), vertex(corner[2]), vertex(corner[3])});
          } while (std::next_permutation(axes.begin(), axes.end()));
        }
  }
  Assign(points, &mesh.rest);
  Assign(tets, &mesh.tets);
  OrientAndLabel(&mesh);
  return mesh;
}

TetMesh SphereMesh(double radius_mm, int n) { return EllipsoidMesh(Vec3::Constant(radius_mm), n); }

TetMesh Jitter(TetMesh mesh, double amount, double min_dihedral_deg, unsigned seed) {
  std::mt19937 random(seed);
  auto uniform = [&] { return (random() >> 8) * (2.0 / (1 << 24)) - 1.0; };
  std::vector<char> fixed(mesh.VertexCount(), 0);
  const Triangles boundary = BoundaryFaces(mesh.tets);
  for (Index f = 0; f < boundary.rows(); ++f)
    for (int k = 0; k < 3; ++k) fixed[boundary(f, k)] = 1;
  std::vector<std::vector<Index>> tets_of(mesh.VertexCount());
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int k = 0; k < 4; ++k) tets_of[mesh.tets(t, k)].push_back(t);
  auto corner = [&](Index t, int k) { return Vec3(mesh.rest.row(mesh.tets(t, k)).transpose()); };
  for (Index v = 0; v < mesh.VertexCount(); ++v) {
    const Vec3 direction = DrawVec3(uniform);
    if (fixed[v]) continue;
    double shortest = 1e300;
    for (Index t : tets_of[v])
      for (int k = 0; k < 4; ++k)
        if (mesh.tets(t, k) != v)
          shortest = std::min(shortest, (corner(t, k).transpose() - mesh.rest.row(v)).norm());
    const Vec3 old = mesh.rest.row(v).transpose();
    for (double scale = amount * shortest; scale > 0.02 * shortest; scale *= 0.7) {
      mesh.rest.row(v) = (old + scale * direction).transpose();
      bool good = true;
      for (Index t : tets_of[v])
        good = good && SmallestDihedral_deg(corner(t, 0), corner(t, 1), corner(t, 2),
                                            corner(t, 3)) >= min_dihedral_deg;
      if (good) break;
      mesh.rest.row(v) = old.transpose();
    }
  }
  return mesh;
}

void PaintSphere(const Vec3& center, double radius_mm, Label label, TetMesh* mesh) {
  for (Index t = 0; t < mesh->TetCount(); ++t) {
    Vec3 c = Vec3::Zero();
    for (int k = 0; k < 4; ++k) c += mesh->rest.row(mesh->tets(t, k)).transpose() / 4;
    if ((c - center).norm() < radius_mm) mesh->region[t] = static_cast<std::uint8_t>(label);
  }
}

CutSurface RectangleCut(const Vec3& corner, const Vec3& u, const Vec3& v, int nu, int nv) {
  CutSurface cut;
  cut.points.resize((nu + 1) * (nv + 1), 3);
  cut.triangles.resize(2 * nu * nv, 3);
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i)
      cut.points.row(j * (nu + 1) + i) =
          (corner + u * (double(i) / nu) + v * (double(j) / nv)).transpose();
  Index f = 0;
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const Index a = j * (nu + 1) + i, b = a + 1, c = a + nu + 1, d = c + 1;
      cut.triangles.row(f++) << a, b, d;
      cut.triangles.row(f++) << a, d, c;
    }
  return cut;
}

CutSurface WithHole(const CutSurface& surface, const Vec3& center, double radius_mm) {
  CutSurface rest = surface;
  Index kept = 0;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    Vec3 middle = Vec3::Zero();
    for (int k = 0; k < 3; ++k)
      middle += surface.points.row(surface.triangles(t, k)).transpose() / 3;
    if ((middle - center).norm() >= radius_mm)
      rest.triangles.row(kept++) = surface.triangles.row(t);
  }
  rest.triangles.conservativeResize(kept, 3);
  return rest;
}

CutSurface Together(const CutSurface& a, const CutSurface& b) {
  CutSurface both;
  both.points.resize(a.points.rows() + b.points.rows(), 3);
  both.points << a.points, b.points;
  both.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  both.triangles.topRows(a.triangles.rows()) = a.triangles;
  both.triangles.bottomRows(b.triangles.rows()) =
      b.triangles.array() + static_cast<Index>(a.points.rows());
  return both;
}

SurfaceMesh SphereSurface(const Vec3& center, double radius_mm, int levels) {
  const Icosahedron ico;
  std::vector<Vec3> points = ico.points;
  std::vector<std::array<int, 3>> faces = ico.faces;
  for (auto& f : faces)
    if (points[f[0]].dot(points[f[1]].cross(points[f[2]])) < 0) std::swap(f[1], f[2]);
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    auto mid = [&](int a, int b) {
      const auto [it, fresh] =
          middle.insert({{std::min(a, b), std::max(a, b)}, static_cast<int>(points.size())});
      if (fresh) points.push_back((points[a] + points[b]).normalized());
      return it->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& f : faces) {
      const int ab = mid(f[0], f[1]), bc = mid(f[1], f[2]), ca = mid(f[2], f[0]);
      finer.push_back({f[0], ab, ca});
      finer.push_back({f[1], bc, ab});
      finer.push_back({f[2], ca, bc});
      finer.push_back({ab, bc, ca});
    }
    faces = std::move(finer);
  }
  for (auto& p : points) p = center + radius_mm * p;
  SurfaceMesh out;
  Assign(points, &out.points);
  Assign(faces, &out.triangles);
  return out;
}

SurfaceMesh TubeSurface(const Vec3& a, const Vec3& b, double radius_mm, int around, int along) {
  const Vec3 axis = (b - a).normalized();
  const Vec3 u = axis.unitOrthogonal(), v = axis.cross(u);
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> faces;
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i < around; ++i) {
      const double angle = 2 * M_PI * i / around;
      points.push_back(a + (b - a) * (double(j) / along) +
                       radius_mm * (std::cos(angle) * u + std::sin(angle) * v));
    }
  const int first = static_cast<int>(points.size());
  points.push_back(a);
  points.push_back(b);
  for (int i = 0; i < around; ++i) {
    const int n = (i + 1) % around, top = along * around;
    for (int j = 0; j < along; ++j) {
      const int p = j * around;
      faces.push_back({p + i, p + n, p + around + n});
      faces.push_back({p + i, p + around + n, p + around + i});
    }
    faces.push_back({first, n, i});
    faces.push_back({first + 1, top + i, top + n});
  }
  SurfaceMesh out;
  Assign(points, &out.points);
  Assign(faces, &out.triangles);
  return out;
}

}  // namespace kerf::testing
