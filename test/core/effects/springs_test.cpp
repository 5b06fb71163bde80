/// Springs and dampers against the formula joint by joint: rows of joints with and without them, shorter and
/// longer than the blocks in which they are gone through.

#include "effects/springs.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "lanes/kernel.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

struct Row {
  std::size_t n, first, last;  ///< joints, the first that has a spring or damper, and one after the last
  bool turned, damped;
};

class SpringsOf : public testing::TestWithParam<Row> {
 protected:
  SpringsOf() {
    for (std::size_t i = 0; i < row.n; ++i) {
      links_.push_back({"link" + std::to_string(i), 1, 1, {}, {1, 0}});
      joints.push_back({"joint" + std::to_string(i)});
      theta.push_back(random_.between(-3, 3));
      omega.push_back(random_.between(-3, 3));
      along.push_back(random_.between(-3, 3));
      if (i < row.first || i >= row.last || (i > row.first && i % 7 == 3)) continue;
      joints[i].stiffness = random_.between(0.5, 2);
      if (row.turned) joints[i].restAngle = random_.between(-1, 1);
      if (row.damped) joints[i].damping = random_.between(0.5, 2);
    }
  }
  static double relative(const std::vector<double>& x, std::size_t i) {
    return i > 0 ? x[i] - x[i - 1] : x[i];
  }
  double torque(std::size_t i) const {
    return -joints[i].stiffness * (relative(theta, i) - joints[i].restAngle) -
           joints[i].damping * relative(omega, i);
  }
  Chain chain() const { return Chain(links_, joints, {}); }

  const Row row = GetParam();
  std::vector<Joint> joints;
  std::vector<double> theta, omega, along;

 private:
  test::Random random_{static_cast<unsigned>(row.n + row.first)};
  std::vector<Link> links_;
};

TEST_P(SpringsOf, AreThoseOfTheFormula) {
  constexpr double before = 0.25;  // what else acts stays
  std::vector<double> expected(row.n, before), torques(row.n, before);
  double lost = 0, change = 0;
  for (std::size_t i = 0; i < row.n; ++i) {
    expected[i] += torque(i);
    if (i > 0) expected[i - 1] -= torque(i);
    torques[i] += torque(i);
    const double rate = relative(omega, i);
    lost += joints[i].damping * rate * rate;
    change += 2 * joints[i].damping * rate * relative(along, i);
  }
  const Chain chain_ = chain();
  Springs springs(chain_);
  std::vector<double> N(row.n, before), tau(row.n, before);
  EXPECT_NEAR(springs.apply(theta.data(), omega.data(), N.data()), lost, 1e-13 * lost);
  springs.addTorques(theta.data(), omega.data(), tau.data());
  EXPECT_NEAR(springs.dissipationAlong(omega.data(), along.data()), change, 1e-13 * lost);
  for (std::size_t i = 0; i < row.n; ++i) {
    ASSERT_NEAR(N[i], expected[i], 1e-14) << i;
    ASSERT_NEAR(tau[i], torques[i], 1e-14) << i;
  }
}

TEST_P(SpringsOf, AreTheSameInLaneOrder) {
  const Chain chain_ = chain();
  for (const simd::Kernel* kernel : simd::kernels()) {
    const LaneOrder order(chain_.size(), kernel->lanes);
    const auto laneOrdered = [&](const std::vector<double>& values) {
      std::vector<double> all(static_cast<std::size_t>(order.paddedSize()));
      order.toLaneOrder(values.data(), all.data());
      return all;
    };
    Springs springs(chain_), there(chain_, &order);
    EXPECT_EQ(there.empty(), springs.empty());
    EXPECT_EQ(there.dissipate(), springs.dissipate());
    if (springs.empty()) continue;
    std::vector<double> N(row.n, 0.25), tau(row.n), laneOrderedN = laneOrdered(N),
                                                    laneOrderedTau = laneOrdered(tau);
    const double lost = springs.apply(theta.data(), omega.data(), N.data());
    EXPECT_NEAR(there.apply(laneOrdered(theta).data(), laneOrdered(omega).data(), laneOrderedN.data()), lost,
                1e-13 * lost);
    springs.addTorques(theta.data(), omega.data(), tau.data());
    there.addTorques(laneOrdered(theta).data(), laneOrdered(omega).data(), laneOrderedTau.data());
    EXPECT_EQ(laneOrderedN, laneOrdered(N)) << order.lanes();
    EXPECT_EQ(laneOrderedTau, laneOrdered(tau)) << order.lanes();
    EXPECT_NEAR(there.dissipationAlong(laneOrdered(omega).data(), laneOrdered(along).data()),
                springs.dissipationAlong(omega.data(), along.data()), 1e-13 * lost);
  }
}

std::vector<Row> rows() {
  std::vector<Row> all;
  for (const std::size_t n : {1, 2, 9, 511, 512, 513, 1025}) {
    for (const std::size_t first : {std::size_t{0}, n / 3}) {
      for (const bool turned : {false, true}) {
        for (const bool damped : {false, true}) {
          all.push_back({n, first, n, turned, damped});
          all.push_back({n, first, (n + first + 1) / 2, turned, damped});
        }
      }
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(OfEveryLength, SpringsOf, testing::ValuesIn(rows()));

}  // namespace
}  // namespace planar_chain
