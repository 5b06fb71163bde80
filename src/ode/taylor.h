#pragma once

/// Steps along the Taylor series of the solution. The tolerance determines the order p:
///
///     y(t + h) = Σ_{k≤p} c_k h^k          c_k = y^(k)(t)/k!
///
/// The error of order p − 1 is |c_p| h^p plus a quarter of |c_{p−1}| h^{p−1}, as every other coefficient may
/// vanish by symmetry. More may: s̈ = −s³ has only every fourth where s = 0, s̈ = −s⁵ every sixth. So the error
/// is at least 4^{−j} |c_{p−j}| h^{p−j}, j ≤ 5. That is less if no coefficient vanishes. All are multiplied
/// by twenty. That makes steps a tenth shorter, and runs as exact for a tolerance as those of the other
/// methods, whose estimates are too large as well. The error is known for every h before a step is made. So
/// each step is as long as it may be, and a shorter one needs no new series. Gauss's rule computes the
/// integrals along the way. Source: Jorba and Zou, see motion_series.h.

#include <array>
#include <vector>

#include "ode/stepper.h"
#include "simd/vectors.h"

namespace planar_chain::ode {

class Taylor : public Stepper {
 public:
  static constexpr double caution = 20;  ///< by which the error is multiplied
  /// 4^−j, j = 5 … 0: the shares of the last coefficients in the error, as above. The last two are added.
  static constexpr int lookedBack = simd::VectorKernel::tailOrders;
  using Shares = std::array<double, lookedBack>;
  static constexpr Shares shares{1. / 1024, 1. / 256, 1. / 64, 1. / 16, 1. / 4, 1};
  static int orderFor(double tolerance);
  /// The nodes and weights of Gauss's rule on [0, 1], columns. Allocates.
  static Eigen::MatrixX2d gaussRule(int count);
  /// f must outlive the stepper. Allocates.
  Taylor(SeriesSystem& f, double tolerance);

  /// The cost of the last attempt.
  double cost() const override { return cost_; }
  const Vector& derivative(double t, const Vector& y) override;
  bool foresees(const State& from, double h) override {
    cost_ = isKnown_ ? 0 : f_.seriesCost(order_);
    const Shares weights = weightsAt(h);  // ready when the series is
    findSeries(from.t, from.y, &from.carry);
    findError(weights);
    return true;
  }
  void step(double t, double h, const Vector& y) override {
    findSeries(t, y);
    findError(weightsAt(h));
    findIncrement(t, h, y);
  }
  void stepAsForeseen(double t, double h, const Vector& y) override { findIncrement(t, h, y); }
  /// By the same series.
  void stepAgain(double t, double h, const Vector& y) override {
    cost_ = 0;
    findIncrement(t, h, y);
  }
  bool lookAgain(State& state, double t) override {
    findTurn(t - state.t);
    return take(state, t);
  }
  void accept() override { forget(); }
  void forget() override { isKnown_ = false; }
  void saveOrRestore(Snapshot& snapshot) override {
    snapshot(cost_, isKnown_);
    if (isKnown_) snapshot(c_);
  }

 private:
  void findSeries(double t, const Vector& y, const Vector* carry = nullptr) {
    if (isKnown_) return;
    f_.series(t, inOrder(y, y_), carry ? inOrder(*carry, carry_) : nullptr, order_, c_.data());
    isKnown_ = true;
  }
  /// y in the order of the series: as it is, or in `room`.
  const double* inOrder(const Vector& y, Vector& room) const {
    if (hasOneOrder_) return y.data();
    f_.toChainOrder(y.data(), room.data());
    return room.data();
  }
  /// Returns the vector for a sum that putInLaneOrder() then writes to `result`, with 0 for the integrals.
  Vector& sumFor(Vector& result) { return hasOneOrder_ ? result : sum_; }
  void putInLaneOrder(Vector& result) {
    sumFor(result).tail(integrandRates_.size()).setZero();
    if (!hasOneOrder_) f_.toLaneOrder(sum_.data(), result.data());
  }
  Shares weightsAt(double h) const;
  void findError(const Shares& weights);
  void findTurn(double h);
  void findIncrement(double t, double h, const Vector& y);

  SeriesSystem& f_;
  const bool hasOneOrder_ = f_.hasOneOrder();
  int order_ = facts().order;
  double cost_;
  Eigen::MatrixX2d rule_;
  std::vector<double> c_;
  Vector y_{f_.size()}, carry_ = y_, sum_ = y_,
                        integrandRates_{f_.size() - f_.driving()};  ///< in the order of the series
  Vector derivative_ = increment_;
  bool isKnown_ = false;
};

}  // namespace planar_chain::ode
