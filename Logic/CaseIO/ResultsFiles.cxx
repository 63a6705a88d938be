#include "CaseIO/ResultsFiles.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "CaseIO/JsonRead.h"
#include "CaseIO/Space.h"
#include "Core/Errors.h"

namespace kerf {
namespace {

const std::vector<std::string> kTimingColumns = {
    "frame",      "capture_ms", "tracking_ms",   "targets_ms", "detection_ms",
    "cutting_ms", "solve_ms",   "structures_ms", "render_ms",  "total_ms"};
constexpr double TimingRow::*kTimingFields[] = {
    &TimingRow::capture_ms,    &TimingRow::tracking_ms, &TimingRow::targets_ms,
    &TimingRow::detection_ms,  &TimingRow::cutting_ms,  &TimingRow::solve_ms,
    &TimingRow::structures_ms, &TimingRow::render_ms,   &TimingRow::total_ms};

/// Micrometres: below every accuracy here, and short to read.
double Rounded(double mm) { return std::round(mm * 1e4) / 1e4; }

}  // namespace

std::string FrameFileName(int frame, const std::string& what, const std::string& extension) {
  char number[32];
  std::snprintf(number, sizeof number, "frame_%05d_", frame);
  return number + what + "." + extension;
}

FeaturesFile::FeaturesFile(const std::string& path)
    : csv_(path, {"frame", "id", "x_mm", "y_mm", "z_mm", "x0_mm", "y0_mm", "z0_mm", "state"}) {}

void FeaturesFile::Add(int frame, const FeatureSet& features, const Points& current,
                       const Points& rest) {
  for (Index i = 0; i < features.Size(); ++i) {
    csv_ << frame << features.id[i];
    for (int k = 0; k < 3; ++k) csv_.Fixed(current(i, k), 4);
    for (int k = 0; k < 3; ++k) csv_.Fixed(rest(i, k), 4);
    csv_ << ToString(features.status[i]);
  }
}

void WriteCutsFile(const std::string& path, const std::vector<CutRecord>& cuts) {
  nlohmann::ordered_json json;
  json["space"] = "LPS";
  json["cuts"] = nlohmann::ordered_json::array();
  for (const auto& cut : cuts) {
    nlohmann::ordered_json entry;
    entry["detected_frame"] = cut.detected_frame;
    entry["polyline_rest"] = nlohmann::ordered_json::array();
    for (Index i = 0; i < cut.polyline_rest.rows(); ++i)
      entry["polyline_rest"].push_back({Rounded(cut.polyline_rest(i, 0)),
                                        Rounded(cut.polyline_rest(i, 1)),
                                        Rounded(cut.polyline_rest(i, 2))});
    entry["depth_mm"] = Rounded(cut.depth_mm);
    entry["confidence"] = Rounded(cut.confidence);
    json["cuts"].push_back(std::move(entry));
  }
  AtomicFile file(path);
  file.Stream() << json.dump(1) << '\n';
  file.Commit();
}

std::vector<CutRecord> ReadCutsFile(const std::string& path, Space* space_out) {
  using namespace json_read;
  const Json json = ReadObject(path);
  const Json* space_tag = Find(json, "space");
  const Space space = ParseSpace(space_tag ? Text(*space_tag, path, "space") : "", path, "space");
  if (space_out) *space_out = space;
  std::vector<CutRecord> cuts;
  const Json* list = Find(json, "cuts");
  if (!list || !list->is_array()) throw InputError(path, "cuts", "is missing or not a list");
  for (std::size_t c = 0; c < list->size(); ++c) {
    const std::string element = "cuts[" + std::to_string(c) + "]";
    const Json& entry = (*list)[c];
    if (!entry.is_object()) throw InputError(path, element, "is not an object");
    CutRecord cut;
    cut.detected_frame = kNoFrame;
    if (auto* v = Find(entry, "detected_frame"))
      cut.detected_frame = Integer(*v, path, element + ".detected_frame");
    if (auto* v = Find(entry, "depth_mm")) cut.depth_mm = Number(*v, path, element + ".depth_mm");
    if (auto* v = Find(entry, "confidence"))
      cut.confidence = Number(*v, path, element + ".confidence");
    if (auto* line = Find(entry, "polyline_rest")) {
      if (!line->is_array()) throw InputError(path, element + ".polyline_rest", "is not a list");
      cut.polyline_rest.resize(static_cast<Index>(line->size()), 3);
      for (std::size_t i = 0; i < line->size(); ++i) {
        const Vec3 p =
            Vector((*line)[i], path, element + ".polyline_rest[" + std::to_string(i) + "]");
        cut.polyline_rest.row(i) = (space == Space::RAS ? FlipSpace(p) : p).transpose();
      }
    }
    cuts.push_back(std::move(cut));
  }
  return cuts;
}

void WriteReliabilityFile(const std::string& path, const std::vector<ReliabilityRow>& rows) {
  CsvWriter csv(path, {"frame", "time_s", "state", "score", "reason", "tumour_u95_mm"});
  for (const auto& r : rows) {
    csv << r.frame;
    csv.Fixed(r.time_s, 4) << r.state;
    csv.Fixed(r.score, 4) << r.reason;
    csv.Fixed(r.tumour_u95_mm, 3);
  }
  csv.Finish();
}

std::vector<ReliabilityRow> ReadReliabilityFile(const std::string& path) {
  const CsvTable t = CsvTable::Read(path);
  const int frame = t.Column("frame"), time = t.Column("time_s"), state = t.Column("state"),
            score = t.Column("score"), reason = t.Column("reason"), u95 = t.Column("tumour_u95_mm");
  std::vector<ReliabilityRow> rows;
  for (std::size_t r = 0; r < t.Rows(); ++r)
    rows.push_back(
        {t.Integer(r, frame), t.Number(r, time), t.Text(r, state), t.Number(r, score),
         t.Text(r, reason),
         t.Text(r, u95).empty() ? std::numeric_limits<double>::quiet_NaN() : t.Number(r, u95)});
  return rows;
}

void WriteTimingFile(const std::string& path, const std::vector<TimingRow>& rows) {
  CsvWriter csv(path, kTimingColumns);
  for (const auto& r : rows) {
    csv << r.frame;
    for (auto field : kTimingFields) csv.Fixed(r.*field, 4);
  }
  csv.Finish();
}

std::vector<TimingRow> ReadTimingFile(const std::string& path) {
  const CsvTable t = CsvTable::Read(path);
  std::vector<int> columns;
  for (const auto& name : kTimingColumns) columns.push_back(t.Column(name));
  std::vector<TimingRow> rows;
  for (std::size_t r = 0; r < t.Rows(); ++r) {
    TimingRow row;
    row.frame = t.Integer(r, columns[0]);
    for (std::size_t k = 0; k < std::size(kTimingFields); ++k)
      row.*kTimingFields[k] = t.Number(r, columns[k + 1]);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace kerf
