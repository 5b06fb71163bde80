/// report_measure: what `report` measures of this program. Each study writes a table with a header to
/// standard output.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "planar_chain/energy.h"
#include "planar_chain/simulation.h"
#include "report/families.h"
#include "report/own.h"
#include "report/timing.h"
#include "report_build.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// ---- Consistency -----------------------------------------------------------------------------

/// On a single link.
void printOrders(const Contest& contest, bool quick) {
  constexpr double stagesSolvedTo = 1e-13;
  const int parts = quick ? 32 : 40;
  for (const Method& method : measuredMethods()) {
    for (int k = 0; k < parts; ++k) {
      const double h = contest.end / std::round(8 * std::pow(2.0, 0.25 * k));
      OwnRun run(contest.scene, contest.end, equalSteps(method, h, stagesSolvedTo));
      const bool arrived = run.steps(std::numeric_limits<int>::max()) == Progress::arrived;
      const Eigen::Vector2d error = run.motion() - Eigen::Vector2d(contest.theta[0], contest.omega[0]);
      std::printf("order,%s,%s,%.9g,%.4e,\n", contest.name.c_str(), method.name, h,
                  arrived ? error.cwiseAbs().maxCoeff() : nan);
    }
  }
}

void printEnergy(const Contest& contest) {
  constexpr double tolerance = 1e-10;
  Scene scene = contest.scene;
  scene.integrator = {"auto", tolerance, 0};
  Simulation simulation(scene);
  const bool isGood = simulation.advanceTo(contest.end);
  const EnergyBalance balance = simulation.energyBalance();
  std::printf("energy,%s,auto,%g,%.4e,%.4e\n", contest.name.c_str(), tolerance,
              isGood ? std::abs(balance.residual) : nan,
              std::abs(balance.now.potential) + balance.now.kinetic + balance.supplied + balance.dissipated);
  std::fflush(stdout);
}

/// study,scene,method,setting,value,scale: "order", the error (rad, rad/s) of each method with equal steps on
/// the scene `pendulum`; "energy", the residual of the energy balance of `auto` at tolerance 1e-10 (J), and
/// the energy at hand.
void studyConsistency(const std::string& folder, bool quick) {
  std::puts("study,scene,method,setting,value,scale");
  printOrders(readContest(folder, "pendulum"), quick);
  for (const std::string& name : contestNames(folder)) {
    const Contest contest = readContest(folder, name);
    if (!quick || contest.scene.chain.size() <= 100) printEnergy(contest);
  }
}

// ---- Effects ---------------------------------------------------------------------------------

/// The scene without an effect; nothing if the scene does not have it.
std::optional<Scene> without(const std::string& effect, const Scene& scene) {
  std::vector<Joint> joints = scene.chain.joints();
  Vec2d gravity = scene.chain.gravity();
  Scene result = scene;
  bool had = effect == "nothing";
  const auto set = [&](double Joint::*number, double value) {
    for (Joint& joint : joints) had |= std::exchange(joint.*number, value) != value;
  };
  if (effect == "gravity") had = !(std::exchange(gravity, {}) == Vec2d{});
  if (effect == "springs") set(&Joint::stiffness, 0);
  if (effect == "dampers") set(&Joint::damping, 0);
  if (effect == "limits") {
    set(&Joint::lower, -infinity);
    set(&Joint::upper, infinity);
    set(&Joint::stopStiffness, 0);
    set(&Joint::stopDamping, 0);
  }
  if (effect == "loads") had = !std::exchange(result.loads, {}).empty();
  if (!had) return std::nullopt;
  result.chain = Chain(scene.chain.links(), joints, gravity);
  return result;
}

/// A scene at its start, ready to be evaluated.
struct Evaluated {
  explicit Evaluated(const Scene& given)
      : scene(given), dynamics(scene), y(dynamics.size()), slope(dynamics.size()) {
    y.setZero();
    readStart(scene, y.data(), y.data() + scene.chain.size());
    dynamics.enterState(y.data());
    dynamics.enter(0);
  }
  double seconds(int times) {
    return secondsOf([&] {
             for (int k = 0; k < times; ++k) dynamics.derivative(0, y.data(), slope.data());
           }) /
           times;
  }
  Scene scene;
  Dynamics dynamics;
  Eigen::VectorXd y, slope;
};

/// scene,links,without,seconds,ratio: an evaluation of each scene that ships, and of the same without one
/// effect; medians of runs in turn.
void studyEffects(const std::string& folder, bool quick) {
  std::puts("scene,links,without,seconds,ratio");
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/config/scenes")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const Scene scene = readSceneText(loadText(file.string()));
    std::vector<const char*> names;
    std::vector<std::unique_ptr<Evaluated>> variants;
    for (const char* effect : {"nothing", "gravity", "springs", "dampers", "limits", "loads"}) {
      const std::optional<Scene> variant = without(effect, scene);
      if (!variant) continue;
      names.push_back(effect);
      variants.push_back(std::make_unique<Evaluated>(*variant));
    }
    const int times = std::max(1, static_cast<int>(2e-4 / variants[0]->seconds(10)));
    std::vector<std::vector<double>> seconds(variants.size()), ratios(variants.size());
    for (int k = 0; k < (quick ? 21 : 201); ++k) {
      for (std::size_t i = 0; i < variants.size(); ++i) {
        seconds[i].push_back(variants[i]->seconds(times));
        ratios[i].push_back(seconds[i].back() / seconds[0].back());
      }
    }
    for (std::size_t i = 0; i < variants.size(); ++i) {
      std::printf("%s,%d,%s,%.4e,%.4f\n", file.stem().string().c_str(), scene.chain.size(), names[i],
                  median(seconds[i]), median(ratios[i]));
    }
    std::fflush(stdout);
  }
}

