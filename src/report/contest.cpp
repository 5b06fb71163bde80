#include "report/contest.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <sstream>
#include <stdexcept>
#include <type_traits>

#include "planar_chain/scene_reader.h"
#include "tools/common.h"

namespace planar_chain::tools {

namespace {

constexpr double lost = 1;        // rad: the run has nothing to do with the motion any more
constexpr double isShort = 0.03;  // s: such runs are made in turns, and thrice to time their steps
constexpr int longChain = 1000;   // links
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// s of this thread on the processor that `call` takes.
template <class Call>
double secondsOf(Call&& call) {
  const auto now = [] {
    timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  call();
  return now() - start;
}

/// The upper one of an even number; of one value at least.
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

using Cells = std::vector<std::string>;

/// The lines of a table after its header, cut at commas, with at least so many cells.
std::vector<Cells> tableOf(const std::string& path, std::size_t cells) {
  std::istringstream file(loadText(path));
  std::string line;
  std::getline(file, line);
  std::vector<Cells> rows;
  while (std::getline(file, line)) {
    rows.emplace_back();
    std::istringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) rows.back().push_back(cell);
    if (rows.back().size() < cells) throw std::runtime_error(path + ": too few columns in \"" + line + "\"");
  }
  return rows;
}

// ---- One run ---------------------------------------------------------------------------------

struct Effort {
  double budget;  ///< s a setting
  int fewest;     ///< runs
  int turns;
  double isLong;         ///< s a run
  double limit;          ///< s a run: longer ones are given up
  double mostLinkSteps;  ///< of a run with equal steps
};

Effort effortFor(const Contest& contest, bool quick) {
  const double longer = contest.scene.chain.size() >= longChain ? 1 : 0;
  return quick ? Effort{0.03, 3, 1, 0.02, 0.1 + 0.3 * longer, 3e5 + 6e5 * longer}
               : Effort{0.1, 10, 3, 0.25, 0.5 + 1.5 * longer, 1e7 + 2e7 * longer};
}

/// Loosest first: tolerances, or steps of 1, 0.3, 0.1, 0.03 … s, as far as the number of steps allows.
std::vector<double> settingsFor(const Contestant& contestant, const Contest& contest, const Effort& effort,
                                bool quick) {
  std::vector<double> settings;
  if (!contestant.hasFixedStep) {
    for (int k = quick ? 3 : 2; k <= (quick ? 9 : 13); k += quick ? 3 : 1) {
      settings.push_back(std::pow(10.0, -k));
    }
    return settings;
  }
  const double smallest = contest.end * contest.scene.chain.size() / effort.mostLinkSteps;
  for (int k = 0; k < 40; k += quick ? 2 : 1) {
    const double h = (k % 2 == 0 ? 1 : 0.3) * std::pow(10.0, -(k / 2));
    if (h <= contest.end / 10 && h >= smallest) settings.push_back(h);
  }
  return settings;
}

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

/// The longest step, s, of so many runs. Each step counts with its least time, less that of reading the
/// clock.
double worstStep(const Contest& contest, const Contestant& contestant, double setting, int runs) {
  std::vector<double> clock(999), least;
  for (double& time : clock) time = secondsOf([] {});
  for (int made = 0; made < runs; ++made) {
    const auto run = contestant.make(contest, setting);
    Progress progress = Progress::underway;
    for (std::size_t k = 0; progress == Progress::underway; ++k) {
      const double seconds = secondsOf([&] { progress = run->step(); });
      if (k == least.size()) least.push_back(seconds);
      least[k] = std::min(least[k], seconds);
    }
  }
  return std::max(0.0, *std::max_element(least.begin(), least.end()) - median(clock));
}

double largestError(const Eigen::VectorXd& values, const std::vector<int>& index,
                    const Eigen::VectorXd& reference) {
  double largest = 0;
  for (std::size_t k = 0; k < index.size(); ++k) {
    const double error = std::abs(values[index[k]] - reference[static_cast<Eigen::Index>(k)]);
    if (!std::isfinite(error)) return nan;  // which std::max would drop
    largest = std::max(largest, error);
  }
  return largest;
}

/// A uniform chain of 1 m and 1 kg, swung out by 0.1 rad and bent a little.
Scene hangingChain(int n) {
  char text[256];
  std::snprintf(text, sizeof text,
                "{chain: [rod], links: {rod: {mass: %.17g, inertia: %.17g, com: [%.17g, 0], pin: [%.17g, 0], "
                "initial: {angle: %.17g}, repeat: %d}}}",
                1.0 / n, std::pow(n, -3.0) / 12, 0.5 / n, 1.0 / n, 0.02 / n, n);
  Scene scene = readSceneText(text);
  scene.q[0] = -pi / 2 + 0.1;
  return scene;
}

// ---- A point ---------------------------------------------------------------------------------

struct Point {
  const Contestant* contestant;
  double setting = 0;
  const char* outcome = "ok";                 ///< or "diverged", "refused", "timed out"
  double thetaError = nan, omegaError = nan;  ///< largest of a link
  int turns = 0;
  std::array<double, 3> medians{};  ///< s, of each turn
  double worstStep = infinity;      ///< s, least of the turns
  bool isMeasuredAgain = false;     ///< in the other turns
  Counts counts{};
};

/// One turn.
void measure(const Contest& contest, const Effort& effort, Point& point) {
  const Ride first = ride(contest, *point.contestant, point.setting, effort.limit);
  point.counts = first.run->counts();
  const int n = contest.scene.chain.size();
  Eigen::VectorXd theta(n), omega(n);
  first.run->read(theta.data(), omega.data());
  const double thetaError = largestError(theta, contest.index, contest.theta);
  const double omegaError = largestError(omega, contest.index, contest.omega);
  const bool isLost = !(thetaError <= lost) || !std::isfinite(omegaError);
  if (first.progress != Progress::arrived || isLost) {
    point.outcome = first.progress == Progress::underway  ? "timed out"
                    : first.progress == Progress::refused ? "refused"
                                                          : "diverged";
    point.turns = 1;
    point.medians = {first.seconds};
    point.worstStep = nan;
    return;
  }
  point.thetaError = thetaError;
  point.omegaError = omegaError;

  point.isMeasuredAgain = first.seconds < isShort;
  const double wanted = std::clamp(effort.budget / first.seconds, 1.0 * effort.fewest, 21.0);
  std::vector<double> times(first.seconds > effort.isLong ? 2
                            : point.isMeasuredAgain
                                ? static_cast<std::size_t>(std::ceil(wanted / effort.turns))
                                : static_cast<std::size_t>(std::ceil(wanted)));
  for (double& time : times) {
    time = ride(contest, *point.contestant, point.setting, effort.limit).seconds;
  }
  point.medians.at(static_cast<std::size_t>(point.turns++)) = median(times);
  point.worstStep = std::min(
      point.worstStep, worstStep(contest, *point.contestant, point.setting, point.isMeasuredAgain ? 3 : 1));
}

/// The same in a process of its own: a crash of another program costs this point only.
void measureApart(const Contest& contest, const Effort& effort, Point& point) {
  static_assert(std::is_trivially_copyable_v<Point>);
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child == 0) {
    measure(contest, effort, point);
    _exit(write(ends[1], &point, sizeof point) == sizeof point ? 0 : 1);
  }
  close(ends[1]);
  Point measured = point;
  const bool isWhole = read(ends[0], &measured, sizeof measured) == sizeof measured;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  point = measured;
  if (isWhole) return;
  point.outcome = "refused";
  point.turns = 1;
  point.medians = {nan};
  point.worstStep = nan;
}

void measureTurn(const Contest& contest, const Effort& effort, Point& point) {
  (point.contestant->engine == "planar_chain" ? measure : measureApart)(contest, effort, point);
}

}  // namespace

