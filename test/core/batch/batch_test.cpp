/// Batches: each run must be what it would be alone, whatever stands beside it.

#include "planar_chain/batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "effects/effect_kind.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::Random;
using test::randomScene;

const std::vector<double> times{0, 0.13, 0.5, 1};

/// A random chain of its own for each run.
void vary(std::size_t run, Scene& scene) {
  scene = randomScene(scene.chain.size(), static_cast<unsigned>(run), {run % 3 == 1, run % 6 == 1, false});
}

BatchResult batchOf(int n, std::size_t runs, const BatchOptions& options = {}) {
  return simulateMany(randomScene(n, 0), runs, vary, times, options);
}

/// States of one run.
std::vector<double> statesOf(const BatchResult& result, std::size_t run) {
  const std::size_t size = result.states.size() / result.runs.size();
  const auto first = result.states.begin() + static_cast<std::ptrdiff_t>(run * size);
  return {first, first + static_cast<std::ptrdiff_t>(size)};
}

bool sameBits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

/// The motion of one scene, by a simulation of a far smaller tolerance.
std::vector<double> exact(Scene scene) {
  scene.integrator.tolerance = 1e-12;
  Simulation simulation(scene);
  std::vector<double> states;
  for (const double t : times) {
    EXPECT_TRUE(simulation.advanceTo(t));
    states.insert(states.end(), simulation.q().begin(), simulation.q().end());
    states.insert(states.end(), simulation.qd().begin(), simulation.qd().end());
  }
  return states;
}

struct OfLength : testing::TestWithParam<int> {};

/// Angles always. Rates if they have a tolerance of their own.
TEST_P(OfLength, EachOfOneToFortyRunsMeetsItsTolerance) {
  const int n = GetParam();
  std::vector<std::vector<double>> alone;
  for (std::size_t run = 0; run < 40; ++run) {
    Scene scene = randomScene(n, 0);
    vary(run, scene);
    alone.push_back(exact(scene));
  }
  for (const bool ofRates : {false, true}) {
    const auto varyAll = [ofRates](std::size_t run, Scene& scene) {
      vary(run, scene);
      if (ofRates) scene.integrator.rateTolerance = scene.integrator.tolerance;
    };
    Scene like = randomScene(n, 0);
    varyAll(0, like);
    for (std::size_t runs = 1; runs <= 40; ++runs) {
      const BatchResult result = simulateMany(like, runs, varyAll, times);
      ASSERT_EQ(result.runs.size(), runs);
      for (std::size_t run = 0; run < runs; ++run) {
        ASSERT_EQ(result.runs[run].outcome, RunOutcome::done) << result.runs[run].reason;
        const std::vector<double> states = statesOf(result, run);
        for (std::size_t i = 0; i < states.size(); ++i) {
          const bool isRate = index(n) <= i % (2 * index(n));
          if (isRate && !ofRates) continue;
          ASSERT_NEAR(states[i], alone[run][i], 1e-8 * (1 + std::abs(alone[run][i]))) << runs << ' ' << run;
        }
      }
    }
  }
}

TEST_P(OfLength, BitsDependNeitherOnThreadsNorOnNeighbours) {
  const BatchResult all = batchOf(GetParam(), 19);
  for (const int threads : {1, 2, 3, 7}) {
    BatchOptions options;
    options.threads = threads;
    EXPECT_TRUE(sameBits(batchOf(GetParam(), 19, options).states, all.states)) << threads;
  }
  for (std::size_t run = 0; run < 19; ++run) {
    // Alone, and among others in another order.
    const auto only = [run](std::size_t, Scene& scene) { vary(run, scene); };
    const auto backwards = [](std::size_t k, Scene& scene) { vary(18 - k, scene); };
    const Scene scene = randomScene(GetParam(), 0);
    EXPECT_TRUE(sameBits(simulateMany(scene, 1, only, times).states, statesOf(all, run))) << run;
    EXPECT_TRUE(sameBits(statesOf(simulateMany(scene, 19, backwards, times), 18 - run), statesOf(all, run)));
  }
}

