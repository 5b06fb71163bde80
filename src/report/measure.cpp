/// report_measure: what `report` measures of this program. Each study writes a table with a header to
/// standard output.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "dynamics/dynamics.h"
#include "effects/effect_kind.h"
#include "report/own_methods.h"
#include "report_build.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// ---- Orders ----------------------------------------------------------------------------------

/// The error (rad, rad/s) of each method with equal steps on the single link of the scene `pendulum`.
void studyOrders(const Arguments& given) {
  constexpr double stagesSolvedTo = 1e-13;
  const Contest contest = readContest(given, "pendulum");
  std::puts("method,step,error");
  for (const std::string& method : steppedMethods()) {
    for (int k = 0; k < (given.has("quick") ? 32 : 40); ++k) {
      const double h = contest.end / std::round(8 * std::pow(2.0, 0.25 * k));
      OwnRun run(contest.scene, contest.end, equalSteps(method, h, stagesSolvedTo));
      const bool arrived = run.steps(std::numeric_limits<int>::max()) == Progress::arrived;
      double theta, omega;
      run.read(&theta, &omega);
      const double error = std::max(std::abs(theta - contest.theta[0]), std::abs(omega - contest.omega[0]));
      std::printf("%s,%.9g,%.4e\n", method.c_str(), h, arrived ? error : nan);
    }
  }
}

// ---- Effects ---------------------------------------------------------------------------------

/// Evaluates the accelerations of a scene at its start, again and again. A rate differs a little each time,
/// as chains whose accelerations are coupled keep what they have found for a state.
std::function<void()> evaluationOf(const Scene& scene) {
  const auto dynamics = std::make_shared<Dynamics>(scene);
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics->size()), slope = y;
  readStart(scene, y.data(), y.data() + scene.chain.size());
  dynamics->enter(0);
  dynamics->enterState(0, y.data());
  const Eigen::Index last = 2 * scene.chain.size() - 1;
  return [=, first = y[last], calls = 0]() mutable {
    constexpr int states = 1024;
    calls = (calls + 1) % states;
    y[last] = first + 1e-9 * calls;
    dynamics->derivative(0, y.data(), slope.data());
  };
}

/// The kind's name, such as "loads".
std::string nameOf(const EffectKind& kind) {
  SceneWords words;
  kind.summarize(readSceneText("{chain: [a], links: {a: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0]}}}"),
                 words);
  std::string name;
  for (const std::string& word : words.leftOut) name += (name.empty() ? "" : " and ") + word;
  return name;
}

/// An evaluation of each scene that ships, and of the same where a kind of effect is not known.
void studyEffects(const Arguments& given) {
  std::puts("scene,links,without,seconds");
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(given.text("data").value_or("") + "/config/scenes")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  const std::vector<const EffectKind*> kinds = effectKinds();
  for (const auto& file : files) {
    const Scene scene = readSceneText(loadText(file.string()));
    std::vector<std::string> names{"nothing"};
    std::vector<std::function<void()>> evaluations{evaluationOf(scene)};
    for (const EffectKind* kind : kinds) {
      SceneWords words;
      kind->summarize(scene, words);
      if (words.runs.empty()) continue;
      const std::string name = nameOf(*kind);
      names.push_back(name.empty() ? words.runs.front() : name);
      std::vector<const EffectKind*> others = kinds;
      others.erase(std::find(others.begin(), others.end(), kind));
      const OtherEffectKinds without(others);
      evaluations.push_back(evaluationOf(scene));
    }
    const int batch = std::max(1, 4000 / scene.chain.size());
    const std::vector<double> seconds = secondsPerCall(evaluations, batch, given.has("quick") ? 21 : 201);
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::printf("%s,%d,%s,%.4e\n", file.stem().string().c_str(), scene.chain.size(), names[i].c_str(),
                  seconds[i]);
    }
  }
}

// ---- Long runs -------------------------------------------------------------------------------

/// The error of the energy, relative to what falling to the bottom sets free, in long runs of the double
/// pendulum. A failed run ends with NaN.
void studyLongRuns(const Arguments& given) {
  std::puts("method,setting,t,steps,energy");
  const Scene scene = readContest(given, "double").scene;
  const std::pair<const char*, double> settings[] = {
      {"auto", 1e-8},   {"dopri5", 1e-8}, {"dop853", 1e-8}, {"rodas5p", 1e-8},        {"radau13", 1e-8},
      {"taylor", 1e-8}, {"rk4", 0.005},   {"auto", 1e-12},  {"ros34pw2_fixed", 0.005}};
  for (const auto& [method, setting] : settings) {
    OwnRun run(scene, given.has("quick") ? 100 : 1e4, methodFor(method, setting));
    const double energyThen = run.energyOfMotion();
    Progress progress = Progress::underway;
    for (double due = 1; progress == Progress::underway; due *= std::pow(10.0, 0.125)) {
      while (progress == Progress::underway && run.time() < due) progress = run.step();
      const bool failed = progress == Progress::diverged || progress == Progress::refused;
      std::printf("%s,%g,%.6g,%lld,%.4e\n", method, setting, run.time(), run.counts().steps,
                  failed ? nan : (run.energyOfMotion() - energyThen) / energyThen);
    }
  }
}

// ---- The program -----------------------------------------------------------------------------

void studyScaling(const Arguments& given) {
  std::puts("engine,method,links,seconds");
  printScaling(ownContestants(true),
               given.has("quick")
                   ? std::vector<int>{2, 10, 100, 1000}
                   : std::vector<int>{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000},
               given.has("quick"));
}

void studyRace(const Arguments& given) {
  std::puts(
      "scene,engine,method,setting,error_theta,error_omega,cpu_seconds,evaluations,steps,rejected,"
      "worst_step_seconds,outcome");
  race(readContest(given, given.text("scene").value_or("")), ownContestants(false), given.has("quick"));
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  using namespace planar_chain::tools;
  return runStudy("report_measure", argc, argv,
                  {{"about", [](const Arguments&) { std::puts(PLANAR_CHAIN_ABOUT); }},
                   {"race", studyRace},
                   {"consistency", studyOrders},
                   {"effects", studyEffects},
                   {"scaling", studyScaling},
                   {"long", studyLongRuns}});
}
