#include "Mechanics/ElasticSystem.h"

namespace kerf {
namespace {
constexpr Index kTetChunk = 512;
constexpr Index kVertexChunk = 256;
/// Block (a, b), a ≤ b, of an element's upper triangle.
constexpr int kUpper[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
}  // namespace

VectorX Flatten(const Points& positions) {
  return Eigen::Map<const VectorX>(positions.data(), positions.size());
}

Points Unflatten(const VectorX& x) { return Eigen::Map<const Points>(x.data(), x.size() / 3, 3); }

void ElasticSystem::Reset(const TetMesh& mesh, const Material& material) {
  material.Validate();
  mesh_ = mesh;
  material_ = material;
  elements_.resize(mesh.TetCount());
  for (Index t = 0; t < mesh.TetCount(); ++t) elements_[t] = MakeElement(mesh, material, t);
  rotations_.assign(mesh.TetCount(), Mat3::Identity());
  BuildPattern();
}

void ElasticSystem::Apply(const TopologyChange& change) {
  if (!change.changed) return;
  const std::vector<CorotationalElement> old_elements = std::move(elements_);
  const std::vector<Mat3> old_rotations = std::move(rotations_);
  mesh_ = change.mesh;
  elements_.resize(mesh_.TetCount());
  rotations_.resize(mesh_.TetCount());
  for (Index t = 0; t < mesh_.TetCount(); ++t) {
    const Index parent = change.parent_tet[t];
    rotations_[t] = old_rotations[parent];
    if (change.kept_tet[parent] == t)
      elements_[t] = old_elements[parent];
    else
      elements_[t] = MakeElement(mesh_, material_, t);
  }
  BuildPattern();
}

void ElasticSystem::BuildPattern() {
  const Index n = mesh_.VertexCount(), tets = mesh_.TetCount();
  matrix_.SetPattern(mesh_.tets, n);
  element_blocks_.resize(10 * static_cast<std::size_t>(tets));
  mass_ = VectorX::Zero(n);
  incident_begin_.assign(n + 1, 0);
  contributor_begin_.assign(matrix_.SlotCount() + 1, 0);
  std::vector<Index> slots(16 * static_cast<std::size_t>(tets));
  for (Index t = 0; t < tets; ++t)
    for (int a = 0; a < 4; ++a) {
      const Index v = mesh_.tets(t, a);
      mass_[v] += 0.25 * material_.density_g_mm3 * elements_[t].volume_mm3;
      ++incident_begin_[v + 1];
      for (int b = 0; b < 4; ++b) {
        const Index slot = matrix_.Slot(v, mesh_.tets(t, b));
        slots[16 * static_cast<std::size_t>(t) + 4 * a + b] = slot;
        ++contributor_begin_[slot + 1];
      }
    }
  auto accumulate = [](std::vector<Index>* begin) {
    for (std::size_t i = 1; i < begin->size(); ++i) (*begin)[i] += (*begin)[i - 1];
  };
  accumulate(&incident_begin_);
  accumulate(&contributor_begin_);
  incident_.resize(4 * static_cast<std::size_t>(tets));
  contributor_.resize(slots.size());
  std::vector<Index> next_incident = incident_begin_, next_contributor = contributor_begin_;
  for (Index t = 0; t < tets; ++t)
    for (int a = 0; a < 4; ++a) {
      incident_[next_incident[mesh_.tets(t, a)]++] = 4 * t + a;
      for (int b = 0; b < 4; ++b) {
        const Index code = 16 * t + 4 * a + b;
        contributor_[next_contributor[slots[code]]++] = code;
      }
    }
}

Corners ElasticSystem::CornersOf(const VectorX& x, Index tet) const {
  Corners corners;
  for (int a = 0; a < 4; ++a) corners.col(a) = x.segment<3>(3 * mesh_.tets(tet, a));
  return corners;
}

void ElasticSystem::UpdateRotations(const Workers& workers, const VectorX& x) {
  workers.ForChunks(mesh_.TetCount(), kTetChunk, [&](Index begin, Index end) {
    for (Index t = begin; t < end; ++t)
      rotations_[t] =
          PolarRotation(DeformationGradient(elements_[t], CornersOf(x, t)), rotations_[t]);
  });
}

double ElasticSystem::ElasticEnergy(const Workers& workers, const VectorX& x) const {
  return workers.SumChunks(mesh_.TetCount(), kTetChunk, [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index t = begin; t < end; ++t)
      sum += ElementEnergy(elements_[t], CornersOf(x, t), rotations_[t]);
    return sum;
  });
}

void ElasticSystem::ElasticGradient(const Workers& workers, const VectorX& x,
                                    VectorX* gradient) const {
  std::vector<Corners> part(mesh_.TetCount());
  workers.ForChunks(mesh_.TetCount(), kTetChunk, [&](Index begin, Index end) {
    for (Index t = begin; t < end; ++t)
      part[t] = ElementGradient(elements_[t], CornersOf(x, t), rotations_[t]);
  });
  gradient->resize(x.size());
  workers.ForChunks(mesh_.VertexCount(), kVertexChunk, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      Vec3 sum = Vec3::Zero();
      for (Index i = incident_begin_[v]; i < incident_begin_[v + 1]; ++i)
        sum += part[incident_[i] / 4].col(incident_[i] % 4);
      gradient->segment<3>(3 * v) = sum;
    }
  });
}

