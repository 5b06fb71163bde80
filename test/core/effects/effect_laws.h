#pragma once

/// The laws that every effect obeys, whatever it does. Each function of effect.h and effect_kind.h that an
/// effect forgets or gets wrong breaks one of them:
///
///     q̈ is that of the dense equations          apply, addDense
///     (s − J)⁻¹ inverts J                        addStiffness, isNonlinear, addTangents, powersAlong,
///                                                addForceStiffness, dependOnMotion, addForceTangents
///     A is ∂ẋ/∂x of the dense equations          the same, by another road
///     ∂f/∂t                                      variesWithTime, applyRates, couple (orders 0 and 1)
///     y(t + h) by a Taylor series and by steps   hasSeries, addOrder, couple (all orders)
///     dE/dt = supplied − dissipated              hasPower, the powers, energyIn, energyOf, inertiaIn
///     effort is what acts                        addTorques
///     lanes and chain order agree                inLanes
///     a batch agrees with single runs            runsInLanes
///
/// A scene must be smooth around its initial state for 10 ms. Joints that are not held must move. Laws leave
/// out changes of prescribed joints.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <utility>
#include <vector>

#include "dynamics/dynamics.h"
#include "dynamics/scene_snapshot.h"
#include "lanes/segments.h"
#include "planar_chain/batch.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/simulation.h"

namespace planar_chain::test {

class EffectLaws {
 public:
  EffectLaws(Scene scene, double t)
      : scene_(std::move(scene)),
        t_(t),
        n_(scene_.chain.size()),
        coordinates_(scene_.chain.coordinates()),
        dynamics_(scene_),
        y_(dynamics_.size()) {
    y_.setZero();
    coordinates_.toAbsolute(scene_.q.data(), y_.data());
    coordinates_.toAbsolute(scene_.qd.data(), y_.data() + n_);
    dynamics_.enter(t);
    dynamics_.enterState(t, y_.data());
    dynamics_.hold(t, y_.data());
    q_.resize(n_);
    qd_.resize(n_);
    coordinates_.toRelative(y_.data(), q_.data());
    coordinates_.toRelative(y_.data() + n_, qd_.data());
  }

  void expectAll() {
    expectAllButTangents();
    expectInverse();
    expectLinearModel();
    expectTimeDerivative();
  }
  void expectAllButTangents() {
    expectDense();
    expectSeries();
    expectEnergyBalance();
    expectEffort();
    expectBatch();
    expectLanes();
  }

 private:
  using VectorXd = Eigen::VectorXd;

  VectorXd slope(double t, const VectorXd& y) {
    VectorXd dydt(y.size());
    dynamics_.derivative(t, y.data(), dydt.data());
    return dydt;
  }
  /// d/dx of f(x) at 0, by a difference of fourth order.
  template <class F>
  static auto difference(double h, F f) {
    return ((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h)).eval();
  }
  VectorXd denseAccelerations(const VectorXd& q, const VectorXd& qd) const {
    return kane(scene_.chain, q, qd, activeForces(scene_, t_, q, qd)).qdd;
  }

  /// True if a joint constraint gives the motion of the joint.
  bool isPrescribed(int joint) const {
    Couplings now(n_);
    dynamics_.effects().couple(t_, 0, now);
    return now.joints[index(joint)].isPrescribed;
  }

  void expectDense() {
    const VectorXd f = slope(t_, y_);
    VectorXd qdd(n_);
    coordinates_.toRelative(f.data() + n_, qdd.data());
    const VectorXd dense = denseAccelerations(q_, qd_);
    EXPECT_LT((qdd - dense).norm(), 1e-9 * (1 + dense.norm())) << "q̈: apply, addDense";
  }

