#include "effects/loads.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace planar_chain {

namespace {

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
  reserve(torques_, held);
  reserve(forces_, held);
  const std::size_t most = loads_.size() + held + capacity_;
  factors_.reserve(loads_.size() + 1);
  sines_.reserve(loads_.size());
  lines_.reserve(loads_.size());
  jointTerms_.reserve(most);
  bodyTerms_.reserve(most);
  enter(0);
}

template <class Command>
void Loads::reserve(Commands<Command>& commands, std::size_t held) {
  commands.held.resize(held);
  commands.waiting.reserve(capacity_);
  commands.timed.reserve(capacity_);
}

/// What starts by t is held; what is over by t is forgotten.
template <class Command>
void Loads::bringForward(Commands<Command>& commands, double t) {
  auto& waiting = commands.waiting;
  const auto due = std::find_if(waiting.begin(), waiting.end(),
                                [t](const Command& command) { return command.window.start > t; });
  for (auto command = waiting.begin(); command != due; ++command) {
    commands.held[static_cast<std::size_t>(command->index)] = *command;
  }
  waiting.erase(waiting.begin(), due);
  if (!waiting.empty()) until_ = std::min(until_, waiting.front().window.start);

  const auto over = [t](const Command& command) { return command.window.stop <= t; };
  commands.timed.erase(std::remove_if(commands.timed.begin(), commands.timed.end(), over),
                       commands.timed.end());
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

  bringForward(torques_, t);
  bringForward(forces_, t);
  for (const auto* commands : {&torques_.held, &torques_.timed}) {
    for (const TorqueCommand& command : *commands) {
      if (acts(command.window, t)) jointTerms_.push_back({command.index, command.torque, 0});
    }
  }
  for (const auto* commands : {&forces_.held, &forces_.timed}) {
    for (const ForceCommand& command : *commands) {
      if (acts(command.window, t)) {
        addBodyTerm({command.index, command.force, command.point, command.moment, 0});
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

void Loads::applyCoefficients(int k, double t, const Rotation<double>* e, std::ptrdiff_t perOrder, double* N,
                              Vec2d* F) {
  const auto coefficient = [this](int order, int factor) -> double& {
    return factorSeries_[static_cast<std::size_t>(order) * mostFactors() + static_cast<std::size_t>(factor)];
  };
  if (k == 1) {
    evaluateFactors(t);
    std::copy(factors_.begin(), factors_.end(), factorSeries_.begin());
    evaluateRates(t);
    std::copy(factors_.begin(), factors_.end(), &coefficient(1, 0));
  } else {
    for (std::size_t i = 0; i < factors_.size(); ++i) coefficient(k, static_cast<int>(i)) = 0;
    for (const SineFactor& sine : sines_) {  // f̈ = −pulsation² f
      coefficient(k, sine.factor) =
          -sine.pulsation * sine.pulsation / (k * (k - 1)) * coefficient(k - 2, sine.factor);
    }
  }

  for (const JointTerm& term : jointTerms_) {
    const double tau = coefficient(k, term.factor) * term.torque;
    N[term.joint] += tau;
    if (term.joint > 0) N[term.joint - 1] -= tau;
  }
  for (const BodyTerm& term : bodyTerms_) {
    const int j = term.body;
    N[j] += coefficient(k, term.factor) * term.moment;
    if (j < reach_) F[j] += coefficient(k, term.factor) * term.force;
    for (int i = 0; i <= (term.factor == 0 ? 0 : k); ++i) {
      N[j] += coefficient(i, term.factor) * cross(e[(k - i) * perOrder + j] * term.point, term.force);
    }
  }
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

bool Loads::hasRoom() const {
  return torques_.waiting.size() + torques_.timed.size() + forces_.waiting.size() + forces_.timed.size() <
         capacity_;
}

template <class Command>
bool Loads::hold(Commands<Command>& commands, const Command& command, double now) {
  if (command.window.start <= now) {
    commands.held[static_cast<std::size_t>(command.index)] = command;
    return true;
  }
  if (!hasRoom()) return false;
  const auto startsLater = [](const Command& one, const Command& other) {
    return one.window.start < other.window.start;
  };
  const auto place = std::upper_bound(commands.waiting.begin(), commands.waiting.end(), command, startsLater);
  commands.waiting.insert(place, command);
  until_ = std::min(until_, command.window.start);
  return true;
}

template <class Command>
bool Loads::add(Commands<Command>& commands, const Command& command, double now) {
  if (!hasRoom()) return false;
  commands.timed.push_back(command);
  if (command.window.start > now) until_ = std::min(until_, command.window.start);
  return true;
}

bool Loads::holdTorque(int joint, double torque, Window window, double now) {
  return hold(torques_, {joint, torque, window}, now);
}

bool Loads::holdForce(int link, Vec2d point, Vec2d force, double moment, Window window, double now) {
  return hold(forces_, {link, point, force, moment, window}, now);
}

bool Loads::addTorque(int joint, double torque, Window window, double now) {
  return add(torques_, {joint, torque, window}, now);
}

bool Loads::addForce(int link, Vec2d point, Vec2d force, double moment, Window window, double now) {
  return add(forces_, {link, point, force, moment, window}, now);
}

void Loads::clearCommands() {
  torques_.waiting.clear();
  forces_.waiting.clear();
  torques_.timed.clear();
  forces_.timed.clear();
  std::fill(torques_.held.begin(), torques_.held.end(), TorqueCommand{});
  std::fill(forces_.held.begin(), forces_.held.end(), ForceCommand{});
}

std::vector<Load> Loads::commands(double t) const {
  std::vector<Load> loads;
  const auto isInForce = [t](const Window& window) { return window.start <= t && t < window.stop; };
  for (const auto* commands : {&torques_.held, &torques_.timed}) {
    for (const auto& [joint, torque, window] : *commands) {
      if (!isInForce(window)) continue;
      loads.push_back(
          {"command", Load::none, {}, {}, 0, joint, torque, Constant{}, window.start, window.stop});
    }
  }
  for (const auto* commands : {&forces_.held, &forces_.timed}) {
    for (const auto& [link, point, force, moment, window] : *commands) {
      if (!isInForce(window)) continue;
      loads.push_back(
          {"command", link, force, point, moment, Load::none, 0, Constant{}, window.start, window.stop});
    }
  }
  return loads;
}

}  // namespace planar_chain
