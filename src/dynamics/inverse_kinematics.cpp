/// Levenberg and Marquardt's method within bounds: with the residual r(q), 3 numbers,
///
///     d = −Jᵀ (J Jᵀ + λ 1)⁻¹ r          J: only columns of joints that move
///
/// The step ends at the bounds, and a joint on its bound that d would move beyond does not move. λ grows
/// until the step makes |r| smaller, and shrinks after.

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <random>

#include "dynamics/given_state.h"
#include "planar_chain/kinematics.h"

namespace planar_chain {

namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double exact = 1e-12;

class Search {
 public:
  Search(const Scene& scene, const Frame& frame, Vec2d place, std::optional<double> angle, double t)
      : scene_(scene), frame_(frame), place_(place), angle_(angle), t_(t), reach_(scene.chain.reach()) {
    const auto n = static_cast<Eigen::Index>(scene.q.size());
    lower_.resize(n);
    upper_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Joint& joint = scene.chain.joints()[static_cast<std::size_t>(i)];
      lower_[i] = joint.lower;
      upper_[i] = joint.upper;
    }
    for (const Drive& drive : scene.drives) lower_[drive.joint] = upper_[drive.joint] = drive.law.at(t).value;
  }

  VectorXd within(const VectorXd& q) const { return q.cwiseMax(lower_).cwiseMin(upper_); }
  /// Angles for another try.
  VectorXd drawn(const VectorXd& around, std::minstd_rand& random) const {
    const auto share = [&] {
      return static_cast<double>(random()) / static_cast<double>(std::minstd_rand::max());
    };
    VectorXd q = around;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const double far = scene_.chain.coordinates().isPrismatic(static_cast<int>(i)) ? reach_ : pi;
      const double low = std::max(lower_[i], q[i] - far), high = std::min(upper_[i], q[i] + far);
      if (low <= high) q[i] = low + share() * (high - low);
    }
    return within(q);
  }

  Reached from(VectorXd q) const {
    constexpr int mostSteps = 500;
    constexpr double first = 1e-3, less = 0.1, more = 4, mostDamping = 1e12, leastGain = 1e-15;
    Vector3d r = residual(q);
    double damping = first;
    for (int k = 0; k < mostSteps && !result(q).isReached; ++k) {
      Eigen::MatrixXd J = jacobianOf(scene_, frame_, t_, q);
      J.row(2) *= angle_ ? reach_ : 0;
      VectorXd next;
      Vector3d then;
      for (;; damping *= more) {
        next = within(q + step(q, J, r, damping * reach_ * reach_));
        then = residual(next);
        if (then.norm() < r.norm() || damping > mostDamping) break;
      }
      const bool isOver = !(then.norm() < (1 - leastGain) * r.norm());
      if (then.norm() < r.norm()) {
        q = next;
        r = then;
      }
      if (isOver) break;
      damping *= less;
    }
    return result(q);
  }

 private:
  Vector3d residual(const VectorXd& q) const {
    const FrameMotion at = motionAt(q);
    const Vec2d gap = at.position - place_;
    return {gap.x, gap.y, reach_ * turn(at)};
  }
  Reached result(const VectorXd& q) const {
    const FrameMotion at = motionAt(q);
    const double distance = length(at.position - place_), left = std::abs(turn(at));
    const bool isReached = distance <= exact * std::max(reach_, length(place_)) && left <= exact;
    return {q, distance, left, isReached};
  }
  FrameMotion motionAt(const VectorXd& q) const {
    const VectorXd still = VectorXd::Zero(q.size());
    return motionOf(scene_, frame_, t_, q, still, still);
  }
  /// From −π to π.
  double turn(const FrameMotion& at) const { return angle_ ? std::remainder(at.angle - *angle_, 2 * pi) : 0; }
  /// `damping` in m².
  VectorXd step(const VectorXd& q, Eigen::MatrixXd J, const Vector3d& r, double damping) const {
    const auto n = q.size();
    for (Eigen::Index left = n;; --left) {
      const Eigen::Matrix3d solved = J * J.transpose() + damping * Eigen::Matrix3d::Identity();
      const VectorXd d = -J.transpose() * solved.ldlt().solve(r);
      bool anyStops = false;
      for (Eigen::Index i = 0; i < n; ++i) {
        const bool stops = (d[i] < 0 && q[i] <= lower_[i]) || (d[i] > 0 && q[i] >= upper_[i]);
        if (stops) J.col(i).setZero();
        anyStops = anyStops || stops;
      }
      if (!anyStops || left == 0) return d;
    }
  }

  const Scene& scene_;
  const Frame& frame_;
  Vec2d place_;
  std::optional<double> angle_;
  double t_, reach_;
  VectorXd lower_, upper_;
};

}  // namespace

Reached inverseKinematics(const Scene& scene, const Frame& frame, Vec2d place, std::optional<double> angle,
                          const std::optional<VectorXd>& start, double t) {
  constexpr int tries = 30;
  std::vector<Fault> faults;
  const VectorXd given =
      start.value_or(VectorXd::Map(scene.q.data(), static_cast<Eigen::Index>(scene.q.size())));
  checkNumbers("start", scene, given, "rad", faults);
  if (!(std::isfinite(place.x) && std::isfinite(place.y)))
    faults.push_back({"place", "two finite numbers, in m", "numbers that are not"});
  if (angle && !std::isfinite(*angle)) faults.push_back({"angle", "a finite number, in rad", toText(*angle)});
  if (scene.tip) faults.push_back({"scene", "a chain whose tip is free", "one whose tip is held"});
  if (!faults.empty()) throw Refused(std::move(faults));

  const Search search(scene, frame, place, angle, t);
  std::minstd_rand random(1);
  Reached best = search.from(search.within(given));
  const auto missing = [&](const Reached& one) {
    return std::hypot(one.distance, scene.chain.reach() * one.turn);
  };
  for (int k = 1; k < tries && !best.isReached; ++k) {
    Reached next = search.from(search.drawn(given, random));
    if (next.isReached || missing(next) < missing(best)) best = std::move(next);
  }
  return best;
}

}  // namespace planar_chain
