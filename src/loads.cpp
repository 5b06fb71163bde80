#include "planar_chain/loads.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace planar_chain {

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double never = std::numeric_limits<double>::infinity();

template <class... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <class... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

}  // namespace

Loads::Loads(const Scene& scene, int commandCapacity)
    : size_(scene.chain.size()), loads_(scene.loads), capacity_(static_cast<std::size_t>(commandCapacity)) {
  for (const Load& load : loads_) {
    if (load.link < Load::none || load.link >= size_ || load.joint < Load::none || load.joint >= size_) {
      throw std::invalid_argument("load " + load.name + " acts on no body of the chain");
    }
  }

  // Room for everything at once, so that enter() never allocates.
  const std::size_t held = commandCapacity > 0 ? static_cast<std::size_t>(size_) : 0;
  heldTorques_.resize(held);
  heldForces_.resize(held);
  timedTorques_.reserve(capacity_);
  timedForces_.reserve(capacity_);
  const std::size_t most = loads_.size() + held + capacity_;
  factors_.reserve(loads_.size() + 1);
  sines_.reserve(loads_.size());
  lines_.reserve(loads_.size());
  jointTerms_.reserve(most);
  bodyTerms_.reserve(most);
  enter(0);
}

bool Loads::acts(const Window& window, double t) {
  if (window.start > t) {
    until_ = std::min(until_, window.start);
    return false;
  }
  if (window.stop <= t) return false;
  until_ = std::min(until_, window.stop);
  return true;
}

int Loads::factorOf(const TimeLaw& law, double t) {
  const int next = static_cast<int>(factors_.size());
  return std::visit(Overloaded{[](const Constant&) { return 0; },
                               [&](const Sine& sine) {
                                 sines_.push_back({2 * pi * sine.frequency, sine.phase, next});
                                 factors_.push_back(0);
                                 longestStep_ = std::min(longestStep_, 0.25 / std::abs(sine.frequency));
                                 return next;
                               },
                               [&](const Ramp& ramp) {
                                 // The straight piece to the right of t; flat before the first and after the
                                 // last corner.
                                 const auto after = std::upper_bound(ramp.times.begin(), ramp.times.end(), t);
                                 const auto k = after - ramp.times.begin();
                                 LineFactor line{0, 0, 0, next};
                                 if (after == ramp.times.begin()) {
                                   line.value = ramp.values.front();
                                 } else if (after == ramp.times.end()) {
                                   line.value = ramp.values.back();
                                 } else {
                                   const auto i = static_cast<std::size_t>(k - 1);
                                   line.t0 = ramp.times[i];
                                   line.value = ramp.values[i];
                                   line.slope = (ramp.values[i + 1] - ramp.values[i]) /
                                                (ramp.times[i + 1] - ramp.times[i]);
                                 }
                                 if (after != ramp.times.end()) until_ = std::min(until_, *after);
                                 lines_.push_back(line);
                                 factors_.push_back(0);
                                 return next;
                               }},
                    law);
}

void Loads::addBodyTerm(const BodyTerm& term) {
  bodyTerms_.push_back(term);
  if (!(term.force == Vec2d{})) reach_ = std::max(reach_, term.body + 1);
}

void Loads::enter(double t) {
  until_ = longestStep_ = never;
  reach_ = 0;
  factors_.assign(1, 1.0);
  sines_.clear();
  lines_.clear();
  jointTerms_.clear();
  bodyTerms_.clear();

  for (const Load& load : loads_) {
    if (!acts({load.start, load.stop}, t)) continue;
    const int factor = factorOf(load.law, t);
    if (load.joint != Load::none) jointTerms_.push_back({load.joint, load.torque, factor});
    if (load.link != Load::none) addBodyTerm({load.link, load.force, load.point, load.moment, factor});
  }

  const auto over = [t](const auto& command) { return command.window.stop <= t; };
  timedTorques_.erase(std::remove_if(timedTorques_.begin(), timedTorques_.end(), over), timedTorques_.end());
  timedForces_.erase(std::remove_if(timedForces_.begin(), timedForces_.end(), over), timedForces_.end());
  for (const auto* commands : {&heldTorques_, &timedTorques_}) {
    for (const TorqueCommand& command : *commands) {
      if (acts(command.window, t)) jointTerms_.push_back({command.joint, command.torque, 0});
    }
  }
  for (const auto* commands : {&heldForces_, &timedForces_}) {
    for (const ForceCommand& command : *commands) {
      if (acts(command.window, t)) {
        addBodyTerm({command.link, command.force, command.point, command.moment, 0});
      }
    }
  }
}

void Loads::evaluateFactors(double t) {
  factors_[0] = 1;
  for (const SineFactor& sine : sines_) {
    factors_[static_cast<std::size_t>(sine.factor)] = std::sin(sine.pulsation * t + sine.phase);
  }
  for (const LineFactor& line : lines_) {
    factors_[static_cast<std::size_t>(line.factor)] = line.value + line.slope * (t - line.t0);
  }
}

