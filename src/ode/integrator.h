#pragma once

/// From one time to another: who chooses the steps.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "ode/stepper.h"
#include "ode/system.h"

namespace planar_chain::simd {
struct VectorKernel;
}

namespace planar_chain::ode {

enum class Outcome {
  arrived,       ///< t is the time asked for
  underway,      ///< a good step on the way there
  switched,      ///< as underway, and f is another one from here on: see switches.h
  notFinite,     ///< the next step leaves the finite numbers, however small it is made
  stepTooSmall,  ///< the tolerance asks for steps below the spacing of the numbers at t, or at 1 s
};

struct StepCount {
  long long accepted = 0;
  long long rejected = 0;
  double lastError = 0;  ///< of the last accepted step, in units of the tolerance; 0 without an estimate
};

/// What the error control looks at: a step of length h may add to component i an error of
///
///     ¼ tolerance · clamp(h / 1 s, 1/1000, 1) · (1 + min(|y_i|, ceiling_i))
///
/// This is the textbook's atol + rtol |y_i| with atol = rtol, but more demanding. A quarter, as errors of
/// angles and rates feed each other while they travel to the end. It is an error per second, not per step, so
/// what adds up over a second meets the tolerance however many steps it took. And a component's size counts
/// only up to its ceiling: an angle that has gone round a million times must not be a million times less
/// exact. Components beyond the ceiling's length are not controlled.
///
/// The rounding of a stiff f may be larger than that, in proportion to h as well, so that no step would be
/// short enough. Hence steps below a millisecond are treated like one of a millisecond, and an error that is
/// no larger than what rounding of y does over the step passes (surroundings.h). Below a tolerance of 1e-10
/// rounding counts in proportion: who asks for less wants every digit, whatever it costs.
struct Tolerance {
  double value = 0;
  Eigen::ArrayXd ceiling;

  /// For the components as f has them.
  Tolerance arrangedBy(const System& f) const;

  /// The factor that stands for the size of component i of a state y.
  double size(const Vector& y, Eigen::Index i) const { return 1 + std::min(std::abs(y[i]), ceiling[i]); }
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  /// Name of the method in use.
  virtual const char* name() const = 0;
  /// One step towards time end, landing on it exactly if it is the last; an adaptive step is no longer than
  /// longestStep, a fixed one as it was asked for. After the last two outcomes state is as it was before.
  /// Allocates nothing.
  virtual Outcome advance(State& state, double end, double longestStep) = 0;
  /// As many of them as it takes, but at most so many. Allocates nothing.
  Outcome integrate(State& state, double end, double longestStep,
                    int mostSteps = std::numeric_limits<int>::max());
  /// A step of the last advance()'s method, without error control: shorter than that one was, from where it
  /// started. False, and nothing has changed, when it is not finite.
  virtual bool stepTo(State& state, double t) = 0;
  /// f has jumped.
  virtual void restart() = 0;
  /// The state was set, or f has become another one altogether.
  virtual void begin() { restart(); }
  virtual const StepCount& count() const = 0;
};

/// Adds an increment to the state, carrying what rounding takes away, and sets its time. False, and nothing
/// has changed, when the result is not finite. Allocates nothing.
bool take(const simd::VectorKernel& vectors, State& state, double t, const Vector& increment);

/// Equal steps of at most h between the times that it must land on.
std::unique_ptr<Integrator> fixedSteps(std::unique_ptr<Stepper> stepper, double h);

/// Steps chosen so that the error estimate of each meets the tolerance (PI control; Hairer and Wanner,
/// Solving ODEs II, section IV.2; the first step as in Solving ODEs I, section II.4).
/// @throws std::invalid_argument for a stepper without error estimate.
std::unique_ptr<Integrator> adaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance);

class Surroundings;

/// The one of several adaptive methods that comes forward fastest, found out while running. The first must
/// have no limit of stability. surroundings: of the system; steppers may share it.
std::unique_ptr<Integrator> fastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, Tolerance tolerance,
                                         std::shared_ptr<Surroundings> surroundings);

}  // namespace planar_chain::ode
