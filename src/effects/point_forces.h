#pragma once

/// Forces at points of bodies that depend on the position and velocity of their point: what air drag and
/// springs to the ground have in common. A force F acts at X from the own point of its body, which is at p,
/// moves at v_p and turns at ω against the ground:
///
///     x = p + X      v = v_p + ω iX      N_k += X×F      X = e_j (point)
///
/// k: the revolute joint with whose body the body j turns. If there is none, the base takes the moment.

#include <vector>

#include "effects/effect_kind.h"
#include "recursion/pose.h"

namespace planar_chain {

/// Positions and velocities of the first bodies of a chain, from a state in chain order. Only the constructor
/// allocates.
class BodyMotions {
 public:
  /// For bodies 0 … count − 1. The chain must outlive this object.
  BodyMotions(const Chain& chain, int count);

  /// x, rates: angles from the base, displacements, and their rates.
  void find(const BaseState& base, const double* x, const double* rates);
  /// A point of a body, link frame.
  PointAt<double> of(int body, Vec2d point) const;
  const Rotation<double>& turn(int body) const { return e_[index(body)]; }
  const Vec2d& pin(int body) const { return own_[index(body)].position; }

 private:
  const Chain& chain_;
  std::vector<double> angles_, rates_;
  std::vector<Rotation<double>> e_;
  std::vector<PointAt<double>> own_;
};

/// The point at which a force acts.
struct ForcePoint {
  int body;
  Vec2d point;  ///< m, link frame
};

/// A force, N, and the power that it takes from the chain, W.
struct PointForce {
  Vec2d F;
  double taken = 0;
};
/// Their derivatives by the position and velocity of the point.
struct PointTangent {
  Matrix2d position, velocity;  ///< F_x, N/m; F_v, N s/m
  Vec2d takenByPosition, takenByVelocity;
};

class PointForces : public Effect, public Forces {
 public:
  LoadKind mostActing() const final { return LoadKind::forces; }
  Forces* forces() final { return this; }
  int reach() const final { return reach_; }
  bool dependOnMotion() const final { return true; }
  Powers apply(const ChainState& at, const Actions& to) final;
  void addTorques(const ChainState& /*at*/, double* /*tau*/) final {}
  void addForceTangents(const ChainState& at, ForceTangent* to) final;
  Powers powersAlong(const ChainState& at, const StateChange& along) final;
  /// Velocities pass 0, and lengths of springs: no series converges there.
  bool hasSeries() const final { return false; }

  const std::vector<ForcePoint>& points() const { return points_; }
  /// Force i at this position and velocity of its point. The position is known only if forces
  /// dependOnPosition().
  virtual PointForce force(std::size_t i, const PointAt<double>& at) const = 0;

 protected:
  explicit PointForces(const Chain& chain) : coordinates_(chain.coordinates()) {}
  void add(const ForcePoint& point);
  virtual PointTangent tangent(std::size_t i, const PointAt<double>& at) const = 0;

 private:
  double rateOf(int body, const ChainState& at) const {
    return coordinates_.angle(at.omega, body) + at.baseRate;
  }
  PointAt<double> pointAt(const ForcePoint& point, const ChainState& at) const;

  Coordinates coordinates_;
  std::vector<ForcePoint> points_;
  int reach_ = 0;
};

/// Adds the same forces in the dense form of EffectKind::addDense(), in their present state.
void addDenseForces(const PointForces& forces, const Scene& scene, double t, const Eigen::VectorXd& q,
                    const Eigen::VectorXd& qd, const DenseActions& to);

}  // namespace planar_chain
