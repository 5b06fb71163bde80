#pragma once

/// The states within a step, from f at its ends and in its middle. With s = (t − t_0)/h:
///
///     θ = p(s) + d g(s)       g = (s − s²)³       d = (8/3) (p'' − h² α)(½)
///     ω = θ'/h                W = W_0 + ∫ Ẇ dt, by Gauss's rule of three points
///
/// p is the quintic through θ, ω and α at both ends. α(½) is f's at its state in the middle. The error of ω
/// is of order h⁵ by the quintic, and h⁶ with d g. So d g is larger than the error that is left.

#include <array>
#include <cstddef>
#include <limits>

#include "ode/system.h"

namespace planar_chain::ode {

class Integrator;

/// Only the constructor allocates. f is evaluated when a result first needs it.
class DenseOutput {
 public:
  /// f must outlive this object.
  explicit DenseOutput(SeriesSystem& f);
  /// True if f has positions. Otherwise nothing else may be called.
  bool isPossible() const { return n_ > 0; }

  /// Evaluates f where the next step starts, unless the last one ended there.
  void begin(const State& from);
  /// Takes the ends of a step. polynomial: whose last step it is, if its states are known for nothing
  /// (Integrator::pieces()), else nullptr.
  void take(const State& from, const State& to, Integrator* polynomial = nullptr);
  /// Call it when f has jumped.
  void forget();
  /// The values that are known where the next step starts.
  void saveOrRestore(Snapshot& snapshot);

  /// True if errorAt() and land() cost little: f is known at both ends, or not needed.
  bool isKnown() const { return polynomial_ || (start_.isKnown && end_.isKnown); }

  /// [θ ω] at t within the step, and the works at its start, in chain order. Valid until the next call. In
  /// the middle d g is left out.
  const Eigen::VectorXd& at(double t) const;
  /// α at t within the step, by p'', in the order of at(). Valid for two more calls.
  const Eigen::VectorXd& accelerationsAt(double t) const;
  /// d, in the order of at(). Valid until the next take().
  const Eigen::VectorXd& quarticTerm() const;
  /// A bound of the error there, in lane order: d g and d g'.
  const Vector& errorAt(double t) const;
  /// Sets `state` to that at t.
  void land(double t, State& state) const;

 private:
  struct End {
    State state;
    Vector slope;
    bool isKnown = false;  ///< slope
    auto rates(Eigen::Index n) const { return slope.segment(n, n); }
  };
  const Vector& inLaneOrderAt(double t) const;
  void startAt(const State& from);
  void evaluate(End& end) const;
  void findRates() const;
  void findQuartic() const;
  void forgetStates();
  double middle() const { return start_.state.t + h_ / 2; }

  SeriesSystem& f_;
  const simd::VectorKernel& vectors_;
  const Eigen::Index n_;  ///< positions, in lane order
  double h_ = 0;
  mutable Eigen::VectorXd turn_;      ///< of θ, from end to end
  mutable bool isTurnKnown_ = false;  ///< where it is rounding, too
  mutable End start_, end_;
  mutable bool isQuarticKnown_ = false;  ///< quartic_ is known
  Integrator* polynomial_ = nullptr;
  mutable State within_;  ///< of the polynomial
  mutable Eigen::VectorXd quartic_, increment_, restored_, quarticInOrder_;
  mutable bool isQuarticInOrder_ = false;
  struct Accelerations {
    double t;
    Eigen::VectorXd values;
  };
  mutable std::array<Accelerations, 3> accelerations_;  ///< the last ones: at both ends and in the middle
  mutable std::size_t next_ = 0;                        ///< of these
  mutable double time_ = std::numeric_limits<double>::quiet_NaN();  ///< of at_
  mutable double timeRestored_ = time_;                             ///< of restored_
  mutable Vector at_, rates_, error_, slope_;
};

}  // namespace planar_chain::ode