void Loads::evaluateRates(double t) {
  factors_[0] = 0;
  for (const SineFactor& sine : sines_) {
    factors_[static_cast<std::size_t>(sine.factor)] =
        sine.pulsation * std::cos(sine.pulsation * t + sine.phase);
  }
  for (const LineFactor& line : lines_) factors_[static_cast<std::size_t>(line.factor)] = line.slope;
}

double Loads::applyFactors(const Rotation<double>* e, const double* omega, const Vec2d* pinVelocity,
                           double* N, Vec2d* F) const {
  double power = 0;
  for (const JointTerm& term : jointTerms_) {
    const double tau = times(term.factor, term.torque);
    const int i = term.joint;
    N[i] += tau;
    power += tau * omega[i];
    if (i > 0) {
      N[i - 1] -= tau;
      power -= tau * omega[i - 1];
    }
  }
  for (const BodyTerm& term : bodyTerms_) {
    const double factor = factors_[static_cast<std::size_t>(term.factor)];
    const int j = term.body;
    const Vec2d force = factor * term.force;
    const double moment = factor * term.moment + cross(e[j] * term.point, force);
    N[j] += moment;
    power += moment * omega[j];
    if (j < reach_) {
      F[j] += force;
      power += dot(force, pinVelocity[j]);
    }
  }
  return power;
}

double Loads::apply(double t, const Rotation<double>* e, const double* omega, const Vec2d* pinVelocity,
                    double* N, Vec2d* F) {
  evaluateFactors(t);
  return applyFactors(e, omega, pinVelocity, N, F);
}

double Loads::applyRates(double t, const Rotation<double>* e, const double* omega, const Vec2d* pinVelocity,
                         double* N, Vec2d* F) {
  evaluateRates(t);
  return applyFactors(e, omega, pinVelocity, N, F);
}

void Loads::addStiffness(double t, const Rotation<double>* e, double* XF) {
  evaluateFactors(t);
  for (const BodyTerm& term : bodyTerms_) {
    XF[term.body] += times(term.factor, dot(e[term.body] * term.point, term.force));
  }
}

double Loads::powerAlong(double t, const Rotation<double>* e, const double* omega, const double* u,
                         const double* v, const Vec2d* pinVelocityChange) {
  evaluateFactors(t);
  double change = 0;
  for (const JointTerm& term : jointTerms_) {
    const int i = term.joint;
    change += times(term.factor, term.torque) * (i > 0 ? v[i] - v[i - 1] : v[0]);
  }
  for (const BodyTerm& term : bodyTerms_) {
    const int j = term.body;
    const Vec2d X = e[j] * term.point;
    double rate = (term.moment + cross(X, term.force)) * v[j] - dot(X, term.force) * omega[j] * u[j];
    if (j < reach_) rate += dot(term.force, pinVelocityChange[j]);
    change += times(term.factor, rate);
  }
  return change;
}

void Loads::addJointTorques(double t, double* tau) {
  evaluateFactors(t);
  for (const JointTerm& term : jointTerms_) tau[term.joint] += times(term.factor, term.torque);
}

void Loads::holdTorque(int joint, double torque, double until) {
  heldTorques_[static_cast<std::size_t>(joint)] = {joint, torque, {-never, until}};
}

void Loads::holdForce(int link, Vec2d point, Vec2d force, double moment, double until) {
  heldForces_[static_cast<std::size_t>(link)] = {link, point, force, moment, {-never, until}};
}

bool Loads::addTorque(int joint, double torque, double start, double stop) {
  if (timedTorques_.size() + timedForces_.size() >= capacity_) return false;
  timedTorques_.push_back({joint, torque, {start, stop}});
  return true;
}

bool Loads::addForce(int link, Vec2d point, Vec2d force, double moment, double start, double stop) {
  if (timedTorques_.size() + timedForces_.size() >= capacity_) return false;
  timedForces_.push_back({link, point, force, moment, {start, stop}});
  return true;
}

void Loads::clearCommands() {
  timedTorques_.clear();
  timedForces_.clear();
  std::fill(heldTorques_.begin(), heldTorques_.end(), TorqueCommand{});
  std::fill(heldForces_.begin(), heldForces_.end(), ForceCommand{});
}

std::vector<Load> Loads::commands(double t) const {
  std::vector<Load> loads;
  for (const auto* commands : {&heldTorques_, &timedTorques_}) {
    for (const auto& [joint, torque, window] : *commands) {
      if (window.stop <= t) continue;
      loads.push_back(
          {"command", Load::none, {}, {}, 0, joint, torque, Constant{}, window.start, window.stop});
    }
  }
  for (const auto* commands : {&heldForces_, &timedForces_}) {
    for (const auto& [link, point, force, moment, window] : *commands) {
      if (window.stop <= t) continue;
      loads.push_back(
          {"command", link, force, point, moment, Load::none, 0, Constant{}, window.start, window.stop});
    }
  }
  return loads;
}

}  // namespace planar_chain
