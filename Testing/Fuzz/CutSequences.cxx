#include "Fuzz/CutSequences.h"

#include <cmath>
#include <map>
#include <random>
#include <sstream>

#include "Cutting/CutRegion.h"
#include "Cutting/DisjointSets.h"
#include "Cutting/ExtrudePolyline.h"
#include "Cutting/SurfaceIndex.h"
#include "Cutting/TetCutter.h"
#include "Support/Draws.h"
#include "Support/TestMeshes.h"

namespace kerf::testing {
namespace {

/// The same numbers on every platform.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed * 2654435761u + 17u) {}
  double Uniform(double low, double high) {
    return low + (high - low) * double(engine_() >> 5) / double(1u << 27);
  }
  Vec3 Within(double low, double high) {
    return DrawVec3([&] { return Uniform(low, high); });
  }
  int Int(int count) { return static_cast<int>(engine_() % unsigned(count)); }
  Vec3 Direction() {
    while (true) {
      const Vec3 d = Within(-1, 1);
      if (d.norm() > 0.2 && d.norm() < 1) return d.normalized();
    }
  }

 private:
  std::mt19937 engine_;
};

TetMesh ZooMesh(Random& random, std::string* name) {
  TetMesh mesh;
  switch (random.Int(6)) {
    case 0:
      *name = "sphere";
      mesh = SphereMesh(30, 3 + random.Int(3));
      break;
    case 1:
      *name = "ellipsoid";
      mesh = EllipsoidMesh({45, 30, 20}, 3 + random.Int(3));
      break;
    case 2:
      *name = "band";
      mesh = BandMesh(400 + random.Int(2000));
      break;
    case 3: {
      *name = "box";
      const int z = 3 + random.Int(4), y = 3 + random.Int(4), x = 3 + random.Int(4);
      mesh = BoxMesh({40, 40, 40}, x, y, z);
      break;
    }
    case 4: {
      *name = "irregular sphere";
      const unsigned seed = 1 + random.Int(1000);
      mesh = Jitter(SphereMesh(30, 3 + random.Int(3)), 0.8, 8, seed);
      break;
    }
    default:
      *name = "irregular box";
      mesh = Jitter(BoxMesh({50, 40, 30}, 6, 5, 4), 0.8, 8, 1 + random.Int(1000));
  }
  PaintSphere({5, 3, 2}, 10, Label::Tumour, &mesh);
  return mesh;
}

/// One cut as it grows. `complete`: it passes through the whole organ at its end.
std::vector<CutSurface> GrowingCut(Random& random, const TetMesh& mesh, std::string* name,
                                   std::optional<CutPlane>* complete) {
  const Vec3 low = mesh.rest.colwise().minCoeff().transpose();
  const Vec3 high = mesh.rest.colwise().maxCoeff().transpose();
  const double size = (high - low).norm();
  const int kind = random.Int(8), steps = 1 + random.Int(6);
  const double cell = random.Uniform(0.03, 0.12) * size;
  Vec3 normal = random.Direction();
  if (random.Int(3) == 0) normal = Vec3::Unit(random.Int(3));  // along the grid of boxes
  Vec3 through = low + (high - low).cwiseProduct(random.Within(0.2, 0.8));
  if (random.Int(3) == 0)  // exactly through a vertex, so that vertices, edges and faces are grazed
    through = mesh.rest.row(random.Int(mesh.VertexCount())).transpose();
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<CutSurface> cuts;
  double width = 1.3, start = -1.3, depth = 2.6;  // of `size`
  switch (kind) {
    case 0:
    case 1:
      *name += " full";
      width = 2.6;
      *complete = CutPlane{through, normal};
      break;
    case 2:
      *name += " half";
      break;
    case 3:
      *name += " depth";
      width = 2.6;
      depth = random.Uniform(1.0, 1.5);
      break;
    case 4:
      *name += " inside";
      start = random.Uniform(-0.2, 0);
      width = random.Uniform(0.1, 0.5);
      depth = -1;
      break;
    default:
      break;
  }
  if (kind >= 5) {  // curved, extruded from a polyline
    *name += " curved";
    const double bend = random.Uniform(-0.12, 0.12) * size, turns = random.Uniform(2, 7);
    const int points = 4 + random.Int(18);
    for (int s = 1; s <= steps; ++s) {
      const int used = std::max(2, points * s / steps);
      Points line(used, 3), ways(used, 3);
      for (int i = 0; i < used; ++i) {
        const double at = double(i) / (points - 1) - 0.5;
        line.row(i) =
            (through + 1.1 * size * at * u + bend * std::sin(turns * at) * normal - 0.6 * size * v)
                .transpose();
        ways.row(i) = (v + 0.2 * at * normal).normalized().transpose();
      }
      cuts.push_back(
          ExtrudePolyline(line, ways, 0.1 * size, random.Int(2) ? 1.4 * size : 0.7 * size, cell));
    }
    return cuts;
  }
  const Vec3 side = depth < 0 ? Vec3(-0.15 * size * v) : Vec3(-1.3 * size * v);
  const Vec3 down = depth < 0 ? Vec3(0.3 * size * v) : Vec3(depth * size * v);
  for (int s = 1; s <= steps; ++s) {
    const double length = width * s / steps;
    cuts.push_back(RectangleCut(through + start * size * u + side, length * size * u, down,
                                std::max(1, int(length * size / cell)),
                                std::max(1, int(down.norm() / cell))));
  }
  return cuts;
}

std::string Problem(const TetMesh& mesh, const MeshQuality& start, const Points& positions,
                    double start_deformed_deg, const TetMesh& first, CutSequenceResult* result) {
  std::ostringstream out;
  const MeshQuality q = MeasureQuality(mesh, mesh.rest);
  result->smallest_dihedral_deg = std::min(result->smallest_dihedral_deg, q.smallest_dihedral_deg);
  if (q.inverted > 0) out << q.inverted << " inverted; ";
  if (q.orphans > 0) out << q.orphans << " orphans; ";
  if (!q.manifold_boundary) out << "boundary not 2-manifold; ";
  if (std::abs(q.volume_mm3 / start.volume_mm3 - 1) > 1e-6)
    out << "volume changed by " << q.volume_mm3 / start.volume_mm3 - 1 << "; ";
  if (start.smallest_dihedral_deg >= 8 && q.smallest_dihedral_deg < 3)
    out << "dihedral angle " << q.smallest_dihedral_deg << "; ";
  if (positions.rows() > 0) {
    const MeshQuality d = MeasureQuality(mesh, positions);
    result->smallest_deformed_deg =
        std::min(result->smallest_deformed_deg, d.smallest_dihedral_deg);
    if (d.inverted > 0 || (start_deformed_deg >= 2 && d.smallest_dihedral_deg < 0.5))
      out << "as deformed " << d.inverted << " inverted, " << d.smallest_dihedral_deg << " deg; ";
  }
  return out.str();
}

std::string ProvenanceProblem(const TetMesh& old_mesh, const TopologyChange& change,
                              const Embedding& points, const Points& rest, Embedding* mapped) {
  std::ostringstream out;
  const double error =
      (change.MapVertexField(old_mesh.rest) - change.mesh.rest).cwiseAbs().maxCoeff();
  if (!(error < 1e-9)) out << "provenance is off by " << error << " mm; ";
  std::vector<char> seen(change.mesh.TetCount(), 0);
  for (Index t = 0; t < old_mesh.TetCount(); ++t)
    if (change.kept_tet[t] >= 0) {
      const Index k = change.kept_tet[t];
      ++seen[k];
      if (change.parent_tet[k] != t || change.mesh.tets.row(k) != old_mesh.tets.row(t)) {
        out << "kept tetrahedron " << t << " differs; ";
        break;
      }
    }
  for (Index t : change.new_tets) ++seen[t];
  for (char s : seen)
    if (s != 1) {
      out << "a tetrahedron is not either kept or new; ";
      break;
    }
  *mapped = change.MapEmbedding(points, old_mesh);
  const double moved =
      (mapped->Positions(change.mesh.rest, change.mesh.tets) - rest).cwiseAbs().maxCoeff();
  if (!(moved < 1e-9)) out << "material points moved by " << moved << " mm; ";
  return out.str();
}

/// Tetrahedra that S may have something to cut in.
Index TetsThatMeet(const TetMesh& mesh, const CutSurface& surface) {
  constexpr double kSlack = 1e-3;  // of the longest edge of a box
  const SurfaceIndex index(surface);
  Index count = 0;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    CutBox box = BoxOf(mesh.rest, mesh.tets.row(t));
    box.Grow(kSlack * (box.high - box.low).maxCoeff());
    count += index.MeetsBox(box.low.transpose(), box.high.transpose());
  }
  return count;
}