  void expectInverse() {
    dynamics_.reserve(1);
    VectorXd f(y_.size());
    VectorXd laneOrdered(dynamics_.sizeInLaneOrder()), at = laneOrdered;
    dynamics_.toLaneOrder(y_.data(), at.data());
    dynamics_.linearize(t_, at.data(), laneOrdered.data());
    for (const double s : {3.0, 100.0}) {
      dynamics_.factor(s);
      VectorXd rhs = VectorXd::LinSpaced(y_.size(), 1, 2);
      for (int j = 0; j < n_; ++j) {
        if (!isPrescribed(j)) continue;
        for (const int row : {j, n_ + j}) {
          const int inner = coordinates_.inner(j);
          rhs[row] = inner >= 0 ? rhs[row - j + inner] : 0;
        }
      }
      VectorXd rhsLaneOrdered(laneOrdered.size()), xLaneOrdered(laneOrdered.size()), x(y_.size());
      dynamics_.toLaneOrder(rhs.data(), rhsLaneOrdered.data());
      dynamics_.solve(rhsLaneOrdered.data(), xLaneOrdered.data());
      dynamics_.toChainOrder(xLaneOrdered.data(), x.data());
      const VectorXd Jx = difference(1e-4 / x.norm(), [&](double h) { return slope(t_, y_ + h * x); });
      const VectorXd rest = s * x - Jx - rhs;
      EXPECT_LT(rest.head(2 * n_).norm(), 1e-7 * (s * x.norm() + Jx.norm()))
          << "s − J: the derivatives, s = " << s;
      EXPECT_LT(rest.tail(rest.size() - 2 * n_).norm(), 1e-7 * (s * x.norm() + Jx.norm()))
          << "s − J: powersAlong, s = " << s;
    }
  }

  void expectLinearModel() {
    const Eigen::MatrixXd A = linearModel(scene_, t_, q_, qd_).A;
    for (int j = 0; j < n_; ++j) {
      if (isPrescribed(j)) continue;  // the dense equations know no other motion of it
      const VectorXd unit = VectorXd::Unit(n_, j);
      const VectorXd byAngle =
          difference(1e-4, [&](double h) { return denseAccelerations(q_ + h * unit, qd_); });
      const VectorXd byRate =
          difference(1e-4, [&](double h) { return denseAccelerations(q_, qd_ + h * unit); });
      EXPECT_LT((A.col(j).tail(n_) - byAngle).norm(), 1e-6 * (1 + A.norm())) << "A, angle " << j;
      EXPECT_LT((A.col(n_ + j).tail(n_) - byRate).norm(), 1e-6 * (1 + A.norm())) << "A, rate " << j;
    }
  }

  void expectTimeDerivative() {
    const VectorXd expected = difference(1e-4, [&](double h) { return slope(t_ + h, y_); });
    dynamics_.reserve(0);
    VectorXd laneOrdered(dynamics_.sizeInLaneOrder()), ft = laneOrdered, at = laneOrdered, own(y_.size());
    dynamics_.toLaneOrder(y_.data(), at.data());
    dynamics_.linearize(t_, at.data(), laneOrdered.data());
    own.setZero();
    ft.setZero();
    if (dynamics_.timeDerivative(ft.data())) dynamics_.toChainOrder(ft.data(), own.data());
    EXPECT_LT((own - expected).norm(), 1e-7 * (1 + expected.norm()))
        << "∂f/∂t: variesWithTime, applyRates, couple";
  }

