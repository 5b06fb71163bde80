#include "dynamics/motion_change.h"

#include <algorithm>
#include <type_traits>

#include "dynamics/inner_end.h"

namespace planar_chain {

namespace {

constexpr double h = 0x1p-300;

template <class Nudged>
Nudged nudged(double value, double change) {
  if constexpr (std::is_same_v<Nudged, Dual>) {
    return {value, change};
  } else {
    return {value, h * change};
  }
}
template <class Nudged>
Vec2<Nudged> nudged(Vec2d value, Vec2d change) {
  return {nudged<Nudged>(value.x, change.x), nudged<Nudged>(value.y, change.y)};
}
double changeOf(std::complex<double> number) {
  return number.imag() / h;
}
double changeOf(Dual number) {
  return number.slope;
}

}  // namespace

template <class Nudged, class Recursion>
MotionChange::Run<Nudged, Recursion>::Run(const Chain& bodies, int n) : recursion(bodies) {
  const auto all = index(n);
  e.resize(all);
  for (auto* numbers : {&omega, &N, &alpha, &moments}) numbers->resize(all);
  F.resize(all);
  joints.resize(all);
}

MotionChange::MotionChange(const Chain& chain, bool hasEnds)
    : chain_(chain), run_(std::in_place_type<Pinned>, chain, chain.size()) {
  const auto n = index(chain.size());
  for (auto* numbers : {&turn, &speed, &N, &held, &alpha, &moments}) numbers->resize(n);
  for (auto* vectors : {&F, &pins, &pinVelocities}) vectors->resize(n);
  if (hasEnds) run_.emplace<WithEnds>(chain.withoutSlides(), chain.size());
}

/// The forces and moments, and the motion of the pins on which they depend.
template <class AnyRun>
void MotionChange::nudgeLoads(const Evaluation& at, bool hasForces, const EffectTangents& tangents,
                              AnyRun& run) {
  using Nudged = typename decltype(run.N)::value_type;
  const std::size_t slides = index(chain_.slides());
  Vec2d dx = pin, dv = velocity;
  for (std::size_t j = 0; j < run.e.size(); ++j) {
    const bool slidesHere = j < slides;
    if (slidesHere) {
      dx += turn[j] * chain_.joints()[j].axis;
      dv += speed[j] * chain_.joints()[j].axis;
    }
    pins[j] = dx;
    pinVelocities[j] = dv;
    Vec2d dF = F[j];
    double dN = N[j];
    if (!tangents.XF.empty() && !slidesHere) dN -= tangents.XF[j] * turn[j];
    if (!tangents.bodies.empty() && !slidesHere) {
      const auto& [K, D] = tangents.bodies[j];
      dF -= K.forcePlace * dx + turn[j] * K.forceTurn + D.forcePlace * dv + speed[j] * D.forceTurn;
      dN -=
          dot(K.momentPlace, dx) + K.momentTurn * turn[j] + dot(D.momentPlace, dv) + D.momentTurn * speed[j];
    }
    run.N[j] = nudged<Nudged>(at.N[j], dN);
    run.F[j] = nudged<Nudged>(hasForces ? at.F[j] : Vec2d{}, dF);
    if (slidesHere) continue;

    const Vec2d P = at.e[j] * chain_.links()[j].pin;
    dx += turn[j] * perp(P);
    dv += speed[j] * perp(P) - (at.omega()[j] * turn[j]) * P;
  }
}

template <class AnyRun>
void MotionChange::nudge(const Evaluation& at, bool hasForces, const Couplings& couplings,
                         const EffectTangents& tangents, AnyRun& run) {
  using Nudged = typename decltype(run.N)::value_type;
  nudgeLoads(at, hasForces, tangents, run);
  for (std::size_t j = 0; j < run.e.size(); ++j) {
    const auto [c, s] = at.e[j];
    run.e[j] = {nudged<Nudged>(c, -s * turn[j]), nudged<Nudged>(s, c * turn[j])};
    run.omega[j] = nudged<Nudged>(at.omega()[j], speed[j]);
    const Coupling<double>& joint = couplings.joints[j];
    run.joints[j] = {joint.rotor, joint.isHeld, nudged<Nudged>(joint.acceleration, held[j])};
  }
}

Vec2<std::complex<double>> MotionChange::accelerate(const Evaluation& at, Pinned& run) {
  using Nudged = std::complex<double>;
  return run.recursion.accelerations(run.e.data(), run.omega.data(), run.N.data(), run.F.data(),
                                     run.joints.data(), nudged<Nudged>(at.ground, acceleration),
                                     nudged<Nudged>(at.groundTurning, turning), run.alpha.data(),
                                     run.moments.data());
}

/// The directions that act at the state.
Tip<Dual> MotionChange::nudgedTip(const Evaluation& at) const {
  const Tip<double>& acting = at.ends.acting;
  const auto rowOf = [&](std::size_t j) { return nudged<Dual>(acting.row[j], {}); };
  return {acting.rows, {rowOf(0), rowOf(1)}, nudged<Dual>(acting.acceleration, tip)};
}

Vec2<Dual> MotionChange::accelerate(const Evaluation& at, WithEnds& run) {
  const int slides = chain_.slides();
  const InnerEnd<Dual> inner = innerEndOf(chain_, run.joints.data(), run.N.data(), run.F.data());
  const EndsMotion<Dual> motion = run.recursion.accelerations(
      run.e.data() + slides, run.omega.data() + slides,
      {run.N.data() + slides, run.F.data() + slides, run.joints.data() + slides,
       nudged<Dual>(at.ground, acceleration), nudged<Dual>(at.groundTurning, turning)},
      inner, nudgedTip(at), run.alpha.data() + slides, run.moments.data() + slides);
  std::copy_n(motion.acceleration.begin(), slides, run.alpha.begin());
  writeHolding(inner, motion, run.moments.data());
  tipForce = {changeOf(motion.tipForce.x), changeOf(motion.tipForce.y)};
  return motion.pinForce;
}

template <class AnyRun>
void MotionChange::takeResults(const AnyRun& run) {
  for (std::size_t j = 0; j < alpha.size(); ++j) {
    alpha[j] = changeOf(run.alpha[j]);
    moments[j] = changeOf(run.moments[j]);
  }
}

void MotionChange::find(const Evaluation& at, bool hasForces, const Couplings& couplings,
                        const EffectTangents& tangents) {
  std::visit(
      [&](auto& run) {
        nudge(at, hasForces, couplings, tangents, run);
        const auto force = accelerate(at, run);
        takeResults(run);
        pinForce = {changeOf(force.x), changeOf(force.y)};
      },
      run_);
}

}  // namespace planar_chain