// ---- Contests --------------------------------------------------------------------------------

Contest readContest(const std::string& folder, const std::string& name) {
  for (const Cells& row : tableOf(folder + "/report/scenes.csv", 4)) {
    if (row[0] != name) continue;
    const bool ships = row[1].rfind("config/", 0) == 0;
    const std::string path = folder + (ships ? "/config/scenes/" + row[1].substr(7) : "/" + row[1]);
    Contest contest{name, readSceneText(loadText(path)), std::stod(row[3]), {}, {}, {}};
    const auto ends = tableOf(folder + "/report/" + name + ".csv", 3);
    const auto half = static_cast<Eigen::Index>(ends.size() / 2);
    contest.theta.resize(half);
    contest.omega.resize(half);
    for (Eigen::Index k = 0; k < half; ++k) {
      const Cells &angle = ends[static_cast<std::size_t>(k)],
                  &rate = ends[static_cast<std::size_t>(half + k)];
      contest.index.push_back(std::stoi(angle[1]));
      contest.theta[k] = std::stod(angle[2]);
      contest.omega[k] = std::stod(rate[2]);
    }
    return contest;
  }
  throw std::runtime_error("the report has no scene \"" + name + "\"");
}

// ---- Studies ---------------------------------------------------------------------------------

void race(const Contest& contest, const std::vector<Contestant>& contestants, bool quick) {
  const Effort effort = effortFor(contest, quick);
  std::vector<Point> points;
  for (const Contestant& each : contestants) {
    if (!each.takes(contest.scene)) continue;
    for (const double setting : settingsFor(each, contest, effort, quick)) {
      points.push_back({&each, setting});
      measureTurn(contest, effort, points.back());
      if (points.back().outcome == std::string("timed out")) break;  // tighter ones take longer still
    }
  }
  for (int turn = 1; turn < effort.turns; ++turn) {
    for (Point& point : points) {
      if (point.isMeasuredAgain) measureTurn(contest, effort, point);
    }
  }
  for (const Point& p : points) {
    std::printf("%s,%s,%s,%g,%.4e,%.4e,%.6e,%lld,%lld,%lld,%.3e,%s\n", contest.name.c_str(),
                p.contestant->engine.c_str(), p.contestant->method.c_str(), p.setting, p.thetaError,
                p.omegaError, median({p.medians.begin(), p.medians.begin() + p.turns}), p.counts.evaluations,
                p.counts.steps, p.counts.rejected, p.worstStep, p.outcome);
  }
}