TEST_P(OfLength, LanesKeepTheRunsWhoseEnergyBalanceCloses) {
  if (GetParam() > 12) return;  // not in lanes
  const auto byTaylor = [](std::size_t run, Scene& scene) {
    vary(run, scene);
    scene.integrator.method = "taylor";
  };
  BatchOptions alone;
  alone.lanes = 1;
  const Scene like = randomScene(GetParam(), 0);
  const BatchResult lanes = simulateMany(like, 12, byTaylor, times);
  const BatchResult singles = simulateMany(like, 12, byTaylor, times, alone);
  for (std::size_t run = 0; run < 12; ++run) {
    // A run that a lane gives up has the bits of a single one.
    EXPECT_FALSE(sameBits(statesOf(lanes, run), statesOf(singles, run))) << run;
  }
}

INSTANTIATE_TEST_SUITE_P(Batch, OfLength, testing::Values(1, 2, 3, 5, 12, 13));

TEST(Batch, StartsOfOneScene) {
  Scene scene = randomScene(2, 3);
  const std::vector<double> starts{0.1, 0.2, 0.3, 0.4, 1, 2, 3, 4, -1, -2, -3, -4};
  const BatchResult result = simulateMany(scene, starts, times);
  ASSERT_EQ(result.runs.size(), 3u);
  for (std::size_t run = 0; run < 3; ++run) {
    const double* start = starts.data() + 4 * run;
    scene.q = {start[0], start[1]};
    scene.qd = {start[2], start[3]};
    const std::vector<double> expected = exact(scene), found = statesOf(result, run);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-7);
  }
  EXPECT_THROW(simulateMany(scene, {1, 2, 3}, times), std::invalid_argument);
  EXPECT_THROW(simulateMany(scene, starts, {1, 0.5}), std::invalid_argument);
  EXPECT_THROW(simulateMany(scene, starts, {-1}), std::invalid_argument);
  EXPECT_THROW(simulateMany(scene, starts, {std::nan("")}), std::invalid_argument);
  EXPECT_TRUE(simulateMany(scene, {}, times).runs.empty());
}

TEST(Batch, FailuresAreMarkedAndLeaveTheOthersAlone) {
  const auto spoil = [](std::size_t run, Scene& scene) {
    vary(run, scene);
    if (run == 2) throw std::runtime_error("no such run");
    if (run == 4) scene.q.pop_back();
    if (run == 6) scene = randomScene(3, 6);
    if (run == 8) scene.qd[0] = 1e200;  // its acceleration is not finite
    if (run == 9) scene.q[1] = std::nan("");
  };
  const BatchResult result = simulateMany(randomScene(2, 0), 12, spoil, times), good = batchOf(2, 12);
  for (std::size_t run = 0; run < 12; ++run) {
    const bool fails = run == 2 || run == 4 || run == 6 || run == 8 || run == 9;
    EXPECT_EQ(result.runs[run].outcome, fails ? RunOutcome::failed : RunOutcome::done) << run;
    EXPECT_EQ(result.runs[run].reason.empty(), !fails) << run;
    if (fails) {
      EXPECT_TRUE(std::isnan(statesOf(result, run).back())) << run;
    } else {
      EXPECT_TRUE(sameBits(statesOf(result, run), statesOf(good, run))) << run;
    }
  }
  EXPECT_EQ(result.runs[2].reason, "no such run");
}

/// Turns the first link with 1 N m in every scene, and needs no key for that.
class Push : public Effect {
 public:
  LoadKind mostActing() const override { return LoadKind::moments; }
  Powers apply(const ChainState& at, const Actions& to) override {
    to.N[0] += 1;
    return {at.omega[0], 0};
  }
  void addTorques(const ChainState& /*at*/, double* tau) override { tau[0] += 1; }
  Powers powersAlong(const ChainState& /*at*/, const StateChange& along) override { return {along.v[0], 0}; }
};

class PushKind : public EffectKind {
 public:
  std::unique_ptr<Effect> make(const Scene&) const override { return std::make_unique<Push>(); }
  void addDense(const Scene&, double, const Eigen::VectorXd&, const Eigen::VectorXd&,
                const DenseActions& to) const override {
    to.tau(0) += 1;
  }
  void summarize(const Scene&, SceneWords&) const override {}
};

