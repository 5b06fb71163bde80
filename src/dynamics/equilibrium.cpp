#include "dynamics/equilibrium.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "dynamics/body_groups.h"
#include "dynamics/closure.h"
#include "dynamics/effect_tangents.h"
#include "dynamics/group_matrix.h"
#include "dynamics/position_terms.h"
#include "dynamics/stored_energy.h"
#include "effects/effects.h"
#include "lanes/segments.h"
#include "recursion/pose.h"

namespace planar_chain {

namespace {

/// rad from the start: an energy that still falls there has no minimum. Smaller, a chain that winds up under
/// a torque is refused though its springs hold it; larger, one that has no equilibrium is refused later.
constexpr double farthest = 1e3;
/// rad in one step. Longer, a step passes the nearest minimum and ends in another one.
constexpr double longestTurn = 1;
/// The largest moment of a balanced pose, over the moments of the weight: some fifty roundings. Below
/// rounding, no pose is balanced.
constexpr double exact = 1e-14;
/// That of a pose from which no step lowers the energy. Larger, a pose on a slope may count as balanced.
constexpr double balanced = 1e-7;
/// rad, off a stationary point. The energy falls by its square, 1e-6 of the curvature: far above rounding.
/// Much larger, the push leads over the next ridge.
constexpr double push = 1e-3;
/// A step must lower the energy by this share of what its slope promises (Armijo's rule). Near 1, good steps
/// are refused; at 0, steps may shrink to nothing on the way.
constexpr double promised = 1e-4;
/// A step is halved down to this share. Below, the energies of both ends differ by rounding alone.
constexpr double shortestStep = 1e-10;
/// A pivot up to this share of the weight's moments may be rounding, so its sign is unknown. Larger, the
/// search leaves minima of soft chains; smaller, it stays on saddles.
constexpr double unsure = 1e-12;

class Search {
 public:
  Search(const Scene& scene, double t)
      : scene_(scene),
        t_(t),
        coordinates_(scene.chain.coordinates()),
        n_(scene.chain.size()),
        effects_(scene, nullptr, &EffectKind::isInEquilibrium),
        groups_(scene, effects_.anyForces(&Forces::dependOnPosition)),
        tangents_(n_, effects_),
        stores_(scene.chain),
        reach_(scene.chain.reach()) {
    effects_.enter(t);
    if (scene.base) base_ = stateOf(*scene.base, t).atRest();
    matrix_.apart = groups_.displacements();
    for (int g = 0; g < groups_.displacements(); ++g)
      matrix_.turner.push_back(groups_.turner(groups_.first(g)));
    for (const Load& load : scene.loads) loads_.push_back({&load, factorAt(load, t)});
    // The moments that weights and forces can have: what residuals are compared with.
    double reach = 0;
    for (const Link& link : scene.chain.links()) reach += length(link.pin) + length(link.com);
    for (const Link& link : scene.chain.links()) {
      scale_ += link.mass * length(scene.chain.gravity()) * reach;
      scale_ += stiffnessOf(link) * std::max(reach, reach_) * reach_;
    }
    for (const auto& [load, factor] : loads_) {
      scale_ +=
          std::abs(factor) * (length(load->force) * reach + std::abs(load->moment) + std::abs(load->torque));
    }
    acting_ = scale_;
    for (const Joint& joint : scene.chain.joints())
      scale_ += (joint.isPrismatic ? reach_ : 1) * momentOf(joint);
    if (!std::isfinite(scale_)) throw std::domain_error("forces and torques whose sum is not finite");
    matrix_.floor *= scale_;
    if (scene.tip) hold();
    N_.resize(n_);
    still_.setZero(n_);
    e_.resize(index(n_));
    for (auto* vectors : {&F_, &pinVelocity_, &position_}) vectors->resize(index(n_));
  }