/// Size and number of what an increment has made, against the mesh it cut and the first one.
std::string GrowthProblem(const TetMesh& old_mesh, const TopologyChange& change,
                          const CutSurface& surface, const CutReport& report,
                          const MeshQuality& start, CutSequenceResult* result) {
  std::ostringstream out;
  const CutOptions promised;
  const TetMesh& mesh = change.mesh;
  const MeshQuality old = MeasureQuality(old_mesh, old_mesh.rest);
  const double mean_mm3 = old.volume_mm3 / old_mesh.TetCount();
  double smallest_mm3 = 1e300;
  for (Index t : change.new_tets)
    smallest_mm3 = std::min(smallest_mm3, TetVolume(mesh.rest, mesh.tets, t));
  const double share = smallest_mm3 / mean_mm3;
  result->smallest_volume_share = std::min(result->smallest_volume_share, share);
  const double rounding = 1 - 1e-5, least = rounding * promised.min_volume_share;
  if (share < std::min(least, rounding * old.smallest_tet_volume_mm3 / mean_mm3))
    out << "a tetrahedron of " << share << " of the mean one; ";
  const double mean_now_mm3 = mean_mm3 * old_mesh.TetCount() / mesh.TetCount();
  if (MeasureQuality(mesh, mesh.rest).smallest_tet_volume_mm3 <
      std::min(least * mean_now_mm3, rounding * start.smallest_tet_volume_mm3))
    out << "smaller tetrahedra than promised after all increments; ";
  if (std::abs(report.smallest_volume_share - share) > 1e-4 * share)
    out << "the volume share is not as reported; ";
  const Index vertices = mesh.VertexCount() - old_mesh.VertexCount();
  const Index tets = mesh.TetCount() - old_mesh.TetCount();
  if (report.new_vertices != vertices || report.new_tets != tets)
    out << "growth is not as reported; ";
  const double crossed = std::max<Index>(1, report.crossed_tets);
  result->most_new_vertices = std::max(result->most_new_vertices, vertices / crossed);
  result->most_new_tets = std::max(result->most_new_tets, tets / crossed);
  if (vertices > promised.max_new_vertices * report.crossed_tets ||
      tets > promised.max_new_tets * report.crossed_tets)
    out << vertices << " vertices and " << tets << " tetrahedra for " << report.crossed_tets
        << "; ";
  if (report.crossed_tets > TetsThatMeet(old_mesh, surface))
    out << "more crossed tetrahedra than meet S; ";
  return out.str();
}

