#include "Mechanics/GripSolver.h"

#include <Eigen/CholmodSupport>
#include <string>

#include "Core/Errors.h"
#include "Mechanics/ElasticSystem.h"

/// Present where the BLAS is OpenBLAS. Its own threads fight with ours over small fronts (70–650 ms
/// for 5–13).
extern "C" void openblas_set_num_threads(int threads) __attribute__((weak));

namespace kerf {
namespace {
/// Keeps pieces without a grip definite; proximal, so it shifts no equilibrium, and far too weak to
/// show in the sensitivities.
constexpr double kProximal_1_s2 = 1e-3;
using Sparse = Eigen::SparseMatrix<double>;
}  // namespace

struct GripSolver::Impl {
  ElasticSystem system;
  Workers workers;
  std::vector<std::vector<Index>> grips;
  std::vector<Index> free_index;  ///< of each vertex among the free ones, −1 = held
  Index free_count = 0;
  Eigen::CholmodSupernodalLLT<Sparse> factor;
  bool analyzed = false, factored = false;
  VectorX x;

  void NumberFree();
  Vec3 CentroidAtRest(Index grip) const;
  /// Factors the free part of the Hessian at x. @return false if it is not definite
  bool Factor(ElasticSystem::Stiffness kind);
  /// Free part of −K v, v zero on free vertices.
  VectorX Coupling(const VectorX& held) const;
  VectorX Gather(const VectorX& full) const;
  void ScatterAdd(const VectorX& free, double length, VectorX* full) const;
};

void GripSolver::Impl::NumberFree() {
  const Index n = system.Mesh().VertexCount();
  std::vector<char> held(n, 0);
  for (const auto& grip : grips)
    for (Index v : grip) held[v] = 1;
  free_index.assign(n, -1);
  free_count = 0;
  for (Index v = 0; v < n; ++v)
    if (!held[v]) free_index[v] = free_count++;
  analyzed = factored = false;
}

Vec3 GripSolver::Impl::CentroidAtRest(Index grip) const {
  Vec3 sum = Vec3::Zero();
  for (Index v : grips[grip]) sum += system.Mesh().rest.row(v).transpose();
  return sum / static_cast<double>(grips[grip].size());
}

bool GripSolver::Impl::Factor(ElasticSystem::Stiffness kind) {
  system.AssembleElastic(workers, x, kind);
  const BlockMatrix& K = system.Matrix();
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(5 * static_cast<std::size_t>(K.SlotCount()));
  for (Index row = 0; row < K.Rows(); ++row) {
    if (free_index[row] < 0) continue;
    for (Index slot = K.RowBegin(row); slot < K.RowBegin(row + 1); ++slot) {
      const Index column = K.Column(slot);
      if (free_index[column] < 0 || column > row) continue;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          if (column == row && j > i) continue;
          double value = K.Block(slot)(i, j);
          if (column == row && i == j) value += kProximal_1_s2 * system.Mass()[row] + 1e-9;
          entries.emplace_back(3 * free_index[row] + i, 3 * free_index[column] + j, value);
        }
    }
  }
  Sparse A(3 * free_count, 3 * free_count);
  A.setFromTriplets(entries.begin(), entries.end());
  if (!analyzed) factor.analyzePattern(A);
  analyzed = true;
  factor.cholmod().print = 0;  // an indefinite matrix is an answer here, not news for the terminal
  factor.factorize(A);
  factored = factor.info() == Eigen::Success;
  return factored;
}

VectorX GripSolver::Impl::Coupling(const VectorX& held) const {
  VectorX product;
  system.Matrix().Multiply(workers, held, &product);
  return -Gather(product);
}

VectorX GripSolver::Impl::Gather(const VectorX& full) const {
  VectorX free(3 * free_count);
  for (Index v = 0; v < static_cast<Index>(free_index.size()); ++v)
    if (free_index[v] >= 0) free.segment<3>(3 * free_index[v]) = full.segment<3>(3 * v);
  return free;
}

