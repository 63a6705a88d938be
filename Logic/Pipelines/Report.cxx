#include "Pipelines/Report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "Pipelines/ReportPage.h"

namespace kerf {
namespace {

double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(std::lround(q * double(values.size() - 1)))];
}

// What a frame costs while it is registered: decoding and drawing run apart.
double Pipeline_ms(const TimingRow& t) {
  return t.tracking_ms + t.targets_ms + t.detection_ms + t.cutting_ms + t.solve_ms +
         t.structures_ms;
}

double Length_mm(const Points& line) {
  double length = 0;
  for (Eigen::Index i = 0; i + 1 < line.rows(); ++i)
    length += (line.row(i + 1) - line.row(i)).norm();
  return length;
}

double TimeOfFrame(const ReportData& data, int frame) {
  for (const ReliabilityRow& r : data.reliability)
    if (r.frame == frame) return r.time_s;
  return std::numeric_limits<double>::quiet_NaN();
}

std::string TrustSentence(const ReportData& data) {
  std::map<std::string, int> states, reasons;
  for (const ReliabilityRow& r : data.reliability) {
    ++states[r.state];
    if (r.state != "green") ++reasons[r.reason];
  }
  const double n = double(data.reliability.size());
  std::string text = fmt::format("The overlay was trusted (green) in {:.0f} % of {} frames",
                                 100 * states["green"] / n, data.reliability.size());
  if (states["amber"] + states["off"] > 0)
    text += fmt::format(", amber in {:.0f} % and off in {:.0f} %", 100 * states["amber"] / n,
                        100 * states["off"] / n);
  const auto most =
      std::max_element(reasons.begin(), reasons.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most != reasons.end() && !most->first.empty()) text += "; most often because: " + most->first;
  return text + fmt::format(". At the end it was {}.", data.reliability.back().state);
}

std::string CutSentence(const ReportData& data) {
  if (!data.cutting) return "Cutting was switched off for this run.";
  if (data.cuts.empty()) return "No cut was found.";
  std::string text = data.cuts.size() == 1 ? "One cut was found:"
                                           : fmt::format("{} cuts were found:", data.cuts.size());
  for (std::size_t i = 0; i < data.cuts.size(); ++i) {
    const CutRecord& cut = data.cuts[i];
    const double time = TimeOfFrame(data, cut.detected_frame);
    text += i == 0 ? " " : "; ";
    text += std::isfinite(time) ? fmt::format("at {:.2f} s (frame {})", time, cut.detected_frame)
                                : fmt::format("in frame {}", cut.detected_frame);
    text += fmt::format(", {:.0f} mm long on the organ's surface", Length_mm(cut.polyline_rest));
  }
  return text + ". The model, with what is inside it, was cut accordingly.";
}

std::string AccuracySentence(const ReportData& data) {
  const auto& last = data.scores->final_values;
  std::string text;
  const auto say = [&](const char* name, const std::string& words) {
    const auto found = last.find(name);
    if (found == last.end()) return;
    text += (text.empty() ? "" : ", ") + fmt::format(fmt::runtime(words), found->second);
  };
  say("dice", "silhouette overlap (Dice) {:.3f}");
  say("organ_mean", "organ surface {:.1f} mm off on average");
  say("internal_mean", "inner structures {:.1f} mm");
  say("tumour_mean", "tumour {:.1f} mm");
  return text.empty() ? "" : "Against the known truth, in the last frame: " + text + ".";
}

std::string SpeedSentence(const ReportData& data) {
  std::vector<double> spent;
  for (const TimingRow& t : data.timing) spent.push_back(Pipeline_ms(t));
  return fmt::format(
      "A frame took {:.1f} ms in the median and {:.1f} ms at the 99th percentile, decoding and "
      "drawing apart.",
      Quantile(spent, 0.5), Quantile(spent, 0.99));
}

const ReportSnapshot* Hero(const ReportData& data) {
  if (data.snapshots.empty()) return nullptr;
  // The first picture well after the first cut shows most; without a cut, the last
  // one that was registered.
  if (!data.cuts.empty())
    for (const ReportSnapshot& s : data.snapshots)
      if (s.frame >= data.cuts.front().detected_frame + 20) return &s;
  for (auto s = data.snapshots.rbegin(); s != data.snapshots.rend(); ++s)
    if (s->frame >= 0) return &*s;
  return &data.snapshots.back();
}

std::string Caption(const ReportSnapshot& s) {
  return s.frame < 0 ? fmt::format("{:.2f} s, not registered", s.time_s)
                     : fmt::format("{:.2f} s, frame {}", s.time_s, s.frame);
}

