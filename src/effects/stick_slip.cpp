#include "effects/stick_slip.h"

#include <algorithm>
#include <limits>

#include "effects/effect_kind.h"

namespace planar_chain {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double never = -1e300;  // rad/s: no rate exceeds it

/// The share of the tolerance that a joint may err by if its band holds it. With 1, a chain of many joints
/// would miss the tolerance together; with 1e-4, rounding decides in chains of a hundred links at 1e-6.
constexpr double accuracy = 0.01;
/// That share for a joint whose c Y is below `weak` tolerances a second: a thousand such joints stick and
/// slip with less.
constexpr double accuracyOfWeak = 0.1, weak = 1e4;
/// A start with so many times what the band or rounding may hide is no error of the torque. With 10, joints
/// of open chains stick and slip by turns. Without a bound, errors of rates in closed ones let bands grow
/// until they held any torque.
constexpr double clear = 1000;
/// Friction that changes no rate by more than this share of the tolerance in a second is left out. Rounding
/// of the joint's moment would decide whether it sticks.
constexpr double negligible = 0.1;
/// rad/s, of a prismatic joint times the chain's reach: more than the rate that the projection onto a held
/// tip gives a joint at rest.
constexpr double leftOver = 1e-11;
/// The least inertia of a body itself, as a share of its inertia about its pin with what it carries there. A
/// point mass and a prismatic joint without mass have none of their own: their yield would have no bound, and
/// no start, however fast, would count. Larger: bands may miss more than the tolerance. Smaller: a start
/// below this share of what friction gives at most counts as rounding.
constexpr double leastOwn = 1e-6;

/// The yield of each joint to its torque or force, as if no pin held its bodies. With a prismatic joint, a
/// body and the one inside turn together.
std::vector<double> yieldsOf(const Chain& chain) {
  const Coordinates& coordinates = chain.coordinates();
  std::vector<double> yields(index(chain.size())), own(yields.size());
  double carried = 0;  // kg, at the outer pin
  for (int i = chain.size(); i-- > 0;) {
    const Link& link = chain.links()[index(i)];
    const Joint& joint = chain.joints()[index(i)];
    const double aboutPin = joint.isPrismatic ? link.mass + carried
                                              : link.inertia + link.mass * dot(link.com, link.com) +
                                                    carried * dot(link.pin, link.pin) + inertiaIn(joint);
    if (coordinates.turner(i) >= 0) own[index(coordinates.turner(i))] += link.inertia;
    yields[index(i)] = 1 / std::max(joint.isPrismatic ? link.mass : own[index(i)], leastOwn * aboutPin);
    carried += link.mass;
  }
  std::vector<double> sums = yields;
  for (int i = 0; i < chain.size(); ++i) {
    const bool isInside = chain.joints()[index(i)].isPrismatic && coordinates.turner(i) >= 0;
    if (coordinates.inner(i) >= 0) sums[index(i)] += yields[index(coordinates.inner(i))];
    if (isInside) sums[index(i)] += 1 / chain.links()[index(i - 1)].mass;
  }
  return sums;
}

}  // namespace

StickSlip::StickSlip(const Chain& chain, double tolerance)
    : coordinates_(chain.coordinates()), n_(chain.size()), tolerance_(tolerance) {
  for (Numbers* numbers : {&sliding_, &breakaway_, &mostYield_, &band_, &direction_, &push_, &angle_}) {
    numbers->setZero(n_);
  }
  const std::vector<double> yields = yieldsOf(chain);
  unit_.setOnes(n_);
  never_.setConstant(n_, never);
  isLoose_.setConstant(n_, false);
  startsClearly_.setConstant(n_, false);
  moments_.setZero(n_);
  for (int i = 0; i < n_; ++i) {
    const Joint& joint = chain.joints()[index(i)];
    if (joint.isPrismatic) unit_[i] = chain.reach();
    if (!mayStick(joint)) continue;
    mostYield_[i] = yields[index(i)];
    breakaway_[i] = std::max(joint.other("breakaway"), joint.other("friction"));
    if (breakaway_[i] * mostYield_[i] < negligible * tolerance * unit_[i]) {
      leftOut_.push_back(i);
      continue;
    }
    joints_.push_back(i);
    sliding_[i] = joint.other("friction");
    hasBreakaway_ = hasBreakaway_ || breakaway_[i] > sliding_[i];
  }
  reserve();
  for (const int i : joints_) band_[i] = ownBand(i);
}

void StickSlip::reserve() {
  for (std::vector<int>* list : {&stuck_, &before_, &loose_}) list->reserve(joints_.size());
}

double StickSlip::ownBand(int joint) const {
  const double breakaway = breakaway_[joint], oneTolerance = tolerance_ * unit_[joint] / mostYield_[joint];
  const double share = breakaway < weak * oneTolerance ? accuracyOfWeak : accuracy;
  return std::max(rounding * breakaway, share * oneTolerance);
}

