/// Stops that are reached and left again within one step, against scipy with events:
/// test/reference/missed_events/stops.py.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "planar_chain/simulation.h"
#include "support/reference_data.h"

namespace planar_chain {
namespace {

struct MissedEvent {
  const char* name;
  std::array<double, 3> q;  ///< at 0.3 s
};

class MissedEvents : public testing::TestWithParam<MissedEvent> {};

std::vector<double> after(Scene scene, const char* method, double tolerance, int rows) {
  scene.integrator.method = method;
  scene.integrator.tolerance = tolerance;
  Simulation simulation(scene);
  for (int k = 1; k <= rows; ++k) EXPECT_TRUE(simulation.advanceTo(0.3 * k / rows)) << simulation.fault();
  return simulation.q();
}

TEST_P(MissedEvents, AreSeenByEveryMethod) {
  for (const double beside : {0.0, 1e-9, 1e-6}) {
    Scene scene = test::referenceScene(std::string("missed_events/") + GetParam().name + ".yaml");
    scene.q[1] += beside;
    // A step ends within the dip.
    const std::vector<double> exact = after(scene, "dopri5", 1e-12, 300);
    if (beside == 0) {
      for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(exact[i], GetParam().q[i], 1e-10);
    }
    for (const char* method : {"auto", "taylor", "dop853", "dopri5", "rodas5p", "radau13", "ros34pw2"}) {
      for (const double tolerance : {1e-3, 1e-4, 1e-6, 1e-8}) {
        for (const int rows : {1, 6}) {
          const std::vector<double> found = after(scene, method, tolerance, rows);
          for (std::size_t i = 0; i < 3; ++i)
            EXPECT_NEAR(found[i], exact[i], 3 * tolerance) << method << " to " << tolerance << ", " << rows
                                                           << " rows, " << beside << " rad beside the limit";
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, MissedEvents,
                         testing::Values(MissedEvent{"hard", {0.940196662562, -1.53308802352, 0.19532430213}},
                                         MissedEvent{"soft",
                                                     {-1.391405711924, -1.152291724824, 0.194536727158}}),
                         [](const auto& one) { return std::string(one.param.name); });

/// A motor that comes to its torque–speed line and leaves it within a step.
struct Pulse {
  int joint;
  double torque, start, end;
};

std::vector<double> motorsAfter(const char* scene, const std::vector<Pulse>& pulses, double end,
                                const char* method, double tolerance, int rows) {
  Scene read = test::referenceScene(std::string("missed_events/") + scene + ".yaml");
  read.integrator.method = method;
  read.integrator.tolerance = tolerance;
  Simulation simulation(read, 4);
  for (const Pulse& pulse : pulses)
    EXPECT_TRUE(simulation.addTorque(pulse.joint, pulse.torque, pulse.end - pulse.start, pulse.start));
  for (int k = 1; k <= rows; ++k) EXPECT_TRUE(simulation.advanceTo(end * k / rows)) << simulation.fault();
  std::vector<double> state = simulation.q();
  state.insert(state.end(), simulation.qd().begin(), simulation.qd().end());
  return state;
}

TEST(Motors, ComeToTheirLineAndLeaveItWithinAStep) {
  const std::vector<Pulse> one{{0, -0.5, 0, 0.2}, {0, 0.1, 0.2, 1}},
      three{{2, 8, 0, 0.05}, {2, -0.1, 0.2, 0.3}};
  const std::vector<double> exact = motorsAfter("motors", three, 0.5, "dopri5", 1e-12, 500);
  for (const char* method : {"auto", "taylor", "dop853", "dopri5", "rodas5p", "radau13"}) {
    for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
      for (const int rows : {1, 5, 50}) {
        SCOPED_TRACE(std::string(method) + " to " + std::to_string(tolerance) + ", " + std::to_string(rows) +
                     " rows");
        const std::vector<double> found = motorsAfter("motor", one, 0.25, method, tolerance, rows);
        EXPECT_NEAR(found[0], 1.242007270245, 0.1 * tolerance);  // test/reference/missed_events/motor.py
        EXPECT_NEAR(found[1], -16.00115176003, 20 * tolerance);
        const std::vector<double> others = motorsAfter("motors", three, 0.5, method, tolerance, rows);
        for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(others[i], exact[i], 0.1 * tolerance);
      }
    }
  }
}

}  // namespace
}  // namespace planar_chain
