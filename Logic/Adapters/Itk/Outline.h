#pragma once

#include "Adapters/Itk/Field.h"

/// Outlines of bodies inside an organ from what their voxels hold. Denoising and half the contrast
/// alone make small bodies smaller: what is thinner than the kernel fades, and where a dark body
/// meets contrast agent or fat, partial volumes look like parenchyma.
namespace kerf {

/// Outline of compact bodies (tumours) that were found roughly, where half of a voxel is body. The
/// fraction of the voxels next to the organ's surface and to `other` is that of their neighbours
/// further in. Reaches at most 2.5 mm beyond `body`.
/// @param hu    as measured, not denoised, brightness drift taken off
/// @param other what else lies in the organ (contrast agent); stays out
Mask OutlineCompact(const ScalarField& hu, const Mask& body, const Mask& organ, const Mask& other);

/// Outline of branching bodies (vessels) whose contrast is less than ten times the noise; others
/// are returned as they are, the noise does not move them. The level is such that the body has the
/// volume that its voxels' intensities add up to; thin ends are followed down to a quarter of the
/// contrast.
Mask OutlineBranching(const ScalarField& hu, const Mask& body, const Mask& organ);

}  // namespace kerf
