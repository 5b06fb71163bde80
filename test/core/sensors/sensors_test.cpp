/// Sensors: statistics of their errors, exact delays, closed forms, and a motion that they do not change.

#include "planar_chain/sensors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <string>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "run/fallbacks.h"
#include "run/sampler.h"
#include "run/step_budget.h"
#include "sensors/random.h"
#include "sensors/sensor_bank.h"

namespace planar_chain {
namespace {

constexpr int many = 100000;

const std::string rod =
    "chain: [rod]\nlinks: {rod: {mass: 2, inertia: 0.3, com: [0.4, 0.1], pin: [1, 0], initial: {angle: "
    "0.5}}}\n";

/// The values of the only sensor, by component, of a rod that hangs or lies still.
std::vector<std::vector<double>> sampled(const std::string& sensor, long long seed = 1, int count = many) {
  Scene scene = readSceneText(rod + "sensors: {" + sensor + "}\nseed: " + std::to_string(seed) + "\n");
  SensorBank bank(scene);
  std::vector<LinkMotion> still(1);
  still[0].com = {0.4, 0.1};
  std::vector<std::vector<double>> values;
  for (int k = 0; k < count; ++k) bank.take({0.0}, still.data());
  bank.confirm();
  for (const Measurement& one : bank.deliver(1e9)) {
    values.resize(one.values.size());
    for (std::size_t i = 0; i < one.values.size(); ++i) values[i].push_back(one.values[i]);
  }
  return values;
}

double meanOf(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value;
  return sum / static_cast<double>(x.size());
}

/// Σ (x_k − mean)(y_{k+lag} − mean)/N
double covariance(const std::vector<double>& x, const std::vector<double>& y, std::size_t lag = 0) {
  const double mx = meanOf(x), my = meanOf(y);
  double sum = 0;
  for (std::size_t k = 0; k + lag < x.size(); ++k) sum += (x[k] - mx) * (y[k + lag] - my);
  return sum / static_cast<double>(x.size());
}

// ---- Random numbers ----------------------------------------------------------------------------

/// The known answers of the authors' library Random123.
TEST(Philox, GivesTheKnownAnswers) {
  const std::uint32_t ones = 0xffffffff;
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (RandomBits{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({ones, ones, ones, ones}, {ones, ones}),
            (RandomBits{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (RandomBits{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

/// normalAt() inverts Φ(x) = erfc(−x/√2)/2. The bound is that of simd::log2.
TEST(Normal, InvertsItsDistribution) {
  for (double x = -8; x <= 5; x += 0.01) {
    EXPECT_NEAR(normalAt(std::erfc(-x / std::sqrt(2.0)) / 2), x, 1e-8 * (1 + std::abs(x))) << x;
  }
}

// ---- Statistics; five standard deviations of each estimate are allowed ---------------------------

TEST(Errors, HaveTheirMeanDeviationAndNoMemory) {
  const double N = many;
  const auto values = sampled(
      "imu: {link: rod, gyro_noise: 0.02, gyro_bias: 0.3, accelerometer_noise: 0.5, accelerometer_bias: -1}");
  const double truth[] = {0, 0, 0, 0, 9.81, 0};
  for (std::size_t i = 0; i < 6; ++i) {
    const double noise = i < 3 ? 0.02 : 0.5, bias = i < 3 ? 0.3 : -1;
    EXPECT_NEAR(meanOf(values[i]), truth[i] + bias, 5 * noise / std::sqrt(N)) << i;
    EXPECT_NEAR(std::sqrt(covariance(values[i], values[i])), noise, 5 * noise / std::sqrt(2 * N)) << i;
    for (const std::size_t lag : {1, 2, 3, 10, 100}) {
      EXPECT_NEAR(covariance(values[i], values[i], lag), 0, 5 * noise * noise / std::sqrt(N)) << i << lag;
    }
    for (std::size_t j = 0; j < i; ++j) {
      const double other = j < 3 ? 0.02 : 0.5;
      EXPECT_NEAR(covariance(values[i], values[j]), 0, 5 * noise * other / std::sqrt(N)) << i << j;
    }
    double fourth = 0;  // a normal number's kurtosis is 3, with the deviation √(24/N)
    for (const double x : values[i]) fourth += std::pow((x - truth[i] - bias) / noise, 4) / N;
    EXPECT_NEAR(fourth, 3, 5 * std::sqrt(96 / N));
  }
}

/// P(round(n/r) = m) = Φ((m + ½) r/σ) − Φ((m − ½) r/σ), n shifted by the bias
TEST(Errors, AreQuantisedAfterwards) {
  const double r = 3e-3, noise = 4e-3, bias = 1e-3, N = many;
  const auto values = sampled("encoder: {joints: all, resolution: 3e-3, noise: 4e-3, bias: 1e-3}")[0];
  std::map<long, double> counts;
  for (const double value : values) {
    const long m = std::lround(value / r);
    ASSERT_EQ(value, static_cast<double>(m) * r);
    ++counts[m];
  }
  const auto phi = [&](double x) { return std::erfc(-(x - bias) / noise / std::sqrt(2.0)) / 2; };
  for (long m = -6; m <= 6; ++m) {
    const double p = phi((static_cast<double>(m) + 0.5) * r) - phi((static_cast<double>(m) - 0.5) * r);
    EXPECT_NEAR(counts[m] / N, p, 5 * std::sqrt(p / N)) << m;
  }
}

/// A walk of K √Δ a sample has over m samples the Allan variance K² Δ (2 m² + 1)/(6 m): K² τ/3 for long τ.
TEST(Errors, WanderWithTheirAllanDeviation) {
  const double K = 0.1, period = 1 / 200.0;
  const auto values = sampled("imu: {link: rod, rate: 200, gyro_bias_walk: 0.1}");
  for (const int m : {1, 10, 100}) {
    double sum = 0, number = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::vector<double>& x = values[axis];
      EXPECT_EQ(x.front(), 0);
      double before = 0;
      for (int k = 0; (k + 1) * m <= many; ++k) {
        const double mean = meanOf({x.begin() + k * m, x.begin() + (k + 1) * m});
        if (k > 0) sum += (mean - before) * (mean - before) / 2, ++number;
        before = mean;
      }
    }
    const double variance = K * K * period * (2.0 * m * m + 1) / (6.0 * m);
    EXPECT_NEAR(sum / number, variance, 5 * variance * std::sqrt(3 / number)) << m;
  }
  EXPECT_EQ(values[3].back(), 0);
  EXPECT_EQ(values[4].back(), 9.81);
}

TEST(Seed, ChangesAllAndTheSameSeedNothing) {
  const std::string imu = "imu: {link: rod, gyro_noise: 1, accelerometer_noise: 1, gyro_bias_walk: 1}";
  const auto once = sampled(imu, 7, 100);
  EXPECT_EQ(once, sampled(imu, 7, 100));
  for (const long long other : {0, 8, -7}) {
    const auto values = sampled(imu, other, 100);
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < 100; ++k) EXPECT_NE(values[i][k], once[i][k]);
    }
  }
  EXPECT_NE(once,
            sampled("other: {link: rod, gyro_noise: 1, accelerometer_noise: 1, gyro_bias_walk: 1}", 7, 100));
}

// ---- Along a motion ------------------------------------------------------------------------------

/// All measurements of a run whose calls end at k/rate.
std::vector<Measurement> run(const Scene& scene, double duration, int rate) {
  Simulation simulation(scene, 0, true);
  std::vector<Measurement> all;
  for (int k = 0; k <= duration * rate; ++k) {
    EXPECT_TRUE(simulation.advanceTo(k / static_cast<double>(rate)));
    for (Measurement& one : simulation.measure()) {
      EXPECT_LE(one.delivered, simulation.time() + 1e-9);
      EXPECT_GT(one.delivered, simulation.time() - 1.0 / rate - 1e-9);  // as soon as it is due
      all.push_back(std::move(one));
    }
  }
  return all;
}

/// With J about the pin and ρ, φ of the centre of mass: J θ̈ = −m g ρ cos(θ + φ), and θ̇² from the energy. At
/// a point s: a = θ̈ i s − θ̇² s.
TEST(Imu, OnAPendulumIsItsClosedForm) {
  const Scene scene =
      readSceneText(rod + "sensors: {imu: {link: rod, point: [0.7, -0.2], angle: 0.3, rate: 130}," +
                    " truth: {joints: all, rate: 130}}");
  const double m = 2, J = 0.3 + m * (0.16 + 0.01), g = 9.81;
  const auto height = [](double theta) { return 0.4 * std::sin(theta) + 0.1 * std::cos(theta); };
  const auto reach = [](double theta) { return 0.4 * std::cos(theta) - 0.1 * std::sin(theta); };
  std::map<long long, double> angle;
  int count = 0, turned = 0;
  const std::vector<Measurement> all = run(scene, 3, 20);
  for (const Measurement& one : all) {
    if (scene.sensors[index(one.sensor)].name == "truth") angle[one.number] = one.values[0];
  }
  for (const Measurement& one : all) {
    if (scene.sensors[index(one.sensor)].name != "imu") continue;
    const double theta = angle.at(one.number), omega = one.values[2];
    const double square = 2 * m * g * (height(0.5) - height(theta)) / J, alpha = -m * g * reach(theta) / J;
    EXPECT_NEAR(omega * omega, square, 1e-6);
    const Vec2d s = Rotation<double>::of(theta) * Vec2d{0.7, -0.2};
    const Vec2d f = alpha * perp(s) - square * s + Vec2d{0, g};
    const Vec2d expected = Rotation<double>::of(-theta - 0.3) * f;
    EXPECT_NEAR(one.values[3], expected.x, 1e-5);
    EXPECT_NEAR(one.values[4], expected.y, 1e-5);
    ++count;
    turned += omega > 0.1 || omega < -0.1;
  }
  EXPECT_EQ(count, 3 * 130 + 1);
  EXPECT_GT(turned, 300);
}

TEST(Imu, AtRestReadsGUpwards) {
  const Scene scene = readSceneText(
      "chain: [rod]\nlinks: {rod: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], initial: {angle: "
      "-1.5707963267948966}}}\nsensors: {imu: {link: rod}}");
  const Measurement one = run(scene, 0.1, 10).back();
  EXPECT_NEAR(one.values[3], -9.81, 1e-9);  // x of the link points down
  EXPECT_NEAR(one.values[4], 0, 1e-9);
}

/// What acts from t = 0 on, as a load or as a command, is in the first value, whether that is taken at once
/// or with the first step.
TEST(Imu, BeginsWithWhatActsAtTheStart) {
  const std::string scene = rod + "sensors: {imu: {link: rod, point: [1, 0]}}\n";
  Simulation loaded(readSceneText(scene + "loads: {turn: {joint: rod_joint, torque: 5}}\n"), 0, true);
  const std::vector<double> expected = loaded.measure().at(0).values;
  for (const double first : {0.0, 0.01}) {
    Simulation commanded(readSceneText(scene), 1, true);
    ASSERT_TRUE(commanded.advanceTo(0));  // as simulate does before it takes the commands of the first tick
    commanded.holdTorque(0, 5, std::numeric_limits<double>::infinity());
    ASSERT_TRUE(commanded.advanceTo(first));
    EXPECT_EQ(commanded.measure().at(0).values, expected) << first;
  }
}

/// A driven joint has its law's angle: what is delivered at t is that at t − delay.
TEST(Delay, IsExact) {
  const Scene scene = readSceneText(
      "chain: [rod]\nlinks: {rod: {mass: 1, inertia: 0.1, com: [0.5, 0], pin: [1, 0], joint: {drive: "
      "{amplitude: 0.5, frequency: 0.7}}}}\nsensors: {late: {joints: all, delay: 0.0375, rate: 160}}");
  const std::vector<Measurement> all = run(scene, 2, 100);
  ASSERT_EQ(all.size(), 2 * 160 - 6 + 1u);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].time, static_cast<double>(k) / 160);
    EXPECT_EQ(all[k].delivered, all[k].time + 0.0375);
    EXPECT_NEAR(all[k].values[0], 0.5 * std::sin(2 * pi * 0.7 * (all[k].delivered - 0.0375)), 1e-15);
  }
}

/// On every scene that ships: the motion is the same to the last bit, and a sensor's values are the same with
/// others beside it. Without errors they are the state.
TEST(Sensors, DoNotChangeTheMotionOrEachOther) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(SCENES_DIR)) {
    if (entry.path().extension() != ".yaml") continue;
    std::ifstream file(entry.path());
    const Scene plain = readSceneText({std::istreambuf_iterator<char>(file), {}});
    if (plain.chain.size() > 60) continue;
    ++scenes;
    Scene one = plain;
    Encoder all;
    for (int i = 0; i < plain.chain.size(); ++i) all.joints.push_back(i);
    one.sensors.push_back({"encoder", 73, 0, all});
    Scene two = one;
    Imu imu;
    imu.link = plain.chain.size() - 1;
    two.sensors.push_back({"imu", 190, 0, imu});
    Simulation without(plain), first(one, 0, true), both(two, 0, true);
    for (const double t : {0.003, 0.1, 0.5}) {
      for (Simulation* simulation : {&without, &first, &both}) ASSERT_TRUE(simulation->advanceTo(t));
      EXPECT_EQ(first.q(), without.q()) << entry.path();
      EXPECT_EQ(both.q(), without.q()) << entry.path();
      EXPECT_EQ(both.qd(), without.qd()) << entry.path();
    }
    const std::vector<Measurement> alone = first.measure();
    std::vector<Measurement> beside = both.measure();
    beside.erase(
        std::remove_if(beside.begin(), beside.end(), [](const auto& each) { return each.sensor > 0; }),
        beside.end());
    ASSERT_EQ(alone.size(), 37u);
    ASSERT_EQ(beside.size(), 37u);
    for (std::size_t k = 0; k < alone.size(); ++k)
      EXPECT_EQ(alone[k].values, beside[k].values) << entry.path();
    Simulation check(plain);
    check.advanceTo(36 / 73.);
    for (std::size_t i = 0; i < check.q().size(); ++i) {
      EXPECT_NEAR(alone.back().values[i], check.q()[i], 1e-4) << entry.path();
    }
  }
  EXPECT_GT(scenes, 10);
}

/// Steps that the energy guard refuses are made again, and so are their measurements.
TEST(Sensors, MeasureRepeatedStepsOnce) {
  Scene scene = readSceneText(
      "chain: [rod]\ngravity: [0, 0]\nlinks: {rod: {mass: 1, inertia: 0, com: [1, 0], pin: [1, 0], joint: "
      "{stiffness: 1.0e+6}, initial: {angle: 0.1}}}\nsensors: {encoder: {joints: all, rate: 5000}}\n"
      "integrator: {method: rk4, step: 0.0035}");
  Simulation simulation(scene, 0, true);
  ASSERT_TRUE(simulation.advanceTo(0.1)) << simulation.fault();
  EXPECT_GT(simulation.statistics().rescues, 0);
  const std::vector<Measurement> all = simulation.measure();
  ASSERT_EQ(all.size(), 501u);
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_EQ(all[k].number, static_cast<long long>(k));
    EXPECT_LE(std::abs(all[k].values[0]), 0.11);  // refused states are beyond
  }
}

