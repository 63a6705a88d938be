#include "Mechanics/TwoLevelPreconditioner.h"

#include <cmath>
#include <numeric>

namespace kerf {
namespace {
/// Loads may differ from the factored ones by this fraction of their sum: a preconditioner need not
/// be exact.
constexpr double kLoadChange = 0.15;
}  // namespace

void TwoLevelPreconditioner::Reset(const Workers& workers, const std::vector<Vec3>& rest,
                                   const ElementField& field) {
  coarse_.Reset(workers, rest, field);
  factored_anchor_.assign(field.VertexCount(), 0.0f);
  factored_ = factored_anchor_;
  origin_.resize(field.VertexCount());
  std::iota(origin_.begin(), origin_.end(), 0);
  diagonal_.assign(field.Chunks().size(), {});
  coarse_change_ = CoarseSpace::Change::kOther;
  workers.ForChunks(static_cast<Index>(field.Chunks().size()), 1,
                    [&](Index c, Index) { RefreshDiagonal(field, c); });
  diagonal_stale_.clear();
  all_stale_ = true;
}

void TwoLevelPreconditioner::FollowVertices(const Workers& workers, const std::vector<Vec3>& rest,
                                            const ElementField& field,
                                            const ElementField::Patch& patch) {
  was_cut_ = true;
  factored_anchor_.resize(field.VertexCount(), 0.0f);
  factored_.resize(field.VertexCount(), 0.0f);
  std::vector<Index> origin;
  for (const Index parent : patch.origins) origin.push_back(origin_[parent]);
  origin_.resize(field.VertexCount());
  for (std::size_t i = 0; i < origin.size(); ++i) origin_[patch.new_vertices[i]] = origin[i];
  coarse_.FollowVertices(rest, field, patch);
  workers.ForChunks(static_cast<Index>(patch.chunks.size()), 1,
                    [&](Index which, Index) { RefreshDiagonal(field, patch.chunks[which]); });
  diagonal_stale_.insert(diagonal_stale_.end(), patch.chunks.begin(), patch.chunks.end());
}

void TwoLevelPreconditioner::FollowCoarse(const Workers& workers, const ElementField& field,
                                          const ElementField::Patch& patch) {
  workers.ForChunks(static_cast<Index>(patch.chunks.size()), 1,
                    [&](Index which, Index) { coarse_.FollowChunk(field, patch.chunks[which]); });
  coarse_change_ = std::max(coarse_change_, coarse_.FollowNodes(field, patch));
  if (coarse_change_ == CoarseSpace::Change::kGrown) coarse_.AssembleGrown(workers, field);
}

void TwoLevelPreconditioner::RefreshDiagonal(const ElementField& field, Index chunk_index) {
  const ElementField::Chunk& chunk = field.Chunks()[chunk_index];
  std::vector<simd::F8>& diagonal = diagonal_[chunk_index];
  diagonal.assign(chunk.vertices.size(), simd::F8{});
  for (std::size_t b = 0; b < chunk.blocks.size(); ++b) {
    const ElementBlock& block = chunk.blocks[b];
    const simd::F8* RB = chunk.states[b].RB;
    const simd::F8 mu = 0.5f * block.two_mu, both = block.lambda + mu;
    for (int a = 0; a < 4; ++a) {
      simd::F8 g[3];
      for (int r = 0; r < 3; ++r)
        g[r] = a > 0 ? RB[3 * a - 3 + r] : -(RB[r] + RB[3 + r] + RB[6 + r]);
      const simd::F8 own = mu * (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
      const simd::F8 x = both * g[0], y = both * g[1];
      simd::F8 d[8] = {x * g[0] + own, y * g[1] + own, both * g[2] * g[2] + own,
                       y * g[2],       x * g[2],       x * g[1],
                       simd::F8{},     simd::F8{}};
      simd::Transpose(d);
      for (int lane = 0; lane < 8; ++lane) diagonal[block.corner[a][lane]] += d[lane];
    }
  }
}

void TwoLevelPreconditioner::UpdateCoarse(const Workers& workers, const ElementField& field,
                                          const FeatureLoads& loads,
                                          const std::vector<float>& anchor) {
  // Compared by vertex: loads come and go (an outline's do in every frame) where others were. What
  // went over to a copy of a vertex is no change.
  std::vector<float> held(anchor.size(), 0.0f);
  for (std::size_t v = 0; v < anchor.size(); ++v) held[origin_[v]] += anchor[v];
  loads.ForVertices(0, field.VertexCount(), [&](Index v, Index l, float w) {
    held[origin_[v]] += w * static_cast<float>(loads.Loads()[l].stiffness);
  });
  double change = 0.0, sum = 0.0;
  for (std::size_t v = 0; v < factored_.size(); ++v) {
    change += std::abs(factored_[v] - held[v]);
    sum += factored_[v];
  }
  bool same = coarse_change_ != CoarseSpace::Change::kOther && change <= kLoadChange * sum &&
              (was_cut_ || !coarse_.IsLong());
  if (same && coarse_change_ == CoarseSpace::Change::kGrown) same = coarse_.Extend(loads, anchor);
  if (!same) {
    factored_anchor_ = anchor;
    factored_ = std::move(held);
    coarse_.Factor(workers, field, loads, anchor);
    all_stale_ = true;
  }
  coarse_change_ = CoarseSpace::Change::kNone;
  was_cut_ = false;
}

void TwoLevelPreconditioner::UpdateDiagonal(const Workers& workers, const ElementField& field,
                                            const FeatureLoads& loads) {
  if (!all_stale_ && diagonal_stale_.empty()) return;
  // Only vertices of these chunks have another diagonal, unless all loads count anew.
  std::vector<char> stale(field.VertexCount(), all_stale_);
  for (Index c : diagonal_stale_)
    for (Index v : field.Chunks()[c].vertices) stale[v] = 1;
  all_stale_ = false;
  diagonal_stale_.clear();
  std::vector<simd::F8> sum(field.VertexCount(), simd::F8{});
  for (std::size_t c = 0; c < diagonal_.size(); ++c)
    for (std::size_t i = 0; i < diagonal_[c].size(); ++i) {
      const Index v = field.Chunks()[c].vertices[i];
      if (!stale[v]) continue;
      sum[v] += diagonal_[c][i];
    }
  loads.ForVertices(0, field.VertexCount(), [&](Index v, Index l, float w) {
    for (int k = 0; k < 6; ++k) sum[v][k] += w * w * loads.Loads()[l].matrix[k];
  });
  inverse_.resize(field.VertexCount());
  workers.ForChunks(field.VertexCount(), 1024, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      if (!stale[v]) continue;
      inverse_[v] = {};
      const simd::F8& d = sum[v];
      Mat3 block;
      block << d[0], d[5], d[4], d[5], d[1], d[3], d[4], d[3], d[2];
      block.diagonal().array() += factored_anchor_[v];
      const Mat3 inverse = block.inverse();
      if (!inverse.allFinite() || !(inverse.diagonal().minCoeff() > 0.0)) continue;
      const Eigen::Matrix3f f = inverse.cast<float>();
      inverse_[v] = {{f(0, 0), f(1, 0), f(2, 0), 0},
                     {f(0, 1), f(1, 1), f(2, 1), 0},
                     {f(0, 2), f(1, 2), f(2, 2), 0}};
    }
  });
}

}  // namespace kerf
