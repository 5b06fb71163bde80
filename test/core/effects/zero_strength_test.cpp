/// Leaving out changes nothing: an effect of strength zero gives the motion of none, bit for bit; and where
/// it does not, the motion of none with exactly what the effect asks of the steps.
///
/// What is zero may be left out, and then there is nothing to compare. So each effect also stands there with
/// a strength that drowns in every rounding: all of it runs, and the bits must be the same.

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "dynamics/dynamics.h"
#include "ode/local_stiffness.h"
#include "ode/methods.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::randomScene;

constexpr double pi = 3.14159265358979323846;
constexpr double forever = std::numeric_limits<double>::infinity();
constexpr double trace = 1e-300;
constexpr double interval = 0.037;  // between the times that are compared; no multiple of a step
constexpr int intervals = 4;

// ---- Motions ---------------------------------------------------------------------------------

/// q and q̇ of all joints at all times, and the steps that led there.
struct Motion {
  std::vector<double> values;
  long long steps = 0, rejected = 0, rescues = 0;
};

/// To the last bit, signs of zeros included.
testing::AssertionResult same(const Motion& a, const Motion& b) {
  if (a.values.size() != b.values.size()) return testing::AssertionFailure() << "of different lengths";
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    if (std::memcmp(&a.values[i], &b.values[i], sizeof a.values[i]) == 0) continue;
    return testing::AssertionFailure()
           << "value " << i << " of " << a.values.size() << ": " << a.values[i] << " and "
           << b.values[i] - a.values[i] << " more; steps " << a.steps << " and " << b.steps;
  }
  if (a.steps != b.steps || a.rejected != b.rejected) return testing::AssertionFailure() << "by other steps";
  return testing::AssertionSuccess();
}

using Command = std::function<void(Simulation&)>;

/// command: given before interval `when`.
Motion motionOf(
    const Scene& scene, int room = 0, const Command& command = [](Simulation&) {}, int when = 0) {
  Simulation simulation(scene, room);
  Motion motion;
  for (int k = 0; k < intervals; ++k) {
    if (k == when) command(simulation);
    EXPECT_TRUE(simulation.advanceTo((k + 1) * interval)) << simulation.fault();
    for (const auto* now : {&simulation.q(), &simulation.qd()}) {
      motion.values.insert(motion.values.end(), now->begin(), now->end());
    }
  }
  motion.steps = simulation.statistics().steps;
  motion.rejected = simulation.statistics().rejected;
  motion.rescues = simulation.statistics().rescues;
  return motion;
}

ode::State startOf(const Scene& scene, const Dynamics& dynamics) {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size());
  const int n = scene.chain.size();
  double theta = 0, omega = 0;
  for (int i = 0; i < n; ++i) {
    y[i] = theta += scene.q[static_cast<std::size_t>(i)];
    y[n + i] = omega += scene.qd[static_cast<std::size_t>(i)];
  }
  return {dynamics, y};
}

/// What is asked of the steps: none longer, and to land on these times and begin anew there.
struct Steps {
  double longest = forever;
  std::set<double> restarts;
};

/// The motion by the integrator alone, without Simulation. For scenes without loads and limits.
Motion motionByHand(Scene scene, const Steps& steps = {}) {
  const int n = scene.chain.size();
  Dynamics dynamics(scene);
  ode::Tolerance tolerance{scene.integrator.tolerance, Eigen::ArrayXd::Constant(2 * n, forever), n};
  tolerance.ceiling.head(n) = 1 + pi;
  const auto integrator =
      ode::makeMethod(scene.integrator.method, dynamics, scene.integrator.step, tolerance);
  ode::State state = startOf(scene, dynamics);
  integrator->begin();

  Motion motion;
  std::set<double> ends = steps.restarts;
  for (int k = 1; k <= intervals; ++k) ends.insert(k * interval);
  int k = 1;
  for (const double end : ends) {
    EXPECT_EQ(integrator->integrate(state, end, steps.longest), ode::Outcome::arrived);
    if (steps.restarts.count(end) > 0) integrator->restart();
    if (end != k * interval) continue;
    ++k;
    const Eigen::VectorXd y = state.restoredBy(dynamics);
    for (int i = 0; i < n; ++i) motion.values.push_back(relative(y.data(), i));
    for (int i = 0; i < n; ++i) motion.values.push_back(relative(y.data() + n, i));
  }
  motion.steps = integrator->count().accepted;
  motion.rejected = integrator->count().rejected;
  return motion;
}

