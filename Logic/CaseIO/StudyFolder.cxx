#include "CaseIO/StudyFolder.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "CaseIO/Csv.h"
#include "CaseIO/JsonRead.h"
#include "CaseIO/Space.h"
#include "Core/Errors.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

std::string FirstExisting(const fs::path& root, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (fs::is_regular_file(root / name)) return (root / name).string();
  return {};
}

void ReadVideo(const json_read::Json& video, const std::string& file, Study* study) {
  using namespace json_read;
  if (!video.is_object()) throw InputError(file, "video", "is not an object");
  if (auto* v = Find(video, "file")) {
    const std::string name = Text(*v, file, "video.file");
    const fs::path relative = fs::path(name).lexically_normal();
    if (name.empty() || relative.is_absolute() || *relative.begin() == "..")
      throw InputError(file, "video.file", "\"" + name + "\" is not a file inside the study");
    study->video = (fs::path(study->root) / relative).string();
  }
  if (auto* v = Find(video, "fps")) {
    study->frames_per_second = Number(*v, file, "video.fps");
    if (study->frames_per_second <= 0) throw InputError(file, "video.fps", "must be positive");
  }
  const std::pair<const char*, int*> counts[] = {
      {"frames", &study->frames}, {"width", &study->width}, {"height", &study->height}};
  for (const auto& [key, value] : counts)
    if (auto* v = Find(video, key)) {
      *value = Integer(*v, file, std::string("video.") + key);
      if (*value <= 0) throw InputError(file, std::string("video.") + key, "must be positive");
    }
}

void ReadSuggestions(const json_read::Json& json, const std::string& file, Study* study) {
  using namespace json_read;
  if (auto* s = Find(json, "suggested_parameters")) {
    if (!s->is_object()) throw InputError(file, "suggested_parameters", "is not an object");
    auto& p = study->suggested;
    const std::pair<const char*, std::optional<double>*> numbers[] = {
        {"young_kPa", &p.young_kPa},
        {"poisson", &p.poisson},
        {"r_neighbour_mm", &p.neighbour_radius_mm},
        {"tau", &p.tau},
        {"r_cut_mm", &p.cut_radius_mm}};
    for (const auto& [key, value] : numbers)
      if (auto* v = Find(*s, key))
        *value = Number(*v, file, std::string("suggested_parameters.") + key);
    if (auto* v = Find(*s, "n")) p.outliers = Integer(*v, file, "suggested_parameters.n");
  }
  if (auto* v = Find(json, "extrusion_hint_ct")) {
    const Vec3 ras = Vector(*v, file, "extrusion_hint_ct");
    if (ras.norm() < 1e-9) throw InputError(file, "extrusion_hint_ct", "is a zero vector");
    study->extrusion_hint = FlipSpace(ras).normalized();
  }
}

void ReadStudyManifest(const std::string& file, Study* study) {
  using namespace json_read;
  const Json json = ReadObject(file);
  if (auto* v = Find(json, "format")) {
    const std::string format = Text(*v, file, "format");
    if (format == "kerf-case")
      throw InputError(file, "format", "this is a case folder (kerf-case), a study is expected");
    if (format != "kerf-study")
      throw InputError(file, "format", "is \"" + format + "\", expected \"kerf-study\"");
  }
  if (auto* v = Find(json, "video")) ReadVideo(*v, file, study);
  if (auto* v = Find(json, "eval_frames")) {
    if (!v->is_array()) throw InputError(file, "eval_frames", "is not a list");
    for (std::size_t i = 0; i < v->size(); ++i) {
      const std::string element = "eval_frames[" + std::to_string(i) + "]";
      study->eval_frames.push_back(Integer((*v)[i], file, element));
      if (study->eval_frames.back() < 0) throw InputError(file, element, "is negative");
    }
    std::sort(study->eval_frames.begin(), study->eval_frames.end());
    study->eval_frames.erase(std::unique(study->eval_frames.begin(), study->eval_frames.end()),
                             study->eval_frames.end());
  }
  if (auto* v = Find(json, "feature_count")) {
    study->feature_count = Integer(*v, file, "feature_count");
    if (study->feature_count <= 0) throw InputError(file, "feature_count", "must be positive");
  }
  ReadSuggestions(json, file, study);
}

}  // namespace

std::vector<int> Study::FramesToWrite(int frame_count) const {
  std::vector<int> frames;
  if (!eval_frames.empty()) {
    for (int f : eval_frames)
      if (f < frame_count) frames.push_back(f);
    return frames;
  }
  for (int f = 0; f < frame_count; f += 5) frames.push_back(f);
  if (frame_count > 0 && frames.back() != frame_count - 1) frames.push_back(frame_count - 1);
  return frames;
}

Study OpenStudy(const std::string& root) {
  if (!fs::is_directory(root)) throw InputError(root, "", "is no folder");
  Study study;
  study.root = root;
  fs::path clean = fs::absolute(root).lexically_normal();
  if (!clean.has_filename()) clean = clean.parent_path();
  study.name = clean.filename().string();
  const fs::path base(root);
  study.video = (base / "video.mp4").string();
  if (fs::exists(base / "case.json")) ReadStudyManifest((base / "case.json").string(), &study);
  // A pattern (f%05d.png) names many files: whoever opens it finds out whether they are there.
  if (study.video.find('%') == std::string::npos && !fs::exists(study.video)) study.video.clear();
  study.ct = FirstExisting(base, {"ct.nii.gz", "ct.nii", "ct.nrrd"});
  study.labels =
      FirstExisting(base, {"labels.nii.gz", "labels.nii", "labels.nrrd", "labels.seg.nrrd"});
  study.organ_surface = FirstExisting(
      base, {"organ_surface.stl", "organ_surface.vtp", "organ_surface.ply", "organ_surface.obj"});
  study.landmarks = FirstExisting(base, {"landmarks.csv"});
  study.features_rest = FirstExisting(base, {"features_rest.csv"});
  study.features_2d = FirstExisting(base, {"features_2d.csv"});
  study.camera = FirstExisting(base, {"camera.yml"});
  if (study.camera.empty())
    throw InputError((base / "camera.yml").string(), "", "is missing (calibration and pose)");
  if (study.ct.empty() && study.labels.empty() && study.organ_surface.empty())
    throw InputError(root, "", "holds neither ct.nii.gz nor labels.nii.gz nor organ_surface.stl");
  return study;
}

