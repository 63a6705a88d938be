#include "Pipelines/DemoPipeline.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "Core/Errors.h"
#include "Pipelines/EvaluatePipeline.h"
#include "Pipelines/PhantomPipeline.h"
#include "Pipelines/PlanPipeline.h"
#include "Pipelines/Report.h"

namespace fs = std::filesystem;

namespace kerf {
namespace {

/// An older demo may be replaced, nothing else.
void RequireDemoFolder(const fs::path& output) {
  std::error_code error;
  if (!fs::exists(output, error)) return;
  if (!fs::is_directory(output, error))
    throw InputError(output.string(), "", "is a file, not a folder");
  if (fs::is_empty(output, error)) return;
  std::ifstream file(output / "study" / "case.json");
  const auto json = nlohmann::json::parse(file, nullptr, false);
  if (!json.is_object() || !json.contains("synthetic"))
    throw UsageError(output.string() +
                     ": is not empty and not an older demo; choose another --output");
}

}  // namespace

DemoResult RunDemo(const std::string& output, Progress& progress) {
  const fs::path root(output);
  RequireDemoFolder(root);
  DemoResult demo;
  demo.study = (root / "study").string();
  demo.case_folder = (root / "case").string();
  demo.results = (root / "results").string();

  {
    SubProgress part(progress, 0.0, 0.2);
    PhantomRequest request;
    request.output = demo.study;
    MakePhantom(request, part);
  }
  {
    SubProgress part(progress, 0.2, 0.35);
    PlanRequest request;
    request.input = (root / "study" / "ct.nii.gz").string();
    request.preset = "kidney";
    request.camera_file = (root / "study" / "camera.yml").string();
    request.landmarks_file = (root / "study" / "landmarks.csv").string();
    const PlannedCase planned = Plan(request, part);
    WriteCase(planned, demo.case_folder, {{"input", "phantom kidney-cut"}});
    demo.tetrahedra = planned.mesh.TetCount();
  }
  {
    SubProgress part(progress, 0.35, 0.9);
    std::error_code error;
    fs::remove_all(demo.results, error);
    ReplayRequest request;
    request.study = demo.study;
    request.results = demo.results;
    request.case_folder = demo.case_folder;
    demo.replay = Replay(request, part);
  }
  {
    SubProgress part(progress, 0.9, 1.0);
    demo.scores = EvaluateAgainstTruth(demo.results, demo.study, part);
    WriteMetricsFile((root / "results" / "metrics.json").string(), &demo.scores, nullptr);
    ReportData& report = *demo.replay.report;
    report.study = "a synthetic kidney with a tumour";
    report.scores = demo.scores;
    WriteReport((root / "results" / "report.html").string(), report);
  }
  const fs::path overlay = root / "results" / "overlay.mp4";
  if (fs::exists(overlay)) demo.overlay = overlay.string();
  demo.report = (root / "results" / "report.html").string();
  return demo;
}

}  // namespace kerf
