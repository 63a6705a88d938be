#pragma once
// Private to Pipelines: the truth of a study.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "CaseIO/StudyFolder.h"
#include "Core/Camera.h"
#include "Core/SurfaceMesh.h"
#include "Evaluation/CutComparison.h"

namespace kerf {

/// The true positions of the study's 300 material points.
struct TrueTracks {
  std::map<int, RestFeature> rest;             ///< by id
  std::map<int, std::map<int, Vec3>> current;  ///< frame → id → LPS mm; evaluated frames only
};

/// Everything of `truth/` that does not belong to one frame.
struct Truth {
  std::string folder;
  Study study;
  std::vector<TrueCut> cuts;
  TrueTracks tracks;
  Vec3 eye = Vec3::Zero();  ///< true camera centre, LPS
  SurfaceMesh rest_outer;   ///< rest surface without cut faces; points as in the file
  std::vector<int> frames;  ///< to be judged
};

/// @throws InputError naming file and element
Truth OpenTruth(const std::string& study);

/// Path of folder/frame_%05d_<what>.<extension> with the first extension that exists; empty where
/// none does.
std::string FindFrameMesh(const std::string& folder, int frame, const std::string& what);
/// An organ surface of the truth or of a result.
struct FrameSurface {
  SurfaceMesh surface;
  std::optional<Points> rest_position;
};
FrameSurface ReadFrameSurface(const std::string& path);
/// An inner structure; empty where nothing of it is left.
SurfaceMesh ReadFrameStructure(const std::string& path);

/// True current positions of rest points, interpolated on the truth's surface of a frame; rows of
/// NaN where the surface has gone there. @param rest N×3, LPS
Points TruePositionsAt(const Truth& truth, int frame, const Points& rest);

}  // namespace kerf
