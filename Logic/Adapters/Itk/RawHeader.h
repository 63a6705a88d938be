#pragma once

#include <string>

#include "Core/Progress.h"

namespace kerf {

/// Checks that ITK's readers leave out or repair in silence, made on the bytes of the header before
/// ITK sees the file: dimension, spacing (NaN, zero, negative), colour, contradictory or sheared
/// axes, length of the voxel data. @throws InputError naming the header's field
void CheckNiftiHeader(const std::string& path, Progress& progress);
/// @param allow_layers a fourth, leading list axis is accepted (.seg.nrrd with overlapping
/// segments)
void CheckNrrdHeader(const std::string& path, bool allow_layers, Progress& progress);
void CheckMetaImageHeader(const std::string& path);

}  // namespace kerf
