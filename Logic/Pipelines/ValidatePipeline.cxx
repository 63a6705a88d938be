#include "Pipelines/ValidatePipeline.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "Adapters/Itk/VolumeFiles.h"
#include "Adapters/OpenCv/VideoSource.h"
#include "Adapters/Rendering/VirtualDisplay.h"
#include "CaseIO/AtomicFile.h"
#include "CaseIO/StudyFolder.h"
#include "Core/Errors.h"
#include "Pipelines/EvaluatePipeline.h"
#include "Pipelines/ReportPage.h"
#include "Pipelines/SideBySide.h"
#include "Pipelines/ValidationPictures.h"
#include "Pipelines/ValidationTables.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

std::vector<Study> OpenStudies(const ValidateRequest& request) {
  if (request.studies.empty()) throw UsageError("validate: name at least one study");
  if (request.variants.empty()) throw UsageError("validate: no variant is left");
  std::vector<Study> studies;
  std::set<std::string> names;
  for (const auto& folder : request.studies) {
    studies.push_back(OpenStudy(folder));
    if (!names.insert(studies.back().name).second)
      throw UsageError("validate: two studies are called " + studies.back().name);
    const fs::path truth = fs::path(folder) / "truth";
    if (!fs::is_directory(truth))
      throw InputError(truth.string(), "", "is missing: the study has no truth to judge against");
  }
  return studies;
}

ReplayRequest RequestOf(const ValidateRequest& all, const Study& study,
                        const ValidationVariant& variant, const std::string& results,
                        const std::string& planned) {
  ReplayRequest request;
  request.study = study.root;
  request.results = results;
  request.threads = all.threads;
  request.drawing = all.drawing;
  request.outline = all.outline;
  request.method = variant.method == Method::Reference ? ReferenceOptions() : MethodOptions();
  request.method.cutting = variant.cutting;
  if (!all.grips) request.method.grips = false;
  if (variant.perfect_tracks) request.tracks = study.features_2d;
  if (!planned.empty())
    request.case_folder = planned;
  else if (all.tetrahedra)
    request.tetrahedra = all.tetrahedra;
  return request;
}

void RunOne(const ReplayRequest& request, ValidationRun* run, Progress& progress) {
  try {
    if (request.tracks && request.tracks->empty())
      throw InputError(request.study, "features_2d.csv", "is missing, perfect tracks were wanted");
    SubProgress replaying(progress, 0.0, 0.9), judging(progress, 0.9, 1.0);
    run->replay = Replay(request, replaying);
    if (run->replay.broken) progress.Warn(*run->replay.broken);
    run->scores = EvaluateAgainstTruth(run->results, request.study, judging);
    WriteMetricsFile((fs::path(run->results) / "metrics.json").string(), &run->scores, nullptr);
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    run->error = e.what();
    progress.Warn(run->variant.Name() + " failed: " + run->error);
  }
}

/// What is better with cutting, in one sentence per method and input.
std::vector<std::string> KeySentences(const std::vector<ValidationRun>& runs) {
  int failed = 0, found = 0, true_cuts = 0, false_cuts = 0, judged = 0;
  for (const auto& run : runs) {
    if (!run.error.empty())
      ++failed;
    else if (run.variant.cutting) {
      ++judged;
      true_cuts += run.scores.cuts.truth;
      found += static_cast<int>(run.scores.cuts.matched.size());
      false_cuts += run.scores.cuts.false_cuts;
    }
  }
  std::vector<std::string> sentences;
  if (judged > 0)
    sentences.push_back(std::to_string(found) + " of " + std::to_string(true_cuts) +
                        " cuts found, " + std::to_string(false_cuts) + " false, in " +
                        std::to_string(judged) + " runs with cutting.");
  if (failed > 0) sentences.push_back(std::to_string(failed) + " runs failed.");
  return sentences;
}

