#include "ode/radau.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "simd/elementary.h"

namespace planar_chain::ode {

namespace {

constexpr int mostIterations = 17;    // for seven stages; Hairer's code RADAU
constexpr double newtonShare = 0.03;  // of the error allowed, or √tolerance if that is less: the same
constexpr double slow = 0.5;          // an iteration that shrinks the change by less may be shaking digits
constexpr double fading = 0.8;        // the power of the last step's rate of convergence that counts; RADAU
constexpr double diverging = 0.99;    // an iteration that shrinks the change by less does not end; RADAU
constexpr double farShorter = 1e-6;   // of the last step, whose polynomial is then of no use
constexpr double halving = 1.8;       // an error of 1.8⁷ makes the step 0.9/1.8 of its length
constexpr double epsilon = std::numeric_limits<double>::epsilon();

}  // namespace

Radau::Radau(LinearizedSystem& f, Tolerance tolerance, std::shared_ptr<const LocalStiffness> stiffness)
    : ImplicitStepper({"radau13", 2 * stages - 1, stages, std::numeric_limits<double>::infinity(), true}, f),
      tolerance_(std::move(tolerance)),
      stiffness_(std::move(stiffness)) {
  f_.reserve(RadauTable::pairs);
}

void Radau::step(double t, double h, const Vector& y) {
  linearize(t, y);
  f_.factor(table_.lambda / h);
  for (int k = 0; k < RadauTable::pairs; ++k) f_.factorComplex(k, table_.mu[k] / h);
  const Allowance allowance(tolerance_, *stiffness_, h);
  const double share = std::min(newtonShare, std::sqrt(tolerance_.value));
  for (Eigen::Index i = 0; i < allowed_.size(); ++i) {
    const double size = allowance.size(tolerance_, y, i);
    const double noise = stiffness_->noise()[i];
    const double lost = std::max(noise * stiffness_->timeOf(h), 2 * epsilon * tolerance_.size(y, i));
    const double most = i < tolerance_.firstRate ? allowance.most : allowance.mostOfRates;
    const auto allowedOf = [&](double one) { return std::max(one * size, allowance.perNoise * noise); };
    allowed_[i] = allowedOf(most);
    mayVanish_[i] = std::max(allowed_[i], tolerance_.value * (most / allowance.most) * size);
    perLost_[i] = 1 / lost;
    // Rates count in full here: with coarser stages the error estimate is meaningless.
    perExactEnough_[i] = 1 / std::max(share * allowedOf(std::min(most, allowance.most)), lost);
  }
  // Works without an error estimate are sums of squares of rates: where those need one iteration, they need
  // two.
  for (Eigen::Index i = allowed_.size(); i < y.size(); ++i) {
    const double size = std::max(tolerance_.unitOfWork, std::abs(y[i]));
    perExactEnough_[i] = 1 / (std::max(newtonShare * tolerance_.value, 2 * epsilon) * size);
  }
  hTried_ = h;
  carryOn(h);
  const double excess = solveStages(t, h, y);
  if (excess == 0) {
    increment_ = Z_.col(stages - 1);
    estimate(t, h, y);
    return;
  }
  rate_ = 1;
  increment_.setConstant(std::nan(""));
  error_.setZero();
  error_[0] = excess * allowed_[0];
}

/// sums = base + x weights; base may be nullptr or sums, not x.
void Radau::multiply(const Stages& x, const RadauTable::Square& weights, const Stages* base,
                     Stages& sums) const {
  static_assert(stages <= simd::VectorKernel::mostTerms);
  const double* columns[stages];
  for (int j = 0; j < stages; ++j) columns[j] = x.col(j).data();
  for (int i = 0; i < stages; ++i) {
    double* to = sums.col(i).data();
    const double* from = base ? base->col(i).data() : nullptr;
    vectors_.combine[stages - 1](1, weights.col(i).data(), columns, from, base ? nullptr : to,
                                 base ? to : nullptr, x.rows());
  }
}

/// Z_i = π(1 + c_i h/hLast) − π(1), π the polynomial of the last step.
void Radau::carryOn(double h) {
  if (h <= farShorter * hLast_ || hLast_ == 0) {
    Z_.setZero();
    return;
  }
  RadauTable::Square weights;
  for (int i = 0; i < stages; ++i) {
    const double x = 1 + table_.c[i] * (h / hLast_);
    const double whole = x * (x - table_.c.array()).prod();
    weights.col(i) = whole * table_.p.array() / (x - table_.c.array());
  }
  weights.row(stages - 1).array() -= 1;
  multiply(last_, weights, nullptr, Z_);
}

/// Iterates until the remaining error, extrapolated from the changes, is small enough. Returns 0; or, if that
/// fails, the error to report in units of the allowed one: NaN if the stages are not finite.
double Radau::solveStages(double t, double h, const Vector& y) {
  static const double failed = simd::power(halving, stages);
  // The first iteration is judged by what the second one changed last time. Where all else is driven, later
  // ones change nothing but digits.
  double rate = rate_ = simd::power(std::max(rate_, epsilon), fading), before = 0;
  for (iterations_ = 1; iterations_ <= mostIterations; ++iterations_) {
    improve(t, h, y);
    if (!change_.allFinite()) return std::nan("");
    const double size = largest(perExactEnough_);
    if (iterations_ > 1 && size > 0) {
      const double theta = size / before;
      if (theta > slow && largest(perLost_) <= 1) return 0;
      if (theta >= diverging) return failed;
      rate = theta / (1 - theta);
      // From Z = 0 the first change is the motion itself, which shrinks faster than the error of a guess.
      if (iterations_ == 2 && hLast_ > 0) rate_ = rate;
      if (rate * size > 1 && simd::power(theta, mostIterations - iterations_) / (1 - theta) * size > 1) {
        return failed;
      }
    }
    if (rate * size <= 1) return 0;
    before = size;
  }
  return failed;
}

/// One iteration of Newton's method.
void Radau::improve(double t, double h, const Vector& y) {
  for (int i = 0; i < stages; ++i) {
    stage_ = y + Z_.col(i);
    f_.slope(t + table_.c[i] * h, stage_.data(), R_.col(i).data());
  }
  multiply(Z_, -table_.W.transpose() / h, &R_, R_);
  multiply(R_, table_.inverseT.transpose(), nullptr, change_);
  f_.solve(change_.col(0).data(), change_.col(0).data());
  for (int k = 0; k < RadauTable::pairs; ++k) {
    pair_.real() = change_.col(1 + 2 * k);
    pair_.imag() = change_.col(2 + 2 * k);
    f_.solveComplex(k, pair_.data(), pair_.data());
    change_.col(1 + 2 * k) = pair_.real();
    change_.col(2 + 2 * k) = pair_.imag();
  }
  multiply(change_, table_.T.transpose(), nullptr, R_);
  Z_ += R_;
  change_.swap(R_);
}

void Radau::estimate(double t, double h, const Vector& y) {
  combined_ = (table_.lambda / h) * Z_.lazyProduct(table_.e);
  stage_ = startSlope_ + combined_;
  f_.solve(stage_.data(), error_.data());
  const auto error = error_.head(allowed_.size()).array().abs();
  if ((error > allowed_).any() && (error <= mayVanish_).all()) {
    stage_ = y + error_;
    f_.slope(t, stage_.data(), error_.data());
    stage_ = error_ + combined_;
    f_.solve(stage_.data(), error_.data());
  }
}

}  // namespace planar_chain::ode
