#pragma once

/// Random chains with joints of any kind, whose forces depend on position and velocity, and the recursion's
/// view of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "dense_chain.h"
#include "recursion/force_tangent.h"
#include "recursion/general_linearized.h"
#include "recursion/general_recursion.h"
#include "recursion/pose.h"

namespace planar_chain::test {

/// Chains of these are drawn: shares of joints that have armatures, are prescribed, are prismatic.
struct Kind {
  double armatures, prescribed, springs;
  double forces = 1;  ///< 0: none that depends on position or velocity
  double prismatic = 0;
  int rows = 0;         ///< of the tip
  bool isFree = false;  ///< begins with two prismatic joints without mass
  double turning = 0;   ///< 0: the base does not turn
};

/// A law of all six numbers of a place: (F, N) = −A sin(B (x, θ, v, ω)).
struct General {
  Eigen::Matrix<Wide, 3, 4> A;
  Eigen::Matrix<Wide, 4, 6> B;

  Eigen::Matrix<WideComplex, 4, 1> phase(const Placed& at) const {
    Eigen::Matrix<WideComplex, 6, 1> place;
    place << at.x, at.theta, at.v, at.omega;
    return B.cast<WideComplex>() * place;
  }
};

/// A spring with a rest length from a point of the body to one of the ground, a drag in the axes of the body,
/// and a force that stays.
struct Attached {
  Vec2d point, anchor, sail, dead;
  double k, c, length, along, across;
};

/// e M e⁻¹
inline Matrix2d turned(Rotation<double> e, const Matrix2d& M) {
  const Vec2d x = e * (M * Vec2d{e.c, -e.s}), y = e * (M * Vec2d{e.s, e.c});
  return {x.x, y.x, x.y, y.y};
}

/// A force that is Φ(V) in the axes of the body: F = e Φ(V) with V = e⁻¹ v_X, so
///
///     F_v = e (∂Φ/∂V) e⁻¹          F_θ = iF − F_v i v_X
///
/// X, v: the point from the inner pin, and its velocity, base axes. slope: ∂Φ/∂V, N s/m.
inline ForceAt forceInBodyAxes(Rotation<double> e, Vec2d X, Vec2d v, Vec2d Phi, const Matrix2d& slope) {
  ForceAt force{X, e * Phi, {}, turned(e, slope), {}};
  force.turn = perp(force.F) - force.velocity * perp(v);
  return force;
}

class RandomChain : public DenseChain {
 public:
  RandomChain(int n, unsigned seed, const Kind& kind) : general_(index(n)), attached_(index(n)) {
    Random random(seed);
    for (int j = 0; j < n; ++j) {
      links.push_back(
          {"", random.between(0.3, 2), random.between(0.02, 0.3), random.vector(0.5), random.vector(0.8)});
      Joint joint;
      joint.isPrismatic = random.between(0, 1) < kind.prismatic;
      joint.axis = Rotation<double>::of(random.between(-3, 3)) * Vec2d{1, 0};
      JointLaw<double> law;
      if (random.between(0, 1) < kind.armatures) law.armature = random.between(0.01, 0.5);
      law.isPrescribed = random.between(0, 1) < kind.prescribed;
      if (law.isPrescribed) law.acceleration = random.between(-3, 3);
      if (kind.isFree && j < 3) {
        joint.isPrismatic = j < 2;
        joint.axis = j == 0 ? Vec2d{1, 0} : Vec2d{0, 1};
        if (j < 2) links.back() = {};
        law = {};
      }
      joints.push_back(joint);
      laws.push_back(law);
      k.push_back(kind.isFree && j < 3 ? 0 : kind.springs * random.between(0, 40));
      d.push_back(kind.isFree && j < 3 ? 0 : kind.springs * random.between(0, 2));
      rest.push_back(random.between(-1, 1));
      torque.push_back(random.between(-2, 2));
      y.push_back(random.between(-3, 3));
      for (Wide* number = general_[index(j)].A.data(); number < general_[index(j)].A.data() + 12; ++number) {
        *number = kind.forces * random.between(-5, 5);
      }
      for (Wide* number = general_[index(j)].B.data(); number < general_[index(j)].B.data() + 24; ++number) {
        *number = random.between(-1, 1);
      }
      Attached& on = attached_[index(j)];
      on = {random.vector(0.5), random.vector(3), random.vector(0.5), random.vector(5), 0, 0, 0, 0, 0};
      on.k = kind.forces * random.between(10, 300);
      on.c = kind.forces * random.between(0, 5);
      on.length = random.between(0, 1);
      on.along = kind.forces * random.between(0, 1);
      on.across = kind.forces * random.between(0, 3);
    }
    drawTip(random, kind);
    for (int j = 0; j < n; ++j) y.push_back(random.between(-2, 2));
    gravity = random.vector(10);
    base = random.vector(1);
    baseVelocity = random.vector(1);
    baseAcceleration = random.vector(5);
    baseTurning = random.between(-2, 2);
    baseRate = kind.turning * random.between(-2, 2);
  }

  std::vector<double> y;