Plot ReliabilityPlot(const ReportData& data) {
  Plot plot;
  plot.title = "Reliability";
  plot.x_label = "time, s";
  plot.y_label = "score";
  plot.y_max = 1.0;
  plot.series.resize(1);
  for (const ReliabilityRow& r : data.reliability) {
    plot.series[0].x.push_back(r.time_s);
    plot.series[0].y.push_back(r.score);
    const std::string color = r.state == "green"   ? "#3bb273"
                              : r.state == "amber" ? "#f0b429"
                                                   : "#d64545";
    if (plot.bands.empty() || plot.bands.back().color != color)
      plot.bands.push_back({plot.bands.empty() ? r.time_s : plot.bands.back().x1, r.time_s, color});
    plot.bands.back().x1 = r.time_s;
  }
  for (std::size_t i = 0; i < data.cuts.size(); ++i) {
    const double time = TimeOfFrame(data, data.cuts[i].detected_frame);
    if (std::isfinite(time)) plot.marks.push_back({time, fmt::format("cut {} found", i + 1)});
  }
  return plot;
}

Plot FitPlot(const ReportData& data) {
  Plot plot;
  plot.title = "Distance between model and image";
  plot.x_label = "time, s";
  plot.y_label = "mm";
  plot.series = {{"features, median", {}, {}, ""}, {"where it is largest", {}, {}, ""}};
  for (const ReportFit& fit : data.fit) {
    for (PlotSeries& series : plot.series) series.x.push_back(fit.time_s);
    plot.series[0].y.push_back(fit.residual_mm);
    plot.series[1].y.push_back(fit.local_misfit_mm);
  }
  return plot;
}

std::optional<Plot> TumourPlot(const ReportData& data) {
  Plot plot;
  plot.title = "Tumour position, 95 % bound";
  plot.x_label = "time, s";
  plot.y_label = "\u00b1 mm";
  plot.series.resize(1);
  for (const ReliabilityRow& r : data.reliability) {
    plot.series[0].x.push_back(r.time_s);
    plot.series[0].y.push_back(r.tumour_u95_mm);
  }
  const auto& y = plot.series[0].y;
  if (std::none_of(y.begin(), y.end(), [](double v) { return std::isfinite(v) && v > 0; }))
    return {};
  return plot;
}

Plot TimingPlot(const ReportData& data) {
  Plot plot;
  plot.title = "Time per frame";
  plot.x_label = "frame";
  plot.y_label = "ms";
  plot.stacked = true;
  const std::pair<const char*, double TimingRow::*> parts[] = {
      {"tracking", &TimingRow::tracking_ms},   {"targets", &TimingRow::targets_ms},
      {"detection", &TimingRow::detection_ms}, {"cutting", &TimingRow::cutting_ms},
      {"solve", &TimingRow::solve_ms},         {"structures", &TimingRow::structures_ms}};
  std::vector<double> totals;
  for (const auto& [label, part] : parts) {
    PlotSeries series{label, {}, {}, ""};
    for (const TimingRow& t : data.timing) {
      series.x.push_back(t.frame);
      series.y.push_back(t.*part);
    }
    plot.series.push_back(std::move(series));
  }
  for (const TimingRow& t : data.timing) totals.push_back(Pipeline_ms(t));
  // One slow first frame must not flatten all the others.
  const double top = std::max(1.3 * Quantile(totals, 0.98), 1e-3);
  if (*std::max_element(totals.begin(), totals.end()) > 2 * top)
    plot.y_max = NiceTicks(0, top, 5).back();
  return plot;
}

Plot ErrorPlot(const Scores& scores) {
  Plot plot;
  plot.title = "Distance from the truth";
  plot.x_label = "frame";
  plot.y_label = "mm, mean";
  const std::pair<const char*, const char*> curves[] = {{"organ_mean", "organ surface"},
                                                        {"internal_mean", "inner structures"},
                                                        {"tumour_mean", "tumour"},
                                                        {"feature_mean", "features"}};
  for (const auto& [name, label] : curves) {
    PlotSeries series{label, {}, {}, ""};
    bool any = false;
    for (const FrameScores& f : scores.frames) {
      const auto found = f.values.find(name);
      series.x.push_back(f.frame);
      series.y.push_back(found == f.values.end() ? std::numeric_limits<double>::quiet_NaN()
                                                 : found->second);
      any = any || found != f.values.end();
    }
    if (any) plot.series.push_back(std::move(series));
  }
  return plot;
}

