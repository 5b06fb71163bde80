#include "report/contest.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>

#include "planar_chain/scene_reader.h"
#include "report/families.h"
#include "report/timing.h"
#include "tools/common.h"

namespace planar_chain::tools {

namespace {

constexpr double lost = 1;        // rad: the run has nothing to do with the motion any more
constexpr double isShort = 0.03;  // s: such runs are made in turns, and thrice to time their steps
constexpr int longChain = 1000;   // links
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  return cells;
}

/// The lines of a table after its header, cut at commas, with at least so many cells.
std::vector<std::vector<std::string>> tableOf(const std::string& path, std::size_t cells) {
  std::istringstream file(loadText(path));
  std::string line;
  std::getline(file, line);
  std::vector<std::vector<std::string>> rows;
  while (std::getline(file, line)) {
    rows.push_back(cellsOf(line));
    if (rows.back().size() < cells) throw std::runtime_error(path + ": too few columns in \"" + line + "\"");
  }
  return rows;
}

bool isLongChain(const Contest& contest) {
  return contest.scene.chain.size() >= longChain;
}

/// Loosest first.
std::vector<double> settingsFor(const Contestant& contestant, const Contest& contest, bool quick) {
  if (!contestant.hasFixedStep) {
    if (quick) return {1e-3, 1e-6, 1e-9};
    return {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13};
  }
  // 1, 0.3, 0.1, 0.03 … s, as far as the number of steps allows.
  const double mostLinkSteps = (quick ? 3e5 : 1e7) * (isLongChain(contest) ? 3 : 1);
  const double smallest = contest.end * contest.scene.chain.size() / mostLinkSteps;
  std::vector<double> steps;
  for (int k = 0; k < 40; ++k) {
    const double h = (k % 2 == 0 ? 1 : 0.3) * std::pow(10.0, -(k / 2));
    if (h <= contest.end / 10 && h >= smallest) steps.push_back(h);
  }
  if (!quick) return steps;
  std::vector<double> some;  // three, a decade apart
  for (std::size_t k = 0; k < 3 && 2 * k < steps.size(); ++k) {
    some.insert(some.begin(), steps[steps.size() - 1 - 2 * k]);
  }
  return some;
}

// ---- One run ---------------------------------------------------------------------------------

struct Ride {
  Progress progress = Progress::underway;  ///< of a run that took longer than the limit, too
  double seconds = 0;
  std::unique_ptr<Run> run;
};

Ride ride(const Contest& contest, const Contestant& contestant, double setting, double limit) {
  const int stepsPerLook = std::max(1, 2000 / contest.scene.chain.size());
  Ride result;
  result.run = contestant.make(contest, setting);
  while (result.progress == Progress::underway && result.seconds <= limit) {
    result.seconds += secondsOf([&] {
      for (int k = 0; k < stepsPerLook && result.progress == Progress::underway; ++k) {
        result.progress = result.run->step();
      }
    });
  }
  return result;
}

/// Makes least[k] the least time of step k.
void timeSteps(const Contest& contest, const Contestant& contestant, double setting,
               std::vector<double>& least) {
  const auto run = contestant.make(contest, setting);
  Progress progress = Progress::underway;
  for (std::size_t k = 0; progress == Progress::underway; ++k) {
    const double seconds = secondsOf([&] { progress = run->step(); });
    if (k == least.size()) least.push_back(seconds);
    least[k] = std::min(least[k], seconds);
  }
}

/// What reading the clock takes.
double clockSeconds() {
  static const double seconds = [] {
    std::vector<double> times(999);
    for (double& time : times) time = secondsOf([] {});
    return median(times);
  }();
  return seconds;
}

double largestError(const std::vector<double>& values, const std::vector<int>& index,
                    const Eigen::VectorXd& reference) {
  double largest = 0;
  for (std::size_t k = 0; k < index.size(); ++k) {
    const double error =
        std::abs(values[static_cast<std::size_t>(index[k])] - reference[static_cast<Eigen::Index>(k)]);
    if (!std::isfinite(error)) return nan;  // which std::max would drop
    largest = std::max(largest, error);
  }
  return largest;
}

// ---- A point ---------------------------------------------------------------------------------

struct Effort {
  double budget;  ///< s a setting
  int fewest;     ///< runs
  int turns;
  double isLong;  ///< s a run
  double limit;   ///< s a run: longer ones are given up
};

Effort effortFor(const Contest& contest, bool quick) {
  const double longer = isLongChain(contest) ? 4 : 1;
  return quick ? Effort{0.03, 3, 1, 0.02, 0.1 * longer} : Effort{0.1, 10, 3, 0.25, 0.5 * longer};
}

struct Result {
  const char* outcome = "ok";                 ///< or "diverged", "refused", "timed out"
  double thetaError = nan, omegaError = nan;  ///< largest of a link
  double median = 0, least = 0;               ///< s, of the runs
  double worstStep = nan;  ///< s: of each step the least over up to three runs, of these the largest
  int runs = 1;
  int turns = 1;  ///< in which the point is to be measured, this one among them
  Counts counts;
};

Result measure(const Contest& contest, const Contestant& contestant, double setting, const Effort& effort) {
  Result result;
  const Ride first = ride(contest, contestant, setting, effort.limit);
  result.counts = first.run->counts();
  result.median = result.least = first.seconds;
  if (first.progress != Progress::arrived) {
    result.outcome = first.progress == Progress::underway  ? "timed out"
                     : first.progress == Progress::refused ? "refused"
                                                           : "diverged";
    return result;
  }

  const auto n = static_cast<std::size_t>(contest.scene.chain.size());
  std::vector<double> theta(n), omega(n);
  first.run->read(theta.data(), omega.data());
  result.thetaError = largestError(theta, contest.index, contest.theta);
  result.omegaError = largestError(omega, contest.index, contest.omega);
  if (!(result.thetaError <= lost) || !std::isfinite(result.omegaError)) {
    result.outcome = "diverged";
    return result;
  }

  if (first.seconds < isShort) result.turns = effort.turns;
  const double wanted = std::clamp(effort.budget / first.seconds, 1.0 * effort.fewest, 21.0);
  result.runs = first.seconds > effort.isLong ? 2 : static_cast<int>(std::ceil(wanted / result.turns));
  std::vector<double> times, steps;
  for (int k = 0; k < result.runs; ++k) {
    times.push_back(ride(contest, contestant, setting, effort.limit).seconds);
  }
  result.median = median(times);
  result.least = *std::min_element(times.begin(), times.end());
  for (int k = 0; k < (first.seconds < isShort ? 3 : 1); ++k) {
    timeSteps(contest, contestant, setting, steps);
  }
  result.worstStep = std::max(0.0, *std::max_element(steps.begin(), steps.end()) - clockSeconds());
  return result;
}

}  // namespace