  WideVector state() const { return Eigen::Map<const Eigen::VectorXd>(y.data(), 2 * size()).cast<Wide>(); }
  /// The bodies there.
  std::vector<Placed> bodies() const { return placed(state().cast<WideComplex>()); }
  Chain chain() const {
    std::vector<Link> named = links;
    std::vector<Joint> plain = joints;
    for (std::size_t i = 0; i < named.size(); ++i) {
      named[i].name = "link_" + std::to_string(i);
      plain[i].name = "joint_" + std::to_string(i);
    }
    return Chain(named, plain, gravity);
  }
  /// The torque or force in each joint, without armatures and what prescribes it.
  std::vector<double> torques() const {
    std::vector<double> all;
    const Coordinates of = coordinates();
    for (int j = 0; j < size(); ++j) {
      const auto i = index(j);
      all.push_back(torque[i] - k[i] * (of.relative(y.data(), j) - rest[i]) -
                    d[i] * of.relative(y.data() + size(), j));
    }
    return all;
  }
  /// The tip, its acceleration less gravity.
  Tip<double> heldTip() const { return {tip.rows, tip.row, tip.acceleration - gravity}; }

  Acting actingOn(int j, const Placed& at) const override {
    Acting sum;
    if (hasNoForces(j)) return sum;
    const Eigen::Matrix<WideComplex, 3, 1> given =
        general_[index(j)].A.cast<WideComplex>() * general_[index(j)].phase(at).array().sin().matrix();
    sum.F -= given.head<2>();
    sum.N -= given[2];
    const Attached& on = attached_[index(j)];
    const auto add = [&](Vec2d point, auto law) {
      const Vector2 X = turnedBy(at.theta, point);
      const Vector2 F = law(Vector2(at.x + X), Vector2(at.v + at.omega * quarter(X)));
      sum.F += F;
      sum.N += crossed(X, F);
    };
    add(on.point, [&](const Vector2& x, const Vector2& v) {
      const Vector2 D = x - wide(on.anchor);
      const WideComplex length = std::sqrt(D.x() * D.x() + D.y() * D.y());
      const Vector2 n = D / length;
      const WideComplex rate = n.x() * v.x() + n.y() * v.y();
      return Vector2(-(Wide(on.k) * (length - Wide(on.length)) + Wide(on.c) * rate) * n);
    });
    add(on.sail, [&](const Vector2&, const Vector2& v) {
      const Vector2 V = turnedBack(at.theta, v);
      const WideComplex size = std::sqrt(Wide(1) + V.x() * V.x() + V.y() * V.y());
      const Vector2 Phi{-Wide(on.along) * size * V.x(), -Wide(on.across) * size * V.y()};
      const WideComplex c = std::cos(at.theta), s = std::sin(at.theta);
      return Vector2(c * Phi.x() - s * Phi.y(), s * Phi.x() + c * Phi.y());
    });
    add(on.point, [&](const Vector2&, const Vector2&) { return wide(on.dead); });
    return sum;
  }

  /// K and D of body j by formula.
  ForceTangent tangentOf(int j, const Placed& at) const {
    ForceTangent tangent;
    if (hasNoForces(j)) return tangent;
    const General& law = general_[index(j)];
    const Eigen::Matrix<Wide, 3, 6> slope =
        law.A * law.phase(at).real().array().cos().matrix().asDiagonal() * law.B;
    take(slope.leftCols<3>().cast<double>(), tangent.K);
    take(slope.rightCols<3>().cast<double>(), tangent.D);

    const Attached& on = attached_[index(j)];
    const auto e = Rotation<double>::of(real(at.theta));
    const double omega = real(at.omega);
    const auto velocity = [&](Vec2d X) { return narrow(at.v) + omega * perp(X); };
    {
      const Vec2d X = e * on.point, D = narrow(at.x) + X - on.anchor, v = velocity(X);
      const double l = length(D);
      const Vec2d n = (1 / l) * D, across = v - dot(n, v) * n;
      const double T = on.k * (l - on.length) + on.c * dot(n, v);
      const Matrix2d nn{n.x * n.x, n.x * n.y, n.x * n.y, n.y * n.y};
      const auto at2 = [&](double along, double sideways, double mixed) {
        return Matrix2d{-along * nn.xx - sideways * (1 - nn.xx) - mixed * n.x * across.x,
                        (sideways - along) * nn.xy - mixed * n.x * across.y,
                        (sideways - along) * nn.yx - mixed * n.y * across.x,
                        -along * nn.yy - sideways * (1 - nn.yy) - mixed * n.y * across.y};
      };
      addForce({X, -T * n, at2(on.k, T / l, on.c / l), at2(on.c, 0, 0), {}}, omega, tangent);
    }
    {
      const Vec2d X = e * on.sail, v = velocity(X), V = Rotation<double>{e.c, -e.s} * v;
      const double size = std::sqrt(1 + dot(V, V));
      const Matrix2d slopeOfPhi{-on.along * (size + V.x * V.x / size), -on.along * V.x * V.y / size,
                                -on.across * V.x * V.y / size, -on.across * (size + V.y * V.y / size)};
      addForce(forceInBodyAxes(e, X, v, {-on.along * size * V.x, -on.across * size * V.y}, slopeOfPhi), omega,
               tangent);
    }
    return tangent;
  }

