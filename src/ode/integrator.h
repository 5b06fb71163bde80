#pragma once

/// Integrators: they choose the steps from one time to another.

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "ode/stepper.h"
#include "ode/system.h"

namespace planar_chain::ode {

enum class Outcome {
  arrived,       ///< t is the end
  underway,      ///< one step was made towards the end
  switched,      ///< as underway, and f changes here: see events.h
  notFinite,     ///< the next step is not finite, however short it is
  undetermined,  ///< a projection moves the state by far more than the tolerance: see projected_steps.h
  endless,       ///< events follow each other, and time does not pass
  stepTooSmall,  ///< the tolerance needs steps below the spacing of the numbers at t, or at 1 s
};

inline bool hasFailed(Outcome outcome) {
  return outcome == Outcome::notFinite || outcome == Outcome::undetermined || outcome == Outcome::endless ||
         outcome == Outcome::stepTooSmall;
}

struct StepCount {
  long long accepted = 0;
  long long rejected = 0;
  double lastError = 0;  ///< of the last accepted step, in units of the tolerance. 0: no estimate
  long long leaps = 0;   ///< among the accepted (leaping_steps.h)
};

/// The error control accepts a step of length h if it adds to component i at most an error of
///
///     ¼ tolerance · clamp(h / 1 s, 1/1000, 1) · min(unit_i + |y_i|, ceiling_i)
///
/// This is the textbook's atol + rtol |y_i| with atol = rtol, but stricter. The factor ¼ is there because
/// errors of angles and rates feed each other on the way to the end. The error is one per second, not per
/// step: the errors of a second meet the tolerance, however many steps it takes. A component's size counts up
/// to its ceiling: an angle after a million turns must be as exact as after one. Components beyond the
/// ceilings are not controlled.
///
/// The rounding of a stiff f may exceed this error at every h. So steps below a millisecond count as one
/// millisecond, and an error passes that is no larger than the effect of rounding y (local_stiffness.h).
/// Below a tolerance of 1e-10 rounding counts in proportion. From 1e-10 on an error estimate near the allowed
/// one is compared, now and then, with that of a step of another length. If it is rounding, so much of the
/// rounding counts for the next steps that they pass.
///
/// If `ofRates` is given, it is the tolerance of rates. Otherwise a rate's error counts as the error of the
/// angle that it causes, and may be 1 s/T times that of an angle:
///
///     T = clamp(max(h/2, 1/|λ|, (2e-10/tolerance)² s), 0, 1 s)
///
/// The size of the rate is at most 16 unit + T |y| then. So an error may be relative to a fast rate, or turn
/// the link as far as that of a slow one, not both: the angle would be off by |y| times its tolerance.
///
/// An error e of the rate that grows along the step turns the link by e h/2 within it. Later it turns it by
/// at least e/|λ|, as no vibration is faster than |λ|, the largest eigenvalue of J. Where stops change the
/// stiffness, |λ| is the least one so far: the error stays when a stop is left. At a tolerance of 2e-10, T is
/// 1 s. Stiff motions then mostly need half the evaluations or fewer, and angles still meet the tolerance.
struct Tolerance {
  static constexpr Eigen::Index none = std::numeric_limits<Eigen::Index>::max();

  Tolerance() = default;
  /// All units are 1.
  Tolerance(double value_, Eigen::ArrayXd ceiling_, Eigen::Index firstRate_ = none,
            std::optional<double> ofRates_ = {})
      : value(value_), ceiling(std::move(ceiling_)), firstRate(firstRate_), ofRates(ofRates_) {
    unit.setOnes(ceiling.size());
  }

  double value = 0;
  Eigen::ArrayXd unit, ceiling;
  Eigen::Index firstRate = none;  ///< components before it are angles
  std::optional<double> ofRates{};
  Eigen::Index works = 0;  ///< components at the end of `ceiling`
  double unitOfWork = 1;   ///< J: that of works beyond the ceilings, too

  /// True if auto expects taylor, and radau13 among the stiff methods, to be the fastest.
  bool isFine() const { return value <= 1e-5; }
  /// Returns this tolerance for components of f in lane order. Allocates.
  Tolerance inLaneOrder(const System& f) const;

