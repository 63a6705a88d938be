// kerf-soak: the Intraoperative page in a window over a video that is played for ever. Says once in
// a while what it costs; ends with status 4 when memory or work grows or the overlay is off.
#include <sys/resource.h>
#include <unistd.h>

#include <QApplication>
#include <QTimer>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <vector>

#include "Adapters/Rendering/VirtualDisplay.h"
#include "Intraoperative/qKerfIntraoperativeWidget.h"
#include "PingPongSource.h"

namespace {

double ResidentMegabytes() {
  std::ifstream statm("/proc/self/statm");
  long total = 0, resident = 0;
  statm >> total >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1048576.0);
}

double ProcessorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_utime.tv_sec + usage.ru_stime.tv_sec +
         1e-6 * (usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

struct Row {
  double time_s, resident_mb, processors, registered, shown, latency_ms;
  int dropped, cuts;
  bool overlay;  ///< shown: the gate is not off, and nobody has to confirm
};

/// Largest growth after the first third, when caches and buffers are full.
double Growth_mb(const std::vector<Row>& rows) {
  if (rows.size() < 3) return 0.0;
  return rows.back().resident_mb - rows[rows.size() / 3].resident_mb;
}

/// Processors in the last third over those in the second.
double GrowthOfWork(const std::vector<Row>& rows) {
  const std::size_t third = rows.size() / 3;
  if (third < 10) return 1.0;  // too few to tell
  double second = 0.0, last = 0.0;
  for (std::size_t i = 0; i < third; ++i) {
    second += rows[third + i].processors;
    last += rows[rows.size() - third + i].processors;
  }
  return second > 0.0 ? last / second : 1.0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || std::string(argv[1]) == "--help") {
    std::printf(
        "kerf-soak CASE VIDEO [SECONDS] [INTERVAL] [MEGABYTES] [CAMERA] [RATE]\n"
        "  Runs the Intraoperative page over VIDEO, to and fro, for SECONDS (3600) and prints\n"
        "  every INTERVAL seconds (60) memory, processors, rates, latency, drops, cuts and\n"
        "  whether the overlay is shown.\n"
        "  Status 4: memory grew by more than MEGABYTES (64) after the first third, or (of 30\n"
        "  rows or more) the last third took a third more of the processors than the second, or\n"
        "  the overlay was off in all of the last third.\n"
        "  CAMERA: calibration with pose, where the case has none.\n"
        "  RATE: pictures a second; default: the video's own.\n"
        "Example: kerf-soak cases/kidney cases/kidney.mp4 3600 60\n");
    return argc < 3 ? 2 : 0;
  }
  const std::string case_folder = argv[1], video = argv[2];
  const double seconds = argc > 3 ? std::atof(argv[3]) : 3600,
               interval = argc > 4 ? std::atof(argv[4]) : 60;
  const double most_mb = argc > 5 ? std::atof(argv[5]) : 64;
  const double rate = argc > 7 ? std::atof(argv[7]) : 0;
  std::string why_not;
  if (!kerf::RenderingAvailable(&why_not)) {
    std::fprintf(stderr, "kerf-soak: nothing can be shown: %s\n", why_not.c_str());
    return 3;
  }
  qputenv("QT_QPA_PLATFORM", "xcb");
  QApplication app(argc, argv);
  int status = 0;
  qKerfIntraoperativeWidget::Services services;
  services.say_problem = [&](const QString& problem) {
    std::fprintf(stderr, "kerf-soak: %s\n", qPrintable(problem));
    status = 3;
    app.quit();
  };
  qKerfIntraoperativeWidget page(std::move(services));
  page.SetRecording(false);
  // Decoded once: what is measured is the session, not the decoder.
  kerf::CaptureOptions options;  // paced, newest frame only
  page.Desk().SetSourceOpener(
      [rate](const std::string& path) -> std::unique_ptr<kerf::FrameSource> {
        return std::make_unique<kerf::PingPongSource>(path, rate);
      },
      options);
  page.resize(1500, 800);
  page.show();
  page.OpenCase(QString::fromStdString(case_folder));
  if (argc > 6) page.UseCamera(argv[6]);
  page.OpenSource(QString::fromStdString(video));

  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  auto last = begin;
  double last_cpu = ProcessorSeconds();
  std::vector<Row> rows;
  QTimer start;
  QObject::connect(&start, &QTimer::timeout, [&] {
    if (page.CurrentStep() == qKerfIntraoperativeWidget::CheckIn && page.Desk().Newest() &&
        page.Desk().MayRegister(page.Desk().Pseudonym()))
      page.StartWithGivenPose();
  });
  start.start(100);
  QTimer report;
  std::printf(
      "time_s,resident_mb,processors,registered_fps,shown_fps,latency_ms,dropped,cuts,overlay\n");
  QObject::connect(&report, &QTimer::timeout, [&] {
    const auto now = Clock::now();
    const double passed = std::chrono::duration<double>(now - last).count();
    const double cpu = ProcessorSeconds();
    const auto latest = page.Desk().Current();  // registered too late is not shown
    const Row row{std::chrono::duration<double>(now - begin).count(),
                  ResidentMegabytes(),
                  (cpu - last_cpu) / passed,
                  latest ? latest->registered_fps : 0.0,
                  page.ShownPerSecond(),
                  page.Latency_ms(),
                  latest ? latest->source.dropped : 0,
                  latest ? static_cast<int>(latest->cuts.size()) : 0,
                  latest && latest->gate != kerf::GateState::Off && !latest->needs_confirmation};
    rows.push_back(row);
    last = now;
    last_cpu = cpu;
    std::printf("%.0f,%.1f,%.2f,%.0f,%.0f,%.0f,%d,%d,%s\n", row.time_s, row.resident_mb,
                row.processors, row.registered, row.shown, row.latency_ms, row.dropped, row.cuts,
                row.overlay ? "shown" : "off");
    std::fflush(stdout);
    if (row.time_s < seconds) return;
    const bool overlay = std::any_of(rows.end() - std::max<std::size_t>(1, rows.size() / 3),
                                     rows.end(), [](const Row& r) { return r.overlay; });
    if (!latest)
      status = 3;
    else if (Growth_mb(rows) > most_mb || GrowthOfWork(rows) > 4.0 / 3.0 || !overlay)
      status = 4;
    app.quit();
  });
  report.start(std::max(1, int(interval * 1000)));
  app.exec();
  std::printf(
      "growth after the first third: %.1f MB; processors in the last third: %.2f times those in "
      "the second\n",
      Growth_mb(rows), GrowthOfWork(rows));
  return status;
}
