#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "CaseIO/AtomicFile.h"
#include "Core/Errors.h"
#include "Pipelines/EvaluatePipeline.h"

namespace kerf {
namespace {

using Json = nlohmann::ordered_json;

Json CutsJson(const CutComparison& cuts) {
  Json json;
  json["true"] = cuts.truth;
  json["detected"] = cuts.detected;
  json["matched"] = Json::array();
  for (const auto& m : cuts.matched) {
    Json match;
    match["cut"] = m.truth;
    match["location"] = {{"mean", m.location.mean_mm},
                         {"hausdorff", m.location.hausdorff_mm},
                         {"detected_to_true_max", m.location.detected_to_true_max_mm},
                         {"true_to_detected_max", m.location.true_to_detected_max_mm},
                         {"detected_to_true_median", m.location.detected_to_true_median_mm}};
    match["true_start_s"] = m.true_start_s;
    if (m.timing_error_s) match["timing_error_s"] = *m.timing_error_s;
    if (m.delay_after_1mm_opening_s)
      match["delay_after_1mm_opening_s"] = *m.delay_after_1mm_opening_s;
    json["matched"].push_back(std::move(match));
  }
  json["missed"] = cuts.missed;
  json["false"] = cuts.false_cuts;
  return json;
}

Json ScoresJson(const Scores& scores) {
  Json json;
  json["case"] = scores.study;
  json["units"] = {{"length", "mm"}, {"time", "s"}};
  json["final"] = Json::object();
  json["over_frames"] = Json::object();
  for (const auto& name : MeasureNames()) {
    if (const auto it = scores.final_values.find(name); it != scores.final_values.end())
      json["final"][name] = it->second;
    if (const auto it = scores.over_frames.find(name); it != scores.over_frames.end())
      json["over_frames"][name] = {{"mean", it->second.mean}, {"worst", it->second.worst}};
  }
  json["cuts"] = CutsJson(scores.cuts);
  json["frames"] = Json::array();
  for (const auto& frame : scores.frames) {
    Json row;
    row["frame"] = frame.frame;
    for (const auto& name : MeasureNames())
      if (const auto it = frame.values.find(name); it != frame.values.end()) row[name] = it->second;
    if (frame.feature_count > 0) row["feature_count"] = frame.feature_count;
    json["frames"].push_back(std::move(row));
  }
  return json;
}

std::string Cell(const char* format, double value) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

std::string Padded(std::string text, std::size_t width) {
  if (text.size() < width) text.insert(0, width - text.size(), ' ');
  return text;
}

}  // namespace

std::string MetricsText(const Scores* scores, const ReferenceScores* reference) {
  Json json = scores ? ScoresJson(*scores) : Json::object();
  json["notice"] = "Research use, not a medical device.";
  if (reference) {
    Json part = Json::object();
    for (const auto& [name, d] : reference->distance) {
      part[name]["mean"] = d.mean_mm;
      part[name]["max"] = d.max_mm;
    }
    for (const auto& [name, dice] : reference->volume_dice) part[name]["volume_dice"] = dice;
    json["reference"] = std::move(part);
  }
  return json.dump(1) + "\n";
}

void WriteMetricsFile(const std::string& path, const Scores* scores,
                      const ReferenceScores* reference) {
  AtomicFile file(path);
  file.Stream() << MetricsText(scores, reference);
  file.Commit();
}

std::string ScoresTable(const Scores& scores) {
  struct Line {
    const char *title, *mean, *max;
  };
  constexpr Line kLines[] = {{"Dice of silhouettes", "dice", nullptr},
                             {"feature error, mm", "feature_mean", "feature_max"},
                             {"  across the line of sight, mm", "lateral_mean", "lateral_max"},
                             {"organ surface, two-sided Hausdorff, mm", "organ_mean", "organ_max"},
                             {"inner structure, Hausdorff, mm", "internal_mean", "internal_max"},
                             {"tumour, Hausdorff, mm", "tumour_mean", "tumour_max"}};
  auto value = [](const std::map<std::string, double>& values, const char* name) {
    const auto it = name ? values.find(name) : values.end();
    if (it == values.end()) return Padded(name ? "-" : "", 9);
    return Padded(Cell(std::string(name) == "dice" ? "%.4f" : "%.2f", it->second), 9);
  };
  std::string text = scores.study + "\n" + std::string(40, ' ') + "   last frame" +
                     "        all frames\n" + std::string(40, ' ') +
                     "     mean      max      mean    worst\n";
  for (const auto& line : kLines) {
    std::map<std::string, double> means, worst;
    for (const auto& [name, summary] : scores.over_frames) {
      means[name] = summary.mean;
      worst[name] = summary.worst;
    }
    if (!scores.over_frames.count(line.mean)) continue;
    std::string title = line.title;
    title.resize(40, ' ');
    text += title + value(scores.final_values, line.mean) + value(scores.final_values, line.max) +
            " " + value(means, line.mean) + value(worst, line.max ? line.max : line.mean) + "\n";
  }
  text += "cuts: " + std::to_string(scores.cuts.truth) + " true, " +
          std::to_string(scores.cuts.detected) + " found, " + std::to_string(scores.cuts.missed) +
          " missed, " + std::to_string(scores.cuts.false_cuts) + " false\n";
  for (const auto& m : scores.cuts.matched) {
    text += "  cut " + std::to_string(m.truth) + ": ";
    if (m.timing_error_s) text += "found " + Cell("%+.2f s", *m.timing_error_s) + " after it began";
    if (m.delay_after_1mm_opening_s)
      text += Cell(" (%+.2f s after it was open by 1 mm)", *m.delay_after_1mm_opening_s);
    text += ", line off by " + Cell("%.2f mm", m.location.mean_mm) + " on average, " +
            Cell("%.2f mm", m.location.hausdorff_mm) + " at most\n";
  }
  return text;
}

std::string ReferenceTable(const ReferenceScores& scores) {
  std::string text = "against the second CT         mean       max  Dice of volumes\n";
  for (const auto& [name, distance] : scores.distance) {
    std::string title = name + ", mm";
    title.resize(24, ' ');
    const auto dice = scores.volume_dice.find(name);
    text += title + Padded(Cell("%.2f", distance.mean_mm), 10) +
            Padded(Cell("%.2f", distance.max_mm), 10) +
            Padded(dice == scores.volume_dice.end() ? "-" : Cell("%.4f", dice->second), 17) + "\n";
  }
  return text;
}

Scores ReadMetricsFile(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw InputError(path, "", "cannot be opened");
  const auto json = Json::parse(in, nullptr, false);
  if (!json.is_object() || !json.contains("frames") || !json["frames"].is_array())
    throw InputError(path, "frames", "is missing: this is no metrics.json");
  Scores scores;
  scores.study = json.value("case", "");
  for (const auto& row : json["frames"]) {
    FrameScores frame;
    frame.frame = row.value("frame", 0);
    frame.feature_count = row.value("feature_count", 0);
    for (const auto& name : MeasureNames())
      if (row.contains(name) && row[name].is_number()) frame.values[name] = row[name];
    scores.frames.push_back(std::move(frame));
  }
  Summarize(&scores);
  if (json.contains("cuts") && json["cuts"].is_object()) {
    const auto& cuts = json["cuts"];
    scores.cuts.truth = cuts.value("true", 0);
    scores.cuts.detected = cuts.value("detected", 0);
    scores.cuts.missed = cuts.value("missed", 0);
    scores.cuts.false_cuts = cuts.value("false", 0);
    for (const auto& m : cuts.value("matched", Json::array())) {
      CutMatch match;
      match.truth = m.value("cut", 0);
      match.true_start_s = m.value("true_start_s", 0.0);
      if (m.contains("timing_error_s")) match.timing_error_s = m["timing_error_s"].get<double>();
      if (m.contains("delay_after_1mm_opening_s"))
        match.delay_after_1mm_opening_s = m["delay_after_1mm_opening_s"].get<double>();
      const auto location = m.value("location", Json::object());
      match.location.mean_mm = location.value("mean", 0.0);
      match.location.hausdorff_mm = location.value("hausdorff", 0.0);
      match.location.detected_to_true_max_mm = location.value("detected_to_true_max", 0.0);
      match.location.true_to_detected_max_mm = location.value("true_to_detected_max", 0.0);
      match.location.detected_to_true_median_mm = location.value("detected_to_true_median", 0.0);
      scores.cuts.matched.push_back(match);
    }
  }
  return scores;
}

}  // namespace kerf