// ---- What measurements cost ----------------------------------------------------------------------

/// Two rods that turn by 1e5 and −3e5 rad in a step: every fixed step is wrong.
const std::string tooFast =
    "chain: [upper, lower]\nlinks:\n  upper: {mass: 1, inertia: 0.08, com: [0.5, 0], pin: [1, 0], initial: "
    "{velocity: 1.0e+7}}\n  lower: {mass: 1, inertia: 0.08, com: [0.5, 0], pin: [1, 0], initial: {velocity: "
    "-3.0e+7}}\nintegrator: {method: rk4, step: 0.01}\nsensors: {encoder: {joints: all, rate: 1000}}\n";

/// Each measurement within a fixed step takes one step of the method: four evaluations of rk4. They are
/// counted, and their errors are of fourth order, as those of the motion.
TEST(Sensors, WithinAFixedStepTakeAStepOfItsMethod) {
  Scene scene =
      readSceneText(rod + "sensors: {encoder: {joints: all, rate: 900}}\nintegrator: {method: rk4}");
  Scene fine = scene;
  fine.integrator.step = 1e-4;
  const std::vector<Measurement> exact = run(fine, 1, 1);
  double before = 0;
  for (const double step : {0.1, 0.05, 0.025}) {
    scene.integrator.step = step;
    Simulation with(scene, 0, true), without(scene);
    ASSERT_TRUE(with.advanceTo(1) && without.advanceTo(1));
    const long long steps = with.statistics().steps - without.statistics().steps;
    EXPECT_GT(steps, 850);  // others are at the ends of steps
    EXPECT_LT(steps, 900);
    EXPECT_EQ(with.statistics().evaluations - without.statistics().evaluations, 4 * steps);
    double error = 0;
    const std::vector<Measurement> all = with.measure();
    for (std::size_t k = 0; k < all.size(); ++k) {
      error = std::max(error, std::abs(all[k].values[0] - exact[k].values[0]));
    }
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / error), 4, 0.5) << step;
    }
    before = error;
  }
}

