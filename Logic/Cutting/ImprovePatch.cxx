#include "Cutting/ImprovePatch.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "Cutting/BoundarySlide.h"

namespace kerf {
namespace {

/// Would S cross an edge at v in this place that it does not cross now?
bool ComesToCross(const SurfaceIndex& surface, const CutPatch& patch, int v, const Vec3& place) {
  if (patch.vertices[v].on) return false;
  std::vector<double> hits;
  for (int w : patch.Neighbors(v)) {
    if (patch.vertices[w].on) continue;
    surface.Crossings(place, patch.vertices[w].rest, &hits);
    if (hits.empty()) continue;
    surface.Crossings(patch.vertices[v].rest, patch.vertices[w].rest, &hits);
    if (hits.empty()) return true;
  }
  return false;
}

}  // namespace

void ImprovePatch(const SurfaceIndex& surface, const RemeshingOptions& options,
                  const CutPatch& before, CutPatch* patch) {
  const double goal = CosineOf(options.goal_angle_deg);
  for (int round = 0; round < options.improvement_rounds; ++round) {
    std::vector<std::pair<double, int>> bad;
    for (std::size_t t = 0; t < patch->tets.size(); ++t)
      if (patch->tets[t].changed) {
        const double worst = patch->WorstCosine(static_cast<int>(t));
        if (worst > goal) bad.push_back({-worst, static_cast<int>(t)});
      }
    if (bad.empty()) return;
    std::sort(bad.begin(), bad.end());
    bool improved = false;
    for (const auto& [key, t] : bad) {
      for (int v : std::array<int, 4>(patch->tets[t].v)) {
        if (patch->WorstCosine(t) <= goal) break;
        if (patch->vertices[v].frozen) continue;
        const double h = patch->vertices[v].size_mm;
        const BoundarySlide slide(*patch, v, 0.25 * options.slide_tolerance * h);
        const bool on = patch->vertices[v].on;
        Vec3 middle = Vec3::Zero();
        const auto neighbors = patch->Neighbors(v);
        for (int w : neighbors) middle += patch->vertices[w].rest / double(neighbors.size());
        for (double step : {0.3, 0.15, 0.06}) {
          double best = patch->WorstCosineAround(v);
          const Vec3 from = patch->vertices[v].rest;
          Vec3 best_place = from;
          std::array<Vec3, 7> ways{Vec3::UnitX(),      -Vec3::UnitX(), Vec3::UnitY(),
                                   -Vec3::UnitY(),     Vec3::UnitZ(),  -Vec3::UnitZ(),
                                   (middle - from) / h};
          for (const Vec3& way : ways) {
            Vec3 d = step * h * way;
            if (slide.OnBoundary()) d = slide.Project(d);
            Vec3 place = from + d;
            if (on) {
              const SurfaceNear near = surface.Closest(place, h);
              if (near.triangle < 0 || near.on_border) continue;
              if (!slide.OnBoundary()) {
                place = near.point;
              } else if (near.distance_mm > 1e-9 * h) {
                Vec3 back;
                if (!slide.Toward(near.point - place, &back)) continue;
                place += back;
                if (surface.Closest(place, h).distance_mm > 0.01 * h) continue;
              }
            }
            if (slide.OnBoundary() && !slide.Allowed(place - from)) continue;
            patch->vertices[v].rest = place;
            const double worst = patch->WorstCosineAround(v);
            if (worst < best - 1e-6) {
              best = worst;
              best_place = place;
            }
          }
          patch->vertices[v].rest = from;
          if (best_place != from && !ComesToCross(surface, *patch, v, best_place) &&
              patch->TryMove(v, best_place, best + 1e-9, before))
            improved = true;
        }
      }
    }
    if (!improved) return;
  }
}

}  // namespace kerf