TEST(Batch, NoKindOfEffectIsLeftOutInLanes) {
  const Scene scene = randomScene(2, 3, {true, true, false});
  const std::vector<double> starts{0.1, 0.2, 0.3, 0.4, 1, 2, 3, 4};
  const BatchResult before = simulateMany(scene, starts, times);
  const PushKind kind;
  const OtherEffectKinds kinds(kind);
  const BatchResult pushed = simulateMany(scene, starts, times);
  BatchOptions alone;
  alone.lanes = 1;
  const BatchResult expected = simulateMany(scene, starts, times, alone);
  EXPECT_TRUE(sameBits(pushed.states, expected.states));
  EXPECT_FALSE(sameBits(pushed.states, before.states));
}

/// Bits tell a lane from a simulation.
TEST(Batch, EachKindSaysWhatRunsInLanes) {
  const auto runsInLanes = [](auto change) {
    Scene scene = randomScene(2, 3, {true, true, false});
    std::vector<Joint> joints = scene.chain.joints();
    change(scene, joints[1]);
    scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
    BatchOptions alone;
    alone.lanes = 1;
    const std::vector<double> starts{0.1, 0.2, 0.3, 0.4};
    return !sameBits(simulateMany(scene, starts, times).states,
                     simulateMany(scene, starts, times, alone).states);
  };
  Load torque;
  torque.joint = 1;
  torque.torque = 2;
  EXPECT_TRUE(runsInLanes([](Scene&, Joint&) {}));
  EXPECT_TRUE(runsInLanes([&](Scene& scene, Joint&) { scene.loads = {torque}; }));
  EXPECT_TRUE(runsInLanes([](Scene&, Joint& joint) { joint.others = {{"effort_limit", 1}}; }));

  EXPECT_FALSE(runsInLanes([](Scene&, Joint& joint) {
    joint.upper = 9;
    joint.stopStiffness = 1;
  }));
  EXPECT_FALSE(runsInLanes([](Scene&, Joint& joint) { joint.others = {{"friction", 0.1}}; }));
  EXPECT_FALSE(runsInLanes([](Scene&, Joint& joint) { joint.others = {{"rotor_inertia", 0.1}}; }));
  EXPECT_FALSE(runsInLanes([](Scene& scene, Joint&) { scene.base.emplace(); }));
  EXPECT_FALSE(runsInLanes([&](Scene& scene, Joint&) {
    scene.loads = {torque};
    scene.loads[0].law = Sine{1, 0};
  }));
  EXPECT_FALSE(runsInLanes([&](Scene& scene, Joint&) {
    scene.loads = {torque};
    scene.loads[0].stop = 0.4;
  }));
}

TEST(Batch, ChainsWithPrismaticJointsHaveTheBitsOfSimulations) {
  // At every place: of a first link, of one within the chain, of the last one.
  for (const std::size_t place : {0u, 1u, 2u}) {
    Scene scene = randomScene(3, 5, {true, true, false});
    std::vector<Joint> joints = scene.chain.joints();
    joints[place].isPrismatic = true;
    joints[place].axis = {1, 0.5};
    scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
    const std::vector<double> starts{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 1, -0.5, 0.2, 2, 0, -1};
    const BatchResult result = simulateMany(scene, starts, times);
    for (std::size_t run = 0; run < 2; ++run) {
      const auto start = starts.begin() + static_cast<std::ptrdiff_t>(6 * run);
      scene.q.assign(start, start + 3);
      scene.qd.assign(start + 3, start + 6);
      Simulation simulation(scene);
      std::vector<double> expected;
      for (const double t : times) {
        ASSERT_TRUE(simulation.advanceTo(t));
        expected.insert(expected.end(), simulation.q().begin(), simulation.q().end());
        expected.insert(expected.end(), simulation.qd().begin(), simulation.qd().end());
      }
      ASSERT_EQ(result.runs[run].outcome, RunOutcome::done) << result.runs[run].reason;
      EXPECT_TRUE(sameBits(statesOf(result, run), expected)) << place;
    }
  }
}

