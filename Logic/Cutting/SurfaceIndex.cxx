#include "Cutting/SurfaceIndex.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "Cutting/EdgeKey.h"

namespace kerf {
namespace {

constexpr int kLeafSize = 4;
constexpr double kAside_mm = 1e-9;  // rounding of distances from a plane
constexpr double kBeyond = 1e-3;    // of a segment, looked at beyond the part that is asked for

double BoxDistance2(const Vec3& low, const Vec3& high, const Vec3& p) {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

inline bool BoxesMeet(const Vec3& low, const Vec3& high, const Vec3& other_low,
                      const Vec3& other_high) {
  for (int k = 0; k < 3; ++k)
    if (low[k] > other_high[k] || other_low[k] > high[k]) return false;
  return true;
}

/// Closest point of a triangle (Ericson's regions). `feature`: 0–2 edge k, 3–5 corner k, 6 inside.
Vec3 ClosestOnTriangle(const std::array<Vec3, 3>& x, const Vec3& p, int* feature) {
  const Vec3 ab = x[1] - x[0], ac = x[2] - x[0], ap = p - x[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return *feature = 3, x[0];
  const Vec3 bp = p - x[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return *feature = 4, x[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return *feature = 0, x[0] + d1 / (d1 - d3) * ab;
  const Vec3 cp = p - x[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return *feature = 5, x[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return *feature = 2, x[0] + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return *feature = 1, x[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (x[2] - x[1]);
  *feature = 6;
  return x[0] + (vb * ab + vc * ac) / (va + vb + vc);
}

}  // namespace

std::vector<Index> EqualPoints(const Points& points) {
  const Index n = static_cast<Index>(points.rows());
  std::vector<Index> by_place(n), number(n);
  std::iota(by_place.begin(), by_place.end(), 0);
  auto less = [&](Index a, Index b) {
    for (int k = 0; k < 3; ++k)
      if (points(a, k) != points(b, k)) return points(a, k) < points(b, k);
    return false;
  };
  std::sort(by_place.begin(), by_place.end(),
            [&](Index a, Index b) { return less(a, b) || (!less(b, a) && a < b); });
  for (Index i = 0; i < n; ++i)
    number[by_place[i]] =
        i > 0 && !less(by_place[i - 1], by_place[i]) ? number[by_place[i - 1]] : by_place[i];
  return number;
}

SurfaceIndex::SurfaceIndex(const CutSurface& surface) {
  const std::vector<Index> number = EqualPoints(surface.points);

  struct Edge {
    std::uint64_t ends;
    int triangle, corner;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * surface.triangles.rows());
  triangles_.reserve(surface.triangles.rows());
  for (Index f = 0; f < surface.triangles.rows(); ++f) {
    Triangle triangle;
    std::array<Index, 3> id;
    for (int k = 0; k < 3; ++k) {
      id[k] = number[surface.triangles(f, k)];
      triangle.x[k] = surface.points.row(surface.triangles(f, k)).transpose();
    }
    const Vec3 normal = (triangle.x[1] - triangle.x[0]).cross(triangle.x[2] - triangle.x[0]);
    const double twice_area = normal.norm();
    if (!(twice_area > 1e-12)) continue;  // a triangle without area separates nothing
    triangle.normal = normal / twice_area;
    triangle.row = f;
    triangle.border = {false, false, false};
    for (int k = 0; k < 3; ++k) {
      edges.push_back({EdgeKey(id[k], id[(k + 1) % 3]), static_cast<int>(triangles_.size()), k});
    }
    triangles_.push_back(triangle);
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.ends < b.ends; });
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t j = i + 1;
    while (j < edges.size() && edges[j].ends == edges[i].ends) ++j;
    if (j == i + 1) triangles_[edges[i].triangle].border[edges[i].corner] = true;
    i = j;
  }
  if (triangles_.empty()) return;
  std::vector<Place> places(triangles_.size());
  for (std::size_t t = 0; t < places.size(); ++t) {
    const auto& x = triangles_[t].x;
    places[t] = {x[0] + x[1] + x[2], static_cast<int>(t)};
  }
  nodes_.reserve(places.size());
  Build(0, static_cast<int>(places.size()), &places);
  std::vector<Triangle> in_order;  // neighbours in the tree are neighbours in memory
  in_order.reserve(places.size());
  for (const Place& place : places) in_order.push_back(triangles_[place.triangle]);
  triangles_ = std::move(in_order);
}

int SurfaceIndex::Build(int first, int count, std::vector<Place>* places) {
  const int index = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Vec3 low, high;
  int left = -1, right = -1;
  if (count > kLeafSize) {
    Vec3 center_low = (*places)[first].center, center_high = center_low;
    for (int i = first + 1; i < first + count; ++i) {
      center_low = center_low.cwiseMin((*places)[i].center);
      center_high = center_high.cwiseMax((*places)[i].center);
    }
    int axis;
    (center_high - center_low).maxCoeff(&axis);
    const auto begin = places->begin() + first;
    // In the middle of the room they take; where that is lopsided, in the middle of their number.
    const double middle = 0.5 * (center_low[axis] + center_high[axis]);
    int half = static_cast<int>(
        std::partition(begin, begin + count,
                       [&](const Place& place) { return place.center[axis] < middle; }) -
        begin);
    if (std::min(half, count - half) < count / 4) {
      half = count / 2;
      std::nth_element(begin, begin + half, begin + count, [&](const Place& a, const Place& b) {
        return a.center[axis] != b.center[axis] ? a.center[axis] < b.center[axis]
                                                : a.triangle < b.triangle;
      });
    }
    left = Build(first, half, places);
    right = Build(first + half, count - half, places);
    low = nodes_[left].low.cwiseMin(nodes_[right].low);
    high = nodes_[left].high.cwiseMax(nodes_[right].high);
  } else {
    low = high = triangles_[(*places)[first].triangle].x[0];
    for (int i = first; i < first + count; ++i)
      for (const Vec3& p : triangles_[(*places)[i].triangle].x) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
  }
  const Vec3 normal = triangles_[(*places)[first].triangle].normal;
  double back = 1e300, front = -1e300;
  for (int i = first; i < first + count; ++i)
    for (const Vec3& p : triangles_[(*places)[i].triangle].x) {
      const double at = normal.dot(p);
      back = std::min(back, at);
      front = std::max(front, at);
    }
  nodes_[index] = {low,  high,  normal, back - kAside_mm,    front + kAside_mm,
                   left, right, first,  left < 0 ? count : 0};
  return index;
}

void SurfaceIndex::CloseTo(int index, const Vec3& p, SurfaceNear* best) const {
  const Node& node = nodes_[index];
  for (int i = node.first; i < node.first + node.count; ++i) {
    const Triangle& triangle = triangles_[i];
    int feature;
    const Vec3 q = ClosestOnTriangle(triangle.x, p, &feature);
    const double d = (p - q).norm();
    if (d > best->distance_mm || (d == best->distance_mm && triangle.row > best->triangle))
      continue;
    const bool border = feature < 3 ? triangle.border[feature]
                        : feature == 6
                            ? false
                            : triangle.border[feature - 3] || triangle.border[(feature - 1) % 3];
    *best = {d, q, triangle.normal, triangle.row, border};
  }
  if (node.left < 0) return;
  int near = node.left, far = node.right;
  double near2 = BoxDistance2(nodes_[near].low, nodes_[near].high, p);
  double far2 = BoxDistance2(nodes_[far].low, nodes_[far].high, p);
  if (far2 < near2) {
    std::swap(near, far);
    std::swap(near2, far2);
  }
  if (near2 <= best->distance_mm * best->distance_mm) CloseTo(near, p, best);
  if (far2 <= best->distance_mm * best->distance_mm) CloseTo(far, p, best);
}

SurfaceNear SurfaceIndex::Closest(const Vec3& p, double max_distance_mm) const {
  SurfaceNear best;
  best.distance_mm = max_distance_mm;
  if (!Empty()) CloseTo(0, p, &best);
  return best;
}

bool SurfaceIndex::BorderWithin(const Vec3& p, double distance_mm) const {
  if (Empty()) return false;
  const double reach2 = distance_mm * distance_mm;
  int stack[64], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (BoxDistance2(node.low, node.high, p) > reach2) continue;
    for (int i = node.first; i < node.first + node.count; ++i)
      for (int k = 0; k < 3; ++k) {
        if (!triangles_[i].border[k]) continue;
        const Vec3 a = triangles_[i].x[k], ab = triangles_[i].x[(k + 1) % 3] - a;
        const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
        if ((a + t * ab - p).squaredNorm() <= reach2) return true;
      }
    if (node.left >= 0) {
      stack[top++] = node.right;
      stack[top++] = node.left;
    }
  }
  return false;
}

void SurfaceIndex::Crossings(const Vec3& a, const Vec3& b, std::vector<double>* t, double from,
                             double to) const {
  t->clear();
  if (Empty()) return;
  const Vec3 ab = b - a;
  // Where boxes and slabs are looked at: a little more than what is asked for.
  const Vec3 start = from > 0 ? Vec3(a + (from - kBeyond) * ab) : a;
  const Vec3 end = to < 1 ? Vec3(a + (to + kBeyond) * ab) : b;
  const Vec3 low = start.cwiseMin(end), high = start.cwiseMax(end), way = end - start;
  int stack[64], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!BoxesMeet(node.low, node.high, low, high)) continue;
    const double at_start = node.normal.dot(start), at_end = node.normal.dot(end);
    if ((at_start > node.front && at_end > node.front) ||
        (at_start < node.back && at_end < node.back))
      continue;
    if (std::abs(at_end - at_start) > kAside_mm) {  // only the piece between the two planes counts
      const double inverse = 1 / (at_end - at_start);
      const double enters = std::clamp((node.back - at_start) * inverse, 0.0, 1.0);
      const double leaves = std::clamp((node.front - at_start) * inverse, 0.0, 1.0);
      const Vec3 p = start + enters * way, q = start + leaves * way, slack = Vec3::Constant(1e-6);
      if (!BoxesMeet(node.low, node.high, p.cwiseMin(q) - slack, p.cwiseMax(q) + slack)) continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const auto& x = triangles_[i].x;
      const double side_a = triangles_[i].normal.dot(a - x[0]);
      const double side_b = triangles_[i].normal.dot(b - x[0]);
      if ((side_a > kAside_mm && side_b > kAside_mm) ||
          (side_a < -kAside_mm && side_b < -kAside_mm))
        continue;
      const Vec3 e1 = x[1] - x[0], e2 = x[2] - x[0], p = ab.cross(e2);
      const double det = e1.dot(p);
      if (std::abs(det) < 1e-14 * e1.norm() * e2.norm() * ab.norm()) continue;
      const Vec3 s = a - x[0];
      const double u = s.dot(p) / det;
      const Vec3 q = s.cross(e1);
      const double v = ab.dot(q) / det, at = e2.dot(q) / det;
      constexpr double kSlack =
          1e-9;  // a segment through an edge of S is not lost between two triangles
      if (u >= -kSlack && v >= -kSlack && u + v <= 1 + kSlack && at >= 0 && at <= 1)
        t->push_back(at);
    }
    if (node.left >= 0) {
      stack[top++] = node.right;
      stack[top++] = node.left;
    }
  }
  std::sort(t->begin(), t->end());
  t->erase(std::unique(t->begin(), t->end(), [](double x, double y) { return y - x < 1e-7; }),
           t->end());
}

bool SurfaceIndex::MeetsBox(const Vec3& low, const Vec3& high) const {
  if (Empty()) return false;
  const Vec3 center = 0.5 * (low + high), half = 0.5 * (high - low);
  // The box between two planes with this normal?
  const auto between = [&](const Vec3& normal, double back, double front) {
    const double at = normal.dot(center), reach = half.dot(normal.cwiseAbs());
    return at - reach <= front && at + reach >= back;
  };
  int stack[64], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!BoxesMeet(node.low, node.high, low, high) || !between(node.normal, node.back, node.front))
      continue;
    if (node.left >= 0) {
      stack[top++] = node.right;
      stack[top++] = node.left;
      continue;
    }
    for (int i = node.first; i < node.first + node.count; ++i) {
      const auto& x = triangles_[i].x;
      const double at = triangles_[i].normal.dot(x[0]);
      if (BoxesMeet(x[0].cwiseMin(x[1]).cwiseMin(x[2]), x[0].cwiseMax(x[1]).cwiseMax(x[2]), low,
                    high) &&
          between(triangles_[i].normal, at - kAside_mm, at + kAside_mm))
        return true;
    }
  }
  return false;
}

}  // namespace kerf