void GripSolver::Impl::ScatterAdd(const VectorX& free, double length, VectorX* full) const {
  for (Index v = 0; v < static_cast<Index>(free_index.size()); ++v)
    if (free_index[v] >= 0) full->segment<3>(3 * v) += length * free.segment<3>(3 * free_index[v]);
}

GripSolver::GripSolver() : impl_(std::make_unique<Impl>()) {
  if (openblas_set_num_threads) openblas_set_num_threads(1);
}
GripSolver::~GripSolver() = default;

void GripSolver::Reset(const TetMesh& mesh, const Material& material) {
  impl_->system.Reset(mesh, material);
  impl_->grips.clear();
  impl_->x.resize(0);
  impl_->NumberFree();
}

void GripSolver::Apply(const TopologyChange& change) {
  if (!change.changed) return;
  const Index old_count = impl_->system.Mesh().VertexCount();
  std::vector<Index> grip_of_old(old_count, -1);
  for (std::size_t g = 0; g < impl_->grips.size(); ++g)
    for (Index v : impl_->grips[g]) grip_of_old[v] = static_cast<Index>(g);
  for (auto& grip : impl_->grips) grip.clear();
  for (Index v = 0; v < change.mesh.VertexCount(); ++v) {
    // A vertex made of gripped ones alone is gripped.
    Index grip = -2;
    for (int k = 0; k < 4; ++k) {
      if (change.vertex_weights(v, k) == 0.0) continue;
      const Index parent = grip_of_old[change.vertex_parents[v][k]];
      grip = grip == -2 || grip == parent ? parent : -1;
    }
    if (grip >= 0) impl_->grips[grip].push_back(v);
  }
  impl_->system.Apply(change);
  impl_->x.resize(0);
  impl_->NumberFree();
}

void GripSolver::SetGrips(std::vector<std::vector<Index>> grips) {
  std::vector<char> used(impl_->system.Mesh().VertexCount(), 0);
  for (std::size_t g = 0; g < grips.size(); ++g) {
    const std::string name = "grip " + std::to_string(g);
    if (grips[g].empty()) throw UsageError(name + " has no vertices");
    for (Index v : grips[g]) {
      if (v < 0 || v >= static_cast<Index>(used.size()))
        throw UsageError(name + ": no vertex " + std::to_string(v));
      if (used[v]) throw UsageError(name + ": vertex " + std::to_string(v) + " is held twice");
      used[v] = 1;
    }
  }
  impl_->grips = std::move(grips);
  impl_->NumberFree();
}

const std::vector<std::vector<Index>>& GripSolver::Grips() const { return impl_->grips; }