/// The states of one run by a simulation in which the same torques are held.
std::vector<double> heldAlone(const Scene& scene, const double* torques) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  Simulation simulation(scene, 1);
  std::vector<double> states;
  for (const double t : times) {
    for (int j = 0; t > simulation.time() && j < scene.chain.size(); ++j) {
      EXPECT_TRUE(simulation.holdTorque(j, torques[j], forever));
    }
    torques += scene.chain.size();
    EXPECT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    states.insert(states.end(), simulation.q().begin(), simulation.q().end());
    states.insert(states.end(), simulation.qd().begin(), simulation.qd().end());
  }
  return states;
}

TEST(Batch, TorquesOfEachRunAreHeldBetweenTheTimes) {
  constexpr std::size_t runs = 11;
  for (const auto& [key, areInLanes] : {std::pair("", true),
                                        {"effort_limit", true},
                                        {"friction", false},
                                        {"motor/time_constant", false},
                                        {"command_delay", false}}) {
    Scene scene = randomScene(2, 3, {true, true, false});
    std::vector<Joint> joints = scene.chain.joints();
    if (*key != 0) joints[1].others = {{"effort_limit", 1}, {key, 0.2}};
    scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
    scene.loads.emplace_back();  // it adds to those held
    scene.loads[0].joint = 0;
    scene.loads[0].torque = 0.5;
    Random random(7);
    BatchOptions options;
    for (std::size_t k = 0; k < runs * times.size() * 2; ++k)
      options.torques.push_back(random.between(-3, 3));
    const auto same = [](std::size_t, Scene&) {};
    const BatchResult result = simulateMany(scene, runs, same, times, options);
    for (std::size_t run = 0; run < runs; ++run) {
      ASSERT_EQ(result.runs[run].outcome, RunOutcome::done) << result.runs[run].reason;
      const std::vector<double> states = statesOf(result, run),
                                expected = heldAlone(scene, &options.torques[run * times.size() * 2]);
      // A run that a lane gives up, as its energy balance does not close, has the bits of a single one.
      EXPECT_EQ(!sameBits(states, expected), areInLanes) << key << ' ' << run;
      for (std::size_t i = 0; i < states.size(); ++i) EXPECT_NEAR(states[i], expected[i], 1e-7) << key;
    }
  }
}

TEST(Batch, TorquesThatNobodyCanHoldAreRefused) {
  Scene scene = randomScene(2, 3);
  scene.drives = {{1, MotionLaw()}};
  BatchOptions options;
  const auto fault = [&] {
    try {
      simulateMany(scene, {1, 2, 3, 4, 5, 6, 7, 8}, {0.5, 1, 2}, options);
    } catch (const Refused& refused) {
      return std::string(refused.what());
    }
    return std::string("none");
  };
  options.torques.assign(11, 0);
  EXPECT_EQ(fault(), "torques: expected 2 x 3 x 2 numbers, for each run, time and joint, got 11");
  options.torques.push_back(0);
  EXPECT_EQ(fault(), "none");
  options.torques[8] = std::nan("");
  options.torques[3] = 0.1;
  EXPECT_EQ(fault(),
            "torques/1/1/0: expected a finite number, in N m, got nan\n"
            "torques/0/1/1: expected 0 N m in a driven joint, got 0.1");
}

TEST(Batch, ALoadOnNoBodyFailsItsRun) {
  Scene scene = randomScene(2, 3, {true, true, false});
  scene.loads.emplace_back();
  scene.loads[0].joint = 2;
  const BatchResult result = simulateMany(scene, {0.1, 0.2, 0.3, 0.4}, times);
  EXPECT_EQ(result.runs[0].reason, "load  acts on no body of the chain");
}

TEST(Batch, CanBeCancelled) {
  const Scene endless = randomScene(2, 0, {false, false, false});
  const std::vector<double> starts{1, 2, 0, 0, 2, 1, 0, 0, 0, 3, 0, 0}, never{1e9};
  BatchOptions options;
  int calls = 0;
  options.keepGoing = [&](std::size_t) { return ++calls < 2; };
  const BatchResult result = simulateMany(endless, starts, never, options);
  EXPECT_EQ(calls, 2);
  for (const BatchRun& run : result.runs) EXPECT_EQ(run.outcome, RunOutcome::cancelled);

  options.keepGoing = [](std::size_t) -> bool { throw std::runtime_error("out"); };
  EXPECT_THROW(simulateMany(endless, starts, never, options), std::runtime_error);
}

}  // namespace
}  // namespace planar_chain