// ---- What is due ------------------------------------------------------------------------------------

StickSlip::Rate StickSlip::rateOf(int joint, const double* omega) const {
  return {coordinates_.relative(omega, joint), epsilon * sumOfSizes(joint, omega)};
}

double StickSlip::slipPastRest(int joint, const double* omega) const {
  const Rate rate = rateOf(joint, omega);
  return -direction_[joint] * rate.value - 4 * rate.rounding + never_[joint];
}

void StickSlip::findSlipPastRest(const double* omega, double* to) const {
  Eigen::Map<Numbers> due(to, n_);
  const Eigen::Index others = n_ - 1;
  if (coordinates_.anyIsPrismatic()) {
    for (int i = 0; i < n_; ++i) due[i] = slipPastRest(i, omega);
    return;
  }
  due[0] = slipPastRest(0, omega);
  const Eigen::Map<const Numbers> outer(omega + 1, others), inner(omega, others);
  due.tail(others) = -direction_.tail(others) * (outer - inner) - 4 * epsilon * (outer.abs() + inner.abs()) +
                     never_.tail(others);
}

void StickSlip::findSlipSlope(const double* alpha, double* to) const {
  Eigen::Map<Numbers> slope(to, n_);
  const Eigen::Index others = n_ - 1;
  if (coordinates_.anyIsPrismatic()) {
    for (int i = 0; i < n_; ++i) slope[i] = -direction_[i] * coordinates_.relative(alpha, i);
    return;
  }
  slope[0] = -direction_[0] * alpha[0];
  const Eigen::Map<const Numbers> outer(alpha + 1, others), inner(alpha, others);
  slope.tail(others) = -direction_.tail(others) * (outer - inner);
}

bool StickSlip::isAtRest(int joint, const double* omega) const {
  const Rate rate = rateOf(joint, omega);
  return std::abs(rate.value) <= 4 * rate.rounding;
}

double StickSlip::looseDue(int joint, const double* omega) const {
  const Rate rate = rateOf(joint, omega);
  return std::abs(rate.value) - 8 * rate.rounding - looseRate(joint);
}

double StickSlip::looseSlope(int joint, const double* omega, const double* alpha) const {
  return std::copysign(1, coordinates_.relative(omega, joint)) * coordinates_.relative(alpha, joint);
}

double StickSlip::looseRate(int joint) const {
  return unit_[joint] * std::max(accuracy * tolerance_, leftOver);
}

// ---- Transitions ------------------------------------------------------------------------------------

void StickSlip::enter(int joint, const double* y) {
  const double rate = coordinates_.relative(y + n_, joint);
  direction_[joint] = (rate > 0) - (rate < 0);
  angle_[joint] = coordinates_.relative(y, joint);
  band_[joint] = ownBand(joint);
  isLoose_[joint] = startsClearly_[joint] = false;
  push_[joint] = 0;
}

void StickSlip::rest(int joint, const double* y, bool passes) {
  const double angle = coordinates_.relative(y, joint);
  const bool hasMoved = std::abs(angle - angle_[joint]) > 8 * epsilon * sumOfSizes(joint, y);
  band_[joint] = hasMoved || startsClearly_[joint] ? ownBand(joint) : 4 * band_[joint];
  direction_[joint] = passes ? -direction_[joint] : 0;
  angle_[joint] = angle;
}

void StickSlip::stay(int joint, const double* y) {
  angle_[joint] = coordinates_.relative(y, joint);
  start(joint, 0);
}

void StickSlip::start(int joint, double direction) {
  direction_[joint] = direction;
  isLoose_[joint] = false;
  push_[joint] = 0;
}

void StickSlip::startWith(int joint, double start, double rounded) {
  startsClearly_[joint] = start > clear * (leastStart(joint) + rounded);
}

void StickSlip::loosen(int joint, double push) {
  isLoose_[joint] = true;
  push_[joint] = push;
}

void StickSlip::slip(int joint, const double* omega) {
  start(joint, coordinates_.relative(omega, joint) > 0 ? 1 : -1);
  startsClearly_[joint] = true;
}

void StickSlip::holdAt(int joint, double moment, double widening) {
  band_[joint] = std::max(band_[joint], widening * (std::abs(moment) - breakaway_[joint]));
}

bool StickSlip::take() {
  std::swap(stuck_, before_);
  stuck_.clear();
  loose_.clear();
  for (const int i : joints_) {
    never_[i] = slips(i) ? 0 : never;
    if (!slips(i)) (isLoose(i) ? loose_ : stuck_).push_back(i);
  }
  moments_ = torques().matrix();
  if (coordinates_.anyIsPrismatic()) {
    for (int i = 0; i < n_; ++i) {
      if (coordinates_.inner(i) >= 0) moments_[coordinates_.inner(i)] -= torques()[i];
    }
  } else {
    moments_.head(n_ - 1) -= torques().tail(n_ - 1).matrix();
  }
  return stuck_ != before_;
}

}  // namespace planar_chain
