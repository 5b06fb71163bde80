#include "effects/point_forces.h"

#include <algorithm>

#include "lanes/segments.h"

namespace planar_chain {

// ---- Where bodies are ------------------------------------------------------------------------------

BodyMotions::BodyMotions(const Chain& chain, int count)
    : chain_(chain), angles_(index(count)), rates_(angles_), e_(index(count)), own_(index(count)) {}

void BodyMotions::find(const BaseState& base, const double* x, const double* rates) {
  const int count = static_cast<int>(e_.size());
  for (int j = 0; j < count; ++j) {
    angles_[index(j)] = chain_.coordinates().angle(x, j) + base.angle;
    rates_[index(j)] = chain_.coordinates().angle(rates, j) + base.rate;
  }
  plainRotations(angles_.data(), e_.data(), count);
  sweepOutwards(chain_, 0, count, PointAt<double>{base.pin, base.velocity}, e_.data(), rates_.data(), x,
                rates, [&](int j, const PointAt<double>& own) { own_[index(j)] = own; });
}

PointAt<double> BodyMotions::of(int body, Vec2d point) const {
  const auto& [position, velocity] = own_[index(body)];
  const Vec2d X = turn(body) * point;
  return {position + X, velocity + rates_[index(body)] * perp(X)};
}

// ---- Forces ------------------------------------------------------------------------------------------

void PointForces::add(const ForcePoint& point) {
  points_.push_back(point);
  reach_ = std::max(reach_, point.body + 1);
}

PointAt<double> PointForces::pointAt(const ForcePoint& point, const ChainState& at) const {
  const Vec2d X = at.e[point.body] * point.point;
  return {(at.pin ? at.pin[point.body] : Vec2d{}) + X,
          at.pinVelocity[point.body] + rateOf(point.body, at) * perp(X)};
}

Powers PointForces::apply(const ChainState& at, const Actions& to) {
  Powers powers;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const ForcePoint& point = points_[i];
    const PointForce acts = force(i, pointAt(point, at));
    const int turner = coordinates_.turner(point.body);
    const double moment = cross(at.e[point.body] * point.point, acts.F);
    if (turner >= 0) {
      to.N[turner] += moment;
    } else {
      powers.supplied -= moment * at.baseRate;  // of the base, which takes it
    }
    to.F[point.body] += acts.F;
    powers.dissipated += acts.taken;
  }
  return powers;
}

void PointForces::addForceTangents(const ChainState& at, ForceTangent* to) {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const int j = points_[i].body;
    const PointAt<double> point = pointAt(points_[i], at);
    const PointTangent change = tangent(i, point);
    addForce({at.e[j] * points_[i].point, force(i, point).F, change.position, change.velocity, {}},
             rateOf(j, at), to[j]);
    if (coordinates_.turner(j) >= 0) continue;
    for (PlaneTangent* moments : {&to[j].K, &to[j].D}) {  // see apply()
      moments->momentShift = {};
      moments->momentTurn = 0;
    }
  }
}

/// δx = δp + iX δθ      δv = δv_p + iX δω − ω X δθ      δ(X×F) = iX·δF − X·F δθ
Powers PointForces::powersAlong(const ChainState& at, const StateChange& along) {
  Powers change;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const int j = points_[i].body;
    const PointAt<double> point = pointAt(points_[i], at);
    const PointTangent by = tangent(i, point);
    const Vec2d X = at.e[j] * points_[i].point;
    const double turn = coordinates_.angle(along.u, j) + along.turn,
                 speed = coordinates_.angle(along.v, j) + along.speed;
    const Vec2d dx = (along.pin ? along.pin[j] : Vec2d{}) + turn * perp(X),
                dv = along.pinVelocity[j] + speed * perp(X) - (rateOf(j, at) * turn) * X;
    change.dissipated += dot(by.takenByPosition, dx) + dot(by.takenByVelocity, dv);
    if (coordinates_.turner(j) >= 0) continue;
    const Vec2d F = force(i, point).F, dF = by.position * dx + by.velocity * dv;
    change.supplied -= cross(X, F) * along.speed + (dot(perp(X), dF) - dot(X, F) * turn) * at.baseRate;
  }
  return change;
}

void addDenseForces(const PointForces& forces, const Scene& scene, double t, const Eigen::VectorXd& q,
                    const Eigen::VectorXd& qd, const DenseActions& to) {
  const Coordinates& coordinates = scene.chain.coordinates();
  Eigen::VectorXd x(q.size()), rates(q.size());
  coordinates.toAbsolute(q.data(), x.data());
  coordinates.toAbsolute(qd.data(), rates.data());
  BodyMotions bodies(scene.chain, forces.reach());
  bodies.find(scene.base ? stateOf(*scene.base, t) : BaseState{}, x.data(), rates.data());
  for (std::size_t i = 0; i < forces.points().size(); ++i) {
    const auto& [body, point] = forces.points()[i];
    const PointAt<double> at = bodies.of(body, point);
    const Vec2d F = forces.force(i, at).F;
    const Vec2d com = scene.chain.links()[index(body)].com;
    to.F(2 * body) += F.x;
    to.F(2 * body + 1) += F.y;
    to.M(body) += cross(bodies.turn(body) * (point - com), F);
  }
}

}  // namespace planar_chain