// ---- Effects ---------------------------------------------------------------------------------

/// The scene with other links, joints or gravity.
template <class Change>
Scene changed(Scene scene, Change&& change) {
  std::vector<Link> links = scene.chain.links();
  std::vector<Joint> joints = scene.chain.joints();
  Vec2d gravity = scene.chain.gravity();
  change(links, joints, gravity);
  scene.chain = Chain(links, joints, gravity);
  return scene;
}

Scene withGravity(const Scene& scene, double strength) {
  return changed(scene, [=](auto&, auto&, Vec2d& gravity) { gravity = {strength, strength}; });
}

Scene withOffsets(const Scene& scene, double strength) {
  return changed(scene, [=](auto& links, auto&, auto&) {
    for (Link& link : links) link.com.y = link.pin.y = strength;
  });
}

/// None that is ever reached.
Scene withLimits(const Scene& scene, double) {
  return changed(scene, [](auto&, auto& joints, auto&) {
    for (Joint& joint : joints) {
      joint.lower = -1000;
      joint.upper = 1000;
      joint.stopStiffness = 1e4;
      joint.stopDamping = 1;
    }
  });
}

Scene withLoad(Scene scene, const Load& load) {
  scene.loads.push_back(load);
  scene.loads.back().name = "nothing";
  return scene;
}

/// In the middle joint.
Load torqueOf(const Scene& scene, double strength) {
  Load load;
  load.joint = scene.chain.size() / 2;
  load.torque = strength;
  return load;
}

/// At a point of the last link.
Load forceOf(const Scene& scene, double strength) {
  Load load;
  load.link = scene.chain.size() - 1;
  load.force = {strength, -strength};
  load.point = {0.3, 0.1};
  return load;
}

Load momentOf(const Scene& scene, double strength) {
  Load load;
  load.link = scene.chain.size() / 2;
  load.moment = strength;
  return load;
}

/// So slow that no step is a quarter of its period.
Scene withSine(const Scene& scene, double strength) {
  Load load = forceOf(scene, strength);
  load.law = Sine{1e-3, 1};
  return withLoad(scene, load);
}

/// Its corners lie before the start and after the end.
Scene withRamp(const Scene& scene, double strength) {
  Load load = torqueOf(scene, 1);
  load.law = Ramp{{-1, 10}, {strength, 3 * strength}};
  return withLoad(scene, load);
}

template <Load (*loadOf)(const Scene&, double)>
Scene with(const Scene& scene, double strength) {
  return withLoad(scene, loadOf(scene, strength));
}

struct Row {
  std::string name;
  std::function<Scene(const Scene&, double strength)> with;
};

/// In every joint where it is 0.
Row rowOf(const JointKey& key) {
  return {std::string("joint/") + key.name, [key](const Scene& scene, double strength) {
            return changed(scene, [=](auto&, auto& joints, auto&) {
              for (Joint& joint : joints) {
                if (key.of(joint) != 0) continue;
                key.member ? void(joint.*key.member = strength) : joint.others.set(key.name, strength);
              }
            });
          }};
}

/// True if a trace makes an effect, and leaves the recursion and the ends of steps as they are.
bool isComparable(const Row& row) try {
  const Scene scene = row.with(randomScene(3, 1, {false, false, false}), trace);
  const Effects effects(scene);
  return !effects.empty() && effects.jointConstraints().empty() && effects.events().empty();
} catch (const Refused&) {
  return false;  // the key needs others beside it
}

/// A row for every key of joints that is comparable by itself, and for what needs more than a number.
std::vector<Row> allRows() {
  std::vector<Row> rows{{"limits", withLimits},     {"torque", with<torqueOf>}, {"force", with<forceOf>},
                        {"moment", with<momentOf>}, {"sine", withSine},         {"ramp", withRamp}};
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (isComparable(rowOf(key))) rows.push_back(rowOf(key));
    }
  }
  return rows;
}

constexpr double strengths[] = {0, trace};

// ---- Every method, short and long chains -----------------------------------------------------

