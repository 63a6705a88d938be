#pragma once

#include "Mechanics/ElasticSolver.h"

namespace kerf {

/// The minimizer of Eq. (5) in double precision, taken to convergence: Newton with the assembled
/// projected Hessian, line search and conjugate gradient. Slow; the yardstick that tests and
/// benchmarks measure the other solvers with. Reads of SolveOptions: max_newton_steps (0: 100),
/// tolerance (relative energy gap; 1e-12 for a yardstick), threads.
std::unique_ptr<ElasticSolver> MakeExactSolver();

}  // namespace kerf
