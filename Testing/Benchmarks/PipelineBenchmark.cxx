/// `Pipeline/<study>`: a whole replay from video without drawing, planning included in the clock of
/// the benchmark but not in the counters, which are of the frames (goal: 10 ms median, 20 ms at 99
/// % with 15,000 tetrahedra). The synthetic patient, and every study of KERF_CASES (where it is not
/// set: beside the checkout).
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "Core/Errors.h"
#include "Pipelines/PhantomPipeline.h"
#include "Pipelines/ReplayPipeline.h"
#include "Support/CasesFolder.h"

namespace kerf::testing {
namespace {

namespace fs = std::filesystem;

/// A folder that goes with the program.
class Scratch {
 public:
  Scratch() : path_(fs::temp_directory_path() / ("kerf-benchmarks-" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
};

const Scratch& GetScratch() {
  static const Scratch scratch;
  return scratch;
}

void Pipeline(benchmark::State& state, const std::string& study) {
  Progress progress;
  ReplayResult result;
  try {
    std::string folder = study;
    if (folder.empty()) {
      folder = (GetScratch() / "phantom").string();
      MakePhantom({PhantomScenario::KidneyCut, folder}, progress);
    }
    for (auto _ : state) {
      ReplayRequest request;
      request.study = folder;
      request.results = (GetScratch() / "results").string();
      request.drawing = ReplayRequest::Drawing::None;
      result = Replay(request, progress);
    }
  } catch (const std::exception& error) {
    state.SkipWithError(error.what());
    return;
  }
  state.counters["p50_ms"] = result.median_ms;
  state.counters["p99_ms"] = result.p99_ms;
  state.counters["cuts"] = result.cuts;
}

const int kRegistered = [] {
  const auto add = [](const std::string& name, const std::string& folder) {
    benchmark::RegisterBenchmark(("Pipeline/" + name).c_str(), Pipeline, folder)
        ->Unit(benchmark::kMillisecond)
        ->Iterations(1);
  };
  add("phantom", "");
  std::vector<fs::path> studies;
  std::error_code error;  // without studies the phantom remains
  for (fs::directory_iterator at(CasesFolder(), error), end; !error && at != end;
       at.increment(error))
    if (std::error_code absent; fs::exists(at->path() / "camera.yml", absent))
      studies.push_back(at->path());
  std::sort(studies.begin(), studies.end());
  for (const fs::path& study : studies) add(study.filename().string(), study.string());
  return 0;
}();

}  // namespace
}  // namespace kerf::testing