std::vector<double> secondsPerCall(const std::vector<std::function<void()>>& calls, int batch,
                                   int repetitions) {
  std::vector<std::vector<double>> times(calls.size());
  for (int k = 0; k < repetitions; ++k) {
    for (std::size_t i = 0; i < calls.size(); ++i) {
      times[i].push_back(secondsOf([&] {
                           for (int made = 0; made < batch; ++made) calls[i]();
                         }) /
                         batch);
    }
  }
  std::vector<double> medians;
  for (const auto& each : times) medians.push_back(median(each));
  return medians;
}

void printScaling(const std::vector<Contestant>& contestants, const std::vector<int>& lengths, bool quick) {
  for (const int n : lengths) {
    const double h = 1e-3 / n;
    const int batch = std::max(1, 2000 / n);
    const int repetitions = std::clamp((quick ? 100'000 : 1'000'000) / (n * batch), 9, 301);
    const Contest contest{"hanging", hangingChain(n), 2 * h * batch * repetitions, {}, {}, {}};
    std::vector<const Contestant*> taking;
    std::vector<std::function<void()>> steps;
    for (const Contestant& each : contestants) {
      if (!each.hasFixedStep || !each.takes(contest.scene)) continue;
      taking.push_back(&each);
      steps.push_back([run = std::shared_ptr<Run>(each.make(contest, h))] { run->step(); });
    }
    const std::vector<double> seconds = secondsPerCall(steps, batch, repetitions);
    for (std::size_t i = 0; i < steps.size(); ++i) {
      std::printf("%s,%s,%d,%.4e\n", taking[i]->engine.c_str(), taking[i]->method.c_str(), n, seconds[i]);
    }
  }
}

int runStudy(const char* program, int argc, char** argv, const Studies& studies) {
  Options options =
      optionsOf(program, "Measures for `report`; prints CSV, or JSON about itself.",
                "WHAT [SCENE]\nSCENE: for WHAT = race", "0 done; 1 it failed; 2 bad arguments.");
  auto add = options.add_options();
  add("data", valued(), "Folder with report/ and config/scenes");
  add("quick", "Fewer and shorter runs");
  return run(options, {"WHAT", "SCENE"}, argc, argv, [&](const Arguments& given) {
    const Request request{given.text("WHAT").value_or(""), given.text("SCENE").value_or(""),
                          given.text("data").value_or(""), given.has("quick")};
    const auto study = studies.find(request.what);
    if (study == studies.end()) throw Refused({{"WHAT", "the name of a study", quoted(request.what)}});
    if (request.folder.empty()) throw Refused({{"--data", "a folder", "nothing"}});
    study->second(request);
    return static_cast<int>(done);
  });
}

}  // namespace planar_chain::tools
