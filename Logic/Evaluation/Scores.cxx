#include "Evaluation/Scores.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "Core/Errors.h"

namespace kerf {
namespace {

bool LargerIsBetter(const std::string& measure) { return measure == "dice"; }

std::string Text(double value) {
  std::ostringstream out;
  out.precision(4);
  out << value;
  return out.str();
}

std::optional<double> Value(const Scores& scores, const std::string& measure) {
  if (measure == "missed") return scores.cuts.missed;
  if (measure == "false") return scores.cuts.false_cuts;
  const auto it = scores.final_values.find(measure);
  if (it == scores.final_values.end()) return std::nullopt;
  return it->second;
}

}  // namespace

const std::vector<std::string>& MeasureNames() {
  static const std::vector<std::string> names = {
      "dice",      "lateral_mean",  "lateral_max",  "feature_mean", "feature_max", "organ_mean",
      "organ_max", "internal_mean", "internal_max", "tumour_mean",  "tumour_max"};
  return names;
}

void Summarize(Scores* scores) {
  scores->final_values.clear();
  scores->over_frames.clear();
  if (scores->frames.empty()) return;
  scores->final_values = scores->frames.back().values;
  for (const auto& name : MeasureNames()) {
    MeasureSummary summary;
    int count = 0;
    for (const auto& frame : scores->frames) {
      const auto it = frame.values.find(name);
      if (it == frame.values.end()) continue;
      const double v = it->second;
      summary.worst = count == 0             ? v
                      : LargerIsBetter(name) ? std::min(summary.worst, v)
                                             : std::max(summary.worst, v);
      summary.mean += v;
      ++count;
    }
    if (count == 0) continue;
    summary.mean /= count;
    scores->over_frames[name] = summary;
  }
}

std::vector<Requirement> ParseRequirements(const std::string& text) {
  std::vector<Requirement> out;
  std::istringstream parts(text);
  std::string part;
  while (std::getline(parts, part, ',')) {
    const auto equals = part.find('=');
    Requirement r;
    r.measure = part.substr(0, equals);
    const auto& names = MeasureNames();
    const bool known = std::find(names.begin(), names.end(), r.measure) != names.end() ||
                       r.measure == "missed" || r.measure == "false";
    if (!known || equals == std::string::npos) {
      std::string all;
      for (const auto& name : names) all += name + ", ";
      throw UsageError("--require: \"" + part + "\" is not MEASURE=NUMBER with a measure of " +
                       all + "missed, false");
    }
    const std::string number = part.substr(equals + 1);
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), r.limit);
    if (error != std::errc() || end != number.data() + number.size() || !std::isfinite(r.limit))
      throw UsageError("--require: \"" + number + "\" in \"" + part + "\" is not a number");
    out.push_back(r);
  }
  if (out.empty()) throw UsageError("--require: names no measure");
  return out;
}

std::vector<std::string> UnmetRequirements(const Scores& scores,
                                           const std::vector<Requirement>& requirements) {
  std::vector<std::string> unmet;
  for (const auto& r : requirements) {
    const auto value = Value(scores, r.measure);
    if (!value) {
      unmet.push_back(r.measure + " could not be measured");
    } else if (LargerIsBetter(r.measure) ? *value < r.limit : *value > r.limit) {
      unmet.push_back(r.measure + " is " + Text(*value) + ", required: " +
                      (LargerIsBetter(r.measure) ? "at least " : "at most ") + Text(r.limit));
    }
  }
  return unmet;
}

}  // namespace kerf