TEST(Sensors, WithinARefusedFixedStepEndAsTheMotionDoes) {
  const Scene scene = readSceneText(tooFast);
  constexpr long long most = 1000, perStep = 12;  // evaluations of a step of rodas5p, with its factorization
  Simulation with(scene, 0, true), without(scene);
  for (Simulation* each : {&with, &without}) {
    const StepBudget budget(*each, 1, most);
    EXPECT_FALSE(each->advanceTo(1, [&] { return budget.isLeft(); }));
    EXPECT_EQ(each->fault(), "");
    EXPECT_LT(each->statistics().steps + each->statistics().rejected, 2 * most);
    EXPECT_LT(each->statistics().evaluations, 2 * most * perStep);
    EXPECT_GT(each->statistics().rescues, 0);
  }
  // Equal numbers of polls give equal states.
  Simulation* const both[] = {&with, &without};
  for (Simulation* each : both) {
    each->reset();
    int polls = 0;
    EXPECT_FALSE(each->advanceTo(1, [&] { return ++polls < 20; }));
  }
  EXPECT_EQ(with.time(), without.time());
  EXPECT_EQ(with.q(), without.q());
  EXPECT_EQ(with.qd(), without.qd());
}

TEST(Sensors, KeepNoInterruptWaiting) {
  Simulation simulation(readSceneText(tooFast), 0, true);
  EXPECT_FALSE(simulation.advanceTo(1, [] { return false; }));
  constexpr int untilTheCheck = 32, measurements = 10, ofRk4 = 4;
  EXPECT_GT(simulation.statistics().evaluations, 0);
  EXPECT_LE(simulation.statistics().evaluations, untilTheCheck * (1 + measurements) * ofRk4 + 10);
}

