/// Series of the derivatives of a motion, against differences of the series of near motions.

#include "lanes/column_series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"
#include "dynamics/near_scenes.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

using Eigen::VectorXd;

struct Case {
  const char* scene;
  std::vector<std::pair<std::string, double>> numbers;  ///< and their values
};

const Case cases[] = {
    {R"(
chain: [arm]
links: {arm: {mass: 1, inertia: 0.08, com: [0.5, 0.1], pin: [1, 0], joint: {damping: 0.2}, initial: {angle: 1.2, velocity: 1}}}
)",
     {{"links/arm/com/1", 0.1}}},
    {R"(
chain: [upper, lower]
gravity: [0.1, -9.81]
links:
  upper: {mass: 1, inertia: 0.08, com: [0.5, 0.02], pin: [1, 0.1], joint: {damping: 0.1}, initial: {angle: 1.2, velocity: 1}}
  lower: {mass: 1, inertia: 0.08, com: [0.5, 0.1], pin: [1, 0], joint: {stiffness: 2}, initial: {angle: 0.9, velocity: -3}}
)",
     {{"links/lower/mass", 1},
      {"links/upper/pin/0", 1},
      {"gravity/0", 0.1},
      {"links/lower/joint/stiffness", 2}}},
    {R"(
chain: [x, y, a, b]
links:
  x: {mass: 1, joint: {type: prismatic, axis: [1, 0.3], stiffness: 3}, initial: {velocity: 1}}
  y: {mass: 0.4, pin: [0, 0.1], joint: {type: prismatic, axis: [0, 1], damping: 0.2}, initial: {velocity: -0.5}}
  a: {mass: 1, inertia: 0.08, com: [0.5, 0.02], pin: [1, 0.1], initial: {angle: 1.2, velocity: 1}}
  b: {mass: 1, inertia: 0.08, com: [0.5, 0.1], pin: [1, 0], joint: {rotor_inertia: 0.1}, initial: {angle: 0.9, velocity: -3}}
)",
     {{"links/y/mass", 0.4}, {"links/a/com/0", 0.5}, {"links/b/joint/rotor_inertia", 0.1}}}};

constexpr int order = 24;

/// The relative state at h, and the series.
struct Motion {
  Motion(const Scene& scene, double h) : n(scene.chain.size()), c(index((order + 1) * 2 * n)), end(2 * n) {
    Dynamics dynamics(scene);
    dynamics.reserveSeries(order);
    const Coordinates& coordinates = scene.chain.coordinates();
    y = VectorXd::Zero(dynamics.size());
    coordinates.toAbsolute(scene.q.data(), y.data());
    coordinates.toAbsolute(scene.qd.data(), y.data() + n);
    dynamics.begin(0, y.data());
    dynamics.series(0, y.data(), nullptr, order, c.data());
    for (int i = 0; i < 2 * n; ++i) {
      end[i] = 0;
      for (int k = order; k >= 0; --k) end[i] = h * end[i] + c[index(k * 2 * n + i)];
    }
    coordinates.toRelative(end.data(), end.data());
    coordinates.toRelative(end.data() + n, end.data() + n);
  }
  int n;
  std::vector<double> c;
  VectorXd y, end;
};

/// By differences of sixth order.
template <class SceneAt>
VectorXd difference(const SceneAt& sceneAt, double h) {
  constexpr double step = 1e-3;
  VectorXd sum = VectorXd::Zero(Motion(sceneAt(0), h).end.size());
  for (const auto& [k, weight] : {std::pair(1, 45.), {2, -9.}, {3, 1.}}) {
    const Motion more(sceneAt(k * step), h), less(sceneAt(-k * step), h);
    sum += weight / (60 * step) * (more.end - less.end);
  }
  return sum;
}

TEST(ColumnSeries, OfEveryKernelAreThoseOfNearMotions) {
  constexpr double h = 0.1;  // s: within the radius of these series
  for (const Case& of : cases) {
    const Value tree = parseYaml(of.scene);
    const Scene scene = readScene(tree);
    const int n = scene.chain.size(), numbers = static_cast<int>(of.numbers.size());
    Eigen::MatrixXd expected(2 * n, 2 * n + numbers);
    for (int k = 0; k < 2 * n; ++k) {
      const auto moved = [&, k](double by) {
        Scene near = scene;
        (k < n ? near.q[index(k)] : near.qd[index(k - n)]) += by;
        return near;
      };
      expected.col(k) = difference(moved, h);
    }
    for (int p = 0; p < numbers; ++p) {
      const auto varied = [&, p](double by) {
        Value near = tree;
        setNumber(near, of.numbers[index(p)].first, of.numbers[index(p)].second + by);
        return readScene(near);
      };
      expected.col(2 * n + p) = difference(varied, h);
    }

    const Motion motion(scene, h);
    Effects effects(scene);
    effects.enter(0);
    Couplings couplings(n);
    effects.couple(0, 0, couplings);
    const Eigen::Matrix4Xd joints =
        jointTerms(effects, couplings, scene.chain.coordinates(), 0, motion.y.data());
    for (const simd::ColumnKernel* kernel : simd::columnKernels()) {
      ColumnSeries series(scene.chain, order, 2 * n + numbers, numbers, *kernel);
      for (int i = 0; i < n; ++i) {
        std::copy_n(joints.col(i).data(), 4, series.joint(i));
        series.start(0, i, i) = series.start(1, i, n + i) = 1;
      }
      for (int p = 0; p < numbers; ++p) {
        NearScenes near(variedNumber(tree, of.numbers[index(p)].first));
        Eigen::Matrix4Xd change;
        ASSERT_TRUE(near.enter(0, effects) && near.changeOfJoints(0, motion.y.data(), effects, change));
        series.change(p) = near.changeOfChain();
        series.change(p).segment(ColumnSeries::Terms::joint(0, n), 4 * n) =
            Eigen::Map<const VectorXd>(change.data(), change.size());
      }
      series.find(motion.c.data());
      EXPECT_LT(series.evaluate(h), 1e-9);
      for (int k = 0; k < expected.cols(); ++k) {
        VectorXd found(2 * n);
        for (int i = 0; i < n; ++i) found[i] = series.value(0, i, k), found[n + i] = series.value(1, i, k);
        const double size = expected.col(k).cwiseAbs().maxCoeff();
        EXPECT_LT((found - expected.col(k)).cwiseAbs().maxCoeff() / size, 1e-9)  // that of the differences
            << kernel->lanes << " lanes, column " << k << ":\n"
            << found.transpose() << "\n"
            << expected.col(k).transpose();
      }
    }
  }
}

}  // namespace
}  // namespace planar_chain