  void expectSeries() {
    constexpr double h = 5e-3;
    if (!dynamics_.hasSeries()) return;
    constexpr int order = 12;
    dynamics_.reserveSeries(order);
    std::vector<double> c(static_cast<std::size_t>(2 * n_ * (order + 1)));
    dynamics_.series(t_, y_.data(), nullptr, order, c.data());
    const Eigen::Map<const Eigen::MatrixXd> rows(c.data(), 2 * n_, order + 1);
    VectorXd bySeries = rows.col(order);
    for (int k = order; k-- > 0;) bySeries = h * bySeries + rows.col(k);

    // A hundred steps of rk4: an error of 1e-13 and less.
    VectorXd y = y_;
    constexpr int steps = 100;
    constexpr double step = h / steps;
    for (int k = 0; k < steps; ++k) {
      const double t = t_ + k * step;
      const VectorXd k1 = slope(t, y), k2 = slope(t + step / 2, y + step / 2 * k1),
                     k3 = slope(t + step / 2, y + step / 2 * k2), k4 = slope(t + step, y + step * k3);
      y += step / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    EXPECT_LT((bySeries - y.head(2 * n_)).norm(), 1e-10 * (1 + y.norm())) << "series: hasSeries, addOrder";
  }

  void expectEnergyBalance() {
    const VectorXd f = slope(t_, y_);
    const auto energy = [&](double h) {
      const VectorXd y = y_ + h * f + h * h / 2 * directional(f);
      return VectorXd::Constant(1, dynamics_.energy(t_ + h, y.data()).total()).eval();
    };
    const double rate = difference(1e-4, energy)[0];
    const double power = dynamics_.works() > 0 ? f[2 * n_] - f[2 * n_ + 1] : 0;
    const double size = 1 + std::abs(rate) + dynamics_.energy(t_, y_.data()).kinetic;
    EXPECT_NEAR(rate, power, 1e-6 * size) << "energy: hasPower, powers, energyIn";
  }
  /// d²y/dt² along the motion.
  VectorXd directional(const VectorXd& f) {
    return difference(1e-4, [&](double h) { return slope(t_ + h, y_ + h * f); });
  }

  /// With gravity off and no forces, M q̈ + … = τ: the effort of all joints, drives and friction included.
  void expectEffort() {
    if (dynamics_.effects().mostActing() == LoadKind::forces) return;
    const VectorXd f = slope(t_, y_);
    VectorXd qdd(n_), effort(n_);
    coordinates_.toRelative(f.data() + n_, qdd.data());
    dynamics_.jointTorques(t_, y_.data(), effort.data());
    // A chain with these torques alone as steady loads.
    Scene bare = scene_;
    bare.chain = bareChain();
    bare.drives.clear();
    bare.loads.clear();
    for (int i = 0; i < n_; ++i) {
      const double rotor = inertiaIn(scene_.chain.joints()[index(i)]) * qdd[i];
      bare.loads.push_back({"effort", Load::none, {}, {}, 0, i, effort[i] - rotor});
    }
    const VectorXd byEffort = kane(bare.chain, q_, qd_, activeForces(bare, t_, q_, qd_)).qdd;
    EXPECT_LT((byEffort - qdd).norm(), 1e-8 * (1 + qdd.norm())) << "effort: addTorques";
  }
  Chain bareChain() const {
    std::vector<Joint> joints;
    for (const Joint& joint : scene_.chain.joints()) {
      joints.push_back({joint.name});
      joints.back().isPrismatic = joint.isPrismatic;
      joints.back().axis = joint.axis;
    }
    return Chain(scene_.chain.links(), joints, scene_.chain.gravity());
  }

  void expectBatch() {
    Scene scene = scene_;
    scene.integrator.method = "auto";
    scene.integrator.tolerance = 1e-10;
    Simulation alone(scene);
    ASSERT_TRUE(alone.advanceTo(0.2)) << alone.fault();
    std::vector<double> expected = alone.q();
    expected.insert(expected.end(), alone.qd().begin(), alone.qd().end());
    std::vector<double> start = scene.q;
    start.insert(start.end(), scene.qd.begin(), scene.qd.end());
    const std::vector<double> states = simulateMany(scene, start, {0.2}).states;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_NEAR(states[i], expected[i], 1e-7 * (1 + std::abs(expected[i])))
          << "a batch: runsInLanes, " << i;
    }
  }

  /// Dynamics has long chains in lanes; an evaluation has every chain in order.
  void expectLanes() {
    if (n_ <= ShortChain::most) return;
    SceneSnapshot snapshot(scene_, t_, q_, qd_);
    const Evaluation& at = snapshot.evaluation();
    const VectorXd f = slope(t_, y_), alpha = VectorXd::Map(at.slopes(), n_);
    EXPECT_LT((f.segment(n_, n_) - alpha).norm(), 1e-9 * alpha.norm()) << "lanes: applyInLanes";
    if (dynamics_.works() == 0) return;
    EXPECT_NEAR(f[2 * n_], at.powers.supplied, 1e-9 * (1 + std::abs(f[2 * n_]))) << "lanes: applyInLanes";
    EXPECT_NEAR(f[2 * n_ + 1], at.powers.dissipated, 1e-9 * (1 + std::abs(f[2 * n_ + 1])));
  }

  const Scene scene_;
  double t_;
  int n_;
  Coordinates coordinates_;
  Dynamics dynamics_;
  VectorXd y_, q_, qd_;
};

}  // namespace planar_chain::test
