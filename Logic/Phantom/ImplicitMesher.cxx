#include "Phantom/ImplicitMesher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "Phantom/PhantomShape.h"

namespace kerf {
namespace {

/// Grid with a node column on each sheet; each cell is split into six tetrahedra around
/// its diagonal, so that neighbouring cells share their face diagonals.
class Grid {
 public:
  explicit Grid(const ImplicitMeshRequest& request) : request_(request) {
    const double h = request.cell_mm;
    const bool divided = !request.sheets.empty();
    const double centre =
        divided ? request.sheet_x(0.5 * (request.low.y() + request.high.y())) : request.low.x();
    const int below = divided ? static_cast<int>(std::ceil((centre - request.low.x()) / h)) + 3 : 1;
    for (int n : request.sheets) planes_.push_back(below + n);
    start_ =
        Vec3(divided ? -below * h : request.low.x() - h, request.low.y() - h, request.low.z() - h);
    const double end_x = divided ? request.high.x() - centre + 3 * h : request.high.x() + h;
    size_ = {static_cast<int>(std::ceil((end_x - start_.x()) / h)) + 1,
             static_cast<int>(std::ceil((request.high.y() + h - start_.y()) / h)) + 1,
             static_cast<int>(std::ceil((request.high.z() + h - start_.z()) / h)) + 1};
    values_.resize(std::size_t(size_[0]) * size_[1] * size_[2]);
    for (std::size_t n = 0; n < values_.size(); ++n)
      values_[n] = request.f(Node(static_cast<int>(n)));
  }
  const std::array<int, 3>& Size() const { return size_; }
  /// Node columns of the sheets.
  const std::vector<int>& Planes() const { return planes_; }
  int Id(int i, int j, int k) const { return (k * size_[1] + j) * size_[0] + i; }
  double Value(int node) const { return values_[node]; }
  /// x − sheet_x(y) of the sheet on which both nodes lie.
  std::optional<double> SharedSheet(int a, int b) const {
    if (a % size_[0] != b % size_[0]) return std::nullopt;
    for (std::size_t s = 0; s < planes_.size(); ++s)
      if (a % size_[0] == planes_[s]) return request_.sheets[s] * request_.cell_mm;
    return std::nullopt;
  }
  Vec3 Node(int node) const {
    const int i = node % size_[0], j = (node / size_[0]) % size_[1],
              k = node / (size_[0] * size_[1]);
    return Bent(start_ + request_.cell_mm * Vec3(i, j, k));
  }
  /// Straight grid coordinates (x measured from the first sheet) to the body's axes.
  Vec3 Bent(const Vec3& p) const {
    return !planes_.empty() ? Vec3(p.x() + request_.sheet_x(p.y()), p.y(), p.z()) : p;
  }
  /// The surface point of an edge; edges on the sheet stay on it.
  Vec3 EdgePoint(int a, int b) const {
    const auto on_sheet = SharedSheet(a, b);
    const Vec3 pa = Node(a), pb = Node(b);
    const double va = Value(a), vb = Value(b);
    // Kept off the nodes (no slivers), then slid onto the surface.
    Vec3 p = pa + std::clamp(va / (va - vb), 0.12, 0.88) * (pb - pa);
    for (int step = 0; step < 6; ++step) {
      Vec3 g = NumericGradient(request_.f, p);
      if (on_sheet) {
        // Move within the sheet: along y the sheet's own slope comes along.
        const double slope =
            (request_.sheet_x(p.y() + 0.05) - request_.sheet_x(p.y() - 0.05)) / 0.1;
        const double gy = g.y() + slope * g.x();
        const double length2 = gy * gy + g.z() * g.z();
        const double scale = request_.f(p) / std::max(length2, 1e-6);
        const double y = p.y() - scale * gy;
        p = Vec3(request_.sheet_x(y) + *on_sheet, y, p.z() - scale * g.z());
      } else {
        p -= request_.f(p) / std::max(g.squaredNorm(), 1e-6) * g;
      }
    }
    return p;
  }

 private:
  const ImplicitMeshRequest& request_;
  std::array<int, 3> size_{};
  Vec3 start_;
  std::vector<int> planes_;
  std::vector<double> values_;
};

/// Collects triangles over vertices that are named by grid edges (or by a node twice).
class Builder {
 public:
  explicit Builder(const Grid& grid) : grid_(grid) {}
  Index Edge(int a, int b) {
    const auto key = std::minmax(a, b);
    const auto [it, fresh] =
        index_.try_emplace({key.first, key.second}, static_cast<Index>(points_.size()));
    if (fresh) {
      points_.push_back(a == b ? grid_.Node(a) : grid_.EdgePoint(key.first, key.second));
      middle_.push_back(0.5 * (grid_.Node(a) + grid_.Node(b)));
    }
    return it->second;
  }
  /// Adds a triangle whose normal has a positive product with `outward`: told from the middles of
  /// the edges, which cannot be degenerate.
  void Add(Index a, Index b, Index c, const Vec3& outward) {
    const Vec3 n = (middle_[b] - middle_[a]).cross(middle_[c] - middle_[a]);
    if (n.dot(outward) < 0.0) std::swap(b, c);
    triangles_.push_back({a, b, c});
  }
  SurfaceMesh Build() const {
    SurfaceMesh mesh;
    mesh.points.resize(static_cast<Eigen::Index>(points_.size()), 3);
    for (std::size_t i = 0; i < points_.size(); ++i) mesh.points.row(i) = points_[i].transpose();
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
    for (std::size_t i = 0; i < triangles_.size(); ++i)
      for (int k = 0; k < 3; ++k) mesh.triangles(i, k) = triangles_[i][k];
    return mesh;
  }