void ElasticSystem::AssembleElastic(const Workers& workers, const VectorX& x, Stiffness kind) {
  workers.ForChunks(mesh_.TetCount(), kTetChunk, [&](Index begin, Index end) {
    for (Index t = begin; t < end; ++t) {
      const ElementMatrix K = kind == Stiffness::Warped
                                  ? WarpedStiffness(elements_[t], rotations_[t])
                                  : ElementHessian(elements_[t], CornersOf(x, t), rotations_[t],
                                                   kind == Stiffness::Projected);
      for (int a = 0; a < 4; ++a)
        for (int b = a; b < 4; ++b)
          element_blocks_[10 * static_cast<std::size_t>(t) + kUpper[a][b]] =
              K.block<3, 3>(3 * a, 3 * b);
    }
  });
  workers.ForChunks(matrix_.SlotCount(), 8 * kVertexChunk, [&](Index begin, Index end) {
    for (Index s = begin; s < end; ++s) {
      Mat3 sum = Mat3::Zero();
      for (Index i = contributor_begin_[s]; i < contributor_begin_[s + 1]; ++i) {
        const Index code = contributor_[i];
        const int a = code / 4 % 4, b = code % 4;
        const Mat3& block =
            element_blocks_[10 * static_cast<std::size_t>(code / 16) + kUpper[a][b]];
        if (a <= b)
          sum += block;
        else
          sum += block.transpose();
      }
      matrix_.Block(s) = sum;
    }
  });
}

double ElasticSystem::AddFeatureForces(const Springs& springs, const Fixations& fixations,
                                       const VectorX& x, VectorX* gradient, bool matrix,
                                       VectorX* weights) {
  double energy = 0.0;
  if (weights) *weights = VectorX::Ones(springs.at.Size());
  for (Index l = 0; l < springs.at.Size(); ++l) {
    if (springs.stiffness[l] == 0.0) continue;
    const auto corner = mesh_.tets.row(springs.at.tet[l]);
    const auto w = springs.at.weights.row(l);
    Vec3 p = Vec3::Zero();
    for (int a = 0; a < 4; ++a) p += w[a] * x.segment<3>(3 * corner[a]);
    const SpringState state = EvaluateSpring(springs, l, p);
    energy += state.energy_nJ;
    if (weights) (*weights)[l] = state.weight;
    for (int a = 0; a < 4; ++a) {
      if (gradient) gradient->segment<3>(3 * corner[a]) += w[a] * state.gradient;
      if (!matrix) continue;
      for (int b = 0; b < 4; ++b)
        matrix_.Block(matrix_.Slot(corner[a], corner[b])) += w[a] * w[b] * state.matrix;
    }
  }
  const double k = fixations.stiffness_g_s2;
  for (std::size_t i = 0; i < fixations.vertices.size(); ++i) {
    const Index v = fixations.vertices[i];
    const Vec3 d = x.segment<3>(3 * v) - fixations.targets.row(static_cast<Index>(i)).transpose();
    energy += 0.5 * k * d.squaredNorm();
    if (gradient) gradient->segment<3>(3 * v) += k * d;
    if (matrix) matrix_.Block(matrix_.Slot(v, v)) += k * Mat3::Identity();
  }
  return energy;
}

}  // namespace kerf