std::vector<int> PieceOfTets(const TetMesh& mesh) {
  DisjointSets joined(mesh.VertexCount());
  for (Index t = 0; t < mesh.TetCount(); ++t)
    for (int k = 1; k < 4; ++k) joined.Join(mesh.tets(t, 0), mesh.tets(t, k));
  std::vector<int> piece(mesh.TetCount());
  for (Index t = 0; t < mesh.TetCount(); ++t)
    piece[t] = static_cast<int>(joined.Find(mesh.tets(t, 0)));
  return piece;
}

/// The share of a tetrahedron below zero of a linear function with these values at its corners.
double ShareBelow(Vec4 values) {
  std::sort(values.data(), values.data() + 4);
  const int below = static_cast<int>((values.array() < 0).count());
  if (below == 0 || below == 4) return below / 4;
  if (below == 3) return 1 - ShareBelow(-values);
  const double apart = 1e-7 * (values[3] - values[0]);
  if (values[1] - values[0] < apart) values[0] = values[1] - apart;
  double share = 0;
  for (int i = 0; i < below; ++i) {
    double term = 1;
    for (int j = 0; j < 4; ++j)
      if (j != i) term *= values[i] / (values[i] - values[j]);
    share += term;
  }
  return share;
}

/// Is there a piece with more than three mean tetrahedra of its tissue on both sides of the plane,
/// both farther from it than vertices are snapped? @param uncut the mesh before all cuts
bool Joins(const TetMesh& mesh, const CutPlane& plane, const TetMesh& uncut) {
  const MeshQuality quality = MeasureQuality(uncut, uncut.rest);
  const double mean_mm3 = quality.volume_mm3 / uncut.TetCount();
  const double snapped_mm = 0.3 * std::cbrt(6 * std::sqrt(2.0) * mean_mm3);
  struct Sides {
    std::array<double, 2> volume_mm3{}, reach_mm{};
  };
  const std::vector<int> piece = PieceOfTets(mesh);
  std::map<int, Sides> sides;
  for (Index t = 0; t < mesh.TetCount(); ++t) {
    Vec4 ahead;
    for (int k = 0; k < 4; ++k)
      ahead[k] = (mesh.rest.row(mesh.tets(t, k)).transpose() - plane.through).dot(plane.normal);
    const double volume = TetVolume(mesh.rest, mesh.tets, t), below = ShareBelow(ahead);
    Sides& of = sides[piece[t]];
    of.volume_mm3[0] += below * volume;
    of.volume_mm3[1] += (1 - below) * volume;
    of.reach_mm[0] = std::max(of.reach_mm[0], -ahead.minCoeff());
    of.reach_mm[1] = std::max(of.reach_mm[1], ahead.maxCoeff());
  }
  for (const auto& [number, of] : sides)
    if (std::min(of.volume_mm3[0], of.volume_mm3[1]) > 3 * mean_mm3 &&
        std::min(of.reach_mm[0], of.reach_mm[1]) > snapped_mm)
      return true;
  return false;
}

