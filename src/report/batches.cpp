/// The speed-up of batches: by SIMD lanes over one run after the other, and by all cores over one. Prints CSV
/// without a header: task, links, way, seconds per run, how many times faster than the way before.
///
///     batches [RUNS [PAIRS]]
///
/// Both ways take turns on the same runs: rods of 1 m and 1 kg under gravity, from random starts, for 20 s at
/// the default tolerance, one state at the end. Lanes: medians over the pairs, of CPU times and of their
/// ratios. Cores: the shortest wall times, as other programs take cores away, and their ratio.

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "lanes/kernel.h"
#include "planar_chain/batch.h"
#include "report/median.h"

using namespace planar_chain;

namespace {

Scene rods(int n) {
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 1; i <= n; ++i) {
    links.push_back({"rod_" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
    joints.push_back({"joint_" + std::to_string(i)});
  }
  const std::vector<double> zero(index(n), 0.0);
  return {Chain(links, joints, {0, -9.81}), zero, zero, {}, {}, {}, 0};
}

std::vector<double> starts(int n, std::size_t runs) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> number(-2, 2);
  std::vector<double> all(runs * 2 * index(n));
  for (double& value : all) value = number(engine);
  return all;
}

double cpuTime() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}
double wallTime() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Times of two ways, s, and their ratio: medians of CPU times; the shortest wall times.
struct Pair {
  double first, second, ratio;
};
Pair byTurns(int pairs, double (*clock)(), const Scene& scene, const std::vector<double>& from,
             const BatchOptions& first, const BatchOptions& second) {
  const auto timeOf = [&](const BatchOptions& options) {
    const double start = clock();
    const BatchResult result = simulateMany(scene, from, {20}, options);
    for (const BatchRun& run : result.runs) {
      if (run.outcome != RunOutcome::done) std::fprintf(stderr, "%s\n", run.reason.c_str());
    }
    return clock() - start;
  };
  std::vector<double> firsts, seconds, ratios;
  for (int k = 0; k < pairs; ++k) {
    firsts.push_back(timeOf(first));
    seconds.push_back(timeOf(second));
    ratios.push_back(firsts.back() / seconds.back());
  }
  if (clock == cpuTime) return {median(firsts), median(seconds), median(ratios)};
  const double least = *std::min_element(firsts.begin(), firsts.end());
  const double other = *std::min_element(seconds.begin(), seconds.end());
  return {least, other, least / other};
}

void print(int n, std::size_t runs, const std::array<std::string, 2>& ways, const Pair& pair) {
  const auto row = [&](const std::string& way, double seconds) {
    std::printf("\"20 s, %zu runs\",%d,\"%s\",%.3e", runs, n, way.c_str(),
                seconds / static_cast<double>(runs));
  };
  row(ways[0], pair.first);
  std::printf(",,\n");
  row(ways[1], pair.second);
  std::printf(",%.2f,\n", pair.ratio);
}

}  // namespace

int main(int count, char** arguments) {
  // The numbers of the arguments, or 0.
  const auto number = [&](int k, long absent) {
    char* end = nullptr;
    const long given = count > k ? std::strtol(arguments[k], &end, 10) : absent;
    return static_cast<int>((end && *end != '\0') || given > 1000000 ? 0 : given);
  };
  const int runs = number(1, 32), pairs = number(2, 11);
  if (runs < 1 || pairs < 1 || count > 3) {
    std::fprintf(stderr, "batches [RUNS [PAIRS]]: expected whole numbers from 1 to 1000000\n");
    return 2;
  }
  const auto many = static_cast<std::size_t>(runs);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // line by line
  BatchOptions alone, inLanes;
  alone.threads = inLanes.threads = 1;
  alone.lanes = 1;

  for (const simd::Kernel* kernel : simd::kernels()) {
    inLanes.lanes = kernel->lanes;
    for (const int n : {1, 2, 3, 6, 12}) {
      const Pair pair = byTurns(pairs, cpuTime, rods(n), starts(n, many), alone, inLanes);
      print(n, many, {"one after the other", "in lanes, " + std::string(kernel->name)}, pair);
    }
  }
  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  for (const int n : {2, 12, 20}) {
    const std::size_t more = many * (n == 2 ? 64 : 2);
    BatchOptions one, all;
    one.threads = 1;
    print(n, more, {"one core", "all " + std::to_string(cores) + " cores"},
          byTurns(pairs, wallTime, rods(n), starts(n, more), one, all));
  }
  return 0;
}
