// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>

#include "tests/bench/measures.hpp"

namespace srd::bench {

namespace {

double cpu_seconds() {
  timespec t{};
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

std::string machine() {
  std::ifstream info("/proc/cpuinfo");
  std::string line, model = "unknown processor";
  int cores = 0;
  while (std::getline(info, line)) {
    if (line.starts_with("processor")) ++cores;
    if (line.starts_with("model name")) model = line.substr(line.find(':') + 2);
  }
  return model + ", " + std::to_string(cores) + " cores";
}

}  // namespace

int print_table(const std::vector<Measure>& measures, int rounds) {
  constexpr double kMinSeconds = 2e-3;  // a turn, long against the clock's own reading
  std::map<std::string, std::vector<double>> seconds;
  std::map<std::string, int> repetitions;
  for (int round = -1; round < rounds; ++round)
    for (const Measure& measure : measures) {
      int& n = repetitions[measure.name];
      if (round < 0) {  // warms up, and finds out how often to repeat
        const double begin = cpu_seconds();
        measure.run();
        const double took = cpu_seconds() - begin;
        n = std::max(1, static_cast<int>(kMinSeconds / std::max(took, 1e-9)));
        continue;
      }
      if (measure.slow && round >= 3) continue;
      const double begin = cpu_seconds();
      for (int i = 0; i < n; ++i) measure.run();
      seconds[measure.name].push_back((cpu_seconds() - begin) / n);
    }

  std::printf("%s; one thread; medians of %d interleaved rounds, CPU time\n\n", machine().c_str(), rounds);
  std::printf("| measure | us |\n|---|---|\n");
  std::map<std::string, double> medians;
  for (const Measure& measure : measures) {
    medians[measure.name] = median(seconds[measure.name]);
    std::printf("| %s | %.1f |\n", measure.name.c_str(), 1e6 * medians[measure.name]);
  }
  std::printf("\n| bar | ours, us | baseline, us | times faster | bar | met |\n|---|---|---|---|---|---|\n");
  for (const Bar& bar : bars()) {
    if (!medians.contains(bar.ours) || !medians.contains(bar.baseline)) continue;
    const double ours = medians[bar.ours], baseline = medians[bar.baseline];
    std::printf("| %s | %.1f | %.1f (%s) | %.1f | %.0f | %s |\n", bar.what.c_str(), 1e6 * ours, 1e6 * baseline,
                bar.baseline.c_str(), baseline / ours, bar.factor, baseline / ours >= bar.factor ? "yes" : "no");
  }
  return 0;
}

}  // namespace srd::bench
