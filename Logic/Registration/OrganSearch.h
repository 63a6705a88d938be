#pragma once

#include <tbb/task_group.h>

#include "Core/Camera.h"
#include "Core/Features.h"
#include "Core/SurfaceMesh.h"

namespace kerf {

/// Looks for the organ in a frame beside other work, where there is a thread to spare. What is
/// found depends on the arguments alone.
class OrganSearch {
 public:
  struct Found {
    Image model;  ///< ProjectedMask of the outline
    Image organ;  ///< what the segmenter says
  };
  /// @param segmenter, frame, camera outlive this; the segmenter isn't called by anyone else in the
  /// meantime
  OrganSearch(OrganSegmenter& segmenter, const Frame& frame, const CameraModel& camera)
      : segmenter_(segmenter), frame_(frame), camera_(camera) {}
  ~OrganSearch();
  OrganSearch(const OrganSearch&) = delete;
  OrganSearch& operator=(const OrganSearch&) = delete;

  /// Starts with the model where it is now. Once.
  void Begin(SurfaceMesh outline);
  /// What was found. @throws what the segmenter threw
  Found& Wait();

 private:
  OrganSegmenter& segmenter_;
  const Frame& frame_;
  const CameraModel& camera_;
  SurfaceMesh outline_;
  Found found_;
  tbb::task_group group_;
};

}  // namespace kerf
