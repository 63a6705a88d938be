#include "Phantom/PhantomScenario.h"

#include <cmath>

#include "Core/Errors.h"
#include "Phantom/PhantomShape.h"

namespace kerf {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

Eigen::Isometry3d FromAxes(const Vec3& x, const Vec3& y_about, const Vec3& origin) {
  const Vec3 ex = x.normalized();
  const Vec3 ez = ex.cross(y_about).normalized();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = ex;
  pose.linear().col(1) = ez.cross(ex);
  pose.linear().col(2) = ez;
  pose.translation() = origin;
  return pose;
}

/// Looks at `target` (organ axes) from +z: image right = +x, image up = +y, then turned a little
/// about all axes.
Eigen::Isometry3d CameraFromOrgan(const Vec3& target, double distance_mm, const Vec3& turn_deg) {
  Mat3 look;
  look << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  const Mat3 turn = (Eigen::AngleAxisd(turn_deg.z() * kDegree, Vec3::UnitZ()) *
                     Eigen::AngleAxisd(turn_deg.y() * kDegree, Vec3::UnitY()) *
                     Eigen::AngleAxisd(turn_deg.x() * kDegree, Vec3::UnitX()))
                        .toRotationMatrix();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = turn * look;
  pose.translation() = Vec3(0, 0, distance_mm) - pose.linear() * target;
  return pose;
}

void SetUpKidney(PhantomSetup* setup) {
  // A left kidney: upper pole medial and posterior, hilum medial and anterior, seen by the
  // laparoscope from in front.
  setup->world_from_organ =
      FromAxes(Vec3(-0.25, 0.25, 0.93), Vec3(-0.80, -0.55, 0.0), Vec3(62.0, 31.5, -118.0));
  CameraModel& camera = setup->camera;
  camera.width = 960;
  camera.height = 540;
  camera.fx = 905.0;
  camera.fy = 906.81;
  camera.cx = 484.0;
  camera.cy = 266.0;
  camera.distortion = {-0.165, 0.052, 6e-4, -4e-4, 0.0};
  camera.camera_from_world = CameraFromOrgan(Vec3(1.0, -1.0, 0.0), 178.0, Vec3(5.0, -4.0, 9.0)) *
                             setup->world_from_organ.inverse();
  PhantomMotionParameters& motion = setup->motion;
  motion.middle_x_mm = 2.0;
  motion.grip_reach_mm = 30.0;
  motion.contraction_y_mm = 6.0;
  if (setup->scenario == PhantomScenario::KidneyTwoCuts) {
    motion.middle_x_mm = -4.0;
    PhantomCutParameters cut;
    cut.sheet_x_mm = -19.6;
    cut.final_depth_mm = 24.0;
    cut.start_frame = 77.0;
    cut.end_frame = 105.0;
    motion.cuts.push_back(cut);
    cut.sheet_x_mm = 11.6;  // as many grid cells away as the organ's mesh asks for
    cut.start_frame = 145.0;
    cut.end_frame = 173.0;
    motion.cuts.push_back(cut);
    motion.load_end_frame = 190.0;
    motion.preload_strain = 0.12;
    motion.final_strain = 0.34;
    motion.bow_mm = 2.5;
    setup->has_tool = true;
    setup->frame_count = 200;
  } else if (setup->scenario != PhantomScenario::KidneyNoCut) {
    PhantomCutParameters cut;
    cut.sheet_x_mm = motion.middle_x_mm;
    cut.complete = setup->scenario == PhantomScenario::KidneyThrough;
    cut.sheet_bend_per_mm = setup->scenario == PhantomScenario::KidneyCurved ? 0.015 : 0.003;
    cut.final_depth_mm = cut.complete ? 70.0 : 30.0;
    cut.start_frame = 77.0;
    cut.end_frame = 118.0;
    motion.cuts.push_back(cut);
    motion.preload_strain = 0.12;
    motion.final_strain = cut.complete ? 0.25 : 0.32;
    motion.bow_mm = 2.5;
    setup->has_tool = true;
  } else {
    motion.preload_strain = 0.10;
    motion.final_strain = 0.14;
    motion.bow_mm = 3.0;
    motion.bend_mm = 6.0;
    motion.twist_deg = 10.0;
  }
}

void SetUpBand(PhantomSetup* setup) {
  setup->is_kidney = false;
  setup->feature_count = 220;
  CameraModel& camera = setup->camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 1060.0;
  camera.cx = 319.5;
  camera.cy = 239.5;
  camera.camera_from_world =
      CameraFromOrgan(Vec3::Zero(), 400.0, Vec3(2.0, 1.5, 1.0)) * setup->world_from_organ.inverse();
  PhantomMotionParameters& motion = setup->motion;
  PhantomCutParameters cut;
  cut.entry_y_mm = -0.5 * setup->band_size_mm.y();
  if (setup->scenario == PhantomScenario::BandTwoCuts) {
    cut.sheet_x_mm = -22.0;
    cut.final_depth_mm = 16.0;
    cut.start_frame = 77.0;
    cut.end_frame = 107.0;
    motion.cuts.push_back(cut);
    cut.sheet_x_mm = 20.0;
    cut.entry_y_mm = -cut.entry_y_mm;  // from the other edge
    cut.into = -1.0;
    cut.start_frame = 112.0;
    cut.end_frame = 142.0;
    motion.cuts.push_back(cut);
    motion.load_end_frame = 167.0;
    motion.preload_strain = 0.25;
    motion.final_strain = 0.45;
    setup->frame_count = 175;
  } else if (setup->scenario != PhantomScenario::BandStretch) {
    cut.complete = setup->scenario == PhantomScenario::BandThrough;
    cut.sheet_x_mm = motion.middle_x_mm = -20.0;
    cut.final_depth_mm = cut.complete ? 44.0 : 18.0;
    cut.start_frame = 77.0;
    cut.end_frame = 118.0;
    motion.cuts.push_back(cut);
    motion.preload_strain = 0.25;
    motion.final_strain = cut.complete ? 0.35 : 0.45;
    motion.contraction_y_mm = 6.0;
  } else {
    motion.preload_strain = 0.40;
    motion.final_strain = 0.70;
  }
}

}  // namespace

