#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Core/Frame.h"

namespace kerf {

/// Image files in the order of their frames.
struct ImageSequence {
  std::vector<std::string> files;
  std::string
      gap;  ///< says which numbered file is missing while later ones exist; empty when none is
};

/// Images of a folder in natural order (`f2` before `f10`), or of a printf pattern (`f%05d.png`,
/// from the first number that exists on). @throws InputError naming the folder or pattern: missing,
/// no image in it, not a pattern
ImageSequence ListImageSequence(const std::string& folder_or_pattern);

/// One image as 8-bit BGR; none where the file is missing or broken.
std::optional<Image> ReadImageFile(const std::string& path);

/// Writes a PNG or JPEG (by suffix), whole or not at all. @throws InputError naming the file
void WriteImageFile(const std::string& path, const Image& image);

/// Natural order: runs of digits compare as numbers, the rest as bytes.
bool NaturalLess(const std::string& a, const std::string& b);

}  // namespace kerf
