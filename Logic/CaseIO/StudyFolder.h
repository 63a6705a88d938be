#pragma once

#include <optional>
#include <string>
#include <vector>

#include "Core/Types.h"

namespace kerf {

/// What the study suggests for the reference method; used by nothing else.
struct SuggestedParameters {
  std::optional<double> young_kPa, poisson, neighbour_radius_mm, tau, cut_radius_mm;
  std::optional<int> outliers;
};

/// A recorded study (layout: docs/reference/study-and-results.md). Paths are absolute or relative
/// as `root` was given; a path is empty where the file is not there. `truth/` is never looked at.
struct Study {
  std::string root, name;     ///< `name` is the folder's
  std::string ct;             ///< ct.nii.gz, .nii, .nrrd
  std::string labels;         ///< labels.nii.gz, .nii, .nrrd, .seg.nrrd
  std::string organ_surface;  ///< organ_surface.stl, .vtp, .ply, .obj
  std::string video;   ///< file, image folder or pattern as case.json names it (default video.mp4);
                       ///< empty where missing
  std::string camera;  ///< camera.yml
  std::string landmarks, features_rest, features_2d;  ///< .csv

  double frames_per_second = 25.0;
  int frames = 0;                      ///< 0 where case.json does not say
  int width = 0, height = 0;           ///< px, 0 where case.json does not say
  std::vector<int> eval_frames;        ///< as listed, ascending; empty where there is no list
  int feature_count = 0;               ///< 0 where case.json does not say
  SuggestedParameters suggested;       ///< --method reference only
  std::optional<Vec3> extrusion_hint;  ///< unit vector, LPS; --method reference only

  /// Frames to be written: the list, or every fifth frame and the last.
  std::vector<int> FramesToWrite(int frame_count) const;
};

/// @throws InputError naming file and key: no folder, no camera.yml, neither labels nor CT nor
/// surface, broken case.json, a case folder given instead of a study. A missing case.json is
/// allowed: defaults.
Study OpenStudy(const std::string& root);

struct RestFeature {
  int id = 0;
  bool use = true;
  Vec3 rest = Vec3::Zero();   ///< LPS, mm
  Vec2 pixel = Vec2::Zero();  ///< frame 0
};
/// features_rest.csv: id,use,x_mm,y_mm,z_mm,u_px,v_px (RAS). @throws InputError; ids must be unique
std::vector<RestFeature> ReadRestFeatures(const std::string& file);

/// Perfect tracks: N features over F frames, complete from frame 0 (a frame without a row: not
/// visible).
struct TrackTable {
  std::vector<int> id;        ///< N, ascending
  Points rest;                ///< N×3, LPS, mm
  Pixels rest_pixels;         ///< N×2, frame 0
  int frames = 0;             ///< F = last frame + 1
  Pixels pixels;              ///< (F·N)×2, frame-major; raw distorted px
  std::vector<char> visible;  ///< F·N

  Index Row(int frame, Index feature) const {
    return static_cast<Index>(frame * static_cast<Index>(id.size()) + feature);
  }
};
/// tracks: frame,id,u_px,v_px,visible; further columns are ignored.
/// @throws InputError naming file, line, column: unknown ids, negative frame, a pair (frame, id)
/// given twice
TrackTable ReadTracks(const std::string& tracks_file, const std::string& features_rest_file);

struct Landmark {
  int id = 0;
  Vec3 rest = Vec3::Zero();   ///< LPS, mm
  Vec2 pixel = Vec2::Zero();  ///< frame 0, raw distorted px
};
/// landmarks.csv: id,x_mm,y_mm,z_mm,u_px,v_px (RAS). @throws InputError
std::vector<Landmark> ReadLandmarks(const std::string& file);

}  // namespace kerf
