/// A restored simulation goes on as the saved one did, bit for bit: the same calls after save() and after
/// restore(), into the same simulation, a new one and a copy. Machines, calls and instants are drawn from
/// fixed seeds.

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "busy_machines.h"
#include "planar_chain/fault.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/sensors.h"

namespace planar_chain {
namespace {

using test::anyCall;
using test::Call;
using test::Random;

/// All that calls give, as numbers.
std::vector<double> resultsOf(Simulation& of, const std::vector<Call>& calls) {
  std::vector<double> all;
  for (const Call& call : calls) {
    const std::string refused = test::refusal(call, of);
    all.push_back(static_cast<double>(refused.size()));
    all.push_back(of.time());
    all.insert(all.end(), of.q().begin(), of.q().end());
    all.insert(all.end(), of.qd().begin(), of.qd().end());
    const Statistics done = of.statistics();
    const EnergyBalance balance = of.energyBalance();
    for (const long long count : {done.steps, done.rejected, done.rescues, done.evaluations})
      all.push_back(static_cast<double>(count));
    all.insert(all.end(), {done.localError, balance.supplied, balance.dissipated, balance.residual});
    for (const Measurement& one : of.measure()) all.insert(all.end(), one.values.begin(), one.values.end());
    for (const long long count : of.cutOffs()) all.push_back(static_cast<double>(count));
    for (const long long count : of.velocityExcesses()) all.push_back(static_cast<double>(count));
  }
  return all;
}

void expectTheSameFuture(const Scene& scene, unsigned seed) {
  constexpr int most = 12;
  Random random(seed);
  const auto draw = [&] {
    std::vector<Call> calls;
    for (int k = 0; k < most; ++k) calls.push_back(anyCall(scene, random));
    return calls;
  };
  Simulation one(scene, 100, true), other(scene, 100, true), untouched(scene, 100, true);
  const std::vector<Call> before = draw(), after = draw(), elsewhere = draw();
  resultsOf(one, before);
  resultsOf(untouched, before);
  resultsOf(other, elsewhere);
  const SavedState saved = one.save();
  const std::unique_ptr<Simulation> twin = one.copy();
  const std::vector<double> expected = resultsOf(untouched, after);
  const auto isExpected = [&](Simulation& of) { return test::areSame(resultsOf(of, after), expected); };
  EXPECT_TRUE(isExpected(one)) << "save() changed something";
  EXPECT_TRUE(isExpected(*twin)) << "a copy";
  one.restore(saved);
  EXPECT_TRUE(isExpected(one)) << "the same simulation";
  other.restore(SavedState(saved.bytes()));
  EXPECT_TRUE(isExpected(other)) << "another simulation";
}

TEST(SavedState, GoesOnBitForBit) {
  test::forEachMachine(3, expectTheSameFuture);
}

std::string refusalOf(Simulation& of, const SavedState& state) {
  const SavedState before = of.save();
  std::string words;
  try {
    of.restore(state);
  } catch (const Refused& refused) {
    words = refused.what();
  }
  EXPECT_EQ(of.save().bytes(), before.bytes());
  return words;
}

TEST(SavedState, OfSomethingElseIsRefused) {
  const Scene scene = readSceneText(test::sprung);
  Scene heavier = scene, ofRk4 = scene;
  std::vector<Link> links = scene.chain.links();
  links[0].mass *= 1 + 1e-15;
  heavier.chain = Chain(links, scene.chain.joints(), scene.chain.gravity());
  ofRk4.integrator.method = "rk4";
  Simulation one(scene, 3), of(heavier, 3), by(ofRk4, 3), withFewer(scene, 2);
  ASSERT_TRUE(one.advanceTo(0.1));
  const std::string other = "saved: expected a state of the same scene";
  for (Simulation* its : {&of, &by, &withFewer}) {
    EXPECT_EQ(refusalOf(*its, one.save()).substr(0, other.size()), other);
  }

  const std::string bytes = one.save().bytes();
  EXPECT_NE(refusalOf(one, SavedState()), "");
  EXPECT_NE(refusalOf(one, SavedState("planar_chain state 0\n" + bytes.substr(21))), "");
  std::string damaged = bytes;
  damaged[damaged.size() / 2] ^= 1;
  EXPECT_NE(refusalOf(one, SavedState(damaged)), "");
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    EXPECT_NE(refusalOf(one, SavedState(bytes.substr(0, size))), "");
  }
  EXPECT_EQ(refusalOf(one, SavedState(bytes)), "");
}

}  // namespace
}  // namespace planar_chain