/// Cuts on the sequence's mesh.
void AddCuts(Random& random, CutSequence* made) {
  CutSequence& sequence = *made;
  const int cuts = 1 + random.Int(3);
  CutSurface before;
  before.points.resize(0, 3);
  before.triangles.resize(0, 3);
  for (int c = 0; c < cuts; ++c) {
    std::optional<CutPlane> complete;
    const auto growing = GrowingCut(random, sequence.mesh, &sequence.name, &complete);
    const bool together = random.Int(2) == 0;  // one S for all cuts, or one after the other
    for (std::size_t i = 0; i < growing.size(); ++i) {
      sequence.surfaces.push_back(together ? Together(before, growing[i]) : growing[i]);
      sequence.completes.push_back(i + 1 == growing.size() ? complete : std::nullopt);
      sequence.cut.push_back(c);
    }
    before = Together(before, growing.back());
  }
  if (random.Int(2) == 0) {
    sequence.name += " deformed";
    const Vec3 way = random.Direction();
    const Vec3 k = way * random.Uniform(0.02, 0.08), d = random.Direction() * 6;
    sequence.positions = sequence.mesh.rest;
    for (Index v = 0; v < sequence.positions.rows(); ++v) {
      const Vec3 x = sequence.mesh.rest.row(v).transpose();
      sequence.positions.row(v) += (d * std::sin(k.dot(x))).transpose() + 0.2 * x.transpose();
    }
  }
}

}  // namespace

