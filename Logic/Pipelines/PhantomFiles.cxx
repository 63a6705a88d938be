#include "Pipelines/PhantomFiles.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "CaseIO/AtomicFile.h"
#include "CaseIO/Space.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

void WriteText(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.Stream() << text;
  file.Commit();
}

double Rounded(double value, int decimals) {
  const double scale = std::pow(10.0, decimals);
  const double rounded = std::round(value * scale) / scale;
  return rounded == 0.0 ? 0.0 : rounded;  // no negative zero
}

Json Triple(const Vec3& lps) {
  const Vec3 p = FlipSpace(lps);
  return {Rounded(p.x(), 3), Rounded(p.y(), 3), Rounded(p.z(), 3)};
}

/// Eigen row-major list of numbers as OpenCV's FileStorage writes matrices.
std::string YamlMatrix(const std::string& name, const Eigen::MatrixXd& m) {
  std::string data;
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j)
      data += fmt::format("{}{:.16e}", data.empty() ? "" : ", ", m(i, j));
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n",
                     name, m.rows(), m.cols(), data);
}

std::string Description(PhantomScenario scenario) {
  switch (scenario) {
    case PhantomScenario::KidneyCut:
      return "Synthetic kidney with tumour and calyces, cut across the long axis from the convex "
             "border beside the tumour while being pulled along the long axis; scissors follow the "
             "tip of the cut.";
    case PhantomScenario::KidneyCurved:
      return "Synthetic kidney as kidney-cut, along a curve that bends by 13 mm towards the "
             "tumour.";
    case PhantomScenario::KidneyThrough:
      return "Synthetic kidney as kidney-cut, cut through from border to hilum: two pieces.";
    case PhantomScenario::KidneyTwoCuts:
      return "Synthetic kidney pulled along the long axis and cut twice from the convex border, "
             "beside the upper calyx and, 2.7 s later, beside the tumour; scissors follow each "
             "tip.";
    case PhantomScenario::KidneyNoCut:
      return "Synthetic kidney pulled, bent and twisted without a cut: every detected cut is "
             "false.";
    case PhantomScenario::BandCut:
      return "Synthetic band stretched, then cut from one edge while being stretched further.";
    case PhantomScenario::BandThrough:
      return "Synthetic band stretched, then cut through from edge to edge: two pieces.";
    case PhantomScenario::BandTwoCuts:
      return "Synthetic band stretched, then cut from one edge and, 1.4 s later, 42 mm away from "
             "the other, while being stretched further.";
    case PhantomScenario::BandStretch:
      return "Synthetic band stretched uniformly without a cut: every detected cut is false.";
  }
  return "";
}

Json Extent(const SurfaceMesh& surface) {
  const Vec3 size = surface.points.colwise().maxCoeff() - surface.points.colwise().minCoeff();
  return {Rounded(size.x(), 1), Rounded(size.y(), 1), Rounded(size.z(), 1)};
}

}  // namespace

void WriteStudyCamera(const std::string& path, const CameraModel& camera,
                      const std::string& comment) {
  Eigen::MatrixXd matrix(3, 3), distortion(1, 5);
  matrix << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  for (int i = 0; i < 5; ++i) distortion(0, i) = camera.distortion[i];
  Eigen::Matrix4d flip = Eigen::Matrix4d::Identity();
  flip(0, 0) = flip(1, 1) = -1.0;
  const Eigen::MatrixXd pose = camera.camera_from_world.matrix() * flip;
  WriteText(path, fmt::format("%YAML:1.0\n---\n# {}\nimage_width: {}\nimage_height: {}\n", comment,
                              camera.width, camera.height) +
                      YamlMatrix("camera_matrix", matrix) +
                      YamlMatrix("distortion_coefficients", distortion) +
                      YamlMatrix("T_cam_from_ct", pose));
}

