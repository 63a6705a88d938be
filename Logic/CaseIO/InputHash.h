#pragma once

#include <string>

#include "Core/Progress.h"

namespace kerf {

/// One hash for what a case is planned from: of a file, or of a folder's files in the order of
/// their names. The CT of a case stands for the input that the case was made from, so that the same
/// patient keeps the pseudonym.
/// @throws InputError naming the file; Cancelled
std::string Sha256OfInput(const std::string& path, Progress& progress);

}  // namespace kerf
