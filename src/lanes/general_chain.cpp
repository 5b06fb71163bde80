#include "lanes/general_chain.h"

#include <algorithm>

#include "lanes/segments.h"

namespace planar_chain {

namespace {

Chain without(const Chain& chain, int leading) {
  return {{chain.links().begin() + leading, chain.links().end()},
          {chain.joints().begin() + leading, chain.joints().end()},
          chain.gravity()};
}

}  // namespace

GeneralChain::GeneralChain(const Chain& chain, const simd::Kernel& kernel, bool inSegments, bool basePays)
    : kernel_(kernel),
      basePays_(basePays),
      leading_(inSegments ? std::min({chain.coordinates().leading(), simd::mostLeading, chain.size() - 1})
                          : 0),
      isMixed_(false),
      laws_(index(chain.size())),
      laneOrder_(chain.size() - leading_, inSegments ? kernel.lanes : 1) {
  using Arrays = simd::GeneralArrays;
  const int n = laneOrder_.bodies(), lanes = kernel_.lanes, rows = (n + lanes - 1) / lanes;
  const auto paddedSize = index(rows * lanes);
  for (int i = 0; i < chain.size(); ++i) isPrismatic_.push_back(chain.joints()[index(i)].isPrismatic);
  joints_.resize(paddedSize * Arrays::jointQuantities);
  isMixed_ = std::find(isPrismatic_.begin() + leading_, isPrismatic_.end(), true) != isPrismatic_.end();
  if (!inSegments) {
    links_ = linksInLanes(chain, lanes, rows, 1, lanes);
    terms_.resize(Arrays::width * Arrays::rows);
    kinds_.resize(index(n));
    return;
  }
  for (int i = 0; i < leading_; ++i) {
    const Link& link = chain.links()[index(i)];
    bodies_.push_back({link.mass, link.inertia, link.com, link.pin});
  }
  links_ = linksInLaneOrder(leading_ > 0 ? without(chain, leading_) : chain, laneOrder_);
  terms_.resize(paddedSize * Arrays::termQuantities);
  pairs_.resize(index(laneOrder_.rounds() * lanes * simd::pairQuantities));
  e_.resize(paddedSize);
  F_.resize(paddedSize);
  for (auto* numbers : {&omega_, &N_, &xdd_, &moments_}) numbers->resize(paddedSize);
  if (isMixed_) displaced_.resize(paddedSize * Arrays::displacementQuantities);
}

std::string GeneralChain::name() const {
  if (!isCut()) return "link by link, for joints of any kind";
  return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name +
         "), for joints of any kind";
}

void GeneralChain::take(const JointLaw<double>* laws) {
  std::copy_n(laws, laws_.size(), laws_.begin());
  const auto lanes = index(laneOrder_.lanes()), n = index(laneOrder_.bodies()), first = index(leading_);
  for (std::size_t j = 0; j < n; ++j) {
    const auto [armature, prescribed, acceleration] = numbersOf(laws[first + j]);
    putInLane(joints_.data(), laneOrder_.laneIndexOf(j), lanes, {armature, prescribed, acceleration});
  }
  bool turns = basePays_, nextIsBare = true;
  for (std::size_t j = 0; j < kinds_.size(); ++j) {
    using Kind = simd::JointKind;
    turns = turns || !isPrismatic_[j];
    kinds_[j] = !isPrismatic_[j] ? Kind::revolute : turns ? Kind::prismatic : Kind::carriage;
  }
  for (std::size_t j = kinds_.size(); j-- > 0;) {
    const bool isBare = !isPrismatic_[j] && !laws[j].isPrescribed && laws[j].armature == 0;
    if (isBare && nextIsBare) kinds_[j] = simd::JointKind::bare;
    nextIsBare = isBare;
  }
}

struct simd::GeneralEnds {
  int leading;
  const Body<double>* bodies;
  const Rotation<double>* e;
  const double* omega;
  const Displacement<double>* displaced;
  const JointLaw<double>* laws;
  const double* N;
  const Vec2d* F;
  Moved<double> base;
  const Tip<double>& tip;
  EndForces<double>& forces;
  double *xdd, *moments;
};

namespace {

/// The wrench of the base, and the force on the tip, which is returned.
Vec2d solveEnds(const ArticulatedTerms<double>& articulated, const TipTerms<double>& ofTip,
                const simd::GeneralEnds& ends) {
  setWrench(articulated, ends.base, ends.forces);
  if (ends.tip.rows == 0) return {};
  holdTip(ofTip, ends.base, ends.tip, ends.forces);
  return ends.forces.tip.force;
}

/// Through the joints inside of the segments.
[[gnu::noinline]] Vec2d meetLeading(ArticulatedTerms<double> articulated, TipTerms<double> ofTip,
                                    const simd::GeneralEnds& ends, Moved<double>& pin) {
  JointTerms<double> joints[simd::mostLeading];
  Vec2d y[simd::mostLeading];
  for (int i = ends.leading; i-- > 0;) {
    const BodyPose<double> body = bodyPose(ends.bodies[i], ends.e[i], ends.omega[i]);
    const JointNumbers<double> law = numbersOf(ends.laws[i]);
    addBody(body, articulated);
    if (ends.F) articulated.b -= ends.F[i];
    joints[i] = passPrismatic(ends.N[i], law, ends.displaced[i].d, articulated);
    stepInwards(ends.displaced[i], articulated);
    ofTip.addBody(body.P, body.ww);
    y[i] = ofTip.passPrismatic(joints[i], law, ends.displaced[i].d);
    ofTip.stepInwards(ends.displaced[i]);
  }
  const Vec2d tipForce = solveEnds(articulated, ofTip, ends);
  pin = ends.base;
  for (int i = 0; i < ends.leading; ++i) {
    const JointNumbers<double> law = numbersOf(ends.laws[i]);
    joints[i].epsilon += dot(y[i], tipForce);
    ends.moments[i] = outwardsPrismatic(joints[i], law, ends.displaced[i], pin, ends.xdd[i]);
    toOuterPin(ends.e[i] * ends.bodies[i].p, ends.omega[i] * ends.omega[i], pin);
  }
  return tipForce;
}

}  // namespace

Vec2d simd::meet(const ArticulatedTerms<double>& articulated, const TipTerms<double>& ofTip,
                 const GeneralEnds& ends, Moved<double>& pin) {
  if (ends.leading > 0) return meetLeading(articulated, ofTip, ends, pin);
  pin = ends.base;
  return solveEnds(articulated, ofTip, ends);
}

void GeneralChain::toLaneOrder(const Loads& external, const double* omega,
                               const Displacement<double>* displaced) {
  laneOrder_.toLaneOrder(external.e + leading_, e_.data());
  laneOrder_.toLaneOrder(omega + leading_, omega_.data());
  laneOrder_.toLaneOrder(external.N + leading_, N_.data());
  if (external.F) laneOrder_.toLaneOrder(external.F + leading_, F_.data());
  if (!isMixed_) return;
  for (std::size_t j = 0; j < index(laneOrder_.bodies()); ++j) {
    const std::size_t i = index(leading_) + j;
    const auto& [d, S, gamma] = displaced[i];
    if (!isPrismatic_[i]) continue;
    putInLane(displaced_.data(), laneOrder_.laneIndexOf(j), index(laneOrder_.lanes()),
              {1, d.x, d.y, S.x, S.y, gamma.x, gamma.y});
  }
}

inline void GeneralChain::run(simd::GeneralRun simd::GeneralKernel::*kind, const Loads& external,
                              const double* theta, const double* omega, const Displacement<double>* displaced,
                              double turning, const simd::GeneralResults& to) {
  const simd::GeneralArrays arrays{laneOrder_.bodies(),
                                   laneOrder_.steps(),
                                   links_.data(),
                                   joints_.data(),
                                   kinds_.data(),
                                   isMixed_ ? displaced : nullptr,
                                   isMixed_ ? displaced_.data() : nullptr,
                                   terms_.data(),
                                   pairs_.data()};
  if (!isCut()) return (kernel_.generalLinks.*kind)(arrays, external, theta, omega, turning, to);
  if (theta) kernel_.rotations(theta, &external.e->c, laneOrder_.bodies() + leading_);
  toLaneOrder(external, omega, displaced);
  (kernel_.generalSegments.*kind)(arrays,
                                  {e_.data(), N_.data(), external.F ? F_.data() : nullptr, external.ground},
                                  nullptr, omega_.data(), turning, {xdd_.data(), moments_.data(), to.ends});
  laneOrder_.toChainOrder(xdd_.data(), to.xdd + leading_);
  laneOrder_.toChainOrder(moments_.data(), to.moments + leading_);
}

void GeneralChain::accelerations(const Loads& external, const double* theta, const double* omega,
                                 const Displacement<double>* displaced, double turning,
                                 const Tip<double>& tip, double* xdd, double* moments,
                                 EndForces<double>& ends) {
  using simd::GeneralKernel;
  if (tip.rows == 0 && !basePays_ && leading_ == 0) {
    return run(&GeneralKernel::plain, external, theta, omega, displaced, turning, {xdd, moments, nullptr});
  }
  const simd::GeneralEnds at{leading_,   bodies_.data(), external.e,
                             omega,      displaced,      laws_.data(),
                             external.N, external.F,     {external.ground, turning},
                             tip,        ends,           xdd,
                             moments};
  run(tip.rows > 0 ? &GeneralKernel::holdingTip : &GeneralKernel::withWrench, external, theta, omega,
      displaced, turning, {xdd, moments, &at});
}

}  // namespace planar_chain
