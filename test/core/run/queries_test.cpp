/// Queries, in any order and number, change no bit of the motion: those of a simulation, in every scene that
/// ships by every method, and in random machines; and those of switches, at other states and times.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "dynamics/dynamics.h"
#include "ode/events.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

Scene randomMachine(int n, unsigned seed) {
  Scene scene = test::randomScene(n, seed);
  test::Random random(seed + 100);
  std::vector<Joint> joints = scene.chain.joints();
  for (int i = 0; i < n; ++i) {
    Joint& joint = joints[static_cast<std::size_t>(i)];
    if (random.between(0, 1) < 0.8)
      joint.others.emplace_back("friction", std::pow(10., random.between(-6, 1)));
    if (random.between(0, 1) < 0.3) {
      joint.lower = scene.q[static_cast<std::size_t>(i)] - random.between(0.1, 1);
      joint.upper = scene.q[static_cast<std::size_t>(i)] + random.between(0.1, 1);
      joint.stopStiffness = 1e3;
      joint.stopDamping = 1;
    }
    if (random.between(0, 1) < 0.5) scene.qd[static_cast<std::size_t>(i)] = 0;
  }
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  if (seed % 2 == 0) scene.loads.clear();
  scene.integrator.tolerance = 1e-7;
  return scene;
}

/// Asks a simulation for something.
void ask(Simulation& of, test::Random& random) {
  std::vector<double> numbers(of.q().size());
  std::vector<LinkMotion> motions(of.q().size());
  switch (random.index(11)) {
    case 0:
      of.energy();
      break;
    case 1:
      of.energyBalance();
      break;
    case 2:
      of.accelerations(numbers.data());
      break;
    case 3:
      of.jointTorques(numbers.data());
      break;
    case 4:
      of.linkMotions(motions.data());
      break;
    case 5:
      of.baseWrench();
      break;
    case 6:
      of.tipForce();
      break;
    case 7:
      of.closureError();
      break;
    case 8:
      of.closureMargin();
      break;
    case 9:
      of.measure();
      break;
    default:
      of.commands();
  }
}

/// steps: of 10 ms.
void expectSameMotion(const Scene& scene, unsigned seed, int steps, const std::string& what) {
  Simulation plain(scene, 4, true), asked(scene, 4, true);
  test::Random random(seed);
  for (int k = 1; k <= steps; ++k) {
    for (int queries = random.index(6); queries > 0; --queries) ask(asked, random);
    const bool arrives = plain.advanceTo(0.01 * k);
    ASSERT_EQ(arrives, asked.advanceTo(0.01 * k)) << what;
    ASSERT_EQ(plain.fault(), asked.fault()) << what;
    ASSERT_EQ(plain.q(), asked.q()) << what << " at " << plain.time();
    ASSERT_EQ(plain.qd(), asked.qd()) << what << " at " << plain.time();
    if (!arrives) return;
  }
}

TEST(Queries, OfASimulationChangeNoBit) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    expectSameMotion(randomMachine(seed % 4 == 0 ? 20 : 4, seed), seed, 20, "seed " + std::to_string(seed));
  }
}

TEST(Queries, OfASimulationChangeNoBitOfAnySceneThatShips) {
  constexpr int most = 100;  // links: longer chains have no part of their own
  for (const auto& entry : std::filesystem::directory_iterator(SCENES_DIR)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    Scene scene = readSceneText(text);
    if (scene.chain.size() > most) continue;
    for (const char* method : {"auto", "dopri5", "dop853", "taylor", "rodas5p", "radau13", "rk4"}) {
      scene.integrator.method = method;
      const std::string what = entry.path().stem().string() + " by " + method;
      try {
        expectSameMotion(scene, 1, 20, what);
      } catch (const std::exception& refused) {
        ASSERT_STREQ(method, "taylor") << what << ": " << refused.what();  // a scene without series
      }
    }
  }
}

/// A machine with its integrator, as a simulation has them, step by step.
struct Stepped {
  explicit Stepped(const Scene& given) : scene(given), dynamics(std::make_unique<Dynamics>(scene)) {
    const int n = scene.chain.size();
    y = Eigen::VectorXd::Zero(dynamics->size());
    toAbsolute(scene.q.data(), n, y.data());
    toAbsolute(scene.qd.data(), n, y.data() + n);
    ode::Tolerance tolerance{1e-7, Eigen::ArrayXd::Constant(2 * n, 4.0), n};
    integrator = ode::stepsToEvents(ode::makeMethod("dopri5", *dynamics, 0, tolerance.inLaneOrder(*dynamics)),
                                    dynamics->effects().events(), *dynamics);
    dynamics->enter(0);
    dynamics->enterState(0, y.data());
    settle();
    integrator->begin();
  }
  void settle() {
    dynamics->hold(state.t, y.data());
    dynamics->toLaneOrder(y.data(), state.y.data());
  }
  void advance() {
    const auto outcome =
        integrator->advance(state, dynamics->effects().until(), dynamics->effects().longestStep());
    ASSERT_FALSE(ode::hasFailed(outcome));
    dynamics->toChainOrder(state.y.data(), y.data());
    if (outcome == ode::Outcome::switched) {
      ++switches;
      dynamics->fire(state.t, y.data(), integrator->event());
      settle();
      integrator->passEvent();
    }
  }

  const Scene scene;
  const std::unique_ptr<Dynamics> dynamics;
  Eigen::VectorXd y;
  ode::State state{dynamics->sizeInLaneOrder()};
  std::unique_ptr<ode::Integrator> integrator;
  int switches = 0;
};

TEST(Queries, OfEventsAtOtherStatesAndTimesChangeNoBit) {
  int switches = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const int n = seed % 4 == 0 ? 20 : 4;
    Scene scene = randomMachine(n, seed);
    scene.drives.clear();
    scene.loads.clear();
    Stepped plain(scene), asked(scene);
    test::Random random(seed);
    for (int k = 0; k < 200; ++k) {
      plain.advance();
      asked.advance();
      ASSERT_EQ(plain.state.t, asked.state.t) << seed;
      ASSERT_EQ(plain.y, asked.y) << "seed " << seed << " at " << plain.state.t;
      for (int queries = random.index(4); queries > 0; --queries) {
        // Another state, now or at another time. Its cache must not be taken for that of the motion.
        Eigen::VectorXd other = asked.y;
        for (int j = 0; j < 2 * n; ++j) other[j] += random.between(-1, 1) * (random.index(2) ? 1e-3 : 1);
        const double t = asked.state.t + (random.index(2) ? 0 : random.between(0, 1e-2));
        const Eigen::VectorXd accelerations = Eigen::VectorXd::Random(asked.dynamics->size());
        const int which = random.index(3);
        for (const ode::EventFunctions* events : asked.dynamics->effects().events()) {
          Eigen::VectorXd found = Eigen::VectorXd::Zero(events->most());
          if (which == 0) events->values(t, other.data(), found.data());
          if (which == 1) events->slopes(t, other.data(), accelerations.data(), found.data());
          if (which == 2) events->noise(t, other.data(), found.data());
        }
      }
    }
    switches += plain.switches;
  }
  EXPECT_GT(switches, 100);
}

}  // namespace
}  // namespace planar_chain