/// Steps that pass for adaptive ones, and are far too long.
class FarTooLong : public ode::StepsOf {
 public:
  using StepsOf::StepsOf;
  const char* name() const override { return "dopri5"; }
  ode::Outcome advance(ode::State& state, double end, double longestStep) override {
    return steps_->advance(state, end, longestStep);
  }
};

TEST(Sensors, WithinAnyStepTakeABoundedNumberOfSteps) {
  const Scene scene = readSceneText(tooFast);
  Dynamics dynamics(scene);
  const Windings windings(scene, dynamics.size());
  Sampler sampler(scene, dynamics, windings);
  FarTooLong steps(ode::makeMethod("rk4", dynamics, 0.0015, toleranceOf(scene, 0, dynamics)));
  Eigen::VectorXd y = Eigen::VectorXd::Zero(dynamics.size());
  y[2] = 1e7, y[3] = -2e7;
  ode::State state(dynamics, y);
  sampler.measureAt(state);
  EXPECT_EQ(sampler.integrate(steps, state, 0.0015, 1), ode::Outcome::arrived);
  long long accepted = 0, rejected = 0;
  sampler.countSteps(accepted, rejected);
  EXPECT_EQ(accepted, 2 * Sampler::mostSteps + 1);  // of dop853, rodas5p and ros34pw2
  EXPECT_LT(rejected, accepted);
  EXPECT_EQ(sampler.measure(state).size(), 2u);
}

