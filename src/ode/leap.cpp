#include "ode/leap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace planar_chain::ode {

namespace {

constexpr int points = Leap::points;
// The positive zeros of P_8 on [−1, 1], and their weights.
constexpr double zeros[] = {0.18343464249564980494, 0.52553240991632898582, 0.79666647741362673959,
                            0.96028985649753623168};
constexpr double weights[] = {0.36268378337836198297, 0.31370664587788728734, 0.22238103445337447054,
                              0.10122853629037625915};

/// P_0 … P_10 at z.
std::array<double, points + 3> legendre(double z) {
  std::array<double, points + 3> P{1, z};
  for (std::size_t k = 1; k + 1 < P.size(); ++k) {
    const auto n = static_cast<double>(k);
    P[k + 1] = ((2 * n + 1) * z * P[k] - n * P[k - 1]) / (n + 1);
  }
  return P;
}

using Weights = Eigen::Matrix<double, points, 1>;

/// The zeros on [0, 1], and the series through values there.
struct Gauss {
  Gauss() {
    for (int i = 0; i < points; ++i) {
      const int k = i < points / 2 ? points / 2 - 1 - i : i - points / 2;
      const double z = i < points / 2 ? -zeros[k] : zeros[k];
      nodes[i] = (1 + z) / 2;
      const auto P = legendre(z);
      for (int j = 0; j < points; ++j)
        series(j, i) = (2 * j + 1) * weights[k] / 2 * P[static_cast<std::size_t>(j)];
    }
  }
  Weights nodes;
  Eigen::Matrix<double, points, points> series;  ///< row k: the coefficient of P_k, from values at the points
};

const Gauss& gauss() {
  static const Gauss table;
  return table;
}

/// The integrals of P_0 … P_7, as polynomials on [0, 1], from 0 to x; and those of these.
struct Integrals {
  explicit Integrals(double x) {
    const auto P = legendre(2 * x - 1);
    std::array<double, points + 2> I{x};
    for (std::size_t k = 1; k < I.size(); ++k)
      I[k] = (P[k + 1] - P[k - 1]) / (2 * (2 * static_cast<double>(k) + 1));
    for (std::size_t k = 0; k < points; ++k) {
      once[k] = I[k];
      twice[k] = k == 0 ? x * x / 2 : (I[k + 1] - I[k - 1]) / (2 * (2 * static_cast<double>(k) + 1));
    }
  }
  std::array<double, points> once{}, twice{};
};

}  // namespace

Leap::Leap(System& f)
    : f_(f),
      n_(f.firstRate()),
      from_(f.sizeInLaneOrder()),
      node_(from_),
      last_(from_),
      increment_(from_.y),
      change_(from_.y),
      slopes_(Eigen::MatrixXd::Zero(from_.y.size(), points)) {}

double Leap::time(int point) const {
  return from_.t + h_ * gauss().nodes[point];
}

/// By the first `terms` of the series of f.
bool Leap::set(State& state, double t, int terms) const {
  const double x = (t - from_.t) / h_;
  const Integrals integrals(x);
  const auto& series = gauss().series;
  Weights once = Weights::Zero(), twice = once;
  for (int k = 0; k < terms; ++k) {
    once += integrals.once[static_cast<std::size_t>(k)] * series.row(k).transpose();
    twice += integrals.twice[static_cast<std::size_t>(k)] * series.row(k).transpose();
  }
  increment_.setZero();
  increment_.head(n_) = x * h_ * from_.y.segment(n_, n_);
  const Eigen::Index others = increment_.size() - n_;
  for (int i = 0; i < points; ++i) {
    increment_.head(n_) += h_ * h_ * twice[i] * slopes_.col(i).segment(n_, n_);
    increment_.tail(others) += h_ * once[i] * slopes_.col(i).tail(others);
  }
  state.y = from_.y;
  state.carry = from_.carry;
  state.t = t;
  return vectors_.addCarried(state.y.data(), state.carry.data(), increment_.data(), increment_.size());
}

bool Leap::projected(State& state, double t, int terms) const {
  return set(state, t, terms) && f_.project(state, from_);
}

Leap::Result Leap::attempt(const State& from, double distance, double h, const Integrator& allowance) {
  from_ = from;
  h_ = h;
  crossing_ = std::numeric_limits<double>::quiet_NaN();
  const Result result = approach(distance);
  return result == Result::made ? iterate(allowance) : result;
}

