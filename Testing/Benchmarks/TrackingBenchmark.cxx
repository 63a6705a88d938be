/// Tracking at 960×540: a textured picture that stretches by 20 %, turns by 6° and moves by 60 px
/// over 30 frames, under noise. `Tracking/<features>`: one frame of the default tracker, all checks
/// on (goal: ≤ 10 ms median at 500).
#include <benchmark/benchmark.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "Adapters/OpenCv/LucasKanadeTracker.h"
#include "Benchmarks/Percentiles.h"

namespace kerf::testing {
namespace {

constexpr int kWidth = 960, kHeight = 540, kFrames = 31;

cv::Matx23d MotionOf(int index) {
  const double s = static_cast<double>(index) / (kFrames - 1), angle = 6 * s * CV_PI / 180;
  const cv::Matx22d m =
      cv::Matx22d(std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle)) *
      cv::Matx22d(1 + 0.2 * s, 0, 0, 1 - 0.08 * s);
  const cv::Vec2d center(kWidth / 2.0, kHeight / 2.0);
  const cv::Vec2d t = center - m * center + cv::Vec2d(50 * s, 33 * s);
  return {m(0, 0), m(0, 1), t[0], m(1, 0), m(1, 1), t[1]};
}

struct Footage {
  std::vector<Frame> frames;
  Image mask{kWidth, kHeight, 1, {}};
};

const Footage& GetFootage() {
  static const Footage footage = [] {
    cv::RNG random(1);
    cv::Mat sum(kHeight, kWidth, CV_32F, cv::Scalar(0));
    for (const int size : {2, 4, 9}) {
      cv::Mat noise(kHeight, kWidth, CV_32F);
      random.fill(noise, cv::RNG::NORMAL, 0, 1);
      cv::GaussianBlur(noise, noise, {0, 0}, size);
      cv::Scalar mean, deviation;
      cv::meanStdDev(noise, mean, deviation);
      sum += noise / deviation[0];
    }
    cv::Mat red, other, picture;
    sum.convertTo(red, CV_8U, 22, 150);
    sum.convertTo(other, CV_8U, 16, 70);
    cv::merge(std::vector<cv::Mat>{other, other, red}, picture);
    Footage made;
    for (int i = 0; i < kFrames; ++i) {
      Image image{kWidth, kHeight, 3, {}};
      image.data.resize(3U * kWidth * kHeight);
      cv::Mat frame(kHeight, kWidth, CV_8UC3, image.data.data()), noise(kHeight, kWidth, CV_8UC3);
      cv::warpAffine(picture, frame, MotionOf(i), frame.size(), cv::INTER_CUBIC,
                     cv::BORDER_REFLECT);
      random.fill(noise, cv::RNG::NORMAL, 6, 2);
      frame += noise;
      made.frames.push_back({i, i / 25.0, std::make_shared<const Image>(std::move(image))});
    }
    // An organ that fills about a third of the image, as in the studies.
    made.mask.data.assign(static_cast<std::size_t>(kWidth) * kHeight, 0);
    cv::Mat mask(kHeight, kWidth, CV_8U, made.mask.data.data());
    cv::ellipse(mask, {kWidth / 2, kHeight / 2}, {300, 150}, 0, 0, 360, cv::Scalar(255),
                cv::FILLED);
    return made;
  }();
  return footage;
}

void BM_Tracking(benchmark::State& state) {
  const Footage& footage = GetFootage();
  const auto tracker = MakeFeatureTracker();
  std::vector<double> wall_ms, cpu_ms, errors_px;
  Index tracked = 0, followed = 0;
  for (auto _ : state) {
    state.PauseTiming();
    FeatureSet features =
        tracker->Detect(footage.frames[0], footage.mask, static_cast<int>(state.range(0)));
    const Pixels start = features.pixels;
    state.ResumeTiming();
    for (int i = 1; i < kFrames; ++i) {
      const Stopwatch watch;
      tracker->Track(footage.frames[i], &features);
      wall_ms.push_back(watch.Wall_ms());
      cpu_ms.push_back(watch.Cpu_ms());
    }
    state.PauseTiming();
    const cv::Matx23d m = MotionOf(kFrames - 1);
    for (Index k = 0; k < features.Size(); ++k) {
      ++followed;
      if (features.status[k] != FeatureStatus::Tracked) continue;
      ++tracked;
      const cv::Vec2d truth = m * cv::Vec3d(start(k, 0), start(k, 1), 1);
      errors_px.push_back(
          std::hypot(features.pixels(k, 0) - truth[0], features.pixels(k, 1) - truth[1]));
    }
    state.ResumeTiming();
  }
  ReportPercentiles(state, wall_ms, cpu_ms);
  state.counters["features"] =
      static_cast<double>(followed) / static_cast<double>(state.iterations());
  state.counters["tracked"] =
      static_cast<double>(tracked) / static_cast<double>(std::max<Index>(1, followed));
  state.counters["median_error_px"] = Percentile(errors_px, 0.5);
  state.counters["max_error_px"] = Percentile(errors_px, 1.0);
}
BENCHMARK(BM_Tracking)
    ->Name("Tracking")
    ->Arg(225)
    ->Arg(500)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kerf::testing
