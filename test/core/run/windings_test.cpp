/// Angles of many turns: no digit of the motion is lost, whether the angles are given or reached.

#include "run/windings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/known_chains.h"

namespace planar_chain {
namespace {

constexpr double turn = 2 * pi;

Scene pendulum(double q, double qd) {
  return {Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {{"rod_joint"}}, {0, -9.81}),
          {q},
          {qd},
          {},
          {"dop853", 1e-13, 1e-3},
          {},
          0};
}

// The remainders were computed with 60 digits (mpmath).
TEST(Windings, ThatAreGivenChangeNoDigitOfTheMotion) {
  struct Case {
    double q, rest;
  };
  for (const Case& c :
       {Case{1e12, -0.6576247591367864}, {1e14, -2.9306228418827818}, {5e16, -1.3292443685473403}}) {
    Simulation far(pendulum(c.q, 0)), near(pendulum(c.rest, 0));
    ASSERT_TRUE(far.advanceTo(1) && near.advanceTo(1));
    EXPECT_NEAR(far.qd()[0], near.qd()[0], 1e-13);
    EXPECT_NEAR(far.energy().total(), near.energy().total(), 1e-13);
    EXPECT_EQ(far.q()[0], static_cast<double>(c.q + static_cast<long double>(near.q()[0] - c.rest)));
    LinkMotion motion;
    far.linkMotions(&motion);
    EXPECT_EQ(motion.angle, far.q()[0]);
  }
}

// The base joint turns 3000 rad and comes to the same state as from three turns less; q counts them all.
TEST(Windings, ThatAreMadeAreCountedAndLoseNothing) {
  Scene scene = pendulum(0.3, 300);
  Simulation straight(scene);
  ASSERT_TRUE(straight.advanceTo(10));
  EXPECT_GT(straight.q()[0], 2900);
  EXPECT_NEAR(straight.energyBalance().residual, 0, 1e-8);

  Simulation parts(scene);
  double turns = 0;
  for (int k = 1; k <= 100; ++k) {
    ASSERT_TRUE(parts.advanceTo(0.1 * k));
    const double whole = std::floor(parts.q()[0] / turn);
    turns += whole;
    parts.setState({parts.q()[0] - turn * whole}, parts.qd());
  }
  EXPECT_NEAR(straight.q()[0], parts.q()[0] + turn * turns, 1e-8);
  EXPECT_NEAR(straight.qd()[0], parts.qd()[0], 1e-8);
}

struct Rest : ode::System {
  int size() const override { return 4; }
  void derivative(double, const double*, double* dydt) override { std::fill_n(dydt, 4, 0.0); }
};

// 1000 turns less, to the last bit of state and carry; the link outside follows, at the same relative angle.
TEST(Windings, AreTakenOffTheStateAndItsCarry) {
  constexpr long double exactTurn = 6.283185307179586476925286766559L;
  const Chain chain({{"rod", 1, 1, {0, 0}, {1, 0}}, {"end", 1, 1, {0, 0}, {1, 0}}}, {{"a"}, {"b"}}, {});
  Windings windings({chain, {0, 0}, {0, 0}, {}, {}, {}}, 4);
  ode::State state(4);
  Eigen::VectorXd y = (Eigen::VectorXd(4) << 6284.1, 6283.9, 7, 8).finished();
  state.y = y;
  state.carry << 1e-13, -2e-13, 0, 0;
  ASSERT_TRUE(windings.takeMore(Rest(), state, y));
  for (const int i : {0, 1}) {
    const long double given = (i == 0 ? 6284.1 : 6283.9) + (i == 0 ? 1e-13L : -2e-13L);
    const long double rest = static_cast<long double>(state.y[i]) + static_cast<long double>(state.carry[i]);
    EXPECT_NEAR(static_cast<double>(rest + 1000 * exactTurn - given), 0, 2e-18) << i;
    EXPECT_EQ(y[i], state.y[i]);
    EXPECT_LT(std::abs(state.carry[i]), 1e-15) << i;
  }
  EXPECT_EQ(y[2], 7);
  std::vector<double> q{y[0], y[1] - y[0]};
  windings.addTo(q);
  EXPECT_DOUBLE_EQ(q[0], 6284.1);
  EXPECT_NEAR(q[1], -0.2, 2e-12);
  EXPECT_FALSE(windings.takeMore(Rest(), state, y));
}

// Without gravity a chain of one centre turns steadily: 1e6 rad/s for 1000 s, and the angle is exact.
TEST(Windings, OfAWheelAreCountedForABillionRadians) {
  Scene scene{Chain({{"wheel", 1, 1, {0, 0}, {0, 0}}, {"inner", 1, 1, {0, 0}, {0, 0}}},
                    {{"wheel_joint"}, {"inner_joint"}}, {}),
              {1, 2},
              {1e6, -2e6},
              {},
              {"rk4", 1e-8, 1e-4},
              {},
              0};
  Simulation simulation(scene);
  ASSERT_TRUE(simulation.advanceTo(20));
  EXPECT_DOUBLE_EQ(simulation.q()[0], 1 + 2e7);
  EXPECT_DOUBLE_EQ(simulation.q()[1], 2 - 4e7);
}

// A spring counts turns: they stay in the state.
TEST(Windings, StayInAJointThatStoresEnergy) {
  Scene scene = test::uniformChain(2, {"", 1, 1, {0, 0}, {1, 0}}, {}, {}, {});
  std::vector<Joint> joints = scene.chain.joints();
  joints[1].stiffness = 1e-3;
  scene.chain = Chain(scene.chain.links(), joints, {});
  scene.q = {1e9, 1e5};
  Simulation simulation(scene);
  EXPECT_DOUBLE_EQ(simulation.energy().total(), 0.5 * 1e-3 * 1e10);
  std::vector<double> torque(2);
  simulation.jointTorques(torque.data());
  EXPECT_DOUBLE_EQ(torque[1], -1e-3 * 1e5);
  ASSERT_TRUE(simulation.advanceTo(0.1)) << simulation.fault();
  EXPECT_NEAR(simulation.energyBalance().residual / simulation.energy().total(), 0, 1e-9);
}

TEST(Windings, ThatADoubleCannotCountAreRefusedAndTheStateIsKept) {
  Simulation simulation(pendulum(1e12, 2));
  EXPECT_THROW(simulation.setState({1e17}, {0}), std::invalid_argument);
  EXPECT_THROW(simulation.setState({0}, {1e200}), std::invalid_argument);
  EXPECT_EQ(simulation.q()[0], 1e12);
  ASSERT_TRUE(simulation.advanceTo(0.1));
  EXPECT_NEAR(simulation.q()[0] - 1e12, 0.2, 0.1);
}

/// v²/(2 a) = 5000 rad, in one stretch of the run. The other joint turns on.
TEST(Windings, AreCountedOnceWhereFrictionHolds) {
  for (const char* method : {"auto", "taylor", "dop853", "rodas5p", "radau13"}) {
    for (const int rows : {1, 4, 200}) {
      Scene scene = readSceneText(
          "chain: [a, b]\ngravity: [0, 0]\nlinks:\n"
          "  a: {mass: 1, inertia: 1, com: [0, 0], pin: [0, 0], joint: {friction: 1}, initial: {velocity: "
          "100}}\n"
          "  b: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0], initial: {velocity: -90}}\n");
      scene.integrator.method = method;
      Simulation simulation(scene);
      for (int k = 1; k <= rows; ++k)
        ASSERT_TRUE(simulation.advanceTo(200.0 * k / rows)) << simulation.fault();
      EXPECT_EQ(simulation.qd()[0], 0);
      EXPECT_NEAR(simulation.q()[0], 5000, 1e-6) << method << ", " << rows << " rows";
      EXPECT_NEAR(simulation.q()[1], 10 * 200 - 5000, 1e-5) << method << ", " << rows << " rows";
    }
  }
}

}  // namespace
}  // namespace planar_chain
