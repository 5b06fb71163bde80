#include "report/contest.h"

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "planar_chain/scene_reader.h"
#include "report/median.h"

namespace planar_chain::tools {

namespace {

constexpr double lost = 1;         // rad: the run has nothing to do with the motion any more
constexpr double isShort = 0.03;   // s: such runs are made in turns, and thrice to time their steps
constexpr double notRepeated = 1;  // s
constexpr int longChain = 1000;    // links
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
               : Effort{0.1, 10, 3, 0.25, 0.5 + 5.5 * longer, 1e7 + 1e8 * longer};
}

/// Loosest first: tolerances, or steps of 1, 0.3, 0.1, 0.03 … s, as far as the number of steps allows.
std::vector<double> settingsFor(const Contestant& contestant, const Contest& contest, const Effort& effort,
                                bool quick) {
  std::vector<double> settings;
  if (!contestant.hasFixedStep) {
    for (int k = quick ? 3 : 0; k <= (quick ? 9 : 13); k += quick ? 3 : 1) {
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
    result.seconds += secondsOf([&] { result.progress = result.run->steps(stepsPerLook); });
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

double largestError(const std::vector<double>& values, const std::vector<int>& index,
                    const std::vector<double>& reference) {
  double largest = 0;
  for (std::size_t k = 0; k < index.size(); ++k) {
    const double error = std::abs(values.at(static_cast<std::size_t>(index[k])) - reference[k]);
    if (!std::isfinite(error)) return nan;  // which std::max would drop
    largest = std::max(largest, error);
  }
  return largest;
}

// ---- A point ---------------------------------------------------------------------------------

struct Point {
  const Contestant* contestant;
  double setting = 0;
  const char* outcome = "ok";             ///< or "diverged", "refused", "timed out"
  double thetaError = 0, omegaError = 0;  ///< largest of a link
  int turns = 0;
  std::array<double, 3> medians{};  ///< s, of each turn
  double worstStep = infinity;      ///< s, least of the turns
  bool isMeasuredAgain = false;     ///< in the other turns
  Counts counts{};
};

void fail(Point& point, const char* outcome, double seconds) {
  point.outcome = outcome;
  point.turns = 1;
  point.medians = {seconds};
  point.thetaError = point.omegaError = point.worstStep = nan;
}

/// One turn.
void measure(const Contest& contest, const Effort& effort, Point& point) {
  const Ride first = ride(contest, *point.contestant, point.setting, effort.limit);
  point.counts = first.run->counts();
  std::vector<double> theta(contest.scene.q.size()), omega(theta);
  first.run->read(theta.data(), omega.data());
  point.thetaError = largestError(theta, contest.index, contest.theta);
  point.omegaError = largestError(omega, contest.index, contest.omega);
  const bool isLost = !(point.thetaError <= lost) || std::isnan(point.omegaError);
  if (first.progress != Progress::arrived || isLost) {
    return fail(point,
                first.progress == Progress::underway  ? "timed out"
                : first.progress == Progress::refused ? "refused"
                                                      : "diverged",
                first.seconds);
  }

  point.isMeasuredAgain = first.seconds < isShort;
  const double wanted = std::clamp(effort.budget / first.seconds, 1.0 * effort.fewest, 21.0) /
                        (point.isMeasuredAgain ? effort.turns : 1);
  std::vector<double> times(first.seconds > effort.isLong ? 2 : static_cast<std::size_t>(std::ceil(wanted)),
                            first.seconds);
  for (double& time : times) {
    if (first.seconds > notRepeated) break;
    time = ride(contest, *point.contestant, point.setting, effort.limit).seconds;
  }
  point.medians.at(static_cast<std::size_t>(point.turns++)) = median(times);
  point.worstStep = std::min(
      point.worstStep, worstStep(contest, *point.contestant, point.setting, point.isMeasuredAgain ? 3 : 1));
}

/// Measures another program in a process of its own: a crash of it costs this point only.
void measureTurn(const Contest& contest, const Effort& effort, Point& point) {
  if (point.contestant->engine == "planar_chain") return measure(contest, effort, point);
  void* const memory = mmap(nullptr, sizeof point, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::runtime_error("no memory to share");
  auto* const shared = new (memory) Point(point);
  const pid_t child = fork();
  if (child == 0) {
    measure(contest, effort, *shared);
    _exit(0);
  }
  int status = -1;
  waitpid(child, &status, 0);
  if (status == 0) {
    point = *shared;
  } else {
    fail(point, "refused", nan);
  }
  munmap(memory, sizeof point);
}

}  // namespace

Progress Run::steps(int most) {
  Progress progress = Progress::underway;
  for (int k = 0; k < most && progress == Progress::underway; ++k) progress = step();
  return progress;
}

// ---- Contests --------------------------------------------------------------------------------

Contest readContest(const Arguments& given, const std::string& name) {
  const std::string folder = given.text("data").value_or("");
  std::istringstream scenes(loadText(folder + "/report/scenes.csv"));
  std::string known, file, reference, quantity, link, value, rest;
  do {
    std::getline(scenes, rest);
    std::getline(scenes, known, ',');
    std::getline(scenes, file, ',');
    std::getline(scenes, reference, ',');
  } while (scenes && known != name);
  if (!scenes) throw std::runtime_error("the report has no scene \"" + name + "\"");
  const bool ships = file.rfind("config/", 0) == 0;
  const std::string path = folder + (ships ? "/config/scenes/" + file.substr(7) : "/" + file);
  Contest contest{name, readSceneText(loadText(path)), 0, {}, {}, {}};
  scenes >> contest.end;
  std::istringstream ends(loadText(folder + "/report/" + name + ".csv"));
  std::getline(ends, rest);
  while (std::getline(ends, quantity, ',') && std::getline(ends, link, ',') &&
         std::getline(ends, value, ',') && std::getline(ends, rest)) {
    if (quantity == "theta") contest.index.push_back(std::stoi(link));
    (quantity == "theta" ? contest.theta : contest.omega).push_back(std::stod(value));
  }
  return contest;
}

Scene uniformChain(int n, double bend, double k, double d, double tip, double lean) {
  const double length = 1.0 / n;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<double> q, qd(static_cast<std::size_t>(n), 0.0);  // q: absolute until all are known
  for (int i = 0; i < n; ++i) {
    const std::string name = "link_" + std::to_string(i + 1);
    const double mass = 1.0 / n * (i == n - 1 ? tip : 1);
    links.push_back({name, mass, mass * length * length / 12, {length / 2, 0}, {length, 0}});
    joints.push_back({name + "_joint"});
    joints.back().stiffness = i > 0 ? k : 0;
    joints.back().damping = i > 0 ? d : 0;
    q.push_back(-pi / 2 + (lean + bend * std::sin(pi * ((i + 0.5) / n))));
  }
  toRelative(q.data(), n, q.data());
  return {Chain(std::move(links), std::move(joints), {0, -9.81}), std::move(q), std::move(qd), {}, {}, {}, 0};
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
    const Contest contest{"hanging", uniformChain(n, 0.02), 2 * h * batch * repetitions, {}, {}, {}};
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
  return run({program,
              "Measures for `report`; prints CSV, or JSON about itself.",
              "0 done; 1 it failed; 2 bad arguments.",
              false,
              {{"study", "What to measure"},
               {"scene", "For the study race"},
               {"data", "Folder with report/ and config/scenes"},
               {"quick", "Fewer and shorter runs", false}},
              [&](const Arguments& given) {
                studies.at(given.text("study").value_or(""))(given);
                return static_cast<int>(done);
              }},
             argc, argv);
}

}  // namespace planar_chain::tools
