/// Read bandwidth of one thread: what the bytes of a solver pass are held against
/// (docs/performance.md).
#include <benchmark/benchmark.h>

#include <cstdint>
#include <string>
#include <vector>

namespace kerf::testing {
namespace {

void RunStream(benchmark::State& state, std::size_t megabytes) {
  std::vector<std::uint64_t> data(megabytes * 1024 * 1024 / sizeof(std::uint64_t), 1);
  for (auto _ : state) {
    std::uint64_t sum[4] = {};
    for (std::size_t i = 0; i + 4 <= data.size(); i += 4)
      for (std::size_t k = 0; k < 4; ++k) sum[k] += data[i + k];
    benchmark::DoNotOptimize(sum);
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations() * megabytes * 1024 * 1024));
}

const int kRegistered = [] {
  for (std::size_t megabytes : {1, 4, 16, 128})
    benchmark::RegisterBenchmark(("Machine/read/" + std::to_string(megabytes) + "MB").c_str(),
                                 RunStream, megabytes);
  return 0;
}();

}  // namespace
}  // namespace kerf::testing
