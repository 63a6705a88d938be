#include "Pipelines/TruthFiles.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "Adapters/OpenCv/CameraFile.h"
#include "Adapters/Vtk/MeshFiles.h"
#include "CaseIO/Csv.h"
#include "CaseIO/ResultsFiles.h"
#include "CaseIO/Space.h"
#include "Core/Errors.h"
#include "Evaluation/SurfaceDistance.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

std::string In(const std::string& folder, const std::string& name) {
  return (fs::path(folder) / name).string();
}

double RequiredNumber(const nlohmann::json& object, const char* key, const std::string& file,
                      const std::string& element) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_number())
    throw InputError(file, element + "." + key, "is missing or not a number");
  return it->get<double>();
}

std::vector<TrueCut> ReadTrueCuts(const std::string& file) {
  // The lines are read as any cuts.json; the truth's are RAS whether tagged or not.
  std::ifstream in(file);
  if (!in) throw InputError(file, "", "cannot be opened");
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("cuts") || !json["cuts"].is_array())
    throw InputError(file, "cuts", "is missing or not a list");
  const std::string space = json.value("space", "RAS");
  std::vector<TrueCut> cuts;
  for (std::size_t c = 0; c < json["cuts"].size(); ++c) {
    const auto& entry = json["cuts"][c];
    const std::string element = "cuts[" + std::to_string(c) + "]";
    TrueCut cut;
    cut.start_frame = RequiredNumber(entry, "start_frame", file, element);
    cut.start_time_s = RequiredNumber(entry, "start_time_s", file, element);
    if (entry.contains("first_frame_opening_over_1mm") &&
        entry["first_frame_opening_over_1mm"].is_number())
      cut.first_frame_opening_over_1mm = entry["first_frame_opening_over_1mm"].get<double>();
    if (!entry.contains("polyline_rest") || !entry["polyline_rest"].is_array())
      throw InputError(file, element + ".polyline_rest", "is missing or not a list");
    const auto& line = entry["polyline_rest"];
    cut.polyline_rest.resize(static_cast<Index>(line.size()), 3);
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (!line[i].is_array() || line[i].size() != 3 || !line[i][0].is_number() ||
          !line[i][1].is_number() || !line[i][2].is_number())
        throw InputError(file, element + ".polyline_rest[" + std::to_string(i) + "]",
                         "is not a list of three numbers");
      const Vec3 p(line[i][0], line[i][1], line[i][2]);
      cut.polyline_rest.row(i) = (space == "LPS" ? p : FlipSpace(p)).transpose();
    }
    cuts.push_back(std::move(cut));
  }
  return cuts;
}

TrueTracks ReadTrueTracks(const std::string& tracks_file, const std::string& rest_file) {
  TrueTracks tracks;
  for (const auto& f : ReadRestFeatures(rest_file)) tracks.rest[f.id] = f;
  const CsvTable t = CsvTable::Read(tracks_file);
  const int frame = t.Column("frame"), id = t.Column("id"), x = t.Column("x_mm"),
            y = t.Column("y_mm"), z = t.Column("z_mm");
  for (std::size_t r = 0; r < t.Rows(); ++r) {
    const int i = t.Integer(r, id);
    if (!tracks.rest.count(i))
      throw InputError(tracks_file, t.Where(r, id),
                       "unknown id " + std::to_string(i) + ": it is not in " + rest_file);
    tracks.current[t.Integer(r, frame)][i] =
        FlipSpace(Vec3(t.Number(r, x), t.Number(r, y), t.Number(r, z)));
  }
  return tracks;
}

/// The rest surface without the faces of cuts: those are inside until they open.
SurfaceMesh ReadRestOuter(const std::string& path) {
  SurfaceMesh surface = ReadSurfaceFile(path).surface;
  const auto cut = ReadPointArray(path, "cut", static_cast<Index>(surface.points.rows()));
  Triangles kept(surface.triangles.rows(), 3);
  Index count = 0;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto v = surface.triangles.row(t);
    if (cut[v[0]] == 0 && cut[v[1]] == 0 && cut[v[2]] == 0) kept.row(count++) = v;
  }
  surface.triangles = kept.topRows(count);
  return surface;
}

}  // namespace

Truth OpenTruth(const std::string& study) {
  Truth truth;
  truth.study = OpenStudy(study);
  truth.folder = In(study, "truth");
  if (!fs::is_directory(truth.folder))
    throw InputError(truth.folder, "", "is missing: the study has no truth to judge against");
  truth.cuts = ReadTrueCuts(In(truth.folder, "cuts.json"));
  const std::string tracks = In(truth.folder, "tracks.csv");
  if (!truth.study.features_rest.empty() && fs::exists(tracks))
    truth.tracks = ReadTrueTracks(tracks, truth.study.features_rest);
  const std::string camera = In(truth.folder, "camera_true.yml");
  truth.eye = ReadCameraFile(fs::exists(camera) ? camera : truth.study.camera).Center();
  truth.rest_outer = ReadRestOuter(In(truth.folder, "rest_organ.vtp"));
  truth.frames = truth.study.eval_frames;
  if (truth.frames.empty())
    for (int f : truth.study.FramesToWrite(truth.study.frames))
      if (!FindFrameMesh(truth.folder, f, "organ").empty()) truth.frames.push_back(f);
  if (truth.frames.empty())
    throw InputError(In(study, "case.json"), "eval_frames", "names no frame to be judged");
  return truth;
}

std::string FindFrameMesh(const std::string& folder, int frame, const std::string& what) {
  for (const char* extension : {"vtp", "ply", "stl", "obj", "vtk"}) {
    const std::string path = In(folder, FrameFileName(frame, what, extension));
    if (fs::exists(path)) return path;
  }
  return {};
}

FrameSurface ReadFrameSurface(const std::string& path) {
  SurfaceFile file = ReadSurfaceFile(path);
  return {std::move(file.surface), std::move(file.rest_position)};
}

SurfaceMesh ReadFrameStructure(const std::string& path) {
  try {
    return ReadSurfaceFile(path).surface;
  } catch (const InputError& e) {
    if (e.Element() == "points" || e.Element() == "triangles") return {};
    throw;
  }
}

Points TruePositionsAt(const Truth& truth, int frame, const Points& rest) {
  const std::string path = FindFrameMesh(truth.folder, frame, "organ");
  const SurfaceMesh current = ReadSurfaceFile(path).surface;
  const auto pid = ReadPointArray(path, "pid", static_cast<Index>(current.points.rows()));
  Points full =
      Points::Constant(truth.rest_outer.points.rows(), 3, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < pid.size(); ++i) {
    if (pid[i] < 0 || pid[i] >= full.rows())
      throw InputError(path, "pid of point " + std::to_string(i), "is not in rest_organ.vtp");
    full.row(pid[i]) = current.points.row(i);
  }
  return CarriedPoints(truth.rest_outer, full, rest);
}

}  // namespace kerf
