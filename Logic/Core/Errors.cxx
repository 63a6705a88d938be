#include "Core/Errors.h"

namespace kerf {

InputError::InputError(const std::string& file, const std::string& element,
                       const std::string& problem)
    : std::runtime_error(file + (element.empty() ? "" : ": " + element) + ": " + problem),
      file_(file),
      element_(element) {}

}  // namespace kerf
