#include "Adapters/OpenCv/LandmarkRegistration.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <random>

#include "Core/Errors.h"

namespace kerf {
namespace {

constexpr double kPi = 3.14159265358979323846;
/// Landmarks are clicked: nobody is better than this, so smaller residuals are not worth more.
constexpr double kLeastScale_px = 1.5;

struct Problem {
  const Points& world;
  const Pixels& pixels;
  const CameraModel& intrinsics;
  std::vector<cv::Point3d> cv_world;
  std::vector<cv::Point2d> cv_normalized;
};

struct Candidate {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  double cost = 0.0;
  double scale_px = 0.0;
};

double RotationBetween_deg(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return Eigen::AngleAxisd(Mat3(a.linear() * b.linear().transpose())).angle() * 180.0 / kPi;
}

std::string Row(Index i) { return "landmark " + std::to_string(i); }

void Check(const Points& world, const Pixels& pixels, const CameraModel& intrinsics,
           const std::string& source) {
  intrinsics.Validate(source);
  if (world.rows() != pixels.rows())
    throw InputError(
        source, "",
        std::to_string(world.rows()) + " points but " + std::to_string(pixels.rows()) + " pixels");
  if (world.rows() < 4)
    throw InputError(source, "",
                     "at least 4 landmarks are needed, there are " + std::to_string(world.rows()));
  for (Index i = 0; i < world.rows(); ++i) {
    if (!world.row(i).allFinite()) throw InputError(source, Row(i), "its position is not a number");
    if (!pixels.row(i).allFinite()) throw InputError(source, Row(i), "its pixel is not a number");
    for (Index j = 0; j < i; ++j)
      if ((world.row(i) - world.row(j)).norm() < 1e-3)
        throw InputError(source, Row(i), "at the same place as landmark " + std::to_string(j));
  }
  const Points centered = world.rowwise() - world.colwise().mean();
  const Vec3 spread = Eigen::JacobiSVD<Eigen::MatrixXd>(centered).singularValues();
  if (spread[1] < 0.02 * spread[0])
    throw InputError(source, "", "the landmarks lie on one line: no pose follows from them");
}

/// Residuals in px, 2N; landmarks behind the camera make it fail.
bool Residuals(const Problem& problem, const Eigen::Isometry3d& pose, Eigen::VectorXd* r) {
  CameraModel camera = problem.intrinsics;
  camera.camera_from_world = pose;
  r->resize(2 * problem.world.rows());
  for (Index i = 0; i < problem.world.rows(); ++i) {
    const Vec3 point = problem.world.row(i);
    if (!(camera.Depth(point) > 1.0)) return false;
    r->segment<2>(2 * i) = camera.Project(point) - problem.pixels.row(i).transpose();
  }
  return r->allFinite();
}

Eigen::VectorXd Distances(const Eigen::VectorXd& r) {
  return Eigen::Map<const Eigen::Matrix<double, 2, Eigen::Dynamic>>(r.data(), 2, r.size() / 2)
      .colwise()
      .norm()
      .transpose();
}

double Median(Eigen::VectorXd values) {
  std::sort(values.data(), values.data() + values.size());
  const Index n = static_cast<Index>(values.size());
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/// Scale of a two-dimensional normal error from the median of its lengths, which is 1.177 σ.
double Scale_px(const Eigen::VectorXd& distances) {
  return std::max(kLeastScale_px, Median(distances) / 1.177);
}

/// Geman–McClure with the corner at three scales.
double RobustCost(const Eigen::VectorXd& distances, double scale_px) {
  const double c2 = 9.0 * scale_px * scale_px;
  return (c2 * distances.array().square() / (c2 + distances.array().square())).sum();
}
Eigen::VectorXd RobustWeights(const Eigen::VectorXd& distances, double scale_px) {
  const double c2 = 9.0 * scale_px * scale_px;
  return (c2 / (c2 + distances.array().square())).square();
}

Eigen::Isometry3d Moved(const Eigen::Isometry3d& pose, const Eigen::Matrix<double, 6, 1>& step) {
  Eigen::Isometry3d moved = pose;
  const double angle = step.head<3>().norm();
  if (angle > 0) moved.linear() = Eigen::AngleAxisd(angle, step.head<3>() / angle) * pose.linear();
  moved.translation() += step.tail<3>();
  return moved;
}

/// Levenberg–Marquardt at a fixed scale. Rotation about the landmarks' centre in the camera frame
/// would couple less, but six unknowns need no finesse. @return false when no landmark-in-front
/// pose is kept
bool Refine(const Problem& problem, double scale_px, Candidate* candidate) {
  Eigen::VectorXd r;
  if (!Residuals(problem, candidate->pose, &r)) return false;
  double cost = RobustCost(Distances(r), scale_px);
  double damping = 1e-4;
  for (int iteration = 0; iteration < 60; ++iteration) {
    Eigen::Matrix<double, Eigen::Dynamic, 6> jacobian(r.size(), 6);
    for (int c = 0; c < 6; ++c) {
      const double h = c < 3 ? 1e-6 : 1e-4;
      Eigen::Matrix<double, 6, 1> step = Eigen::Matrix<double, 6, 1>::Zero();
      Eigen::VectorXd plus, minus;
      step[c] = h;
      if (!Residuals(problem, Moved(candidate->pose, step), &plus)) return false;
      step[c] = -h;
      if (!Residuals(problem, Moved(candidate->pose, step), &minus)) return false;
      jacobian.col(c) = (plus - minus) / (2 * h);
    }
    const Eigen::VectorXd weights = RobustWeights(Distances(r), scale_px);
    Eigen::VectorXd doubled(r.size());
    for (Index i = 0; i < weights.size(); ++i) doubled.segment<2>(2 * i).setConstant(weights[i]);
    const Eigen::Matrix<double, 6, 6> normal =
        jacobian.transpose() * doubled.asDiagonal() * jacobian;
    const Eigen::Matrix<double, 6, 1> gradient = jacobian.transpose() * doubled.asDiagonal() * r;
    bool improved = false;
    double gained = 0;
    while (!improved && damping < 1e8) {
      Eigen::Matrix<double, 6, 6> damped = normal;
      damped.diagonal() += damping * normal.diagonal();
      const Eigen::Isometry3d pose = Moved(candidate->pose, -damped.ldlt().solve(gradient));
      Eigen::VectorXd next;
      const bool possible = Residuals(problem, pose, &next);
      const double next_cost = possible ? RobustCost(Distances(next), scale_px) : cost;
      if (possible && next_cost < cost) {
        gained = cost - next_cost;
        cost = next_cost;
        candidate->pose = pose;
        r = next;
        improved = true;
        damping = std::max(1e-9, damping * 0.2);
      } else {
        damping *= 8.0;
      }
    }
    if (!improved || gained < 1e-12 * (1.0 + cost)) break;
  }
  candidate->cost = cost;
  candidate->scale_px = scale_px;
  return true;
}

void AddCandidate(const Problem& problem, const cv::Mat& rotation_vector,
                  const cv::Mat& translation, std::vector<Candidate>* candidates) {
  cv::Mat rotation;
  cv::Rodrigues(rotation_vector, rotation);
  Candidate candidate;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) candidate.pose.linear()(i, j) = rotation.at<double>(i, j);
    candidate.pose.translation()[i] = translation.at<double>(i);
  }
  Eigen::VectorXd r;
  if (!candidate.pose.matrix().allFinite() || !Residuals(problem, candidate.pose, &r)) return;
  const Eigen::VectorXd distances = Distances(r);
  candidate.scale_px = Scale_px(distances);
  // Median first, then all: an outlier must not choose the start.
  candidate.cost = Median(distances) + 1e-3 * RobustCost(distances, 10.0);
  candidates->push_back(candidate);
}

std::vector<std::array<Index, 3>> Triples(Index count) {
  std::vector<std::array<Index, 3>> triples;
  for (Index i = 0; i < count; ++i)
    for (Index j = i + 1; j < count; ++j)
      for (Index k = j + 1; k < count; ++k) triples.push_back({i, j, k});
  constexpr std::size_t kMost = 400;
  if (triples.size() <= kMost) return triples;
  // Fisher–Yates by hand: std::shuffle differs between libraries.
  std::mt19937 random(20161);
  for (std::size_t i = 0; i < kMost; ++i)
    std::swap(triples[i], triples[i + random() % (triples.size() - i)]);
  triples.resize(kMost);
  return triples;
}

std::vector<Candidate> Starts(const Problem& problem) {
  std::vector<Candidate> candidates;
  const cv::Matx33d unit = cv::Matx33d::eye();
  for (const auto& [i, j, k] : Triples(static_cast<Index>(problem.world.rows()))) {
    const std::vector<cv::Point3d> object{problem.cv_world[i], problem.cv_world[j],
                                          problem.cv_world[k]};
    const std::vector<cv::Point2d> image{problem.cv_normalized[i], problem.cv_normalized[j],
                                         problem.cv_normalized[k]};
    std::vector<cv::Mat> rotations, translations;
    cv::solveP3P(object, image, unit, cv::noArray(), rotations, translations, cv::SOLVEPNP_P3P);
    for (std::size_t s = 0; s < rotations.size(); ++s)
      AddCandidate(problem, rotations[s], translations[s], &candidates);
  }
  for (const int method : {cv::SOLVEPNP_EPNP, cv::SOLVEPNP_SQPNP}) {
    cv::Mat rotation, translation;
    try {
      if (cv::solvePnP(problem.cv_world, problem.cv_normalized, unit, cv::noArray(), rotation,
                       translation, false, method))
        AddCandidate(problem, rotation, translation, &candidates);
    } catch (const cv::Exception&) {
      // A degenerate set for this method; the triples remain.
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  return candidates;
}

/// The best starts that differ from each other, refined.
std::vector<Candidate> RefineStarts(const Problem& problem, const std::vector<Candidate>& starts) {
  std::vector<Candidate> chosen;
  constexpr std::size_t kMost = 12;
  for (const Candidate& start : starts) {
    if (chosen.size() == kMost) break;
    const bool known = std::any_of(chosen.begin(), chosen.end(), [&](const Candidate& other) {
      return RotationBetween_deg(start.pose, other.pose) < 4.0;
    });
    if (!known) chosen.push_back(start);
  }
  std::vector<Candidate> refined;
  for (Candidate candidate : chosen) {
    bool good = true;
    // The scale follows the residuals, from a generous one down.
    for (int round = 0; good && round < 4; ++round) {
      good = Refine(problem, candidate.scale_px, &candidate);
      Eigen::VectorXd r;
      if (good && Residuals(problem, candidate.pose, &r))
        candidate.scale_px = Scale_px(Distances(r));
    }
    if (good) refined.push_back(candidate);
  }
  if (refined.empty()) return refined;
  // Compared at one scale, the smallest that any of them reached.
  const double scale_px =
      std::min_element(refined.begin(), refined.end(), [](const Candidate& a, const Candidate& b) {
        return a.scale_px < b.scale_px;
      })->scale_px;
  for (Candidate& candidate : refined) {
    Eigen::VectorXd r;
    Residuals(problem, candidate.pose, &r);
    candidate.cost = RobustCost(Distances(r), scale_px);
    candidate.scale_px = scale_px;
  }
  std::stable_sort(refined.begin(), refined.end(),
                   [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; });
  return refined;
}

void Describe(const Points& world, LandmarkResult* result) {
  char text[200];
  for (const Index i : result->outliers) {
    std::snprintf(text, sizeof text, "landmark %d is %.0f px (%.1f mm) off and was left out; ",
                  static_cast<int>(i), result->residual_px[i], result->residual_mm[i]);
    result->warning += text;
  }
  if (world.rows() - static_cast<Index>(result->outliers.size()) < 5)
    result->warning += "fewer than five landmarks agree: check the overlay; ";
  if (result->ambiguous) {
    std::snprintf(text, sizeof text,
                  "another pose, turned by %.0f degrees, explains the landmarks about as well; ",
                  result->ambiguity_deg);
    result->warning += text;
  }
  if (!result->warning.empty()) result->warning.resize(result->warning.size() - 2);
}

}  // namespace

LandmarkResult RegisterLandmarks(const Points& world, const Pixels& pixels,
                                 const CameraModel& intrinsics, const std::string& source) {
  Check(world, pixels, intrinsics, source);
  Problem problem{world, pixels, intrinsics, {}, {}};
  for (Index i = 0; i < world.rows(); ++i) {
    const Vec2 normalized = intrinsics.Undistort(pixels.row(i));
    problem.cv_world.emplace_back(world(i, 0), world(i, 1), world(i, 2));
    problem.cv_normalized.emplace_back(normalized.x(), normalized.y());
  }
  const std::vector<Candidate> poses = RefineStarts(problem, Starts(problem));
  if (poses.empty())
    throw InputError(source, "", "no pose has all landmarks in front of the camera");

  LandmarkResult result;
  result.camera = intrinsics;
  result.camera.camera_from_world = poses[0].pose;
  Eigen::VectorXd r;
  Residuals(problem, poses[0].pose, &r);
  result.residual_px = Distances(r);
  const double scale_px = Scale_px(result.residual_px);
  result.weight = RobustWeights(result.residual_px, scale_px);
  result.residual_mm.resize(world.rows());
  double squares = 0;
  Index kept = 0;
  for (Index i = 0; i < world.rows(); ++i) {
    const double focal_px = 0.5 * (intrinsics.fx + intrinsics.fy);
    result.residual_mm[i] = result.residual_px[i] * result.camera.Depth(world.row(i)) / focal_px;
    if (result.residual_px[i] > 4.5 * scale_px) {
      result.outliers.push_back(i);
    } else {
      squares += result.residual_px[i] * result.residual_px[i];
      ++kept;
    }
  }
  result.rms_px = kept > 0 ? std::sqrt(squares / kept) : 0.0;
  std::sort(result.outliers.begin(), result.outliers.end(),
            [&](Index a, Index b) { return result.residual_px[a] > result.residual_px[b]; });
  // About as well: by less than a likelihood ratio of exp(4) at this scale.
  for (const Candidate& other : poses) {
    const double turned = RotationBetween_deg(other.pose, poses[0].pose);
    if (turned < 5.0 || other.cost - poses[0].cost > 8.0 * scale_px * scale_px) continue;
    result.ambiguous = true;
    result.ambiguity_deg = turned;
    break;
  }
  Describe(world, &result);
  return result;
}

}  // namespace kerf
