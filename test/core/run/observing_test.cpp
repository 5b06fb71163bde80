/// Queries change nothing: a simulation that is queried between all calls and one that never is go through
/// the same states, bit for bit. Machines, calls and queries are drawn from fixed seeds.

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "busy_machines.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/sensors.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

using test::anyCall;
using test::areSame;
using test::Call;
using test::Random;
using test::refusal;

// ---- Queries -------------------------------------------------------------------------------------

/// Makes a query, any of them.
void query(Simulation& of, Random& random) {
  const std::size_t n = of.q().size();
  std::vector<double> numbers(n);
  std::vector<LinkMotion> motions(n);
  const std::function<void()> all[] = {
      [&] { of.energy(); },
      [&] { of.energyBalance(); },
      [&] { of.accelerations(numbers.data()); },
      [&] { of.jointTorques(numbers.data()); },
      [&] { of.linkMotions(motions.data()); },
      [&] { of.baseWrench(); },
      [&] { of.tipForce(); },
      [&] { of.closureError(); },
      [&] { of.closureMargin(); },
      [&] { of.measure(); },
      [&] { of.commands(); },
      [&] { of.statistics(); },
      [&] {
        const auto size = static_cast<Eigen::Index>(n);
        linearModel(of.scene(), of.time(), Eigen::VectorXd::Map(of.q().data(), size),
                    Eigen::VectorXd::Map(of.qd().data(), size));
      },
  };
  all[random.index(static_cast<int>(std::size(all)))]();
}

/// Makes these calls, one simulation being queried between them. Returns the first after which it has gone
/// another way than one that is not; "": none.
std::string difference(const Scene& scene, unsigned seed) {
  constexpr int calls = 40, mostQueries = 3;
  constexpr unsigned seedOfQueries = 1000;
  Random random(seed), queries(seed + seedOfQueries);
  Simulation queried(scene, 100, true), alone(scene, 100, true);
  for (int k = 0; k < calls; ++k) {
    for (int left = queries.index(mostQueries + 1); left > 0; --left) query(queried, queries);
    const Call call = anyCall(scene, random);
    const std::string refused = refusal(call, alone);
    if (refusal(call, queried) != refused) return "call " + std::to_string(k) + " is refused: " + refused;
    if (!areSame(queried.q(), alone.q()) || !areSame(queried.qd(), alone.qd()))
      return "state after call " + std::to_string(k);
  }
  if (queried.statistics().steps != alone.statistics().steps) return "steps";
  return queried.cutOffs() == alone.cutOffs() ? "" : "torques that were cut off";
}

TEST(Observing, ChangesNoBitOfTheMotion) {
  test::forEachMachine(6, [](const Scene& scene, unsigned seed) { EXPECT_EQ(difference(scene, seed), ""); });
}

}  // namespace
}  // namespace planar_chain