 private:
  const Grid& grid_;
  std::map<std::pair<int, int>, Index> index_;
  std::vector<Vec3> points_, middle_;
  std::vector<std::array<Index, 3>> triangles_;
};

void MarchTetrahedron(const Grid& grid, const std::array<int, 4>& node, Builder* out) {
  std::array<int, 4> in{}, outside{};
  int n_in = 0, n_out = 0;
  Vec3 outward = Vec3::Zero();
  for (int n : node) {
    if (grid.Value(n) < 0.0) {
      in[n_in++] = n;
      outward -= grid.Node(n);
    } else {
      outside[n_out++] = n;
    }
  }
  if (n_in == 0 || n_out == 0) return;
  outward /= n_in;
  for (int i = 0; i < n_out; ++i) outward += grid.Node(outside[i]) / n_out;
  if (n_in == 1) {
    out->Add(out->Edge(in[0], outside[0]), out->Edge(in[0], outside[1]),
             out->Edge(in[0], outside[2]), outward);
  } else if (n_in == 3) {
    out->Add(out->Edge(in[0], outside[0]), out->Edge(in[1], outside[0]),
             out->Edge(in[2], outside[0]), outward);
  } else {
    const Index a = out->Edge(in[0], outside[0]), b = out->Edge(in[0], outside[1]);
    const Index c = out->Edge(in[1], outside[1]), d = out->Edge(in[1], outside[0]);
    out->Add(a, b, c, outward);
    out->Add(a, c, d, outward);
  }
}

/// The inside part of one triangle of grid nodes on the sheet.
void ClipTriangle(const Grid& grid, const std::array<int, 3>& node, Builder* out) {
  std::array<Index, 4> polygon{};
  int n = 0;
  for (int i = 0; i < 3; ++i) {
    const int a = node[i], b = node[(i + 1) % 3];
    const bool a_in = grid.Value(a) < 0.0, b_in = grid.Value(b) < 0.0;
    if (a_in) polygon[n++] = out->Edge(a, a);
    if (a_in != b_in) polygon[n++] = out->Edge(a, b);
  }
  for (int i = 2; i < n; ++i) out->Add(polygon[0], polygon[i - 1], polygon[i], Vec3::UnitX());
}

}  // namespace

ImplicitMesh MeshImplicit(const ImplicitMeshRequest& request) {
  const Grid grid(request);
  const std::vector<int>& planes = grid.Planes();
  std::vector<Builder> pieces(planes.size() + 1, Builder(grid)),
      sections(planes.size(), Builder(grid));
  const auto& size = grid.Size();
  // The six paths from corner 000 to corner 111.
  static const int kSteps[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k + 1 < size[2]; ++k) {
    for (int j = 0; j + 1 < size[1]; ++j) {
      for (int i = 0; i + 1 < size[0]; ++i) {
        Builder& piece = pieces[std::upper_bound(planes.begin(), planes.end(), i) - planes.begin()];
        for (const auto& steps : kSteps) {
          std::array<int, 3> at{i, j, k};
          std::array<int, 4> node{grid.Id(i, j, k), 0, 0, 0};
          for (int n = 0; n < 3; ++n) {
            ++at[steps[n]];
            node[n + 1] = grid.Id(at[0], at[1], at[2]);
          }
          MarchTetrahedron(grid, node, &piece);
        }
      }
      for (std::size_t s = 0; s < planes.size(); ++s) {
        const int i = planes[s];
        ClipTriangle(grid, {grid.Id(i, j, k), grid.Id(i, j + 1, k), grid.Id(i, j + 1, k + 1)},
                     &sections[s]);
        ClipTriangle(grid, {grid.Id(i, j, k), grid.Id(i, j + 1, k + 1), grid.Id(i, j, k + 1)},
                     &sections[s]);
      }
    }
  }
  ImplicitMesh mesh;
  for (const Builder& piece : pieces) mesh.pieces.push_back(piece.Build());
  for (const Builder& section : sections) mesh.sections.push_back(section.Build());
  return mesh;
}

}  // namespace kerf