CutSequence MakeCutSequence(unsigned seed) {
  Random random(seed);
  CutSequence sequence;
  sequence.mesh = ZooMesh(random, &sequence.name);
  AddCuts(random, &sequence);
  return sequence;
}

CutSequence MakeCutSequence(unsigned seed, TetMesh mesh, const std::string& name) {
  Random random(seed);
  CutSequence sequence;
  sequence.mesh = std::move(mesh);
  sequence.name = name;
  AddCuts(random, &sequence);
  return sequence;
}

CutSequenceResult RunCutSequence(const CutSequence& sequence) {
  CutSequenceResult result;
  TetMesh mesh = sequence.mesh;
  Points positions = sequence.positions;
  const MeshQuality start = MeasureQuality(mesh, mesh.rest);
  const double deformed_deg =
      positions.rows() > 0 ? MeasureQuality(mesh, positions).smallest_dihedral_deg : 0;
  Embedding points;  // material points: middles of faces towards vertex 0
  for (Index t = 0; t < mesh.TetCount(); t += 3) points.tet.push_back(t);
  points.weights.resize(points.Size(), 4);
  for (Index i = 0; i < points.Size(); ++i)
    points.weights.row(i) << 0.05 * (i % 3), 0.3, 0.4, 0.3 - 0.05 * (i % 3);
  const Points rest = points.Positions(mesh.rest, mesh.tets);

  TetCutter cutter;
  int components = start.components, first_done = 1 << 30;
  for (std::size_t i = 0; i < sequence.surfaces.size(); ++i) {
    ++result.increments;
    CutReport report;
    const Points* current = positions.rows() > 0 ? &positions : nullptr;
    const TopologyChange change = cutter.Cut(mesh, sequence.surfaces[i], &report, current);
    std::string problem;
    if (report.done != change.changed) problem += "report and change disagree; ";
    if (!change.changed) {
      if (change.mesh.rest != mesh.rest || change.mesh.tets != mesh.tets)
        problem += "refused, but changed; ";
      if (report.reason.empty()) problem += "refused without a reason; ";
      result.refused += report.reason.find("well shaped") != std::string::npos;
      result.partial += report.partial;
    } else {
      ++result.done;
      result.partial += report.partial;
      if (report.partial == report.reason.empty()) problem += "partial and reason disagree; ";
      Embedding mapped;
      problem += ProvenanceProblem(mesh, change, points, rest, &mapped);
      problem += GrowthProblem(mesh, change, sequence.surfaces[i], report, start, &result);
      result.chips += report.chips;
      points = mapped;
      if (current) positions = change.MapVertexField(positions);
      mesh = change.mesh;
      problem += Problem(mesh, start, positions, deformed_deg, sequence.mesh, &result);
    }
    if (!problem.empty()) {
      result.failure = "increment " + std::to_string(i) + ": " + problem;
      return result;
    }
    if (report.components < components) result.failure = "components were joined";
    if (report.done && report.components != MeasureQuality(mesh, mesh.rest).components)
      result.failure = "components are not as reported";
    components = report.components;
    if (report.done) first_done = std::min(first_done, sequence.cut[i]);
    const bool refused = !report.done && report.reason.find("well shaped") != std::string::npos;
    if (!sequence.completes[i] || refused) continue;
    const bool joined = Joins(mesh, *sequence.completes[i], sequence.mesh);
    if (report.partial) {
      ++result.partial_complete;
      result.partial_joined += joined;
      continue;
    }
    const bool across = first_done < sequence.cut[i];
    ++result.complete;
    result.missed_separations += joined;
    result.complete_across += across;
    result.missed_across += across && joined;
  }
  return result;
}

}  // namespace kerf::testing
