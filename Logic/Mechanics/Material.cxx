#include "Core/Errors.h"
#include "Mechanics/ElasticSolver.h"

namespace kerf {

double Material::Mu_Pa(std::uint8_t region) const {
  const double factor =
      region == static_cast<std::uint8_t>(Label::Tumour) ? tumour_stiffness_factor : 1.0;
  return 1000.0 * factor * young_kPa / (2.0 * (1.0 + poisson));
}

double Material::Lambda_Pa(std::uint8_t region) const {
  const double factor =
      region == static_cast<std::uint8_t>(Label::Tumour) ? tumour_stiffness_factor : 1.0;
  return 1000.0 * factor * young_kPa * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
}

void Material::Validate() const {
  if (!(young_kPa > 0.0)) throw UsageError("Young's modulus must be positive (kPa)");
  if (!(poisson >= 0.0 && poisson < 0.5)) throw UsageError("Poisson's ratio must be in [0, 0.5)");
  if (!(tumour_stiffness_factor > 0.0))
    throw UsageError("the tumour stiffness factor must be positive");
  if (!(density_g_mm3 > 0.0)) throw UsageError("the density must be positive");
}

}  // namespace kerf
