#include "Cutting/CutAttempt.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Cutting/CrossedEdges.h"
#include "Cutting/ImprovePatch.h"
#include "Cutting/SnapVertices.h"

namespace kerf {
namespace {

constexpr double kAsMuch = 0.9;  // of the area that another attempt separates
constexpr double kDeformedAngle_deg = 0.6;

double AngleOf(double cosine) {
  return cosine > 1 ? 0 : std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI;
}

/// Of changed tetrahedra: angles, and the volume.
void MeasureShape(CutAttempt* attempt) {
  const CutPatch& patch = attempt->patch;
  double worst = -1, worst_current = -1;
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    if (!patch.tets[t].changed) continue;
    worst = std::max(worst, patch.WorstCosine(static_cast<int>(t)));
    attempt->smallest_mm3 = std::min(attempt->smallest_mm3, patch.Volume_mm3(static_cast<int>(t)));
    if (patch.deformed)
      worst_current = std::max(worst_current, patch.WorstCosineCurrent(static_cast<int>(t)));
  }
  attempt->angle_deg = AngleOf(worst);
  attempt->angle_current_deg = AngleOf(worst_current);
}

/// But for the angle at rest, by which attempts are compared.
bool Meets(const CutAttempt& attempt, const CutDemands& demands) {
  const CutPatch& patch = attempt.patch;
  if (patch.deformed && attempt.angle_current_deg < demands.angles.current_deg) return false;
  return attempt.smallest_mm3 >= demands.volume_mm3 &&
         patch.vertices.size() <= demands.most_vertices && patch.tets.size() <= demands.most_tets;
}

/// Attempts along one sheet. All that sets them apart is how vertices are snapped: one that snaps
/// them as an earlier one did would end as that did, and is not made again.
class Attempts {
 public:
  /// What becomes of an attempt; stays when the attempt itself is taken.
  struct Outcome {
    std::optional<CutAttempt> attempt;  ///< none where an earlier one was the same
    bool given_up = false, idle = false;
    double area_mm2 = 0;
    Index closed = 0;
    std::vector<int> pinched;
  };

  Attempts(const CutPatch& before, const CutPatch& start, const CoreNear& near,
           const SurfaceIndex& sheet, bool snapping, std::size_t most_vertices)
      : before_(before),
        start_(start),
        near_(near),
        sheet_(sheet),
        snapping_(snapping),
        most_vertices_(most_vertices) {}

  Outcome Try(const RemeshingOptions& options) {
    CutAttempt attempt{start_, {}, 0, 180, 180, 1e300, false};
    CoreNear near = near_;
    RemeshingOptions used = options;
    if (!snapping_) used.snap_fraction = used.accept_fraction = 0;
    attempt.snapped = SnapVertices(sheet_, used, before_, &near, &attempt.patch);
    for (const Made& made : made_)
      if (SameSnapping(made.vertices, attempt.patch.vertices)) return made.outcome;
    std::vector<CutPatch::Vertex> vertices = attempt.patch.vertices;
    Outcome outcome;
    if (!SplitCrossedEdges(sheet_, near, most_vertices_, &attempt.patch)) {
      attempt.given_up = true;
    } else {
      if (snapping_) ImprovePatch(sheet_, used, before_, &attempt.patch);
      attempt.separation = OpenFacesOnS(sheet_, &attempt.patch);
      MeasureShape(&attempt);
    }
    outcome.given_up = attempt.given_up;
    outcome.idle = attempt.separation.faces.empty();
    outcome.area_mm2 = attempt.separation.area_mm2;
    outcome.closed = attempt.separation.closed;
    outcome.pinched = attempt.separation.pinched;
    made_.push_back({std::move(vertices), outcome});
    outcome.attempt = std::move(attempt);
    return outcome;
  }

 private:
  struct Made {
    std::vector<CutPatch::Vertex> vertices;  ///< snapped, before anything is split
    Outcome outcome;                         ///< without the attempt
  };
  static bool SameSnapping(const std::vector<CutPatch::Vertex>& a,
                           const std::vector<CutPatch::Vertex>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const CutPatch::Vertex& v, const CutPatch::Vertex& w) {
                        return v.rest == w.rest && v.current == w.current && v.on == w.on &&
                               v.moved == w.moved;
                      });
  }

  const CutPatch& before_;
  const CutPatch& start_;
  const CoreNear& near_;
  const SurfaceIndex& sheet_;
  bool snapping_;
  std::size_t most_vertices_;
  std::vector<Made> made_;
};

}  // namespace