/// Mean feature error over time, one curve per variant.
Plot ErrorPlot(const std::vector<ValidationRun>& runs, const std::string& study,
               const std::string& measure, const std::string& title) {
  Plot plot;
  plot.title = study + ": " + title;
  plot.x_label = "frame";
  plot.y_label = "mm";
  for (const auto& run : runs) {
    if (run.study != study || !run.error.empty()) continue;
    PlotSeries series;
    series.label = run.variant.Name();
    for (const auto& frame : run.scores.frames) {
      const auto it = frame.values.find(measure);
      series.x.push_back(frame.frame);
      series.y.push_back(it == frame.values.end() ? std::numeric_limits<double>::quiet_NaN()
                                                  : it->second);
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

/// A run and what the pages show of it.
struct Shown {
  ValidationRun run;
  std::vector<std::pair<Image, std::string>> pictures;
};

/// Pictures are no reason to lose a run that is scored.
void Draw(const std::string& study, Shown* shown, Progress& progress) {
  try {
    shown->pictures = PicturesOf(shown->run, study);
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {
    progress.Warn(shown->run.variant.Name() + ": no pictures: " + e.what());
  }
}

void WritePages(const ValidateRequest& request, int jobs, const std::vector<Study>& studies,
                const std::vector<std::optional<Shown>>& all) {
  const std::string& output = request.output;
  std::vector<ValidationRun> runs;
  for (const auto& shown : all)
    if (shown) runs.push_back(shown->run);
  const auto in = [&](const char* name) { return (fs::path(output) / name).string(); };
  std::vector<ValidationTable> tables = DiceTables(runs);
  for (auto& table : DistanceTables(runs)) tables.push_back(std::move(table));
  tables.push_back(CutTable(runs));

  ReportPage page("Kerf: validation", std::to_string(studies.size()) + " studies, " +
                                          std::to_string(runs.size()) + " runs");
  page.KeySentences(KeySentences(runs));
  for (const auto& run : runs)
    if (!run.error.empty()) page.Warning(run.study + ", " + run.variant.Name() + ": " + run.error);
  page.Paragraph(
      "Paper: Paulus et al. 2016, Tables 1 and 2. Its objects are real tissue and silicone, these "
      "studies are simulations with exact truth: the columns stand side by side as an "
      "orientation.");
  std::string markdown;
  for (const auto& table : tables) {
    page.Heading(table.title);
    page.Table(table.header, table.rows);
    markdown += Markdown(table);
  }
  if (jobs > 1)
    page.Paragraph("Times a frame: " + std::to_string(jobs) +
                   " studies ran beside each other, alone they take less (--jobs 1).");
  if (!request.grips || !request.outline)
    page.Paragraph(std::string("For comparison:") + (request.grips ? "" : " without grips") +
                   (request.outline ? "" : " initial poses as they are given"));
  // With all of them at the end only: encoding takes its time.
  if (runs.size() == all.size()) {
    page.Heading("The last frames");
    for (const auto& shown : all)
      if (!shown->pictures.empty()) page.Pictures(shown->pictures);
  }
  page.Heading("Errors over time");
  for (const auto& study : studies) {
    page.Figure(ErrorPlot(runs, study.name, "feature_mean", "mean feature error"));
    page.Figure(ErrorPlot(runs, study.name, "organ_mean", "mean distance of the organ surface"));
  }
  page.Write(in("validation.html"));
  AtomicFile text(in("validation.md"));
  text.Stream() << markdown;
  text.Commit();

  auto json = nlohmann::ordered_json::array();
  for (const auto& run : runs) {
    nlohmann::ordered_json entry = {{"study", run.study},
                                    {"variant", run.variant.Name()},
                                    {"results", fs::relative(run.results, output).string()}};
    if (run.error.empty()) {
      entry["median_ms"] = run.replay.median_ms;
      entry["p99_ms"] = run.replay.p99_ms;
      entry["gate"] = ToString(run.replay.final_gate);
      entry["metrics"] = nlohmann::ordered_json::parse(MetricsText(&run.scores, nullptr));
    } else {
      entry["error"] = run.error;
    }
    json.push_back(std::move(entry));
  }
  AtomicFile file(in("validation.json"));
  file.Stream() << nlohmann::ordered_json({{"jobs", jobs},
                                           {"grips", request.grips},
                                           {"outline", request.outline},
                                           {"runs", json}})
                       .dump(1)
                << '\n';
  file.Commit();
}

}  // namespace

std::string ValidationVariant::Name() const {
  return std::string(method == Method::Kerf ? "kerf" : "reference") +
         (perfect_tracks ? "-tracks" : "-video") + (cutting ? "-cut" : "-nocut");
}

std::vector<ValidationRun> Validate(const ValidateRequest& request, Progress& progress) {
  const std::vector<Study> studies = OpenStudies(request);
  const int count = static_cast<int>(studies.size()),
            variants = static_cast<int>(request.variants.size());
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const int jobs = std::min(count, request.jobs > 0 ? request.jobs : cores);
  // What sets the environment or makes singletons comes before there are threads.
  if (request.drawing != ReplayRequest::Drawing::None) RenderingAvailable();
  SilenceFfmpeg();
  InitializeItk();
  std::vector<std::optional<Shown>> all(std::size_t(count) * variants);
  std::mutex pages;
  const auto study_job = [&](int s, Progress& share) {
    const Study& study = studies[s];
    std::string planned;  // the first run plans, the others use its case
    for (int v = 0; v < variants; ++v) {
      share.ThrowIfCancelled();
      Shown shown;
      ValidationRun& run = shown.run;
      run.study = study.name;
      run.variant = request.variants[v];
      run.results = (fs::path(request.output) / study.name / run.variant.Name()).string();
      SubProgress part(share, double(v) / variants, double(v + 1) / variants, study.name + ", ");
      RunOne(RequestOf(request, study, run.variant, run.results, planned), &run, part);
      const std::string own_case = (fs::path(run.results) / "case").string();
      if (planned.empty() && fs::exists(fs::path(own_case) / "case.json")) planned = own_case;
      if (request.drawing != ReplayRequest::Drawing::None) Draw(study.root, &shown, part);
      run.replay.report.reset();  // its pictures are in its own report.html
      const std::lock_guard lock(pages);
      all[std::size_t(s) * variants + v] = std::move(shown);
      WritePages(request, jobs, studies, all);
    }
  };
  RunSideBySide(count, jobs, study_job, progress);
  std::vector<ValidationRun> runs;
  for (auto& shown : all) runs.push_back(std::move(shown->run));
  return runs;
}

}  // namespace kerf