std::vector<RestFeature> ReadRestFeatures(const std::string& file) {
  const CsvTable table = CsvTable::Read(file);
  const int id = table.Column("id"), x = table.Column("x_mm"), y = table.Column("y_mm"),
            z = table.Column("z_mm"), u = table.Column("u_px"), v = table.Column("v_px");
  const int use = table.HasColumn("use") ? table.Column("use") : -1;
  std::vector<RestFeature> features;
  std::set<int> seen;
  for (std::size_t r = 0; r < table.Rows(); ++r) {
    RestFeature f;
    f.id = table.Integer(r, id);
    if (!seen.insert(f.id).second)
      throw InputError(file, table.Where(r, id), "id " + std::to_string(f.id) + " appears twice");
    f.use = use < 0 || table.Integer(r, use) != 0;
    f.rest = FlipSpace(Vec3(table.Number(r, x), table.Number(r, y), table.Number(r, z)));
    f.pixel = Vec2(table.Number(r, u), table.Number(r, v));
    features.push_back(f);
  }
  if (features.empty()) throw InputError(file, "", "holds no features");
  return features;
}

TrackTable ReadTracks(const std::string& tracks_file, const std::string& features_rest_file) {
  std::map<int, RestFeature> rest;
  for (const auto& f : ReadRestFeatures(features_rest_file)) rest[f.id] = f;

  const CsvTable table = CsvTable::Read(tracks_file);
  const int frame = table.Column("frame"), id = table.Column("id"), u = table.Column("u_px"),
            v = table.Column("v_px"), visible = table.Column("visible");
  TrackTable tracks;
  std::map<int, Index> column;
  for (std::size_t r = 0; r < table.Rows(); ++r) {
    const int i = table.Integer(r, id), f = table.Integer(r, frame);
    if (!rest.count(i))
      throw InputError(tracks_file, table.Where(r, id),
                       "unknown id " + std::to_string(i) + ": it is not in " + features_rest_file);
    if (f < 0) throw InputError(tracks_file, table.Where(r, frame), "is negative");
    if (f > 10000000) throw InputError(tracks_file, table.Where(r, frame), "is too large");
    column[i] = 0;
    tracks.frames = std::max(tracks.frames, f + 1);
  }
  if (column.empty()) throw InputError(tracks_file, "", "holds no tracks");
  const auto n = static_cast<Index>(column.size());
  tracks.rest.resize(n, 3);
  tracks.rest_pixels.resize(n, 2);
  for (auto& [i, k] : column) {
    k = static_cast<Index>(tracks.id.size());
    tracks.id.push_back(i);
    tracks.rest.row(k) = rest[i].rest.transpose();
    tracks.rest_pixels.row(k) = rest[i].pixel.transpose();
  }
  const std::size_t cells = std::size_t(tracks.frames) * n;
  if (cells > (std::size_t(1) << 28) / 4)
    throw InputError(tracks_file, "", "spans too many frames");
  tracks.pixels = Pixels::Zero(static_cast<Index>(cells), 2);
  tracks.visible.assign(cells, 0);
  std::vector<char> given(cells, 0);
  for (std::size_t r = 0; r < table.Rows(); ++r) {
    const int f = table.Integer(r, frame);
    const Index row = tracks.Row(f, column[table.Integer(r, id)]);
    if (given[row])
      throw InputError(tracks_file, table.Where(r, id),
                       "frame " + std::to_string(f) + " has this id twice");
    given[row] = 1;
    tracks.visible[row] = table.Integer(r, visible) != 0;
    // An invisible point may have no position.
    if (tracks.visible[row] || !table.Text(r, u).empty())
      tracks.pixels.row(row) << table.Number(r, u), table.Number(r, v);
  }
  // Where a frame has no row, the last known position stands, as with any tracker that lost a
  // point.
  for (Index k = 0; k < n; ++k) {
    Vec2 last = tracks.rest_pixels.row(k).transpose();
    for (int f = 0; f < tracks.frames; ++f) {
      const Index row = tracks.Row(f, k);
      if (given[row])
        last = tracks.pixels.row(row).transpose();
      else
        tracks.pixels.row(row) = last.transpose();
    }
  }
  return tracks;
}

std::vector<Landmark> ReadLandmarks(const std::string& file) {
  const CsvTable table = CsvTable::Read(file);
  const int id = table.Column("id"), x = table.Column("x_mm"), y = table.Column("y_mm"),
            z = table.Column("z_mm"), u = table.Column("u_px"), v = table.Column("v_px");
  std::vector<Landmark> landmarks;
  for (std::size_t r = 0; r < table.Rows(); ++r)
    landmarks.push_back(
        {table.Integer(r, id),
         FlipSpace(Vec3(table.Number(r, x), table.Number(r, y), table.Number(r, z))),
         Vec2(table.Number(r, u), table.Number(r, v))});
  if (landmarks.empty()) throw InputError(file, "", "holds no landmarks");
  return landmarks;
}

}  // namespace kerf