CutDemands DemandsOn(const CutPatch& patch, Index work, double mean_mm3,
                     const CutOptions& options) {
  const double enough = CosineOf(options.min_dihedral_deg);
  const double enough_current = CosineOf(2 * kDeformedAngle_deg);
  double worst = -1, worst_current = -1;
  CutDemands demands;
  demands.volume_mm3 = options.min_volume_share * mean_mm3;
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const auto& v = patch.tets[t].v;
    const auto &a = patch.vertices[v[0]], &b = patch.vertices[v[1]], &c = patch.vertices[v[2]],
               &d = patch.vertices[v[3]];
    if (!AllAnglesAbove(enough, a.rest, b.rest, c.rest, d.rest))
      worst = std::max(worst, patch.WorstCosine(static_cast<int>(t)));
    if (patch.deformed &&
        !AllAnglesAbove(enough_current, a.current, b.current, c.current, d.current))
      worst_current = std::max(worst_current, patch.WorstCosineCurrent(static_cast<int>(t)));
    demands.volume_mm3 = std::min(demands.volume_mm3, patch.Volume_mm3(static_cast<int>(t)));
  }
  demands.angles = {std::min(options.min_dihedral_deg, AngleOf(worst)),
                    std::min(kDeformedAngle_deg, 0.5 * AngleOf(worst_current))};
  demands.most_vertices = patch.vertices.size() + std::size_t(options.max_new_vertices * work);
  demands.most_tets = patch.tets.size() + std::size_t(options.max_new_tets * work);
  if (!options.snapping) {  // no guarantees
    demands.volume_mm3 = 0;
    demands.most_vertices = 5 * patch.vertices.size() + 64;
    demands.most_tets = std::numeric_limits<std::size_t>::max();
  }
  return demands;
}

std::optional<CutAttempt> CutAlong(CutSheet* sheet, const CutPatch& before, CutPatch* start_patch,
                                   const CutOptions& options, const CutDemands& demands) {
  CutPatch& start = *start_patch;
  const CoreNear near = sheet->NearOf(start);
  MarkVerticesOnS(sheet->index, near, &start);
  std::optional<CutAttempt> best, idle_attempt;
  bool separates = false;
  int idle = 0;
  Attempts attempts(before, start, near, sheet->index, options.snapping, demands.most_vertices);
  for (double factor : {1.0, 0.7, 1.25, 0.45}) {
    RemeshingOptions remeshing;
    remeshing.snap_fraction = factor * options.snap_fraction;
    Attempts::Outcome outcome = attempts.Try(remeshing);
    // Where the boundary would touch itself in a vertex, that vertex is better not on S.
    for (int v : outcome.pinched)
      if (v < static_cast<int>(start.vertices.size())) remeshing.off.push_back(v);
    if (!remeshing.off.empty() && options.snapping) {
      Attempts::Outcome clear = attempts.Try(remeshing);
      if (clear.attempt && !clear.given_up && clear.attempt->angle_deg >= demands.angles.rest_deg &&
          Meets(*clear.attempt, demands) && clear.closed < outcome.closed &&
          clear.area_mm2 >= kAsMuch * outcome.area_mm2)
        outcome = std::move(clear);
    }
    if (outcome.given_up) {
      separates = true;
      continue;
    }
    if (outcome.idle) {
      if (idle == 0) idle_attempt = std::move(outcome.attempt);
      if (++idle == 2 && !separates) break;  // S only touches the organ
      continue;
    }
    separates = true;
    // The same as an earlier one is no better.
    if (!outcome.attempt || !Meets(*outcome.attempt, demands)) continue;
    if (!best || outcome.attempt->angle_deg > best->angle_deg) best = std::move(outcome.attempt);
    if (best->angle_deg >= std::min(6.0, 2 * options.min_dihedral_deg) || !options.snapping) break;
  }
  if (best && options.snapping && best->angle_deg < demands.angles.rest_deg) best.reset();
  sheet->refused = separates && !best;
  if (idle_attempt && !best && !separates)  // what it would open stays closed for a pinch
    sheet->Leave(idle_attempt->patch,
                 StillJoined(idle_attempt->patch, idle_attempt->separation.kept));
  return best;
}

}  // namespace kerf
