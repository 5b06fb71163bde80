#include "lanes/coupled_chain.h"

#include "lanes/segments.h"
#include "lanes/short_chain.h"

namespace planar_chain {

CoupledChain::CoupledChain(const Chain& chain)
    : CoupledChain(chain, simd::kernelFor(chain.size()), chain.size() > ShortChain::most) {}

CoupledChain::CoupledChain(const Chain& chain, const simd::Kernel& kernel, bool inSegments)
    : kernel_(kernel), arrangement_(chain.size(), inSegments ? kernel.lanes : 1) {
  using Arrays = simd::CoupledArrays;
  const int n = chain.size(), lanes = kernel_.lanes, rows = (n + lanes - 1) / lanes;
  const auto places = index(rows * lanes);
  links_ = inSegments ? linksArranged(chain, arrangement_) : linksInLanes(chain, lanes, rows, 1, lanes);
  joints_.resize(places * Arrays::jointQuantities);
  if (!inSegments) {
    handles_.resize(Arrays::width * Arrays::rows);
    couples_.resize(index(n));
    return;
  }
  handles_.resize(places * Arrays::handleQuantities);
  pairs_.resize(index(arrangement_.rounds() * lanes * simd::pairQuantities));
  e_.resize(places);
  F_.resize(places);
  for (auto* numbers : {&omega_, &N_, &alpha_, &moments_}) numbers->resize(places);
}

std::string CoupledChain::name() const {
  if (!isCut()) return "link by link, for rotors and given motions";
  return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name +
         "), for rotors and given motions";
}

void CoupledChain::couple(const Coupling<double>* joints) {
  const auto lanes = index(arrangement_.lanes());
  const auto n = index(arrangement_.bodies());
  const auto couples = [&](std::size_t j) { return j < n && (joints[j].isHeld || joints[j].rotor != 0); };
  for (std::size_t j = 0; j < n; ++j) {
    const auto [rotor, held, acceleration] = numbersOf(joints[j]);
    putInLane(joints_.data(), arrangement_.placeOf(j), lanes, {rotor, held, acceleration});
    if (!couples_.empty()) couples_[j] = couples(j) || couples(j + 1);
  }
}

inline void CoupledChain::run(simd::CoupledRun simd::CoupledKernel::*kind, const Outside& outside,
                              const double* theta, const double* omega, double turning,
                              const simd::CoupledResults& to) {
  const simd::CoupledArrays arrays{arrangement_.bodies(), arrangement_.steps(), links_.data(), joints_.data(),
                                   couples_.data(),       handles_.data(),      pairs_.data()};
  if (!isCut()) return (kernel_.coupledLinks.*kind)(arrays, outside, theta, omega, turning, to);
  if (theta) kernel_.rotations(theta, &outside.e->c, arrangement_.bodies());
  arrangement_.arrange(outside.e, e_.data());
  arrangement_.arrange(omega, omega_.data());
  arrangement_.arrange(outside.N, N_.data());
  if (outside.F) arrangement_.arrange(outside.F, F_.data());
  (kernel_.coupledSegments.*kind)(
      arrays, {e_.data(), N_.data(), outside.F ? F_.data() : nullptr, outside.ground}, nullptr, omega_.data(),
      turning, {alpha_.data(), moments_.data(), to.pinForce, to.ends});
  arrangement_.restore(alpha_.data(), to.alpha);
  arrangement_.restore(moments_.data(), to.moments);
}

Vec2d CoupledChain::accelerations(const Outside& outside, const double* theta, const double* omega,
                                  double turning, double* alpha, double* moments) {
  Vec2d pinForce;
  run(&simd::CoupledKernel::plain, outside, theta, omega, turning, {alpha, moments, &pinForce, nullptr});
  return pinForce;
}

struct simd::ChainEnds {
  const InnerEnd<double>& inner;
  const Tip<double>& tip;
  Vec2d base;
  double turning;
  EndsMotion<double>& motion;
};

void simd::meet(const EndedPin<double>& shown, const ChainEnds& ends, Vec2d& a, Vec2d& tipForce) {
  EndsEquations<double>(shown, ends.inner, ends.base, ends.turning).solve(ends.tip, ends.motion);
  a = ends.motion.pinAcceleration;
  tipForce = ends.motion.tipForce;
}

void CoupledChain::accelerations(const Outside& outside, const double* theta, const double* omega,
                                 double turning, const InnerEnd<double>& inner, const Tip<double>& tip,
                                 double* alpha, double* moments, EndsMotion<double>& motion) {
  const simd::ChainEnds ends{inner, tip, outside.ground, turning, motion};
  const auto kind = tip.rows > 0 ? &simd::CoupledKernel::holdingTip : &simd::CoupledKernel::onSlides;
  run(kind, outside, theta, omega, turning, {alpha, moments, nullptr, &ends});
}

}  // namespace planar_chain