TEST(Sensors, BeginAgainAtAReset) {
  const Scene scene = readSceneText(rod + "sensors: {imu: {link: rod, gyro_noise: 1, gyro_bias_walk: 1}}");
  Simulation simulation(scene, 0, true);
  simulation.advanceTo(0.5);
  const std::vector<Measurement> before = simulation.measure();
  EXPECT_TRUE(simulation.measure().empty());
  simulation.advanceTo(1);
  simulation.reset();
  simulation.advanceTo(0.5);
  const std::vector<Measurement> again = simulation.measure();
  ASSERT_EQ(before.size(), 51u);
  ASSERT_EQ(again.size(), 51u);
  for (std::size_t k = 0; k < 51; ++k) EXPECT_EQ(before[k].values, again[k].values);
}

/// Those whose delay is not over are kept beside. What is kept is the same, errors and all.
TEST(Sensors, KeepTheNewestAndCountTheLost) {
  constexpr int kept = 1'000'000 / 6, inFlight = 300, older = 1000;
  const Scene scene = readSceneText(
      rod + "sensors: {imu: {link: rod, gyro_noise: 1, gyro_bias_walk: 1, rate: 1000, delay: 0.3}}");
  SensorBank often(scene), once(scene);
  std::vector<LinkMotion> still(1);
  std::vector<Measurement> all;
  for (int k = 0; k < older + kept + inFlight; ++k) {
    for (SensorBank* bank : {&often, &once}) bank->take({0.0}, still.data());
    if (k % 10'000 != 0) continue;
    for (SensorBank* bank : {&often, &once}) bank->confirm();
    all = often.deliver(k / 1000.);
  }
  for (SensorBank* bank : {&often, &once}) bank->confirm();
  all = often.deliver(1e9);
  EXPECT_EQ(often.lost(), 0);
  EXPECT_EQ(once.lost(), older);
  const std::vector<Measurement> newest = once.deliver(1e9);
  ASSERT_EQ(newest.size(), static_cast<std::size_t>(kept + inFlight));
  EXPECT_EQ(newest.front().number, older);
  ASSERT_FALSE(all.empty());
  for (std::size_t k = 1; k <= all.size(); ++k) {
    EXPECT_EQ(newest[newest.size() - k].number, all[all.size() - k].number);
    EXPECT_EQ(newest[newest.size() - k].values, all[all.size() - k].values);
  }
}

TEST(Sensors, OfASimulationThatDoesNotMeasureGiveNothing) {
  Simulation simulation(readSceneText(rod + "sensors: {imu: {link: rod}}"));
  simulation.advanceTo(1);
  EXPECT_TRUE(simulation.measure().empty());
}

}  // namespace
}  // namespace planar_chain