void AddMesh(const ReportData& data, ReportPage* page) {
  std::vector<std::string> header{""};
  std::vector<std::vector<std::string>> rows{{"tetrahedra"},
                                             {"vertices"},
                                             {"volume, ml"},
                                             {"pieces"},
                                             {"smallest dihedral angle, \u00b0"},
                                             {"inverted"},
                                             {"boundary closed and 2-manifold"}};
  const auto add = [&](const char* name, const std::optional<MeshQuality>& q) {
    if (!q) return;
    header.push_back(name);
    const std::string cells[] = {std::to_string(q->tets),
                                 std::to_string(q->vertices),
                                 fmt::format("{:.1f}", q->volume_mm3 / 1000),
                                 std::to_string(q->components),
                                 fmt::format("{:.1f}", q->smallest_dihedral_deg),
                                 std::to_string(q->inverted),
                                 q->manifold_boundary ? "yes" : "no"};
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i].push_back(cells[i]);
  };
  add("as planned", data.planned_mesh);
  add("at the end", data.final_mesh);
  page->Heading("The model");
  page->Table(header, rows);
}

void AddCuts(const ReportData& data, ReportPage* page) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < data.cuts.size(); ++i) {
    const CutRecord& cut = data.cuts[i];
    const double time = TimeOfFrame(data, cut.detected_frame);
    rows.push_back({fmt::format("cut {}", i + 1), std::to_string(cut.detected_frame),
                    std::isfinite(time) ? fmt::format("{:.2f}", time) : "",
                    fmt::format("{:.0f}", Length_mm(cut.polyline_rest)),
                    fmt::format("{:.0f}", cut.depth_mm), fmt::format("{:.2f}", cut.confidence)});
  }
  page->Heading("Cuts");
  page->Table({"", "found in frame", "at, s", "length, mm", "depth, mm", "confidence"}, rows);
}

void AddScores(const Scores& scores, ReportPage* page) {
  page->Heading("Accuracy");
  page->Figure(ErrorPlot(scores));
  std::vector<std::vector<std::string>> rows;
  for (const std::string& name : MeasureNames()) {
    const auto last = scores.final_values.find(name);
    const auto over = scores.over_frames.find(name);
    if (last == scores.final_values.end() && over == scores.over_frames.end()) continue;
    rows.push_back(
        {name, last == scores.final_values.end() ? "" : fmt::format("{:.3f}", last->second),
         over == scores.over_frames.end() ? "" : fmt::format("{:.3f}", over->second.mean),
         over == scores.over_frames.end() ? "" : fmt::format("{:.3f}", over->second.worst)});
  }
  page->Table({"measure (mm; dice 0..1)", "last frame", "mean over frames", "worst"}, rows);
}

std::vector<std::vector<std::string>> Rows(
    const std::vector<std::pair<std::string, std::string>>& pairs) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, value] : pairs) rows.push_back({name, value});
  return rows;
}

}  // namespace

std::vector<std::string> KeySentences(const ReportData& data) {
  std::vector<std::string> sentences;
  if (!data.reliability.empty()) sentences.push_back(TrustSentence(data));
  sentences.push_back(CutSentence(data));
  std::string last = data.scores ? AccuracySentence(data) : "";
  if (last.empty() && !data.timing.empty()) last = SpeedSentence(data);
  if (!last.empty()) sentences.push_back(last);
  return sentences;
}

void WriteReport(const std::string& path, const ReportData& data) {
  ReportPage page("Kerf report: " + data.study,
                  "Registration of a planned model to recorded video, method " + data.method);
  const ReportSnapshot* hero = Hero(data);
  if (hero) page.Picture(hero->image, Caption(*hero));
  page.KeySentences(KeySentences(data));
  for (const std::string& warning : data.warnings) page.Warning(warning);

  std::vector<std::pair<Image, std::string>> others;
  for (const ReportSnapshot& s : data.snapshots)
    if (&s != hero) others.push_back({s.image, Caption(s)});
  if (!others.empty()) {
    page.Heading("Pictures");
    page.Pictures(others);
  }
  if (!data.reliability.empty()) {
    page.Heading("How far the overlay is to be trusted");
    page.Figure(ReliabilityPlot(data),
                "The strip below shows what the gate let through: green, amber (caution) or red "
                "(overlay off).");
    if (!data.fit.empty())
      page.Figure(FitPlot(data),
                  "Between tracked features and their places on the model, across the line of "
                  "sight: the median of all, and of the six neighbours that fit worst. What a "
                  "single camera does not see, the depth, is not in it.");
    if (const auto tumour = TumourPlot(data)) page.Figure(*tumour);
  }
  if (!data.cuts.empty()) AddCuts(data, &page);
  if (data.scores) AddScores(*data.scores, &page);
  if (!data.timing.empty()) {
    page.Heading("Time");
    page.Figure(TimingPlot(data), SpeedSentence(data));
  }
  if (data.planned_mesh || data.final_mesh) AddMesh(data, &page);
  if (!data.parameters.empty()) {
    page.FoldedHeading("Parameters");
    page.Table({}, Rows(data.parameters));
  }
  if (!data.versions.empty()) {
    page.FoldedHeading("Versions");
    page.Table({}, Rows(data.versions));
  }
  page.Write(path);
}

}  // namespace kerf