  std::vector<double> from(std::vector<double> q, int mostSteps, const std::function<bool()>& keepGoing) {
    for (int j = 0; j < n_ && !held_; ++j) {
      if (!coordinates_.isPrismatic(j)) q[index(j)] = nearer(j, q[index(j)]);
    }
    for (const Drive& drive : scene_.drives) q[index(drive.joint)] = drive.law.at(t_).value;
    Eigen::VectorXd theta(n_);
    coordinates_.toAbsolute(q.data(), theta.data());
    for (int i = 0; i < coordinates_.leading() && !held_ && !groups_.dependOnPosition(); ++i) {
      if (!groups_.isDriven(i)) equilibrateCarriage(i, theta);
    }
    const Eigen::VectorXd start = theta;
    int step = 0;
    for (; step < mostSteps && (!keepGoing || keepGoing()); ++step) {
      find(theta);
      const bool isBalanced = groups_.size() == 0 || moment_.cwiseAbs().maxCoeff() <= exact * scale_;
      if (isBalanced && leaveSaddle(theta)) continue;
      if (isBalanced || !descend(theta)) {
        // No step lowers the energy: rounding is all that is left, or the energy is flat.
        if (leaveSaddle(theta)) continue;
        if (!isBalanced) requireBalance(theta, step);
        std::vector<double> found(index(n_));
        coordinates_.toRelative(theta.data(), found.data());
        for (const Drive& drive : scene_.drives) found[index(drive.joint)] = q[index(drive.joint)];
        return found;
      }
      for (int j = 0; j < n_; ++j) {
        if (std::abs(theta[j] - start[j]) > farthest * unitOf(j)) giveUpFarFromStart(j);
      }
    }
    throw SearchGaveUp("the search for an equilibrium gave up after " + std::to_string(step) +
                       " steps: there may be one");
  }

 private:
  /// @throws SearchGaveUp on a slope
  void requireBalance(const Eigen::VectorXd& theta, int step) {
    find(theta);
    const double left = moment_.cwiseAbs().maxCoeff();
    if (left <= balanced * scale_) return;
    throw SearchGaveUp("the search for an equilibrium gave up after " + std::to_string(step) +
                       " steps, where " + toText(left) + " N m are not balanced: there may be one");
  }
  /// The angle q of a joint; or, if all that acts is too weak to hold it more than a turn of a step away,
  /// where its springs and stops alone have least energy. The search would go there by a step for each rad.
  double nearer(int j, double q) const {
    const double least = leastStored(stores_, scene_.chain.joints()[index(j)], q, acting_);
    return std::abs(least - q) > longestTurn ? least : q;
  }

  /// The displacement that counts as much as an angle of 1 rad, m. It makes forces comparable with moments.
  double unitOf(int j) const { return coordinates_.isPrismatic(j) ? reach_ : 1; }

  /// @throws SearchGaveUp where springs or stops hold body j, else std::domain_error
  [[noreturn]] void giveUpFarFromStart(int j) const {
    const std::vector<Joint>& joints = scene_.chain.joints();
    const auto own = joints.begin() + j;
    if (std::all_of(own->isPrismatic ? own : joints.begin(), own + 1, storesEnergy))
      throw SearchGaveUp("the search for an equilibrium gave up " + toText(farthest * unitOf(j)) +
                         (own->isPrismatic ? " m" : " rad") + " from its start: there may be one");
    if (own->isPrismatic) throw std::domain_error(endlessMotion(*own));
    throw std::domain_error("the energy falls without end, as under a constant torque without a spring");
  }
  static std::string endlessMotion(const Joint& joint, const std::string& why = "") {
    return "the joint " + joint.name + " slides without end" + why + ": it needs a spring or a limit";
  }

  /// A tip that is held: what closes the chain.
  struct Held {
    Held(const Scene& scene, int n) : mechanism(scene, true), closure(mechanism), at(n), y(2 * n) {}

    Mechanism mechanism;
    Closure closure;
    Couplings at;
    Vec2d force;              ///< λ
    Eigen::VectorXd y, x[2];  ///< x: how far each row of the tip moves with each group
  };