  double deadXF(int j, const Placed& at) const {
    const Attached& on = attached_[index(j)];
    return hasNoForces(j) ? 0 : dot(Rotation<double>::of(real(at.theta)) * on.point, on.dead);
  }

  static double real(WideComplex z) { return static_cast<double>(z.real()); }
  static Vec2d narrow(const Vector2& a) { return {real(a.x()), real(a.y())}; }

 private:
  /// A moment on a body that turns with the base is the base's alone: these have neither.
  bool hasNoForces(int j) const { return coordinates().turner(j) < 0; }
  void drawTip(Random& random, const Kind& kind) {
    tip.rows = kind.rows;
    tip.row[0] = Rotation<double>::of(random.between(-3, 3)) * Vec2d{1, 0};
    tip.row[1] = perp(tip.row[0]);
    tip.acceleration = random.vector(2);
  }

  static void take(const Eigen::Matrix3d& slope, PlaneTangent& to) {
    to = {{slope(0, 0), slope(0, 1), slope(1, 0), slope(1, 1)},
          {slope(0, 2), slope(1, 2)},
          {slope(2, 0), slope(2, 1)},
          slope(2, 2)};
  }

  std::vector<General> general_;
  std::vector<Attached> attached_;
};

/// What the recursions need of the state of a random chain.
struct AtState {
  explicit AtState(const RandomChain& of)
      : chain(of.chain()), answer(of.solve(of.state().cast<WideComplex>())), N(index(of.size())) {
    const Coordinates& coordinates = chain.coordinates();
    const int n = of.size();
    XF = N;
    for (const Placed& at : of.bodies()) {
      const int j = static_cast<int>(e.size()), turner = coordinates.turner(j);
      const Acting acting = of.actingOn(j, at);
      tangents.push_back(of.tangentOf(j, at));
      F.push_back(RandomChain::narrow(acting.F));
      if (turner >= 0) {
        N[index(turner)] += RandomChain::real(acting.N);
        XF[index(turner)] += of.deadXF(j, at);
      }
      e.push_back(Rotation<double>::of(RandomChain::real(at.theta)));
      omega.push_back(RandomChain::real(at.omega));
      xdd.push_back(RandomChain::real(answer.xdd[j]));
      displaced.push_back(displacementOf(of.joints[index(j)].axis, e.back(), omega.back(), of.y[index(j)],
                                         of.y[index(n + j)]));
    }
    base = of.baseAcceleration - of.gravity;
    state = {e.data(),
             omega.data(),
             of.y.data() + n,
             xdd.data(),
             displaced.data(),
             F.data(),
             XF.data(),
             of.k.data(),
             of.d.data(),
             of.laws.data(),
             base,
             of.baseTurning,
             RandomChain::narrow(answer.tip),
             of.heldTip()};
  }

  Chain chain;
  DenseChain::Answer answer;
  std::vector<ForceTangent> tangents;
  std::vector<Rotation<double>> e;
  std::vector<Vec2d> F;
  std::vector<double> N, XF, omega, xdd;
  std::vector<Displacement<double>> displaced;
  Vec2d base;
  GeneralState state;
};

/// Calls check(chain, seed) with random chains of every kind and length. forces: 0, none that depends on
/// position or velocity. tips: false if all are free.
template <class Check>
void forAllKinds(double forces, const Check& check, bool tips = true) {
  unsigned seed = 0;
  for (const Kind& of : {Kind{0, 0, 0}, Kind{0, 0, 1}, Kind{0.5, 0, 1}, Kind{0.5, 0.3, 1}}) {
    for (const double prismatic : {0.0, 0.3, 0.7, 1.0, -1.0}) {
      for (const int rows : {0, 1, 2}) {
        for (int n = 1; n <= 12; ++n) {
          Kind kind = of;
          kind.forces = forces;
          kind.turning = 1;
          kind.isFree = prismatic < 0 && n > 2;
          kind.prismatic = std::max(prismatic, 0.0);
          kind.rows = rows;
          if (rows > 0 && !tips) continue;
          const RandomChain chain(n, ++seed, kind);
          const auto freedoms = std::count_if(chain.laws.begin(), chain.laws.end(),
                                              [](const auto& law) { return !law.isPrescribed; });
          if (freedoms < rows) continue;
          SCOPED_TRACE(testing::Message()
                       << n << " bodies, prismatic " << prismatic << ", rows " << rows << ", seed " << seed);
          check(chain, seed);
        }
      }
    }
  }
}

/// The largest difference over the largest number of `among`.
inline double errorOf(const ComplexVector& is, const ComplexVector& exact, const ComplexVector& among) {
  return static_cast<double>((is - exact).cwiseAbs().maxCoeff() / (1e-3L + among.cwiseAbs().maxCoeff()));
}
inline double errorOf(const ComplexVector& is, const ComplexVector& exact) {
  return errorOf(is, exact, exact);
}

}  // namespace planar_chain::test
