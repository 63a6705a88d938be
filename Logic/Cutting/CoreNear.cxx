#include "Cutting/CoreNear.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kOnS = 1e-6;  // of the edge length: lies on S already

}  // namespace

CoreNear::CoreNear(const SurfaceIndex& surface, const CutPatch& patch,
                   const std::vector<SurfaceNear>& known)
    : near_(patch.vertices.size()) {
  const auto core = [&](int v) { return patch.vertices[v].core; };
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const auto& v = patch.tets[t].v;
    if (core(v[0]) && core(v[1]) && core(v[2]) && core(v[3])) tets_.push_back(static_cast<int>(t));
  }
  Measure(patch);
  for (std::size_t v = 0; v < near_.size(); ++v) {
    if (!patch.vertices[v].core) continue;
    if (!known.empty() && known[v].triangle >= 0)
      near_[v] = known[v];
    else
      near_[v] = surface.Closest(patch.vertices[v].rest, std::sqrt(longest2_[v]));
  }
}

void CoreNear::Measure(const CutPatch& patch) {
  longest2_.assign(patch.vertices.size(), 0);
  for (int t : tets_) {
    const auto& v = patch.tets[t].v;
    for (int i = 0; i < 4; ++i)
      for (int k = i + 1; k < 4; ++k) {
        const double length2 =
            (patch.vertices[v[i]].rest - patch.vertices[v[k]].rest).squaredNorm();
        longest2_[v[i]] = std::max(longest2_[v[i]], length2);
        longest2_[v[k]] = std::max(longest2_[v[k]], length2);
      }
  }
}

void CoreNear::Update(const SurfaceIndex& surface, const CutPatch& patch,
                      const std::vector<int>& moved) {
  if (moved.empty()) return;
  const std::vector<double> before = std::move(longest2_);
  Measure(patch);
  const auto ask = [&](int v) {
    near_[v] = surface.Closest(patch.vertices[v].rest, std::sqrt(longest2_[v]));
  };
  for (int v : moved)
    if (patch.vertices[v].core) ask(v);
  for (std::size_t v = 0; v < near_.size(); ++v)
    if (near_[v].triangle < 0 && longest2_[v] > before[v]) ask(static_cast<int>(v));
}

void MarkVerticesOnS(const SurfaceIndex& surface, const CoreNear& near, CutPatch* patch) {
  for (std::size_t v = 0; v < patch->vertices.size(); ++v) {
    auto& vertex = patch->vertices[v];
    const double close_mm = kOnS * vertex.size_mm;
    vertex.on = vertex.core ? near[static_cast<int>(v)].distance_mm < close_mm
                            : surface.Closest(vertex.rest, close_mm).triangle >= 0;
  }
}

}  // namespace kerf