  void hold() {
    held_.emplace(scene_, n_);
    Effects all(scene_);
    all.enter(t_);
    all.couple(t_, 0, held_->at);
    held_->at.tipVelocity = {};
  }

  /// λ and the step of Newton's method that keeps the tip: with H turn = Γ + Σ X_r δφ_r and X_rᵀ turn = 0.
  Eigen::VectorXd closedTurn() {
    Held& held = *held_;
    const int rows = held.at.tip.rows;
    Eigen::VectorXd turn = matrix_.solved(moment_), by[2];
    Eigen::Matrix2d S = Eigen::Matrix2d::Identity();
    Eigen::Vector2d rest = Eigen::Vector2d::Zero();
    for (int r = 0; r < rows; ++r) {
      by[r] = matrix_.solved(held.x[r]);
      rest[r] = -held.x[r].dot(turn);
    }
    for (int r = 0; r < rows; ++r) {
      for (int s = 0; s < rows; ++s) S(r, s) = held.x[r].dot(by[s]);
    }
    const Eigen::Vector2d phi = S.fullPivLu().solve(rest);
    for (int r = 0; r < rows; ++r) {
      turn += phi[r] * by[r];
      held.force += phi[r] * held.at.tip.row[index(r)];
    }
    return turn;
  }
  /// The step, with the force on the tip in H as far as it is known. Empty if no share gives pivots above
  /// `least`.
  Eigen::VectorXd turnFrom(const Eigen::VectorXd& theta, const std::vector<double>& shares,
                           double least = 0) {
    if (!matrix_.factorBy(shares, least)) return {};
    if (!held_) return matrix_.solved(moment_);
    closedTurn();
    find(theta);
    return matrix_.factorBy(shares, least) ? closedTurn() : Eigen::VectorXd();
  }

  /// Newton's method along the axis of a carriage whose springs and stops are piecewise linear.
  void equilibrateCarriage(int i, Eigen::VectorXd& theta) {
    const Joint& joint = scene_.chain.joints()[index(i)];
    constexpr int most = 100;
    for (int step = 0; step < most; ++step) {
      find(theta);
      double force = N_[i];
      for (int j = i; j < n_; ++j) {
        const Link& link = scene_.chain.links()[index(j)];
        force += dot(axisOf(i), link.mass * scene_.chain.gravity() + F_[index(j)]);
      }
      if (std::abs(force) <= exact * scale_) return;
      const double stop = force > 0 ? joint.upper : joint.lower, k = tangents_.k[index(i)];
      if (k > 0) {
        theta[i] += force / k;
      } else if (std::isfinite(stop) && (force > 0 ? theta[i] <= stop : theta[i] >= stop)) {
        theta[i] = stop + force / joint.stopStiffness;
      } else {
        throw std::domain_error(endlessMotion(joint, " under " + toText(force) + " N"));
      }
    }
    throw std::domain_error("none was found for the joint " + joint.name);
  }