GripReport GripSolver::Solve(const std::vector<Eigen::Isometry3d>& motions,
                             const GripOptions& options, Points* positions) {
  Impl& s = *impl_;
  if (motions.size() != s.grips.size()) throw UsageError("grips and motions differ in number");
  if (positions->rows() != s.system.Mesh().VertexCount() || !positions->allFinite())
    throw UsageError("positions and mesh differ in vertex count, or a position is not finite");
  s.workers.Use(options.threads);
  s.x = Flatten(*positions);
  VectorX held = VectorX::Zero(s.x.size());
  for (std::size_t g = 0; g < s.grips.size(); ++g)
    for (Index v : s.grips[g])
      held.segment<3>(3 * v) =
          motions[g] * Vec3(s.system.Mesh().rest.row(v).transpose()) - s.x.segment<3>(3 * v);
  // Predictor: the free part follows the grips linearly, so that they don't crush what is next to
  // them.
  s.system.UpdateRotations(s.workers, s.x);
  if (s.free_count > 0 && held.squaredNorm() > 0.0 && s.Factor(ElasticSystem::Stiffness::Projected))
    s.ScatterAdd(s.factor.solve(s.Coupling(held)), 1.0, &s.x);
  s.x += held;
  GripReport report;
  VectorX gradient;
  auto evaluate = [&] {
    s.system.UpdateRotations(s.workers, s.x);
    s.system.ElasticGradient(s.workers, s.x, &gradient);
    return s.system.ElasticEnergy(s.workers, s.x);
  };
  double energy = evaluate();
  for (; s.free_count > 0 && !report.converged && report.newton_steps < options.max_newton_steps;
       ++report.newton_steps) {
    if (!s.Factor(ElasticSystem::Stiffness::Exact) &&
        !s.Factor(ElasticSystem::Stiffness::Projected))
      break;
    const VectorX free_gradient = s.Gather(gradient);
    const VectorX step = -s.factor.solve(free_gradient);
    const double slope = free_gradient.dot(step);
    const VectorX before = s.x;
    double length = 1.0, trial = 0.0;
    bool accepted = false;
    for (int halving = 0; halving < 20 && !accepted; ++halving, length *= 0.5) {
      s.x = before;
      s.ScatterAdd(step, length, &s.x);
      trial = evaluate();
      accepted = trial <= energy + 1e-4 * length * slope + 1e-12 * energy;
    }
    if (!accepted) {
      s.x = before;
      evaluate();
      break;
    }
    energy = trial;
    report.converged = step.cwiseAbs().maxCoeff() <= options.tolerance_mm;
  }
  report.converged |= s.free_count == 0;
  // The sensitivities belong to the Hessian here.
  if (s.free_count > 0 && !s.Factor(ElasticSystem::Stiffness::Exact))
    s.Factor(ElasticSystem::Stiffness::Projected);
  report.elastic_energy_uJ = 1e-3 * energy;
  *positions = Unflatten(s.x);
  return report;
}

Eigen::MatrixXd GripSolver::Sensitivities(const Embedding& points) const {
  const Impl& s = *impl_;
  if (s.x.size() == 0 || (s.free_count > 0 && !s.factored))
    throw UsageError("sensitivities need an equilibrium: solve first");
  const Index columns = 6 * static_cast<Index>(s.grips.size());
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(s.x.size(), columns);
  Eigen::MatrixXd right(3 * s.free_count, columns);
  for (std::size_t g = 0; g < s.grips.size(); ++g) {
    Vec3 center = Vec3::Zero();
    for (Index v : s.grips[g])
      center += s.x.segment<3>(3 * v) / static_cast<double>(s.grips[g].size());
    for (int k = 0; k < 6; ++k) {
      const Index column = 6 * static_cast<Index>(g) + k;
      for (Index v : s.grips[g])
        moved.col(column).segment<3>(3 * v) =
            k < 3 ? Vec3(Vec3::Unit(k))
                  : Vec3(Vec3::Unit(k - 3).cross(s.x.segment<3>(3 * v) - center));
      if (s.free_count > 0) right.col(column) = s.Coupling(moved.col(column));
    }
  }
  if (s.free_count > 0) {
    const Eigen::MatrixXd free = s.factor.solve(right);
    for (Index column = 0; column < columns; ++column) {
      VectorX full = moved.col(column);
      s.ScatterAdd(free.col(column), 1.0, &full);
      moved.col(column) = full;
    }
  }
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(3 * points.Size(), columns);
  for (Index i = 0; i < points.Size(); ++i)
    for (int a = 0; a < 4; ++a)
      out.middleRows<3>(3 * i) +=
          points.weights(i, a) * moved.middleRows<3>(3 * s.system.Mesh().tets(points.tet[i], a));
  return out;
}

Eigen::Isometry3d GripSolver::Moved(Index grip, const Eigen::Isometry3d& motion,
                                    const Eigen::Matrix<double, 6, 1>& step) const {
  const Vec3 center = motion * impl_->CentroidAtRest(grip);
  const double angle = step.tail<3>().norm();
  Eigen::Isometry3d change = Eigen::Isometry3d::Identity();
  if (angle > 0.0)
    change.linear() = Eigen::AngleAxisd(angle, step.tail<3>() / angle).toRotationMatrix();
  change.translation() = center + step.head<3>() - change.linear() * center;
  return change * motion;
}

}  // namespace kerf