PhantomScenario ParsePhantomScenario(const std::string& name) {
  std::string known;
  for (const auto s : kPhantomScenarios) {
    if (name == ToString(s)) return s;
    known += std::string(known.empty() ? "" : ", ") + ToString(s);
  }
  throw UsageError("unknown scenario '" + name + "', known are " + known);
}

const char* ToString(PhantomScenario scenario) {
  switch (scenario) {
    case PhantomScenario::KidneyCut:
      return "kidney-cut";
    case PhantomScenario::KidneyCurved:
      return "kidney-curved";
    case PhantomScenario::KidneyThrough:
      return "kidney-through";
    case PhantomScenario::KidneyTwoCuts:
      return "kidney-two-cuts";
    case PhantomScenario::KidneyNoCut:
      return "kidney-nocut";
    case PhantomScenario::BandCut:
      return "band-cut";
    case PhantomScenario::BandThrough:
      return "band-through";
    case PhantomScenario::BandTwoCuts:
      return "band-two-cuts";
    case PhantomScenario::BandStretch:
      return "band-stretch";
  }
  return "";
}

bool IsKidney(PhantomScenario scenario) { return scenario < PhantomScenario::BandCut; }

PhantomSetup MakePhantomSetup(PhantomScenario scenario, std::uint32_t seed) {
  PhantomSetup setup;
  setup.scenario = scenario;
  setup.seed = seed;
  if (IsKidney(scenario)) {
    SetUpKidney(&setup);
    for (auto& cut : setup.motion.cuts) cut.entry_y_mm = KidneyEntryY_mm(cut.sheet_x_mm);
  } else {
    SetUpBand(&setup);
  }
  for (int frame = setup.rest_frames - 5; frame < setup.frame_count; frame += 5)
    setup.eval_frames.push_back(frame);
  return setup;
}

}  // namespace kerf
