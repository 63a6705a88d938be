#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "Core/Camera.h"

namespace kerf {

enum class PhantomScenario {
  KidneyCut,
  KidneyCurved,
  KidneyThrough,
  KidneyTwoCuts,
  KidneyNoCut,
  BandCut,
  BandThrough,
  BandTwoCuts,
  BandStretch
};
inline constexpr std::array kPhantomScenarios{
    PhantomScenario::KidneyCut,     PhantomScenario::KidneyCurved, PhantomScenario::KidneyThrough,
    PhantomScenario::KidneyTwoCuts, PhantomScenario::KidneyNoCut,  PhantomScenario::BandCut,
    PhantomScenario::BandThrough,   PhantomScenario::BandTwoCuts,  PhantomScenario::BandStretch};

/// One of the names of ToString; @throws UsageError on anything else
PhantomScenario ParsePhantomScenario(const std::string& name);
const char* ToString(PhantomScenario scenario);
bool IsKidney(PhantomScenario scenario);  ///< otherwise a band

/// One cut through the full thickness. Times in frames, lengths in the organ's own axes.
struct PhantomCutParameters {
  double sheet_x_mm = 0.0;         ///< where the sheet meets the long axis at the entry edge
  double sheet_bend_per_mm = 0.0;  ///< the sheet is x = sheet_x + bend · depth²
  double entry_y_mm = 0.0;         ///< the edge where the cut enters (depth 0)
  double into = 1.0;               ///< +1 when it advances along +y, −1 along −y
  double final_depth_mm = 0.0;     ///< may lie beyond the far edge
  bool complete = false;           ///< the cut ends beyond the far edge: two pieces
  double start_frame = 0.0, end_frame = 0.0;  ///< of its growth
};

/// How the organ moves. Times in frames; lengths in the organ's own axes (x long, y from the convex
/// border or lower edge across, z up).
struct PhantomMotionParameters {
  std::vector<PhantomCutParameters> cuts;  ///< ascending in x; their sheets do not meet
  double middle_x_mm = 0.0;  ///< the stretch is about this section (curved as the first sheet)
  double load_start_frame = 25.0;  ///< everything is at rest until here
  double preload_end_frame = 72.0, load_end_frame = 142.0;
  double preload_strain = 0.0;  ///< in the middle, before the cut
  double final_strain =
      0.0;  ///< far-field strain at the end: a mouth in the middle opens by 2 · strain · depth
  double grip_reach_mm = 0.0;     ///< the stretch fades with tanh(x / reach); 0 = uniform
  double contraction_y_mm = 0.0;  ///< axis about which the section contracts
  double bow_mm = 0.0;            ///< the middle rises towards the camera
  double bend_mm = 0.0;           ///< sideways bending, at 50 mm from the middle
  double twist_deg = 0.0;         ///< about the long axis, at 50 mm from the middle
};

/// Everything that one scenario fixes. `seed` varies noise and textures, never the geometry or the
/// motion.
struct PhantomSetup {
  PhantomScenario scenario = PhantomScenario::KidneyCut;
  std::uint32_t seed = 1;
  bool is_kidney = true;
  Vec3 band_size_mm{120.0, 30.0, 4.0};
  Eigen::Isometry3d world_from_organ = Eigen::Isometry3d::Identity();  ///< organ axes → patient LPS
  CameraModel camera;
  PhantomMotionParameters motion;
  bool has_tool = false;
  int frame_count = 150;
  int rest_frames = 25;
  double frames_per_second = 25.0;
  int feature_count = 225;
  std::vector<int> eval_frames;  ///< 20, 25, … 145
};

PhantomSetup MakePhantomSetup(PhantomScenario scenario, std::uint32_t seed);

}  // namespace kerf
