#include "Mechanics/FeatureLoads.h"

#include <tuple>

namespace kerf {

void FeatureLoads::Set(const Springs& springs, const Fixations& fixations, const TetMesh& mesh,
                       const ElementField& field, bool renumbered) {
  springs_ = &springs;
  fixations_ = &fixations;
  spring_weights_ = Eigen::VectorXd::Ones(springs.at.Size());
  if (!renumbered && attached_tet_ == springs.at.tet && attached_vertex_ == fixations.vertices &&
      attached_weights_.rows() == springs.at.weights.rows() &&
      attached_weights_ == springs.at.weights)
    return;
  attached_tet_ = springs.at.tet;
  attached_weights_ = springs.at.weights;
  attached_vertex_ = fixations.vertices;
  loads_.assign(attached_tet_.size() + attached_vertex_.size(), {});
  products_.assign(loads_.size(), {});
  entries_.clear();
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    Load& load = loads_[l];
    const bool spring = l < attached_tet_.size();
    for (int a = 0; a < 4; ++a) {
      const Index outer =
          spring ? mesh.tets(attached_tet_[l], a) : attached_vertex_[l - attached_tet_.size()];
      load.vertex[a] = field.Inner(outer);
      load.weight[a] = spring ? static_cast<float>(springs.at.weights(static_cast<Index>(l), a))
                              : (a == 0 ? 1.0f : 0.0f);
      if (load.weight[a] != 0.0f)
        entries_.push_back({load.vertex[a], static_cast<Index>(l), load.weight[a]});
    }
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.vertex, a.load) < std::tie(b.vertex, b.load);
  });
}

Vec3 FeatureLoads::InnerPosition(const Load& load, const std::vector<double>& x) const {
  Vec3 p = Vec3::Zero();
  for (int a = 0; a < 4; ++a)
    if (load.weight[a] != 0.0f)
      p += static_cast<double>(load.weight[a]) * Eigen::Map<const Vec3>(&x[3 * load.vertex[a]]);
  return p;
}

SpringState FeatureLoads::EvaluateOne(std::size_t l, const Vec3& world) const {
  if (l < attached_tet_.size()) return EvaluateSpring(*springs_, static_cast<Index>(l), world);
  SpringState state;
  const double k = fixations_->stiffness_g_s2;
  const Vec3 d =
      world - fixations_->targets.row(static_cast<Index>(l - attached_tet_.size())).transpose();
  state.energy_nJ = 0.5 * k * d.squaredNorm();
  state.gradient = k * d;
  state.matrix = k * Mat3::Identity();
  return state;
}

double FeatureLoads::Evaluate(const Eigen::Isometry3d& world_from_inner,
                              const std::vector<double>& x) {
  const Mat3 R = world_from_inner.linear();
  double energy = 0.0;
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    Load& load = loads_[l];
    const SpringState state = EvaluateOne(l, world_from_inner * InnerPosition(load, x));
    if (l < attached_tet_.size()) spring_weights_[static_cast<Index>(l)] = state.weight;
    energy += state.energy_nJ;
    const Vec3 g = R.transpose() * state.gradient;
    const Mat3 M = R.transpose() * state.matrix * R;
    load.gradient = {static_cast<float>(g.x()), static_cast<float>(g.y()),
                     static_cast<float>(g.z()), 0.0f};
    const double entries[6] = {M(0, 0), M(1, 1), M(2, 2), M(1, 2), M(0, 2), M(0, 1)};
    for (int i = 0; i < 6; ++i) load.matrix[i] = static_cast<float>(entries[i]);
    load.stiffness = M.trace() / 3.0;
  }
  return energy;
}

