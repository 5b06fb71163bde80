#include "dynamics/varied_motion.h"

#include <algorithm>
#include <utility>

namespace planar_chain {

VariedMotion::VariedMotion(const Scene& scene, const Effects& effects, std::vector<Column> columns,
                           Share share)
    : effects_(effects),
      mechanism_(scene, true),
      n_(mechanism_.size()),
      columns_(std::move(columns)),
      share_(std::move(share)),
      evaluator_(mechanism_, effects),
      at_(mechanism_, effects),
      couplings_(n_),
      tangents_(n_, effects),
      solved_(n_, effects),
      change_(mechanism_),
      solve_(mechanism_, effects, solved_, false),
      part_(index(2 * n_ + 2)),
      complexPart_(part_.size()) {
  enter();
}

void VariedMotion::enter() {
  evaluator_.forgetCouplings();
  tangents_.takeConstant(effects_);
  solved_.takeConstant(effects_);
}

const Evaluation& VariedMotion::at(double t, const double* y) {
  evaluator_.evaluate(t, y, at_);
  tangents_.takeJoints(effects_, at_.state());
  tangents_.takeForces(effects_, at_.state());
  effects_.couple(t, 0, couplings_);
  return at_;
}

const Couplings& VariedMotion::couplings(double t) {
  effects_.couple(t, 0, couplings_);
  return couplings_;
}

void VariedMotion::findChange(const double* c, const double* prescribed) {
  const Coordinates& coordinates = mechanism_.coordinates();
  std::fill(change_.N.begin(), change_.N.end(), 0.0);
  std::copy_n(c, n_, change_.turn.begin());
  std::copy_n(c + n_, n_, change_.speed.begin());
  for (int i = 0; i < n_; ++i) {
    change_.prescribed[index(i)] = prescribed ? prescribed[i] : 0;
    const double torque = -tangents_.k[index(i)] * coordinates.relative(c, i) -
                          tangents_.d[index(i)] * coordinates.relative(c + n_, i);
    coordinates.addTorque(torque, i, change_.N.data());
  }
}

void VariedMotion::change(const double* c, const double* prescribed, double* to) {
  findChange(c, prescribed);
  change_.find(at_, effects_.acting() == LoadKind::forces, couplings_, tangents_);
  std::copy(change_.xdd.begin(), change_.xdd.end(), to);
}

void VariedMotion::findSource(const Column& column, double* to) {
  if (column.number) return column.number->slopes(at_.t, at_.y.data(), to);
  std::fill(part_.begin(), part_.end(), 0.0);
  findChange(part_.data(), nullptr);
  if (column.joint >= 0) mechanism_.coordinates().addTorque(1, column.joint, change_.N.data());
  change_.find(at_, effects_.acting() == LoadKind::forces, couplings_, tangents_);
  std::copy(change_.xdd.begin(), change_.xdd.end(), to);
}

void VariedMotion::derivative(double t, const double* y, double* dydt) {
  const Evaluation& motion = at(t, y);
  std::copy_n(y + n_, n_, dydt);
  std::copy_n(motion.slopes(), n_, dydt + n_);
  const bool hasForces = effects_.acting() == LoadKind::forces;
  for (const Column& column : columns_) {
    y += 2 * n_;
    dydt += 2 * n_;
    std::copy_n(y + n_, n_, dydt);
    findChange(y, nullptr);
    if (column.joint >= 0) {
      mechanism_.coordinates().addTorque(share_(column, t) / column.scale, column.joint, change_.N.data());
    }
    change_.find(at_, hasForces, couplings_, tangents_);
    std::copy(change_.xdd.begin(), change_.xdd.end(), dydt + n_);
    if (!column.number) continue;
    column.number->slopes(t, at_.y.data(), part_.data());
    for (int i = 0; i < n_; ++i) dydt[n_ + i] += part_[index(i)] / column.scale;
  }
}

void VariedMotion::linearize(double t, const double* y, double* dydt) {
  derivative(t, y, dydt);
  solve_.linearize(at_);
}

void VariedMotion::solve(const double* rhs, double* x) {
  for (int k = 0; k < size(); k += 2 * n_) {
    std::copy_n(rhs + k, 2 * n_, part_.begin());
    part_[index(2 * n_)] = part_[index(2 * n_ + 1)] = 0;
    solve_.solve(part_.data(), part_.data());
    std::copy_n(part_.begin(), 2 * n_, x + k);
  }
}

void VariedMotion::solveComplex(int k, const std::complex<double>* rhs, std::complex<double>* x) {
  for (int i = 0; i < size(); i += 2 * n_) {
    std::copy_n(rhs + i, 2 * n_, complexPart_.begin());
    complexPart_[index(2 * n_)] = complexPart_[index(2 * n_ + 1)] = 0;
    solve_.solveComplex(k, complexPart_.data(), complexPart_.data());
    std::copy_n(complexPart_.begin(), 2 * n_, x + i);
  }
}

}  // namespace planar_chain