class ZeroStrength : public testing::TestWithParam<std::tuple<std::string, int>> {
 protected:
  static int size() { return std::get<1>(GetParam()); }
  static Scene byMethod(Scene scene) {
    const std::string& method = std::get<0>(GetParam());
    scene.integrator = {method, method == "ros34pw2" ? 1e-3 : 1e-6, 0.0007};
    return scene;
  }
  /// Gravity and general offsets.
  static Scene bare() {
    return byMethod(randomScene(size(), 30 + static_cast<unsigned>(size()), {false, false, false}));
  }
  /// Loads of every kind, springs in every second joint, dampers in every third.
  static Scene full() {
    const Scene scene = randomScene(size(), 40 + static_cast<unsigned>(size()));
    return byMethod(changed(scene, [](auto&, auto& joints, auto&) {
      for (std::size_t i = 0; i < joints.size(); ++i) {
        if (i % 2 == 1) joints[i].stiffness = 0;
        if (i % 3 != 2) joints[i].damping = 0;
      }
    }));
  }
};

TEST_P(ZeroStrength, IsAbsence) {
  const std::vector<Row> rows = allRows();
  EXPECT_GE(rows.size(), 8U) << "stiffness and damping are comparable";
  for (const bool isBare : {true, false}) {
    const Scene scene = isBare ? bare() : full();
    SCOPED_TRACE(isBare ? "alone" : "beside others");
    const Motion none = motionOf(scene);
    EXPECT_EQ(none.rescues, 0) << "the guard is to have no reason";
    for (const Row& row : rows) {
      for (const double strength : strengths) {
        SCOPED_TRACE(row.name + (strength == 0 ? " of 0" : " of a trace"));
        EXPECT_TRUE(same(none, motionOf(row.with(scene, strength))));
      }
    }
  }
}

TEST_P(ZeroStrength, OfGravityAndOffsetsIsAbsence) {
  for (const Row& row : {Row{"gravity", withGravity}, Row{"offsets", withOffsets}}) {
    const Motion none = motionOf(row.with(bare(), 0.0));
    for (const double strength : {-0.0, trace}) {
      EXPECT_TRUE(same(none, motionOf(row.with(bare(), strength)))) << row.name << ' ' << strength;
    }
  }
}

TEST_P(ZeroStrength, OfCommandsIsAbsence) {
  const int last = size() - 1;
  for (const bool isBare : {true, false}) {
    const Scene scene = isBare ? bare() : full();
    SCOPED_TRACE(isBare ? "alone" : "beside others");
    const Motion none = motionOf(scene);
    EXPECT_TRUE(same(none, motionOf(scene, 4))) << "room for commands";
    for (const double strength : strengths) {
      const auto hold = [=](Simulation& simulation) {
        simulation.holdTorque(last / 2, strength, forever);
        simulation.holdForce(last, {0.3, 0.1}, {strength, strength}, strength, forever);
      };
      EXPECT_TRUE(same(none, motionOf(scene, 4, hold))) << "held " << strength;
      const auto push = [=](Simulation& simulation) {
        simulation.addTorque(last / 2, strength, 10);
        simulation.addForce(last, {0.3, 0.1}, {strength, strength}, strength, 10);
      };
      EXPECT_TRUE(same(none, motionOf(scene, 4, push))) << "timed " << strength;
    }
  }
}

TEST_P(ZeroStrength, OfTheGuardIsAbsence) {
  const Motion guarded = motionOf(bare());
  EXPECT_EQ(guarded.rescues, 0);
  EXPECT_TRUE(same(motionByHand(bare()), guarded));
}

// ---- What even a trace asks of the steps -----------------------------------------------------

TEST_P(ZeroStrength, OfASineLimitsTheStepAndNothingElse) {
  const double frequency = 400;
  Load load = forceOf(bare(), trace);
  load.law = Sine{frequency, 1};
  const Motion motion = motionOf(withLoad(bare(), load));
  EXPECT_TRUE(same(motionByHand(bare(), {0.25 / frequency, {}}), motion));
  if (ode::hasFixedStep(bare().integrator.method)) {
    EXPECT_TRUE(same(motionOf(bare()), motion)) << "equal steps are as they were asked for";
  }
}

TEST_P(ZeroStrength, OfWindowsAndCornersBeginsANewStepThereAndNothingElse) {
  Load window = momentOf(bare(), trace);
  window.start = 0.0423;
  window.stop = 0.1456;
  EXPECT_TRUE(same(motionByHand(bare(), {forever, {0.0423, 0.1456}}), motionOf(withLoad(bare(), window))))
      << "window";

  Load ramp = torqueOf(bare(), trace);
  ramp.law = Ramp{{0.05, 0.08, 0.1345}, {0, 1, -1}};
  EXPECT_TRUE(same(motionByHand(bare(), {forever, {0.05, 0.08, 0.1345}}), motionOf(withLoad(bare(), ramp))))
      << "ramp";
}