// ---- Long runs -------------------------------------------------------------------------------

/// Five rods that turn and whirl about the ground pin, and no gravity: energy and angular momentum stay.
Scene freeChain() {
  Scene scene = readSceneText(
      "{chain: [rod], gravity: [0, 0], links: {rod: {mass: 1, inertia: 0.08333333333333333, com: [0.5, 0], "
      "pin: [1, 0], repeat: 5}}}");
  scene.q = {0, 0.5, 0.5, -1, 1};
  scene.qd = {1, 0.5, -1, 1, 0};
  return scene;
}

void followLong(const char* name, const Scene& scene, const std::string& method, double setting, double end) {
  const Chain& chain = scene.chain;
  const int n = chain.size();
  const bool isFree = chain.gravity().x == 0 && chain.gravity().y == 0;
  OwnRun run(scene, end, methodFor(method, setting));
  const auto energy = [&](const Eigen::VectorXd& y) {
    return energyOf(chain, y.data(), y.data() + n).total();
  };
  const auto momentum = [&](const Eigen::VectorXd& y) {
    return angularMomentum(chain, y.data(), y.data() + n);
  };
  // Against the energy that falling to the bottom sets free.
  Eigen::VectorXd bottom = Eigen::VectorXd::Zero(2 * n);
  bottom.head(n).setConstant(-pi / 2);
  const double lowest = isFree ? 0 : energy(bottom);
  const double energyThen = energy(run.motion()), momentumThen = momentum(run.motion());
  Progress progress = Progress::underway;
  for (double due = 1; progress == Progress::underway; due *= std::pow(10.0, 0.125)) {
    while (progress == Progress::underway && run.time() < due) progress = run.step();
    const bool failed = progress == Progress::diverged || progress == Progress::refused;
    std::printf("%s,%s,%g,%.6g,%lld,%.4e,%.4e\n", name, method.c_str(), setting, run.time(),
                run.counts().steps,
                failed ? nan : (energy(run.motion()) - energyThen) / (energyThen - lowest),
                failed || !isFree ? nan : (momentum(run.motion()) - momentumThen) / momentumThen);
  }
  std::fflush(stdout);
}

/// scene,method,setting,t,steps,energy,momentum: relative errors of what no force changes, over long runs. A
/// failed run ends with NaN.
void studyLongRuns(const std::string& folder, bool quick) {
  std::puts("scene,method,setting,t,steps,energy,momentum");
  const Contest pendulum = readContest(folder, "double");
  const double end = quick ? 100 : 1e4;
  const std::pair<const char*, Scene> scenes[] = {{"double", pendulum.scene}, {"free_chain", freeChain()}};
  const std::pair<const char*, double> runs[] = {
      {"auto", 1e-8},   {"dopri5", 1e-8}, {"dop853", 1e-8}, {"rodas5p", 1e-8},        {"radau13", 1e-8},
      {"taylor", 1e-8}, {"rk4", 0.005},   {"auto", 1e-12},  {"ros34pw2_fixed", 0.005}};
  for (const auto& [name, scene] : scenes) {
    for (const auto& [method, setting] : runs) followLong(name, scene, method, setting, end);
  }
}

// ---- The program -----------------------------------------------------------------------------

int measure(int argc, char** argv) {
  CLI::App app("Measures what `report` needs, as CSV on standard output.", "report_measure");
  std::string what, folder;
  bool quick = false;
  constexpr const char* choices = "about, list, race, consistency, effects, scaling or long";
  app.add_option("WHAT", what, choices)->required();
  app.add_option("--data", folder, "Folder with report/ and config/scenes")->required();
  app.add_flag("--quick", quick, "Fewer and shorter runs");
  app.footer("Exit status: 0 done; 1 it failed; 2 bad arguments.");
  if (const auto status = parseArguments(app, argc, argv)) return *status;

  const std::map<std::string, std::function<void()>> studies{
      {"about",
       [] {
         nlohmann::ordered_json about{{"commit", PLANAR_CHAIN_COMMIT},
                                      {"compiler", PLANAR_CHAIN_COMPILER},
                                      {"flags", PLANAR_CHAIN_FLAGS},
                                      {"recursion", Simulation(hangingChain(1000)).recursion()}};
         std::puts(about.dump().c_str());
       }},
      {"list", [&] { listPoints(folder, ownContestants(), quick); }},
      {"race", [&] { racePoints(folder, ownContestants(), quick); }},
      {"consistency", [&] { studyConsistency(folder, quick); }},
      {"effects", [&] { studyEffects(folder, quick); }},
      {"scaling",
       [&] {
         std::puts("engine,method,links,seconds");
         printScaling(ownEqualSteps(),
                      quick ? std::vector<int>{2, 10, 100, 1000}
                            : std::vector<int>{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000},
                      quick);
       }},
      {"long", [&] { studyLongRuns(folder, quick); }}};
  const auto study = studies.find(what);
  if (study == studies.end()) throw Refused({{"WHAT", choices, describe(Value(what))}});
  study->second();
  return done;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  namespace tools = planar_chain::tools;
  return tools::run("report_measure", [&] { return tools::measure(argc, argv); });
}