  double size(const Vector& y, Eigen::Index i) const {
    return std::min(unit[i] + std::abs(y[i]), ceiling[i]);
  }
};

struct LocatedEvent;

class Integrator {
 public:
  Integrator() = default;
  Integrator(const Integrator&) = delete;
  Integrator& operator=(const Integrator&) = delete;
  virtual ~Integrator() = default;
  /// The name of the method in use.
  virtual const char* name() const = 0;
  /// Makes one step towards time `end`. The last step ends there exactly. An adaptive step is no longer than
  /// longestStep; a fixed one ignores it. After a failure `state` is unchanged. Allocates nothing.
  virtual Outcome advance(State& state, double end, double longestStep) = 0;
  /// Calls advance() until `end`, or mostSteps times. Allocates nothing.
  Outcome integrate(State& state, double end, double longestStep,
                    int mostSteps = std::numeric_limits<int>::max());
  /// Repeats the last advance() from its start with a shorter step, to time t and without error control.
  /// Returns false, and changes nothing, if the result is not finite. Allocates nothing.
  virtual bool stepTo(State& state, double t) = 0;
  /// stepTo() without integrals. It costs nothing if the step is a polynomial.
  virtual bool lookTo(State& state, double t) = 0;
  /// MethodFacts::pieces of the method of the last advance().
  virtual int pieces() const { return 1; }
  /// Returns the largest ratio of a component of `error`, in lane order, to the error that a step of h may
  /// add at y. The last advance() may end with an error more whose norm is at most 1.
  virtual double errorNorm(const Vector& y, double h, const Vector& error) const = 0;
  /// The event at which the last advance() ended. Valid only after `switched`.
  virtual const LocatedEvent& event() const;
  /// Call this when the state was set to one within the last advance(). May move it within its error.
  virtual void endAt(State& /*state*/) {}
  /// Call this when the state was moved within its error.
  virtual void forgetSlope() = 0;
  /// Call one of these when f has jumped; when its stiffness may have changed, too; when the state was set,
  /// or f was replaced. A kink is a jump after which the step size still suits; at a stiff one the stiffness
  /// may have changed, too.
  void restart() { restartAfter(Change::jump); }
  void passEvent() { restartAfter(Change::stiffness); }
  void begin() { restartAfter(Change::all); }
  enum class Change { kink, stiffKink, jump, stiffness, all };
  virtual void restartAfter(Change change) = 0;
  /// From the next step on. An integrator without error control ignores it.
  virtual void setTolerance(const Tolerance& /*tolerance*/) {}
  virtual StepCount count() const = 0;
  /// All that the next steps depend on, and count() (simd/snapshot.h). The tolerance is set before. Call it
  /// between two advance().
  virtual void saveOrRestore(Snapshot& snapshot) = 0;
};

/// Steps of another integrator, with something more: what is not said otherwise is that one's.
class StepsOf : public Integrator {
 public:
  explicit StepsOf(std::unique_ptr<Integrator> steps) : steps_(std::move(steps)) {}

  const char* name() const override { return steps_->name(); }
  bool stepTo(State& state, double t) override { return steps_->stepTo(state, t); }
  bool lookTo(State& state, double t) override { return steps_->lookTo(state, t); }
  int pieces() const override { return steps_->pieces(); }
  double errorNorm(const Vector& y, double h, const Vector& error) const override {
    return steps_->errorNorm(y, h, error);
  }
  void restartAfter(Change change) override { steps_->restartAfter(change); }
  void forgetSlope() override { steps_->forgetSlope(); }
  void setTolerance(const Tolerance& tolerance) override { steps_->setTolerance(tolerance); }
  StepCount count() const override { return steps_->count(); }
  void saveOrRestore(Snapshot& snapshot) override { steps_->saveOrRestore(snapshot); }

 protected:
  std::unique_ptr<Integrator> steps_;
};

/// Makes equal steps of at most h to the end of each advance(). Allocates.
std::unique_ptr<Integrator> fixedSteps(std::unique_ptr<Stepper> stepper, double h);

class LocalStiffness;

/// Makes steps whose error estimates meet the tolerance. Integrators of the same state may share `stiffness`,
/// which is that of the stepper's system. Allocates.
/// @throws std::invalid_argument for a stepper without error estimate
std::unique_ptr<Integrator> adaptiveSteps(std::unique_ptr<Stepper> stepper, Tolerance tolerance,
                                          std::shared_ptr<LocalStiffness> stiffness);

/// Uses the fastest of several adaptive methods, by trials during the run. The first method must have no
/// limit of stability, another one must have one. jumpsOften: as in SeriesSystem. Allocates.
std::unique_ptr<Integrator> fastestSteps(std::vector<std::unique_ptr<Stepper>> steppers, Tolerance tolerance,
                                         std::shared_ptr<LocalStiffness> stiffness, bool jumpsOften);

}  // namespace planar_chain::ode