void WriteStudyManifest(const std::string& path, const PhantomSetup& setup,
                        const PhantomAnatomy& anatomy, const LabelMap* labels) {
  const bool kidney = setup.is_kidney;
  Json json;
  json["format"] = "kerf-study";
  json["name"] = std::string("phantom-") + ToString(setup.scenario);
  json["description"] = Description(setup.scenario);
  json["kind"] = kidney ? "kidney" : "silicone";
  json["synthetic"] = {
      {"scenario", ToString(setup.scenario)}, {"seed", setup.seed}, {"motion", "closed form"}};
  json["units"] = {{"length", "mm"}, {"time", "s"},       {"angle", "degrees"},
                   {"image", "px"},  {"intensity", "HU"}, {"modulus", "kPa"}};
  json["video"] = {{"file", "video.mp4"},
                   {"fps", setup.frames_per_second},
                   {"frames", setup.frame_count},
                   {"width", setup.camera.width},
                   {"height", setup.camera.height}};
  json["organ_size_mm"] = Extent(anatomy.organ);
  json["internal_size_mm"] = kidney ? Extent(anatomy.internal) : Json(nullptr);
  json["preoperative"] = kidney ? "ct.nii.gz (+ labels.nii.gz)" : "organ_surface.stl + dims.json";
  json["ct"] = nullptr;
  if (labels != nullptr) {
    const GridGeometry& grid = labels->grid;
    auto cm3 = [&](Label label) { return Rounded(labels->LabelVolume_mm3(label) / 1000.0, 4); };
    json["ct"] = {{"shape", {grid.size[0], grid.size[1], grid.size[2]}},
                  {"spacing_mm", {grid.spacing_mm[0], grid.spacing_mm[1], grid.spacing_mm[2]}},
                  {"label_volumes_cm3",
                   {{"organ_rest", cm3(Label::Organ)},
                    {"tumour", cm3(Label::Tumour)},
                    {"internal", cm3(Label::Internal)}}}};
  }
  json["feature_count"] = setup.feature_count;
  json["eval_frames"] = setup.eval_frames;
  json["rest_frames"] = setup.rest_frames;
  json["tool_in_view"] = setup.has_tool;
  json["pose_in_camera_yml"] = "exact";
  // The sheet is extruded along the organ's own third axis, away from the camera.
  const Vec3 down = -(setup.world_from_organ.linear().col(2));
  json["extrusion_hint_ct"] = {Rounded(-down.x(), 4), Rounded(-down.y(), 4), Rounded(down.z(), 4)};
  json["suggested_parameters"] = {{"young_kPa", kidney ? 15 : 180},
                                  {"poisson", 0.45},
                                  {"r_neighbour_mm", kidney ? 15 : 10},
                                  {"tau", 8},
                                  {"n", 8},
                                  {"r_cut_mm", kidney ? 7 : 5}};
  WriteText(path, json.dump(1) + "\n");
}

void WriteTrueCuts(const std::string& path, const PhantomSetup& setup,
                   const PhantomMotion& motion) {
  Json json;
  json["frame_of_points"] = "CT frame (RAS), mm";
  json["cuts"] = Json::array();
  for (int index = 0; index < motion.CutCount(); ++index) {
    const PhantomCutParameters& c = setup.motion.cuts[index];
    Json cut;
    cut["index"] = index;
    cut["start_frame"] = c.start_frame;
    cut["start_time_s"] = c.start_frame / setup.frames_per_second;
    cut["end_frame"] = c.end_frame;
    cut["enters_at_depth"] = Rounded(c.entry_y_mm, 3);
    cut["units"] = "mm, depth measured along the width axis from the entry edge";
    cut["complete"] = c.complete;
    for (int frame = 0; frame < setup.frame_count; ++frame) {
      cut["advance_mm_per_frame"].push_back(Rounded(motion.TipDepth_mm(frame, index), 3));
      if (!cut.contains("first_frame_opening_over_1mm") &&
          motion.Opening_mm(0.0, frame, index) > 1.0)
        cut["first_frame_opening_over_1mm"] = frame;
    }
    const Points line = CutLine(setup, motion, index, c.final_depth_mm);
    for (Index i = 0; i < line.rows(); ++i) {
      cut["polyline_rest"].push_back(Triple(setup.world_from_organ * line.row(i).transpose()));
      cut["polyline_rest_depth"].push_back(Rounded(motion.Depth_mm(line.row(i), index), 3));
    }
    cut["evaluated"] = Json::array();
    for (int frame : setup.eval_frames) {
      const double tip = motion.TipDepth_mm(frame, index);
      Json at{{"frame", frame},
              {"advance_mm", Rounded(tip, 3)},
              {"opening_mm", Rounded(motion.Opening_mm(0.0, frame, index), 3)},
              {"lip_minus", Json::array()},
              {"lip_plus", Json::array()}};
      auto lip = [&](const Vec3& rest, int region) {
        return Triple(setup.world_from_organ * motion.Position(rest, region, frame));
      };
      for (Index i = 0; i < line.rows(); ++i) {
        const Vec3 p = line.row(i);
        if (motion.Depth_mm(p, index) >= tip) continue;
        at["lip_minus"].push_back(lip(p, index));
        at["lip_plus"].push_back(lip(p, index + 1));
      }
      cut["evaluated"].push_back(at);
    }
    json["cuts"].push_back(cut);
  }
  WriteText(path, json.dump(1) + "\n");
}

void WriteBandDimensions(const std::string& path, const PhantomSetup& setup) {
  const Json json{{"length_mm", setup.band_size_mm.x()},
                  {"width_mm", setup.band_size_mm.y()},
                  {"thickness_mm", setup.band_size_mm.z()},
                  {"ct_from_band", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}},
                  {"band_axes", "x length, y width, z thickness, origin at the centre"}};
  WriteText(path, json.dump(1) + "\n");
}

}  // namespace kerf
