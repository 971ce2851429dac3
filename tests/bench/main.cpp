// SPDX-License-Identifier: Apache-2.0
// srd_bench: speed of the instrument against its baselines. All of Google Benchmark's options (--benchmark_out=FILE
// --benchmark_out_format=json ..), or --table [ROUNDS] for medians of interleaved rounds and the bars.
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <cstring>
#include <opencv2/core.hpp>

#include "tests/bench/measures.hpp"

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const bool table = argc > 1 && std::strcmp(argv[1], "--table") == 0;
  if (!table) {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  }
  const auto measures = srd::bench::make_measures();
  if (table) return srd::bench::print_table(measures, argc > 2 ? std::max(1, std::atoi(argv[2])) : 15);
  for (const auto& measure : measures)
    benchmark::RegisterBenchmark(measure.name.c_str(), [&measure](benchmark::State& state) {
      for (auto _ : state) measure.run();
    })->Unit(benchmark::kMicrosecond);
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