  /// Γ and the tridiagonal matrix of the groups.
  void find(const Eigen::VectorXd& theta) {
    pose(theta);
    N_.setZero();
    std::fill(F_.begin(), F_.end(), Vec2d{});
    effects_.enterState(t_, (Eigen::VectorXd(2 * n_) << theta, still_).finished().data());
    const ChainState at{t_, theta.data(), still_.data(), e_.data(), pinVelocity_.data(), 0, position_.data()};
    effects_.apply(at, {N_.data(), F_.data()});
    tangents_.takeConstant(effects_);
    tangents_.takeJoints(effects_, at);
    tangents_.takeForces(effects_, at);
    const int groups = groups_.size();
    moment_.setZero(groups);
    matrix_.kappa.setZero(groups);
    matrix_.spring.setZero(groups);
    Vec2d outer;
    if (held_) outer = held_->force;
    matrix_.across.setZero(matrix_.apart);
    for (int j = n_ - 1; j >= 0; --j) addBody(j, theta[j], outer);
    for (int g = 0; g < groups; ++g) {
      const int first = groups_.first(g);
      matrix_.spring[g] = unitOf(first) * unitOf(first) * tangents_.k[index(first)];
    }
    matrix_.terms.clear();
    const GroupedPose posed{scene_.chain, groups_, reach_, e_.data(), theta.data()};
    for (int j = 0; groups_.dependOnPosition() && j < n_; ++j)
      addPositionTerms(posed, tangents_.bodies[index(j)].K, j, matrix_.terms);
    for (int r = 0; held_ && r < held_->at.tip.rows; ++r)
      held_->x[r] = posed.tipAlong(held_->at.tip.row[index(r)]);
  }
  /// Poses the bodies.
  void pose(const Eigen::VectorXd& theta) {
    for (int j = 0; j < n_; ++j)
      e_[index(j)] = plainRotation(coordinates_.angle(theta.data(), j) + base_.angle);
    sweepOutwards(scene_.chain, PointAt<double>{base_.pin, {}}, e_.data(), still_.data(), theta.data(),
                  still_.data(), [&](int j, const auto& own) { position_[index(j)] = own.position; });
  }
  /// Adds body j to the sums over the bodies further out. x: its coordinate; outer: the sum of forces.
  void addBody(int j, double x, Vec2d& outer) {
    const Link& link = scene_.chain.links()[index(j)];
    const Vec2d weight = link.mass * scene_.chain.gravity();
    const Vec2d R = e_[index(j)] * link.com, P = e_[index(j)] * link.pin;
    const Vec2d all = outer + weight + F_[index(j)];
    const int turned = groups_.turner(j);
    const bool isPrismatic = coordinates_.isPrismatic(j);
    if (turned >= 0) {
      moment_[turned] += (isPrismatic ? 0 : N_[j]) + cross(R, weight) + cross(P, outer);
      matrix_.kappa[turned] += dot(R, weight) + dot(P, outer);
      if (!isPrismatic && !tangents_.XF.empty()) matrix_.kappa[turned] += tangents_.XF[index(j)];
    }
    if (isPrismatic) {
      const Vec2d d = axisOf(j), S = x * d;
      const int own = groups_.of(j);
      if (turned >= 0) {
        moment_[turned] += cross(S, all);
        matrix_.kappa[turned] += dot(S, all);
      }
      if (own >= 0) {
        moment_[own] += reach_ * N_[j] + dot(reach_ * d, all);
        matrix_.across[own] = -dot(reach_ * perp(d), all);
      }
    }
    outer = all;
  }
  Vec2d axisOf(int i) const { return e_[index(i)] * scene_.chain.joints()[index(i)].axis; }
  /// V of weights, springs, stops and loads, J.
  double energyAt(const Eigen::VectorXd& theta) {
    double energy = energyOf(scene_.chain, stores_, theta.data(), still_.data(), base_).potential;
    if (loads_.empty()) return energy;
    pose(theta);
    for (const auto& [load, factor] : loads_) {
      if (load->joint != Load::none)
        energy -= factor * load->torque * coordinates_.relative(theta.data(), load->joint);
      if (load->link == Load::none) continue;
      const Vec2d point = position_[index(load->link)] + e_[index(load->link)] * load->point;
      energy -=
          factor * (dot(load->force, point) + load->moment * coordinates_.angle(theta.data(), load->link));
    }
    return energy;
  }

  /// theta turned, with the tip where it is held.
  Eigen::VectorXd moved(const Eigen::VectorXd& theta, const Eigen::VectorXd& turn, double share) {
    Eigen::VectorXd next = theta;
    for (int j = 0; j < n_; ++j) {
      if (groups_.of(j) >= 0) next[j] += share * unitOf(j) * turn[groups_.of(j)];
    }
    if (!held_) return next;
    held_->y << next, still_;
    const bool isClosed = held_->closure.project(held_->at, held_->y.data(), nullptr);
    return isClosed ? Eigen::VectorXd(held_->y.head(n_)) : theta;
  }