TEST_P(ZeroStrength, OfACommandOnTheWayBeginsANewStepThereAndNothingElse) {
  const auto hold = [](Simulation& simulation) { simulation.holdTorque(0, trace, forever); };
  const Motion motion = motionOf(bare(), 4, hold, 3);
  EXPECT_TRUE(same(motionByHand(bare(), {forever, {3 * interval}}), motion));
  if (ode::hasFixedStep(bare().integrator.method)) {
    EXPECT_TRUE(same(motionOf(bare()), motion)) << "equal steps go on as they were";
  }
}

// ---- Works that nothing does -----------------------------------------------------------------

/// Where steps are as long as the largest eigenvalue lets them be, its last bit is in every step.
TEST(ZeroStrengthOf, WorksIsAbsenceInTheLargestEigenvalue) {
  for (int n = 1; n <= 40; ++n) {
    const auto eigenvalueOf = [n](const Scene& scene) {
      Dynamics dynamics(scene);
      ode::LocalStiffness stiffness(dynamics);
      stiffness.update(0, startOf(scene, dynamics).y);
      return stiffness.largestEigenvalue();
    };
    const Scene bare = randomScene(n, static_cast<unsigned>(n), {false, false, false});
    const Scene traced = changed(bare, [](auto&, auto& joints, auto&) {
      for (Joint& joint : joints) joint.damping = trace;
    });
    EXPECT_EQ(eigenvalueOf(bare), eigenvalueOf(traced)) << "damping of " << n;
    EXPECT_EQ(eigenvalueOf(bare), eigenvalueOf(with<momentOf>(bare, 0))) << "moment on " << n;
  }
}

/// A rod let go level turns back at −π, a millionth before its limit: there the integrator looks between the
/// ends of a step, and must leave nothing of that behind.
TEST(ZeroStrengthOf, ALimitIsAbsenceButForWhatAMethodKeepsFromStepToStep) {
  for (const std::string& method : ode::methodNames()) {
    Scene scene{Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {{"rod_joint"}}, {0, -9.81}),
                {0},
                {0},
                {},
                {method, 1e-8, 0.01, false, 1e-8},  // steps so short that all methods look
                {},
                0};
    const auto endOf = [](const Scene& of) {
      Simulation simulation(of);
      EXPECT_TRUE(simulation.advanceTo(2.5));
      return std::make_tuple(simulation.q()[0], simulation.statistics().evaluations,
                             simulation.statistics().rejected);
    };
    const auto [free, itsEvaluations, itsRejected] = endOf(scene);
    const auto limited = changed(scene, [](auto&, auto& joints, auto&) {
      joints[0].lower = -pi - 1e-6;
      joints[0].stopStiffness = 1;
    });
    const auto [q, evaluations, rejected] = endOf(limited);
    const bool looksAtItsSeries = method == "taylor" || method == "auto";
    if (looksAtItsSeries) {
      EXPECT_EQ(evaluations, itsEvaluations) << method;
      EXPECT_EQ(rejected, itsRejected) << method << ": to look at a series costs nothing";
    } else {
      EXPECT_GT(evaluations, itsEvaluations) << method << " has not looked";
      EXPECT_GE(rejected, itsRejected) << method << ": steps to look count";
    }
    if (looksAtItsSeries || method == "rk4" || method.substr(0, 3) == "ros" ||
        method == "rodas5p") {  // keep nothing
      EXPECT_EQ(q, free) << method;
    } else {
      EXPECT_NEAR(q, free, 1e-9) << method;
    }
  }
}

#ifdef __SANITIZE_ADDRESS__  // or it takes minutes
const auto lengths = testing::Values(1, 3, 20);
#else
const auto lengths = testing::Values(1, 2, 3, 8, 20, 60);
#endif
INSTANTIATE_TEST_SUITE_P(Scenes, ZeroStrength,
                         testing::Combine(testing::ValuesIn(ode::methodNames()), lengths),
                         [](const auto& scene) {
                           return std::get<0>(scene.param) + "_" + std::to_string(std::get<1>(scene.param));
                         });

}  // namespace
}  // namespace planar_chain