double FeatureLoads::FitRigid(const std::vector<double>& x, Eigen::Isometry3d* world_from_inner) {
  constexpr int kIterations = 30;    // a few for a frame's motion; jumps take more
  constexpr double kSmallMm = 0.02;  // what the elastic solve takes care of anyway
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  std::vector<Vec3> inner(loads_.size());
  for (std::size_t l = 0; l < loads_.size(); ++l) inner[l] = InnerPosition(loads_[l], x);
  auto energy_at = [&](const Eigen::Isometry3d& frame, const Vec3& center, Mat6* A, Vec6* b) {
    double energy = 0.0;
    A->setZero();
    b->setZero();
    for (std::size_t l = 0; l < loads_.size(); ++l) {
      const Vec3 p = frame * inner[l];
      const SpringState state = EvaluateOne(l, p);
      energy += state.energy_nJ;
      const Vec3 arm = p - center;
      Mat3 cross;
      cross << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
      const Mat3 MC = state.matrix * cross;
      A->topLeftCorner<3, 3>() += state.matrix;
      A->topRightCorner<3, 3>() -= MC;
      A->bottomRightCorner<3, 3>() -= cross * MC;
      b->head<3>() += state.gradient;
      b->tail<3>() += arm.cross(state.gradient);
    }
    A->bottomLeftCorner<3, 3>() = A->topRightCorner<3, 3>().transpose();
    return energy;
  };
  Vec3 center = Vec3::Zero();
  for (const Vec3& p : inner) center += *world_from_inner * p / static_cast<double>(inner.size());
  double radius2 = 1.0;
  for (const Vec3& p : inner)
    radius2 = std::max(radius2, (*world_from_inner * p - center).squaredNorm());
  Mat6 A, trial_A;
  Vec6 b, trial_b;
  double energy = inner.empty() ? 0.0 : energy_at(*world_from_inner, center, &A, &b);
  for (int iteration = 0; iteration < kIterations && energy > 0.0; ++iteration) {
    // Directions that no load constrains (the depth of rays, turns about a line) don't move.
    const double weak = 1e-6 * A.topLeftCorner<3, 3>().trace() + 1e-12;
    A.diagonal().head<3>().array() += weak;
    A.diagonal().tail<3>().array() += weak * radius2;
    Vec6 step = -A.ldlt().solve(b);
    if (!(step.head<3>().norm() + step.tail<3>().norm() * std::sqrt(radius2) > kSmallMm)) break;
    if (step.tail<3>().norm() > 1.0) step /= step.tail<3>().norm();
    double trial_energy = energy;
    Eigen::Isometry3d trial;
    for (int halving = 0; halving < 8 && !(trial_energy < energy); ++halving, step *= 0.5) {
      const double angle = step.tail<3>().norm();
      Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
      if (angle > 0.0)
        motion.linear() = Eigen::AngleAxisd(angle, step.tail<3>() / angle).toRotationMatrix();
      motion.translation() = center + step.head<3>() - motion.linear() * center;
      trial = motion * *world_from_inner;
      // Products of rotations drift from the group in the last digits.
      trial.linear() = Eigen::Quaterniond(trial.linear()).normalized().toRotationMatrix();
      trial_energy = energy_at(trial, center, &trial_A, &trial_b);
    }
    if (!(trial_energy < energy)) break;
    const bool done = energy - trial_energy < 1e-3 * energy;
    *world_from_inner = trial;
    energy = trial_energy;
    A = trial_A;
    b = trial_b;
    if (done) break;
  }
  return Evaluate(*world_from_inner, x);
}

double FeatureLoads::EnergyAt(double distance_mm) const {
  double stiffness = 0.0;
  for (std::size_t l = 0; l < attached_tet_.size(); ++l) stiffness += loads_[l].stiffness;
  return 0.5 * stiffness * distance_mm * distance_mm;
}

double FeatureLoads::Multiply(const simd::F4* p) {
  double curvature = 0.0;
  for (std::size_t l = 0; l < loads_.size(); ++l) {
    const Load& load = loads_[l];
    __m128 at = _mm_setzero_ps();
    for (int a = 0; a < 4; ++a)
      at = _mm_add_ps(at, _mm_mul_ps(_mm_set1_ps(load.weight[a]), simd::Load(p[load.vertex[a]])));
    simd::F4 d;
    simd::Store(&d, at);
    const simd::F4 y = load.Times(d);
    products_[l] = y;
    curvature += d.x * y.x + d.y * y.y + d.z * y.z;
  }
  return curvature;
}

}  // namespace kerf
