#pragma once

/// The motion of a chain together with columns c of its derivative, as one initial value problem:
///
///     y = [θ ω | c_1 | c_2 …]        ċ = J c + f_u u(t) + f_p        (dynamics.h has θ and ω)
///
/// J c is one sweep with dual numbers (motion_change.h), f_u a torque in a joint, f_p a difference of f
/// between scenes that are near in a number. Implicit methods take the block J of the motion for each column:
/// what couples the columns to the motion is left to their iterations.
///
/// Columns are stored divided by a scale of their own, so that each counts as much as the motion in the error
/// control.

#include <complex>
#include <functional>
#include <vector>

#include "dynamics/exact_solve.h"
#include "dynamics/motion_change.h"
#include "dynamics/near_scenes.h"
#include "ode/system.h"

namespace planar_chain {

class VariedMotion final : public ode::LinearizedSystem {
 public:
  /// What moves a column besides J c: a torque in a joint, a number, or nothing.
  struct Column {
    int joint = -1;
    NearScenes* number = nullptr;
    bool isLag = false;  ///< the torque is that in the lag of the joint's motor; if not, it is held
    double scale = 1;
  };

  /// share(column, t): the torque in its joint at t per torque that is held, or was in the lag.
  using Share = std::function<double(const Column&, double)>;

  /// The effects of the dynamics must outlive this object. Allocates.
  VariedMotion(const Scene& scene, const Effects& effects, std::vector<Column> columns, Share share);

  int states() const { return 2 * n_; }
  std::vector<Column>& columns() { return columns_; }
  const Mechanism& mechanism() const { return mechanism_; }
  /// Call it when what acts has changed.
  void enter();
  /// What acts at a state of the motion, and f. Valid until the next call.
  const Evaluation& at(double t, const double* y);
  const Couplings& couplings(double t);
  /// How the rates change by J c, n values, if the held joints speed up by `prescribed` besides; or nullptr.
  void change(const double* c, const double* prescribed, double* to);
  double shareOf(const Column& column, double t) const { return share_(column, t); }
  /// The change of the moment in a joint in the last change() or findSource().
  double moment(int joint) const { return change_.moments[index(joint)]; }
  /// f_u + f_p of a column at the state of the last at(), n values, not scaled.
  void findSource(const Column& column, double* to);

  int size() const override { return 2 * n_ * (1 + static_cast<int>(columns_.size())); }
  const simd::VectorKernel& vectors() const override { return simd::vectors(mechanism_.kernelChoice()); }
  void derivative(double t, const double* y, double* dydt) override;
  void reserve(int complexCount) override { solve_.reserve(complexCount); }
  void linearize(double t, const double* y, double* dydt) override;
  bool timeDerivative(double*) override { return false; }
  ode::LinearCosts linearCosts() const override { return solve_.costs(); }
  void factor(double s) override { solve_.factor(s); }
  void solve(const double* rhs, double* x) override;
  void factorComplex(int k, std::complex<double> s) override { solve_.factorComplex(k, s); }
  void solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) override;

 private:
  void findChange(const double* c, const double* prescribed);

  const Effects& effects_;
  const Mechanism mechanism_;
  const int n_;
  std::vector<Column> columns_;
  Share share_;
  Evaluator evaluator_;
  Evaluation at_;
  Couplings couplings_;
  EffectTangents tangents_, solved_;
  MotionChange change_;
  ExactSolve solve_;
  std::vector<double> part_;
  std::vector<std::complex<double>> complexPart_;
};

}  // namespace planar_chain
