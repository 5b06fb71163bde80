#pragma once

/// The motion of a chain that is not bare: with prismatic joints, armatures, prescribed joints, friction, a
/// base that moves, a held tip, or forces that depend on the motion. Bare chains have none and run dynamics.h
/// alone.
///
/// If joints only stick, long chains of revolute joints run without evaluation.h: bodies that stick together
/// are one body (welded_chain.h).
///
/// Results at a state are kept, by its time and all its numbers: the same state is not computed again. Those
/// for the steps of a method, for switches and for queries are kept apart. So no query between two steps
/// changes a bit of the motion.
///
/// States y = [ψ ψ̇] are in chain order.

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/closure.h"
#include "dynamics/evaluation.h"
#include "dynamics/welded_chain.h"
#include "ode/system.h"

namespace planar_chain {

/// Only the constructor allocates.
class GeneralMotion final : private Mechanics {
 public:
  /// The mechanism and the effects must outlive this object.
  GeneralMotion(const Mechanism& mechanism, Effects& effects);
  GeneralMotion(const GeneralMotion&) = delete;
  GeneralMotion& operator=(const GeneralMotion&) = delete;

  std::string recursion() const;
  /// True if bodies that stick together may be welded.
  /// The number of states that were computed, but for queries.
  long long evaluations() const { return evaluations_; }

  // ---- What acts has changed: call one of these -------------------------------------------------------

  /// After Effects::enter(), and before Effects::enterState().
  void forget() { forget(true); }
  /// Before Effects::fire().
  void prepareChange();
  /// After Effects::saveOrRestore(): the count, and the states whose results are known.
  void saveOrRestore(Snapshot& snapshot);

  // ---- Results; valid until the next call -------------------------------------------------------------

  /// Writes ψ̈, and returns the powers: for the steps of a method.
  Powers rates(double t, const double* y, double* slopes) {
    const Evaluation& at = this->at(t, y, stepped_, asked_);
    std::copy_n(at.slopes(), n_, slopes);
    return at.powers;
  }
  /// See ode::System.
  void endedAt(ode::State& state) const;
  /// The powers alone.
  Powers powers(double t, const double* y);
  /// Everything: for a Jacobian or a series. Does not change what rates() will give.
  const Evaluation& at(double t, const double* y);
  /// Everything: for a query. Changes nothing that the functions above give or count.
  const Evaluation& query(double t, const double* y);
  /// The couplings at t.
  const Couplings& couplings(double t);
  Evaluator& evaluator() { return evaluator_; }
  /// A query: writes the torques of drives, rotors left out, and of friction, n values.
  void torques(double t, const double* y, double* tau);

  // ---- Held joints: driven or stuck ---------------------------------------------------------------------

  /// Puts held joints where they are at t, exactly. Returns true if there are any.
  bool hold(double t, double* y);
  /// hold() for relative angles and rates.
  void hold(double t, double* q, double* qd) { couplings(t).hold(q, qd); }

  // ---- A held tip ----------------------------------------------------------------------------------------

  /// Moves a state onto the conditions of held joints and the tip (closure.h). carry: as ode::State, or
  /// nullptr. Returns false if it cannot.
  bool project(double t, double* y, double* carry);
  /// The distance of the tip from where it is held, m; 0 if it is free.
  double closureError(double t, const double* y) {
    return closure_ ? length(closure_->gap(couplings(t), y)) : 0;
  }
  /// See Closure::spread(); 1 if the tip is free.
  double spread(double t, const double* y) { return closure_ ? closure_->spread(couplings(t), y) : 1; }
  /// spread() where the last project() ended.
  double lastSpread() const { return closure_ ? closure_->lastSpread(couplingsNow_) : 1; }
  bool isStretched(double t, const double* y) override {
    // Rounding, 1e-16, grows by one over the margin in the force on the tip: beyond this to 1e-7 of it.
    // Larger, motions that only come near such a pose are stopped; smaller, rounding chooses their way.
    constexpr double undecided = 1e-9;
    return spread(t, y) < undecided;
  }

 private:
  struct Welded {
    explicit Welded(const Mechanism& of) : chain(of.chain(), of.kernel()) {}

    WeldedChain chain;
    bool isWelded = false;  ///< chain has the joints that stick now
    bool hasConstantMoments = false;
    const Evaluation* last = nullptr;  ///< what the chain computed last
  };

  /// The results at a state: known in one of these, or computed in `own`.
  const Evaluation& at(double t, const double* y, Evaluation& own, Evaluation& other) {
    if (own.isAt(t, y)) return own;
    if (other.isAt(t, y)) return other;
    ++evaluations_;
    isWelded() ? runWelded(t, y, own) : evaluator_.evaluate(t, y, own);
    return own;
  }
  JointAnswer answer(double t, const double* y) override;
  void snapPrescribed(double t, double* y, double most) override;
  void forget(bool holds) override;
  bool isWelded() const { return welded_ && effects_.acting() != LoadKind::forces; }
  void runWelded(double t, const double* y, Evaluation& to);
  Powers weldedPowers(const ChainState& at, double* N);

  Coordinates coordinates_;
  Effects& effects_;
  int n_;
  Evaluator evaluator_;
  // For rates(); for events and at(). They are of the welded chain, if there is one, without at()'s extras.
  Evaluation stepped_, asked_;
  Evaluation whole_;  ///< for at(), beside a welded chain
  Evaluation queried_;
  std::optional<Welded> welded_;
  std::optional<Closure> closure_;  ///< if the tip is held
  Couplings couplingsNow_;
  std::vector<double> scratch_, snapped_;
  long long evaluations_ = 0;
};

}  // namespace planar_chain
