/// Random machines that hit their stops: every adaptive method against dop853 at a fine tolerance.
///
/// The motions are short, so an error is still multiplied by what a small change of the start is multiplied
/// by: the growth g. An error of at most `tolerance` a second then becomes tolerance · t · g, if the
/// tolerance of rates is given, too. Without it a rate's error counts as that of the angle that it causes
/// during the contact (ode/integrator.h). It stays when the contact is over, and only angles are compared.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "contact_machine.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"

namespace planar_chain {
namespace {

using test::contactMachine;
using test::Random;

constexpr double t = 0.1;  // s: some contacts each, of which a hard one takes 1 ms

struct Result {
  bool hasSeries = true, hasArrived = false;
  std::vector<double> q, qd;
  double energy = 0, residual = 0;
  long long evaluations = 0;
  std::string fault;
};

Result after(Scene scene, const std::string& method, double tolerance) {
  scene.integrator.method = method;
  scene.integrator.tolerance = tolerance;
  Result result;
  try {
    Simulation simulation(scene);
    constexpr int most = 10000;  // calls: far beyond what any method needs
    int calls = 0;
    result.hasArrived = simulation.advanceTo(t, [&calls] { return ++calls < most; });
    result.fault = calls < most ? simulation.fault() : "far too many steps";
    result.q = simulation.q();
    result.qd = simulation.qd();
    const EnergyBalance balance = simulation.energyBalance();
    result.energy = balance.now.kinetic + balance.now.potential;
    result.residual = balance.residual;
    result.evaluations = simulation.statistics().evaluations;
  } catch (const std::invalid_argument& reason) {
    EXPECT_EQ(method, "taylor") << reason.what();
    result.hasSeries = false;
  }
  return result;
}

/// The largest difference of two, in 1 + their size.
double apart(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(
      a.begin(), a.end(), b.begin(), 0.0, [](double x, double y) { return std::max(x, y); },
      [](double x, double y) { return std::abs(x - y) / (1 + std::abs(x)); });
}

/// By what a small change of the start is multiplied: in angles, in rates, and in the energy.
struct Growth {
  double ofAngles = 1, ofRates = 1, ofEnergy = 1;
};

Growth growthOf(const Scene& scene, const Result& exact, double fine, unsigned seed) {
  // Far above the errors at `fine`, far below the ways into the softest stops.
  constexpr double change = 1e-8;
  Growth growth;
  for (unsigned k = 0; k < 3; ++k) {
    Scene beside = scene;
    Random random(3 * seed + k);
    for (std::size_t i = 0; i < scene.q.size(); ++i) {
      const auto isIts = [i](const Drive& drive) { return index(drive.joint) == i; };
      if (std::any_of(scene.drives.begin(), scene.drives.end(), isIts)) continue;
      beside.q[i] += change * random.between(-1, 1) * (1 + std::abs(scene.q[i]));
      beside.qd[i] += change * random.between(-1, 1) * (1 + std::abs(scene.qd[i]));
    }
    const Result moved = after(beside, "auto", fine);
    if (!moved.hasArrived) continue;
    growth.ofAngles = std::max(growth.ofAngles, apart(exact.q, moved.q) / change);
    growth.ofRates = std::max(growth.ofRates, apart(exact.qd, moved.qd) / change);
    growth.ofEnergy = std::max(growth.ofEnergy, std::abs(exact.energy - moved.energy) / change);
  }
  return growth;
}

/// Compares methods with `exact`. most: how far angles may be off, in tolerance · growth.
void expectTheSame(Scene scene, const Result& exact, const Growth& growth, double tolerance,
                   bool hasRateTolerance, double most, bool conserves,
                   const std::vector<std::string>& methods = ode::methodNames()) {
  if (hasRateTolerance) scene.integrator.rateTolerance = tolerance;
  const double allowed = most * tolerance;
  for (const std::string& method : methods) {
    if (ode::hasFixedStep(method)) continue;
    SCOPED_TRACE(method + " to " + std::to_string(tolerance) + (hasRateTolerance ? ", rates too" : ""));
    const Result found = after(scene, method, tolerance);
    if (!found.hasSeries) continue;
    EXPECT_TRUE(found.hasArrived) << found.fault;
    EXPECT_LE(apart(exact.q, found.q), allowed * growth.ofAngles);
    if (!hasRateTolerance) continue;
    EXPECT_LE(apart(exact.qd, found.qd), allowed * growth.ofRates);
    if (conserves) {
      EXPECT_LE(std::abs(found.residual), allowed * growth.ofEnergy);
    }
  }
}

/// Returns false if the machine is not compared.
bool compare(unsigned seed, bool conserves) {
  const std::string text = contactMachine(seed, conserves);
  SCOPED_TRACE("machine " + std::to_string(seed) + "\n" + text);
  const Scene scene = readSceneText(text);
  constexpr double fine = 1e-10;
  const Result exact = after(scene, "dop853", fine);
  EXPECT_TRUE(exact.hasArrived) << exact.fault;
  // Costs too much; or what is linear in the change is not linear in the tolerance.
  constexpr long long mostEvaluations = 10000;
  constexpr double mostGrowth = 1e3;
  if (!exact.hasArrived || exact.evaluations > mostEvaluations) return false;
  const Growth growth = growthOf(scene, exact, fine, seed);
  if (growth.ofAngles > mostGrowth) return false;
  for (const double tolerance : {1e-4, 1e-6}) {
    expectTheSame(scene, exact, growth, tolerance, true, t, conserves);
    expectTheSame(scene, exact, growth, tolerance, false, 4, conserves);
  }
  // The errors of radau13 are 1e-5 of the tolerance here. Each landing may add 1e-4 of what a step may.
  expectTheSame(scene, exact, growth, 1e-6, false, 1e-3, conserves, {"radau13"});
  return true;
}

TEST(Contacts, AreTheSameByEveryMethod) {
#ifdef __SANITIZE_ADDRESS__  // or it takes minutes
  constexpr unsigned machines = 16;
#else
  constexpr unsigned machines = 80;
#endif
  unsigned compared = 0;
  for (unsigned seed = 1; seed <= machines; ++seed) compared += compare(seed, seed % 3 == 0);
  EXPECT_GT(2 * compared, machines);
}

// A long step of taylor leaves a stop and hits it again: a look at its ends sees nothing.
TEST(Contacts, BetweenTheEndsOfALongStepAreFound) {
  const Scene scene = readSceneText(contactMachine(2588, false));
  EXPECT_LT(apart(after(scene, "dop853", 1e-10).q, after(scene, "taylor", 1e-6).q), 1e-7);
  // So do long steps at a loose tolerance.
  Scene loose = scene;
  loose.integrator.rateTolerance = 1e-4;
  for (const char* method : {"dop853", "radau13"})
    EXPECT_LT(apart(after(scene, "dop853", 1e-10).qd, after(loose, method, 1e-4).qd), 1e-4) << method;
}

}  // namespace
}  // namespace planar_chain
