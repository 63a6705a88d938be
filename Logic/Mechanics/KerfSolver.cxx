#include "Mechanics/ExactSolver.h"

namespace kerf {

std::unique_ptr<ElasticSolver> MakeKerfSolver() { return MakeExactSolver(); }

}  // namespace kerf
