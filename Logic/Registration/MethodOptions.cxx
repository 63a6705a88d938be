#include "Registration/MethodOptions.h"

#include "Core/Errors.h"

namespace kerf {

SolveOptions MethodOptions::FrameSolve() {
  SolveOptions solve;
  solve.max_newton_steps = kFrameNewtonSteps;
  solve.most_iterations = kFrameIterations;
  return solve;
}

double MethodOptions::SpringStiffness_g_s2() const {
  if (spring_g_s2) return *spring_g_s2;
  return 1000.0 * material.young_kPa * spring_factor_mm;
}

void MethodOptions::Validate() const {
  material.Validate();
  const auto positive = [](double value, const char* name) {
    if (!(value > 0.0)) throw UsageError(std::string(name) + " must be positive");
  };
  positive(SpringStiffness_g_s2(), "--spring");
  positive(neighbour_radius_mm, "--neighbour-radius");
  positive(tau, "--tau");
  positive(outliers, "--outliers");
  positive(cut_radius_mm, "--cut-radius");
  positive(steps_per_frame, "--steps-per-frame");
  if (cut_depth_mm) positive(*cut_depth_mm, "--cut-depth");
  if (extrusion && !(std::abs(extrusion->norm() - 1.0) < 1e-6))
    throw UsageError("--extrusion must be a direction other than 0,0,0");
}

MethodOptions ReferenceOptions() {
  MethodOptions options;
  options.method = Method::Reference;
  options.spring_factor_mm = 1.0;
  options.along_factor = 1.0;
  options.robust_scale_mm = 0.0;
  options.silhouette_factor = 0.0;
  options.grips = false;
  options.steps_per_frame = 5;
  options.structure_mode = StructureCutMode::DeleteTriangles;
  return options;
}

}  // namespace kerf