// ---- Contests --------------------------------------------------------------------------------

std::vector<std::string> contestNames(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& row : tableOf(folder + "/report/scenes.csv", 4)) names.push_back(row[0]);
  return names;
}

Contest readContest(const std::string& folder, const std::string& name) {
  for (const auto& row : tableOf(folder + "/report/scenes.csv", 4)) {
    if (row[0] != name) continue;
    const bool ships = row[1].rfind("config/", 0) == 0;
    const std::string path = folder + (ships ? "/config/scenes/" + row[1].substr(7) : "/" + row[1]);
    Contest contest{name, readSceneText(loadText(path)), std::strtod(row[3].c_str(), nullptr), {}, {}, {}};
    const auto ends = tableOf(folder + "/report/" + name + ".csv", 3);
    const auto half = static_cast<Eigen::Index>(ends.size() / 2);
    contest.theta.resize(half);
    contest.omega.resize(half);
    for (std::size_t k = 0; k < ends.size(); ++k) {
      const auto at = static_cast<Eigen::Index>(k);
      const double value = std::strtod(ends[k][2].c_str(), nullptr);
      if (at < half) contest.index.push_back(std::atoi(ends[k][1].c_str()));
      (at < half ? contest.theta[at] : contest.omega[at - half]) = value;
    }
    return contest;
  }
  throw std::runtime_error("the report has no scene \"" + name + "\"");
}

// ---- The protocol ----------------------------------------------------------------------------

void listPoints(const std::string& folder, const std::vector<Contestant>& contestants, bool quick) {
  for (const std::string& name : contestNames(folder)) {
    const Contest contest = readContest(folder, name);
    for (const Contestant& each : contestants) {
      if (!each.takes(contest.scene)) continue;
      for (const double setting : settingsFor(each, contest, quick)) {
        std::printf("%s,%s,%s,%g\n", name.c_str(), each.engine.c_str(), each.method.c_str(), setting);
      }
    }
  }
}

void racePoints(const std::string& folder, const std::vector<Contestant>& contestants, bool quick) {
  std::map<std::string, Contest> contests;
  for (std::string line; std::getline(std::cin, line);) {
    const std::vector<std::string> cells = cellsOf(line);
    if (cells.size() != 4) throw std::runtime_error("scene,engine,method,setting expected: " + line);
    if (contests.count(cells[0]) == 0) contests.emplace(cells[0], readContest(folder, cells[0]));
    const auto contestant = std::find_if(contestants.begin(), contestants.end(), [&](const Contestant& each) {
      return each.engine == cells[1] && each.method == cells[2];
    });
    if (contestant == contestants.end()) throw std::runtime_error("no contestant is called " + line);
    const Contest& contest = contests.at(cells[0]);
    const Result r =
        measure(contest, *contestant, std::strtod(cells[3].c_str(), nullptr), effortFor(contest, quick));
    std::printf("%s,%.4e,%.4e,%.6e,%lld,%lld,%lld,%.3e,%s,%d,%.6e,%d\n", line.c_str(), r.thetaError,
                r.omegaError, r.median, r.counts.evaluations, r.counts.steps, r.counts.rejected, r.worstStep,
                r.outcome, r.runs, r.least, r.turns);
    std::fflush(stdout);
  }
}

void printScaling(const std::vector<Contestant>& contestants, const std::vector<int>& lengths, bool quick) {
  for (const Contestant& each : contestants) {
    for (const int n : lengths) {
      const double h = 1e-3 / n;
      const int batch = std::max(1, 2000 / n);
      const int repetitions = std::clamp((quick ? 100'000 : 1'000'000) / (n * batch), 9, 301);
      const Contest contest{"hanging", hangingChain(n), 2 * h * batch * repetitions, {}, {}, {}};
      if (!each.hasFixedStep || !each.takes(contest.scene)) continue;
      const auto run = each.make(contest, h);
      std::vector<double> times;
      for (int k = 0; k < repetitions; ++k) {
        times.push_back(secondsOf([&] {
                          for (int step = 0; step < batch; ++step) run->step();
                        }) /
                        batch);
      }
      std::printf("%s,%s,%d,%.4e\n", each.engine.c_str(), each.method.c_str(), n, median(times));
      std::fflush(stdout);
    }
  }
}

}  // namespace planar_chain::tools
