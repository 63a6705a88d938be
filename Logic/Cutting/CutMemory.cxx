#include "Cutting/CutMemory.h"

#include <algorithm>

#include "Cutting/CutRegion.h"

namespace kerf {
namespace {

bool Holds(const std::vector<std::uint64_t>& hashes, std::uint64_t hash) {
  return std::binary_search(hashes.begin(), hashes.end(), hash);
}

}  // namespace

CutProgress::CutProgress(const CutSurface& surface, const CutMemory* memory, double near_mm) {
  const Index triangles = static_cast<Index>(surface.triangles.rows());
  hashes.resize(triangles);
  fresh.assign(triangles, 1);
  waiting.assign(triangles, 0);
  for (Index t = 0; t < triangles; ++t) hashes[t] = HashOfTriangle(surface, t);
  if (!memory) return;
  CutBox near;
  bool any_new = false;
  for (Index t = 0; t < triangles; ++t) {
    waiting[t] = Holds(memory->left, hashes[t]);
    fresh[t] = !waiting[t] && !Holds(memory->settled, hashes[t]);
    if (!fresh[t]) continue;
    any_new = true;
    for (int k = 0; k < 3; ++k) near.Add(surface.points.row(surface.triangles(t, k)));
  }
  near.Grow(near_mm);
  for (Index t = 0; t < triangles; ++t)
    if (waiting[t] && (!any_new || near.Meets(BoxOf(surface.points, surface.triangles.row(t))))) {
      waiting[t] = 0;
      fresh[t] = 1;
    }
}

bool CutProgress::Waits() const {
  return std::find(waiting.begin(), waiting.end(), 1) != waiting.end();
}

void CutProgress::SettleTriedAgain(CutMemory* memory) const {
  for (std::size_t t = 0; t < hashes.size(); ++t) {
    const auto at = std::lower_bound(memory->left.begin(), memory->left.end(), hashes[t]);
    if (!fresh[t] || at == memory->left.end() || *at != hashes[t]) continue;
    memory->left.erase(at);
    memory->settled.insert(
        std::lower_bound(memory->settled.begin(), memory->settled.end(), hashes[t]), hashes[t]);
  }
}

void CutProgress::Remember(const std::vector<char>& left, CutMemory* memory) const {
  memory->settled.clear();
  memory->left.clear();
  for (std::size_t t = 0; t < hashes.size(); ++t)
    (left[t] || waiting[t] ? memory->left : memory->settled).push_back(hashes[t]);
  std::sort(memory->settled.begin(), memory->settled.end());
  std::sort(memory->left.begin(), memory->left.end());
}

}  // namespace kerf
