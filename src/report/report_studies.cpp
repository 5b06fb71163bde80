#include "report/report_studies.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "planar_chain/energy.h"
#include "planar_chain/simulation.h"
#include "report/report_own.h"
#include "report/stability_measure.h"

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
      OwnRun run(contest.scene, contest.end, [&](Dynamics& dynamics) {
        return ode::fixedSteps(makeStepper(method, dynamics, stagesSolvedTo), h);
      });
      Progress progress = Progress::underway;
      while (progress == Progress::underway) progress = run.step();
      double theta = 0, omega = 0;  // of one link
      run.read(&theta, &omega);
      const double error = std::max(std::abs(theta - contest.theta[0]), std::abs(omega - contest.omega[0]));
      std::printf("order,%s,%s,%.9g,%.4e,\n", contest.name.c_str(), method.name, h,
                  progress == Progress::arrived ? error : nan);
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

}  // namespace

void studyConsistency(const std::string& folder, bool quick) {
  std::puts("study,scene,method,setting,value,scale");
  printOrders(readContest(folder, "pendulum"), quick);
  for (const std::string& name : contestNames(folder)) {
    const Contest contest = readContest(folder, name);
    if (!quick || contest.scene.chain.size() <= 100) printEnergy(contest);
  }
}

// ---- Effects ---------------------------------------------------------------------------------

namespace {

struct Effect {
  const char* name;
  /// Takes it out of a scene; false when it is not there.
  bool (*remove)(std::vector<Link>&, std::vector<Joint>&, Vec2d& gravity, std::vector<Load>&);
};

/// Sets a number of each part to 0; true if one was not.
template <class Parts, class Number>
bool clear(Parts& parts, Number&& number) {
  bool wasThere = false;
  for (auto& part : parts) {
    wasThere = wasThere || number(part) != 0;
    number(part) = 0;
  }
  return wasThere;
}

constexpr Effect effects[] = {
    {"nothing", [](auto&, auto&, auto&, auto&) { return true; }},
    {"gravity",
     [](auto&, auto&, Vec2d& gravity, auto&) {
       const bool wasThere = gravity.x != 0 || gravity.y != 0;
       gravity = {};
       return wasThere;
     }},
    {"springs",
     [](auto&, auto& joints, auto&, auto&) {
       return clear(
           joints, [](auto& j) -> auto& { return j.stiffness; });
     }},
    {"dampers",
     [](auto&, auto& joints, auto&, auto&) {
       return clear(
           joints, [](auto& j) -> auto& { return j.damping; });
     }},
    {"limits",
     [](auto&, auto& joints, auto&, auto&) {
       bool wasThere = false;
       for (Joint& joint : joints) {
         wasThere = wasThere || std::isfinite(joint.lower) || std::isfinite(joint.upper);
         joint.lower = -std::numeric_limits<double>::infinity();
         joint.upper = std::numeric_limits<double>::infinity();
         joint.stopStiffness = joint.stopDamping = 0;
       }
       return wasThere;
     }},
    {"loads",
     [](auto&, auto&, auto&, auto& loads) {
       const bool wereThere = !loads.empty();
       loads.clear();
       return wereThere;
     }},
};

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
    const double start = threadSeconds();
    for (int k = 0; k < times; ++k) dynamics.derivative(0, y.data(), slope.data());
    return (threadSeconds() - start) / times;
  }
  Scene scene;
  Dynamics dynamics;
  Eigen::VectorXd y, slope;
};

}  // namespace

void studyEffects(const std::string& folder, bool quick) {
  std::puts("scene,links,without,seconds,ratio");
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/config/scenes")) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const Scene scene = sceneOfFile(file.string());
    std::vector<const char*> names;
    std::vector<std::unique_ptr<Evaluated>> variants;
    for (const Effect& effect : effects) {
      Scene without = scene;
      std::vector<Link> links = scene.chain.links();
      std::vector<Joint> joints = scene.chain.joints();
      Vec2d gravity = scene.chain.gravity();
      if (!effect.remove(links, joints, gravity, without.loads)) continue;
      without.chain = Chain(links, joints, gravity);
      names.push_back(effect.name);
      variants.push_back(std::make_unique<Evaluated>(without));
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

// ---- Scaling ---------------------------------------------------------------------------------

void studyScaling(bool quick) {
  std::puts("engine,method,links,seconds");
  const std::vector<int> lengths =
      quick ? std::vector<int>{2, 10, 100, 1000}
            : std::vector<int>{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000};
  for (const Method& method : measuredMethods()) {
    for (const int n : lengths) {
      std::printf("planar_chain,%s,%d,%.4e\n", method.name, n, costOf(method, n, quick));
      std::fflush(stdout);
    }
  }
}

// ---- Long runs -------------------------------------------------------------------------------

namespace {

/// Five rods that turn and whirl about the ground pin, and no gravity: nothing changes energy and angular
/// momentum.
Scene freeChain() {
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 1; i <= 5; ++i) {
    const std::string name = "rod_" + std::to_string(i);
    links.push_back({name, 1, 1. / 12, {0.5, 0}, {1, 0}});
    joints.push_back({name + "_joint"});
  }
  return {Chain(links, joints, {}), {0, 0.5, 0.5, -1, 1}, {1, 0.5, -1, 1, 0}, {}, {}, {}, 0};
}

void followLong(const char* name, const Scene& scene, const std::string& method, double setting, double end) {
  const int n = scene.chain.size();
  const bool isFree = scene.chain.gravity().x == 0 && scene.chain.gravity().y == 0;
  OwnRun run(scene, end, methodFor(method, setting));
  Eigen::VectorXd theta(n), omega(n);
  const auto energy = [&] {
    run.read(theta.data(), omega.data());
    return energyOf(scene.chain, theta.data(), omega.data()).total();
  };
  const auto momentum = [&] {
    run.read(theta.data(), omega.data());
    return angularMomentum(scene.chain, theta.data(), omega.data());
  };
  // Against the energy that may move: that of falling to the bottom.
  Eigen::VectorXd bottom = Eigen::VectorXd::Zero(2 * n);
  bottom.head(n).setConstant(-std::acos(0.0));
  const double lowest = isFree ? 0 : energyOf(scene.chain, bottom.data(), bottom.data() + n).total();
  const double energyThen = energy(), momentumThen = momentum();
  Progress progress = Progress::underway;
  for (double look = 1; progress == Progress::underway; look *= std::pow(10.0, 0.125)) {
    while (progress == Progress::underway && run.time() < look) progress = run.step();
    const bool failed = progress == Progress::diverged || progress == Progress::refused;
    std::printf("%s,%s,%g,%.6g,%lld,%.4e,%.4e\n", name, method.c_str(), setting, run.time(),
                run.counts().steps, failed ? nan : (energy() - energyThen) / (energyThen - lowest),
                failed || !isFree ? nan : (momentum() - momentumThen) / momentumThen);
  }
  std::fflush(stdout);
}

}  // namespace

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

}  // namespace planar_chain::tools