  /// One step. Returns false if none lowers the energy or, close to the minimum, the moments.
  bool descend(Eigen::VectorXd& theta) {
    // The true matrix if it is positive definite, else the nearest of some that are.
    Eigen::VectorXd turn = turnFrom(theta, {0.0, 1. / 64, 1. / 8, 0.5, 1.0});
    if (turn.size() == 0) return false;
    turn *= std::min(1.0, longestTurn / turn.cwiseAbs().maxCoeff());
    const double slope = moment_.dot(turn), energy = energyAt(theta);
    const double largest = moment_.cwiseAbs().maxCoeff();
    for (double share = 1; share > shortestStep; share /= 2) {
      const Eigen::VectorXd next = moved(theta, turn, share);
      if (energyAt(next) < energy - promised * share * slope) {
        theta = next;
        return true;
      }
    }
    // Energies differ by rounding alone: Newton's step by itself, while it lowers the moments. A held tip
    // makes a minimum where H alone has none.
    turn = turnFrom(theta, {0.0}, held_ ? -std::numeric_limits<double>::infinity() : 0);
    if (turn.size() == 0) return false;
    const Eigen::VectorXd next = moved(theta, turn, 1);
    find(next);
    if (!(moment_.cwiseAbs().maxCoeff() < largest)) return false;
    theta = next;
    return true;
  }

  /// Moves downhill off a maximum, a saddle or an inflexion. Returns false at a minimum.
  bool leaveSaddle(Eigen::VectorXd& theta) {
    constexpr int mostPushes = 1000;
    constexpr double epsilon = std::numeric_limits<double>::epsilon();
    find(theta);
    const Eigen::Index groups = matrix_.kappa.size(), bad = matrix_.factor(0, unsure * scale_);
    if (groups == 0 || ++pushes_ > mostPushes) return false;
    // The softest direction x: xᵀ H x is that pivot; or by inverse iteration.
    Eigen::VectorXd x(groups);
    if (bad < groups) {
      x = matrix_.alongPivot(bad);
    } else {
      for (Eigen::Index g = 0; g < groups; ++g) x[g] = 1 + 0.5 * plainRotation(static_cast<double>(g)).s;
      for (int k = 0; k < 4; ++k) x = matrix_.solved(x).normalized();
    }
    x *= push / x.cwiseAbs().maxCoeff();
    const Eigen::VectorXd one = moved(theta, x, 1), other = moved(theta, x, -1);
    const double energy = energyAt(theta), oneEnergy = energyAt(one), otherEnergy = energyAt(other);
    const double rounding =
        bad < groups && matrix_.pivot[bad] < -unsure * scale_ ? 0 : (16 + n_) * epsilon * scale_;
    if (!(std::min(oneEnergy, otherEnergy) < energy - rounding)) return false;
    theta = oneEnergy < otherEnergy ? one : other;
    return true;
  }

  const Scene& scene_;
  double t_;
  const Coordinates coordinates_;
  int n_, pushes_ = 0;
  GroupMatrix matrix_;
  Effects effects_;
  const BodyGroups groups_;
  EffectTangents tangents_;
  const Stores stores_;
  const double reach_;
  BaseState base_;                 ///< where it stands still
  double scale_ = 0, acting_ = 0;  ///< acting_: of weights, loads and springs to the ground alone
  std::optional<Held> held_;
  std::vector<std::pair<const Load*, double>> loads_;  ///< and their factors
  Eigen::VectorXd N_, still_, moment_;
  std::vector<Vec2d> F_, pinVelocity_, position_;
  std::vector<Rotation<double>> e_;
};

}  // namespace

std::vector<double> equilibriumOf(const Scene& scene, double t, const std::vector<double>& q, int mostSteps,
                                  const std::function<bool()>& keepGoing) {
  return Search(scene, t).from(q, mostSteps, keepGoing);
}

}  // namespace planar_chain
