#include "Pipelines/ValidationTables.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

namespace kerf {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Tables 1 and 2 of Paulus et al. 2016, by the study that stands for the experiment: without and
/// with cutting.
struct PaperDice {
  double without, with;
};
struct PaperDistance {
  double mean_without, mean_with, max_without, max_with;
};
const std::map<std::string, PaperDice> kPaperDice = {{"silicone-left", {0.815, 0.952}},
                                                     {"silicone-middle", {0.900, 0.964}},
                                                     {"liver-1", {0.906, 0.963}}};
const std::map<std::pair<std::string, std::string>, PaperDistance> kPaperDistance = {
    {{"kidney-1", "feature"}, {1.69, 0.52, 11.2, 5.4}},
    {{"kidney-1", "organ"}, {1.76, 1.49, 13.1, 10.1}},
    {{"kidney-1", "internal"}, {1.10, 0.82, 8.9, 7.6}},
    {{"kidney-2", "feature"}, {2.45, 1.28, 12.9, 5.6}},
    {{"kidney-2", "organ"}, {1.96, 1.22, 13.1, 6.9}},
    {{"kidney-2", "internal"}, {1.69, 1.04, 7.4, 4.6}}};

std::string Number(const char* format, double value) {
  if (std::isnan(value)) return "–";
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string GroupName(const ValidationVariant& v) {
  return std::string(v.method == Method::Kerf ? "Kerf" : "Reference method") +
         (v.perfect_tracks ? ", perfect tracks" : ", from video");
}

/// The runs of one study in one group: without and with cutting; null where there is none.
struct Pair {
  std::string study;
  const ValidationRun* without = nullptr;
  const ValidationRun* with = nullptr;
  double Value(const ValidationRun* run, const std::string& measure) const {
    if (!run || !run->error.empty()) return kNone;
    const auto it = run->scores.final_values.find(measure);
    return it == run->scores.final_values.end() ? kNone : it->second;
  }
};

struct Group {
  std::string name;
  std::vector<Pair> pairs;
};

/// Groups and studies in the order in which they were run.
std::vector<Group> Grouped(const std::vector<ValidationRun>& runs) {
  std::vector<Group> groups;
  for (const auto& run : runs) {
    const std::string name = GroupName(run.variant);
    Group* group = nullptr;
    for (auto& g : groups)
      if (g.name == name) group = &g;
    if (!group) group = &groups.emplace_back(Group{name, {}});
    Pair* pair = nullptr;
    for (auto& p : group->pairs)
      if (p.study == run.study) pair = &p;
    if (!pair) pair = &group->pairs.emplace_back(Pair{run.study, nullptr, nullptr});
    (run.variant.cutting ? pair->with : pair->without) = &run;
  }
  return groups;
}

}  // namespace

std::vector<ValidationTable> DiceTables(const std::vector<ValidationRun>& runs) {
  std::vector<ValidationTable> tables;
  for (const auto& group : Grouped(runs)) {
    ValidationTable table;
    table.title = "Dice of silhouettes at the last frame: " + group.name;
    table.header = {"study", "without cutting", "with cutting", "paper, without", "paper, with"};
    for (const auto& pair : group.pairs) {
      const auto paper = kPaperDice.find(pair.study);
      const bool known = paper != kPaperDice.end();
      table.rows.push_back({pair.study, Number("%.3f", pair.Value(pair.without, "dice")),
                            Number("%.3f", pair.Value(pair.with, "dice")),
                            Number("%.3f", known ? paper->second.without : kNone),
                            Number("%.3f", known ? paper->second.with : kNone)});
    }
    tables.push_back(std::move(table));
  }
  return tables;
}

std::vector<ValidationTable> DistanceTables(const std::vector<ValidationRun>& runs) {
  const std::pair<const char*, const char*> entities[] = {{"feature", "features"},
                                                          {"lateral", "features, across the sight"},
                                                          {"organ", "organ surface"},
                                                          {"internal", "inner structure"},
                                                          {"tumour", "tumour"}};
  std::vector<ValidationTable> tables;
  for (const auto& group : Grouped(runs)) {
    ValidationTable table;
    table.title = "Distances at the last frame, mm: " + group.name;
    table.header = {"study",          "entity",           "average, without",
                    "average, with",  "largest, without", "largest, with",
                    "paper, average", "paper, largest"};
    for (const auto& pair : group.pairs)
      for (const auto& [measure, entity] : entities) {
        const std::string mean = std::string(measure) + "_mean",
                          max = std::string(measure) + "_max";
        const double mean_without = pair.Value(pair.without, mean),
                     mean_with = pair.Value(pair.with, mean);
        if (std::isnan(mean_without) && std::isnan(mean_with)) continue;
        const auto paper = kPaperDistance.find({pair.study, measure});
        std::string paper_mean = "–", paper_max = "–";
        if (paper != kPaperDistance.end()) {
          const auto& p = paper->second;
          paper_mean = Number("%.2f", p.mean_without) + " → " + Number("%.2f", p.mean_with);
          paper_max = Number("%.1f", p.max_without) + " → " + Number("%.1f", p.max_with);
        }
        table.rows.push_back({pair.study, entity, Number("%.2f", mean_without),
                              Number("%.2f", mean_with),
                              Number("%.1f", pair.Value(pair.without, max)),
                              Number("%.1f", pair.Value(pair.with, max)), paper_mean, paper_max});
      }
    tables.push_back(std::move(table));
  }
  return tables;
}

ValidationTable CutTable(const std::vector<ValidationRun>& runs) {
  ValidationTable table;
  table.title = "Cuts, trust and speed";
  table.header = {"study",    "variant",         "cuts",       "found",
                  "missed",   "false",           "delay, s",   "after 1 mm open, s",
                  "line, mm", "gate at the end", "ms a frame", "99 %, ms"};
  for (const auto& run : runs) {
    std::vector<std::string> row = {run.study, run.variant.Name()};
    if (!run.error.empty()) {
      row.resize(table.header.size(), "–");
      row[2] = "failed";
      table.rows.push_back(std::move(row));
      continue;
    }
    const auto& cuts = run.scores.cuts;
    double delay = kNone, opening = kNone, line = kNone;
    if (!cuts.matched.empty()) {
      const auto& m = cuts.matched.front();
      delay = m.timing_error_s.value_or(kNone);
      opening = m.delay_after_1mm_opening_s.value_or(kNone);
      line = m.location.mean_mm;
    }
    // Where nothing was to be found, nothing was missed.
    const auto count = [&](int n) {
      return run.variant.cutting ? std::to_string(n) : std::string("–");
    };
    for (const std::string& cell :
         {std::to_string(cuts.truth), count(static_cast<int>(cuts.matched.size())),
          count(cuts.missed), count(cuts.false_cuts), Number("%+.2f", delay),
          Number("%+.2f", opening), Number("%.2f", line),
          std::string(ToString(run.replay.final_gate)), Number("%.1f", run.replay.median_ms),
          Number("%.1f", run.replay.p99_ms)})
      row.push_back(cell);
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::string Markdown(const ValidationTable& table) {
  std::string text = "### " + table.title + "\n\n|";
  for (const auto& cell : table.header) text += " " + cell + " |";
  text += "\n|";
  for (std::size_t i = 0; i < table.header.size(); ++i) text += i == 0 ? "---|" : "---:|";
  text += "\n";
  for (const auto& row : table.rows) {
    text += "|";
    for (const auto& cell : row) text += " " + cell + " |";
    text += "\n";
  }
  return text + "\n";
}

}  // namespace kerf