/// Computes f at the points from one to the next.
Leap::Result Leap::approach(double distance) {
  constexpr double rest = 1e-6;  // nearer, rounding is as large as the motion
  std::array<double, points + 1> at{from_.t}, distances{distance};
  node_ = from_;
  for (int i = 0; i < points; ++i) {
    const double step = time(i) - node_.t;
    // The first one without f, which may not be determined where the step starts.
    increment_.setZero();
    increment_.head(n_) = step * node_.y.segment(n_, n_);
    if (i > 0) {
      const auto slope = slopes_.col(i - 1);
      increment_.head(n_) += step * step / 2 * slope.segment(n_, n_);
      increment_.tail(increment_.size() - n_) = step * slope.tail(increment_.size() - n_);
    }
    if (!vectors_.addCarried(node_.y.data(), node_.carry.data(), increment_.data(), increment_.size()))
      return Result::diverged;
    node_.t = time(i);
    if (!f_.project(node_, from_)) return Result::diverged;
    const auto k = static_cast<std::size_t>(i + 1);
    at[k] = node_.t;
    margin_ = std::max(f_.margin(), rest * rest);
    distances[k] = std::sqrt(margin_);
    f_.slope(node_.t, node_.y.data(), slopes_.col(i).data());
  }
  // The crossing, by the nearest state and its neighbour: between them, or ahead of all.
  constexpr double far = 0.3;
  const auto [least, most] = std::minmax_element(distances.begin(), distances.end());
  if (*most <= rest) return Result::diverged;
  if (*least > far * *most) return Result::nothing;
  const auto k = static_cast<std::size_t>(least - distances.begin());
  const bool isLast = k == points;
  const std::size_t other = isLast || (k > 0 && distances[k - 1] < distances[k + 1]) ? k - 1 : k + 1;
  const double both = isLast ? distances[k] - distances[other] : distances[k] + distances[other];
  crossing_ = k == 0 ? from_.t : at[k] + (at[other] - at[k]) * distances[k] / both;
  // Near a point, or behind all?
  constexpr double atStart = 0.011, near = 0.03, end = 0.93;
  const double share = (crossing_ - from_.t) / h_;
  const bool isNear =
      share > atStart && ((gauss().nodes.array() - share).abs().minCoeff() < near || share > end);
  return isNear ? Result::nearCrossing : Result::made;
}

/// In units of the error that ten steps as long may add: from one crossing to the next, a motion makes more
/// of them. A change that is rounding counts as none: of a state near the crossing, off the branch.
double Leap::norm(const Vector& change, const Integrator& allowance) const {
  constexpr double steps = 10;
  return change.cwiseAbs().maxCoeff() <= rounding_ ? 0 : allowance.errorNorm(from_.y, steps * h_, change);
}

Leap::Result Leap::iterate(const Integrator& allowance) {
  constexpr int most = 20;
  constexpr double exact = 0.1;  // of the allowance
  constexpr double second = 1;   // s
  // Errors of positions and rates off the branch, at the distance of the last point: they vanish with the
  // next projections.
  constexpr double epsilon = 20 * std::numeric_limits<double>::epsilon();
  const double fastest = from_.y.segment(n_, n_).cwiseAbs().maxCoeff();
  rounding_ = 1e-13 * (1 + from_.y.cwiseAbs().maxCoeff()) + epsilon / std::sqrt(margin_) +
              epsilon / margin_ * fastest;
  last_ = node_;
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0;; ++k) {
    for (int i = 0; i < points; ++i) {
      if (!projected(node_, time(i), points)) return Result::diverged;
      f_.slope(node_.t, node_.y.data(), slopes_.col(i).data());
    }
    change_ = node_.y - last_.y;
    std::swap(last_.y, node_.y);
    const double change = norm(change_, allowance);
    if (change <= exact) break;
    if (k > 1 && change > before / 2) {
      // It changes no more but by rounding, or it diverges.
      if (!(allowance.errorNorm(from_.y, std::max(h_, second), change_) <= 1)) return Result::diverged;
      rounding_ = 2 * change_.cwiseAbs().maxCoeff();
      break;
    }
    if (k == most || !std::isfinite(change)) return Result::diverged;
    before = change;
  }
  return estimate(allowance);
}

/// By the last terms of the series, at the last point: those that are left out are smaller than the last two
/// as much as these are smaller than the two before. Two, as every other term is 0 where the motion is
/// symmetric.
Leap::Result Leap::estimate(const Integrator& allowance) {
  double share = 0;
  for (int terms = points; terms > points - 4; terms -= 2) {
    if (!projected(last_, time(points - 1), terms) || !projected(node_, time(points - 1), terms - 2))
      return Result::diverged;
    change_ = node_.y - last_.y;
    const double size = norm(change_, allowance);
    if (terms == points) {
      error_ = size;
    } else {
      share = size > 0 ? std::min(error_ / size, 1.0) : 1;
    }
  }
  error_ *= share;
  return std::isfinite(error_) ? Result::made : Result::diverged;
}

}  // namespace planar_chain::ode
