#include "lanes/general_chain.h"

#include <algorithm>

#include "lanes/segments.h"
#include "lanes/short_chain.h"

namespace planar_chain {

namespace {

Chain without(const Chain& chain, int leading) {
  return {{chain.links().begin() + leading, chain.links().end()},
          {chain.joints().begin() + leading, chain.joints().end()},
          chain.gravity()};
}

}  // namespace

GeneralChain::GeneralChain(const Chain& chain, bool basePays)
    : GeneralChain(chain, simd::kernelFor(chain.size()), chain.size() > ShortChain::most, basePays) {}

GeneralChain::GeneralChain(const Chain& chain, const simd::Kernel& kernel, bool inSegments, bool basePays)
    : kernel_(kernel),
      basePays_(basePays),
      leading_(inSegments ? std::min({chain.coordinates().leading(), simd::mostLeading, chain.size() - 1})
                          : 0),
      isMixed_(false),
      laws_(index(chain.size())),
      arrangement_(chain.size() - leading_, inSegments ? kernel.lanes : 1) {
  using Arrays = simd::GeneralArrays;
  const int n = arrangement_.bodies(), lanes = kernel_.lanes, rows = (n + lanes - 1) / lanes;
  const auto places = index(rows * lanes);
  for (int i = 0; i < chain.size(); ++i) isPrismatic_.push_back(chain.joints()[index(i)].isPrismatic);
  joints_.resize(places * Arrays::jointQuantities);
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
  links_ = linksArranged(leading_ > 0 ? without(chain, leading_) : chain, arrangement_);
  terms_.resize(places * Arrays::termQuantities);
  pairs_.resize(index(arrangement_.rounds() * lanes * simd::pairQuantities));
  e_.resize(places);
  F_.resize(places);
  for (auto* numbers : {&omega_, &N_, &xdd_, &moments_}) numbers->resize(places);
  isMixed_ = std::find(isPrismatic_.begin() + leading_, isPrismatic_.end(), true) != isPrismatic_.end();
  if (isMixed_) displaced_.resize(places * Arrays::displacementQuantities);
}

std::string GeneralChain::name() const {
  if (!isCut()) return "link by link, for joints of any kind";
  return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name +
         "), for joints of any kind";
}

void GeneralChain::take(const JointLaw<double>* laws) {
  std::copy_n(laws, laws_.size(), laws_.begin());
  const auto lanes = index(arrangement_.lanes()), n = index(arrangement_.bodies()), first = index(leading_);
  for (std::size_t j = 0; j < n; ++j) {
    const auto [armature, prescribed, acceleration] = numbersOf(laws[first + j]);
    putInLane(joints_.data(), arrangement_.placeOf(j), lanes, {armature, prescribed, acceleration});
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

Vec2d simd::meet(const ArticulatedTerms<double>& shownByBodies, const TipTerms<double>& tipOfBodies,
                 const GeneralEnds& ends, Moved<double>& pin) {
  JointTerms<double> joints[mostLeading];
  Vec2d y[mostLeading];
  ArticulatedTerms<double> shown = shownByBodies;
  TipTerms<double> ofTip = tipOfBodies;
  for (int i = ends.leading; i-- > 0;) {
    const Turned<double> body = turned(ends.bodies[i], ends.e[i], ends.omega[i]);
    const JointNumbers<double> law = numbersOf(ends.laws[i]);
    addBody(body, shown);
    if (ends.F) shown.b -= ends.F[i];
    joints[i] = passPrismatic(ends.N[i], law, ends.displaced[i].d, shown);
    stepInwards(ends.displaced[i], shown);
    ofTip.addBody(body.P, body.ww);
    y[i] = ofTip.passPrismatic(joints[i], law, ends.displaced[i].d);
    ofTip.stepInwards(ends.displaced[i]);
  }
  pin = ends.base;
  setWrench(shown, pin, ends.forces);
  if (ends.tip.rows > 0) holdTip(ofTip, pin, ends.tip, ends.forces);
  for (int i = 0; i < ends.leading; ++i) {
    const JointNumbers<double> law = numbersOf(ends.laws[i]);
    joints[i].epsilon += dot(y[i], ends.forces.tip.force);
    ends.moments[i] = outwardsPrismatic(joints[i], law, ends.displaced[i], pin, ends.xdd[i]);
    toOuterPin(ends.e[i] * ends.bodies[i].p, ends.omega[i] * ends.omega[i], pin);
  }
  return ends.forces.tip.force;
}

void GeneralChain::arrange(const Outside& outside, const double* omega,
                           const Displacement<double>* displaced) {
  arrangement_.arrange(outside.e + leading_, e_.data());
  arrangement_.arrange(omega + leading_, omega_.data());
  arrangement_.arrange(outside.N + leading_, N_.data());
  if (outside.F) arrangement_.arrange(outside.F + leading_, F_.data());
  if (!isMixed_) return;
  for (std::size_t j = 0; j < index(arrangement_.bodies()); ++j) {
    const std::size_t i = index(leading_) + j;
    const auto& [d, S, gamma] = displaced[i];
    if (!isPrismatic_[i]) continue;
    putInLane(displaced_.data(), arrangement_.placeOf(j), index(arrangement_.lanes()),
              {1, d.x, d.y, S.x, S.y, gamma.x, gamma.y});
  }
}

EndForces<double> GeneralChain::accelerations(const Outside& outside, const double* theta,
                                              const double* omega, const Displacement<double>* displaced,
                                              double turning, const Tip<double>& tip, double* xdd,
                                              double* moments) {
  EndForces<double> forces;
  const simd::GeneralEnds ends{leading_,  bodies_.data(), outside.e,
                               omega,     displaced,      laws_.data(),
                               outside.N, outside.F,      {outside.ground, turning},
                               tip,       forces,         xdd,
                               moments};
  const auto kind = tip.rows > 0                ? &simd::GeneralKernel::holdingTip
                    : basePays_ || leading_ > 0 ? &simd::GeneralKernel::withWrench
                                                : &simd::GeneralKernel::plain;
  const simd::GeneralArrays arrays{arrangement_.bodies(),
                                   arrangement_.steps(),
                                   links_.data(),
                                   joints_.data(),
                                   kinds_.data(),
                                   displaced,
                                   isMixed_ ? displaced_.data() : nullptr,
                                   terms_.data(),
                                   pairs_.data()};
  if (!isCut()) {
    (kernel_.generalLinks.*kind)(arrays, outside, theta, omega, turning, {xdd, moments, &ends});
    return forces;
  }
  if (theta) kernel_.rotations(theta, &outside.e->c, arrangement_.bodies() + leading_);
  arrange(outside, omega, displaced);
  (kernel_.generalSegments.*kind)(arrays,
                                  {e_.data(), N_.data(), outside.F ? F_.data() : nullptr, outside.ground},
                                  nullptr, omega_.data(), turning, {xdd_.data(), moments_.data(), &ends});
  arrangement_.restore(xdd_.data(), xdd + leading_);
  arrangement_.restore(moments_.data(), moments + leading_);
  return forces;
}

}  // namespace planar_chain
