#include "planar_chain/kinematics.h"

#include <cmath>

#include "dynamics/given_state.h"
#include "recursion/dual.h"
#include "recursion/pose.h"

namespace planar_chain {

namespace {

using Eigen::VectorXd;

void check(const Scene& scene, const Frame& frame, std::vector<Fault>& faults) {
  if (frame.link >= 0 && frame.link < scene.chain.size()) return;
  faults.push_back({"frame", "a frame on a link of the chain", "link " + std::to_string(frame.link)});
}

/// The base at t.
struct BaseMotion {
  GivenMotion x, y, angle;

  BaseMotion(const Scene& scene, double t) {
    if (!scene.base) return;
    x = scene.base->x.at(t);
    y = scene.base->y.at(t);
    angle = scene.base->angle.at(t);
  }
};

}  // namespace

Frame frameNamed(const Scene& scene, const std::string& name) {
  std::string others;
  for (const Frame& frame : scene.frames) {
    if (frame.name == name) return frame;
    others += frame.name + ", ";
  }
  const int last = scene.chain.size() - 1;
  if (name == "tip") return {name, last, scene.chain.links().back().pin, 0};
  throw Refused({{"frame", "the name of a frame (" + others + "tip)", quoted(name)}});
}

// ---- Forwards --------------------------------------------------------------------------------------------

/// By the one sweep outwards on dual numbers: values at t, slopes by time. So v is the slope of the position,
/// and a that of v.
FrameMotion motionOf(const Scene& scene, const Frame& frame, double t, const VectorXd& q, const VectorXd& qd,
                     const VectorXd& qdd) {
  std::vector<Fault> faults;
  checkTime(t, faults);
  check(scene, frame, faults);
  bool haveSizes = checkNumbers("q", scene, q, "rad", faults);
  haveSizes = checkNumbers("qd", scene, qd, "rad/s", faults) && haveSizes;
  haveSizes = checkNumbers("qdd", scene, qdd, "rad/s²", faults) && haveSizes;
  if (!haveSizes || !faults.empty()) throw Refused(std::move(faults));

  const Coordinates& coordinates = scene.chain.coordinates();
  VectorXd x(q.size()), xd(q.size()), xdd(q.size());
  coordinates.toAbsolute(q.data(), x.data());
  coordinates.toAbsolute(qd.data(), xd.data());
  coordinates.toAbsolute(qdd.data(), xdd.data());
  const BaseMotion base(scene, t);
  const auto count = index(frame.link + 1);
  std::vector<Rotation<Dual>> e(count);
  std::vector<Dual> omega(count), displacements(count), rates(count);
  for (std::size_t j = 0; j < count; ++j) {
    const int i = static_cast<int>(j);
    omega[j] = {base.angle.rate + coordinates.angle(xd.data(), i),
                base.angle.acceleration + coordinates.angle(xdd.data(), i)};
    const double angle = base.angle.value + coordinates.angle(x.data(), i);
    e[j] = turning(Rotation<double>::of(angle), omega[j].value);
    displacements[j] = {x[i], xd[i]};
    rates[j] = {xd[i], xdd[i]};
  }
  PointAt<Dual> at{{{base.x.value, base.x.rate}, {base.y.value, base.y.rate}},
                   {{base.x.rate, base.x.acceleration}, {base.y.rate, base.y.acceleration}}};
  sweepOutwards(scene.chain, 0, frame.link + 1, at, e.data(), omega.data(), displacements.data(),
                rates.data(), [&at](int, const PointAt<Dual>& own) { at = own; });
  const Vec2<Dual> arm = e.back() * Vec2<Dual>{frame.point.x, frame.point.y};
  const Vec2<Dual> position = at.position + arm, velocity = at.velocity + omega.back() * perp(arm);
  return {{position.x.value, position.y.value},
          base.angle.value + coordinates.angle(x.data(), frame.link) + frame.angle,
          {velocity.x.value, velocity.y.value},
          omega.back().value,
          {velocity.x.slope, velocity.y.slope},
          omega.back().slope};
}

FrameMotion motionOf(const Frame& frame, const Link& link, const LinkMotion& motion) {
  const Rotation<double> e = Rotation<double>::of(motion.angle);
  const double w = motion.omega;
  const Vec2d arm = e * (frame.point - link.com);
  return {motion.innerPin + e * frame.point,
          motion.angle + frame.angle,
          motion.velocity + w * perp(arm),
          w,
          motion.acceleration + motion.alpha * perp(arm) - (w * w) * arm,
          motion.alpha};
}

Eigen::MatrixXd jacobianOf(const Scene& scene, const Frame& frame, double t, const VectorXd& q) {
  const VectorXd still = VectorXd::Zero(q.size());
  const Vec2d position = motionOf(scene, frame, t, q, still, still).position;
  const Chain& chain = scene.chain;
  const Coordinates& coordinates = chain.coordinates();
  VectorXd x(q.size());
  coordinates.toAbsolute(q.data(), x.data());
  const BaseMotion base(scene, t);
  const int count = frame.link + 1;
  std::vector<Rotation<double>> e;
  for (int i = 0; i < count; ++i)
    e.push_back(Rotation<double>::of(base.angle.value + coordinates.angle(x.data(), i)));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, q.size());
  sweepOutwards(chain, 0, count, PointAt<double>{{base.x.value, base.y.value}, {}}, e.data(), still.data(),
                x.data(), still.data(), [&](int j, const PointAt<double>& own) {
                  const bool isPrismatic = coordinates.isPrismatic(j);
                  const Vec2d d = isPrismatic ? e[index(j)] * chain.joints()[index(j)].axis
                                              : perp(position - own.position);
                  J.col(j) << d.x, d.y, isPrismatic ? 0 : 1;
                });
  return J;
}

}  // namespace planar_chain
