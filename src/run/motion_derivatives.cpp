#include "run/motion_derivatives.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "dynamics/closure.h"
#include "effects/motors.h"
#include "ode/explicit_runge_kutta.h"
#include "ode/local_stiffness.h"
#include "ode/methods.h"
#include "ode/radau.h"
#include "run/derivative_notes.h"

namespace planar_chain {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The tolerance where the motion has none.
constexpr double ofFixedSteps = 1e-9;
/// Finer ones are rounding: of a sweep, of a difference between scenes.
constexpr double finestOfColumns = 1e-12, finestOfNumbers = 1e-10;

ode::Tolerance toleranceFor(const IntegratorSettings& settings, int n, int size, bool hasNumbers) {
  const double finest = hasNumbers ? finestOfNumbers : finestOfColumns;
  const double value =
      ode::hasFixedStep(settings.method) ? ofFixedSteps : std::max(settings.tolerance, finest);
  return {value, Eigen::ArrayXd::Constant(size, infinity), n, value};
}

std::unique_ptr<ode::Integrator> stepsOf(VariedMotion& motion, const ode::Tolerance& tolerance) {
  // The columns move nothing else, and do not make the motion stiffer.
  const auto stiffness = std::make_shared<ode::LocalStiffness>(motion, motion.size() - motion.states());
  std::vector<std::unique_ptr<ode::Stepper>> steppers;
  steppers.push_back(std::make_unique<ode::Radau>(motion, tolerance, stiffness));
  steppers.push_back(std::make_unique<ode::ExplicitRungeKutta>(ode::dop853(), motion));
  return ode::fastestSteps(std::move(steppers), tolerance, stiffness, false);
}

/// The least scale of the column of a number: what is below a tenth of what the number itself moves may be
/// rounding of the difference.
double leastOf(double number, double slope) {
  return 0.1 * std::max(slope, 1.0) / number;
}

/// The joints whose motors lag, in chain order.
std::vector<int> lagsOf(const Chain& chain) {
  std::vector<int> lags;
  for (int i = 0; i < chain.size(); ++i) {
    if (chain.joints()[index(i)].other(timeConstant) > 0) lags.push_back(i);
  }
  return lags;
}

double largest(const Eigen::Ref<const VectorXd>& values) {
  return values.size() > 0 ? values.cwiseAbs().maxCoeff() : 0;
}

/// The derivative of f along a direction at 0, by a difference of sixth order. size: of the direction.
template <class F>
auto differenceOf(const F& f, double size, double reach) {
  const double h = reach / size;
  decltype(f(h)) sum = 45 * (f(h) - f(-h));
  sum -= 9 * (f(2 * h) - f(-2 * h));
  sum += f(3 * h) - f(-3 * h);
  sum /= 60 * h;
  return sum;
}

}  // namespace

MotionDerivatives::MotionDerivatives(const Scene& scene, const Effects& effects,
                                     const CommandEffect* commands, const std::vector<VariedNumber>& numbers,
                                     bool fromStart, bool motors, double t, const VectorXd& y)
    : scene_(scene),
      effects_(effects),
      commands_(commands),
      n_(scene.chain.size()),
      since_(t),
      lags_(motors && commands ? lagsOf(scene.chain) : std::vector<int>()),
      alongSeries_(scene, effects, commands, lags_, numbers_),
      pieceBegan_(t) {
  for (const VariedNumber& number : numbers) {
    numbers_.push_back(std::make_unique<NearScenes>(number));
    paths_.push_back(number.path);
    sizes_.push_back(number.size);
  }
  columns_.setZero(2 * n_, 3 * n_ + static_cast<Eigen::Index>(lags_.size() + numbers.size()));
  beginColumns(fromStart, y);
  if (commands) noteProducts(scene.chain, motors, notes_);
  noteRest(
      scene.chain, t, y, couplingsAt(t),
      [&](int joint) { return motion(t, y).at(t, y.data()).moments[index(joint)]; }, notes_);
  enterNumbers(t);
  keep();
}

MotionDerivatives::General::General(MotionDerivatives& of)
    : motion(
          of.scene_, of.effects_,
          [&of] {
            std::vector<VariedMotion::Column> columns(index(2 * of.n_));
            for (int i = 0; i < of.n_; ++i) columns.push_back({i});
            for (const int i : of.lags_) columns.push_back({i, nullptr, true});
            for (const auto& number : of.numbers_) columns.push_back({-1, number.get()});
            return columns;
          }(),
          [&of](const VariedMotion::Column& column, double at) {
            if (!of.commands_) return 1.0;
            if (column.isLag) return of.commands_->shareOfLag(column.joint, at - of.since_);
            const double acts = of.since_ + of.commands_->delayOf(column.joint);
            return of.pieceBegan_ < acts ? 0 : of.commands_->shareOf(column.joint, at - acts);
          }),
      steps(stepsOf(motion, toleranceFor(of.scene_.integrator, of.n_, motion.size(), !of.numbers_.empty()))),
      state(motion.size()) {}

VariedMotion& MotionDerivatives::motion(double t, const VectorXd& y) {
  if (general_) return general_->motion;
  general_ = std::make_unique<General>(*this);
  VariedMotion& motion = general_->motion;
  const double slope = largest(Eigen::Map<const VectorXd>(motion.at(t, y.data()).slopes(), n_));
  for (std::size_t k = 0; k < motion.columns().size(); ++k) {
    VariedMotion::Column& column = motion.columns()[k];
    VectorXd source = VectorXd::Zero(n_);
    if (fault_.empty()) motion.findSource(column, source.data());
    const double size = std::max(largest(columns_.col(static_cast<Eigen::Index>(k))), largest(source));
    const std::size_t others = motion.columns().size() - numbers_.size();
    const double least = k >= others ? leastOf(sizes_[k - others], slope) : 0;
    column.scale = size > least ? size : least > 0 ? least : 1;
  }
  return motion;
}

// ---- The start ---------------------------------------------------------------------------------------

void MotionDerivatives::beginColumns(bool fromStart, const VectorXd& y) {
  const Coordinates& coordinates = scene_.chain.coordinates();
  MatrixXd unit = MatrixXd::Identity(2 * n_, 2 * n_);
  for (const Drive& drive : scene_.drives)
    unit(drive.joint, drive.joint) = unit(n_ + drive.joint, n_ + drive.joint) = 0;
  for (int k = 0; k < 2 * n_; ++k) {
    coordinates.toAbsolute(unit.col(k).data(), columns_.col(k).data());
    coordinates.toAbsolute(unit.col(k).data() + n_, columns_.col(k).data() + n_);
  }
  if (effects_.holdTip()) close(y);
  stopHeldJoints(since_, y);
  for (std::size_t k = 0; fromStart && k < numbers_.size(); ++k)
    columns_.col(columns_.cols() - static_cast<Eigen::Index>(numbers_.size() - k)) = numbers_[k]->start();
}

Couplings MotionDerivatives::couplingsAt(double t) const {
  Couplings couplings(n_);
  effects_.couple(t, 0, couplings);
  return couplings;
}

/// A state beside the present one is moved to where the tip is held.
void MotionDerivatives::close(const VectorXd& y) {
  Closure closure(motion(since_, y).mechanism());
  const Couplings couplings = couplingsAt(since_);
  // Its sixth power is small, and the rounding of a projection, 1e-13, over it.
  constexpr double reach = 0.01;
  for (int k = 0; k < 2 * n_; ++k) {
    const VectorXd column = columns_.col(k);
    const double size = largest(column);
    if (size == 0) continue;
    columns_.col(k) = differenceOf(
        [&](double h) {
          VectorXd moved = y.head(2 * n_) + h * column;
          closure.project(couplings, moved.data(), nullptr);
          return moved;
        },
        size, reach);
  }
}

/// A joint that sticks stops at once, by the impulse of its friction.
void MotionDerivatives::stopHeldJoints(double t, const VectorXd& y) {
  const Couplings couplings = couplingsAt(t);
  const Coordinates& coordinates = scene_.chain.coordinates();
  const VectorXd still = VectorXd::Zero(2 * n_);
  VectorXd stops(n_), change(n_);
  for (int k = 0; k < 2 * n_; ++k) {
    for (int i = 0; i < n_; ++i) {
      const bool isPrescribed = couplings.joints[index(i)].isPrescribed;
      stops[i] = isPrescribed ? -coordinates.relative(columns_.col(k).data() + n_, i) : 0;
    }
    if (largest(stops) == 0) continue;
    motion(t, y).at(t, y.data());
    motion(t, y).change(still.data(), stops.data(), change.data());
    columns_.col(k).tail(n_) += change;
  }
}

// ---- A smooth piece ----------------------------------------------------------------------------------

bool MotionDerivatives::enterNumbers(double t) {
  for (std::size_t k = 0; k < numbers_.size(); ++k) {
    if (numbers_[k]->enter(t, effects_)) continue;
    fail(t, paths_[k] + " moves the time of a jump, or adds an effect");
    return false;
  }
  return true;
}

/// The scale of a column stays until the column is far larger: a new one restarts the method.
void MotionDerivatives::scaleColumns() {
  constexpr double farLarger = 64;
  std::vector<VariedMotion::Column>& columns = general_->motion.columns();
  for (std::size_t k = 0; k < columns.size(); ++k) {
    double& scale = columns[k].scale;
    const double size = largest(columns_.col(static_cast<Eigen::Index>(k)));
    if (!(size > farLarger * scale)) continue;
    scale = size;
    hasChanged_ = true;
  }
}

/// The next time after t at which a held torque begins to act.
double MotionDerivatives::nextShare(double t) const {
  double next = infinity;
  for (int i = 0; commands_ && i < n_; ++i) {
    const double acts = since_ + commands_->delayOf(i);
    if (acts > t) next = std::min(next, acts);
  }
  return next;
}

void MotionDerivatives::follow(double t, const VectorXd& y, double end, const VectorXd& yEnd,
                               const MotionInSeries& series) {
  if (!fault_.empty() || end <= t) return;
  const double most = 100 * scene_.integrator.tolerance;
  if (!ColumnSteps::isAlong(series, t, y.head(2 * n_), end, yEnd.head(2 * n_), most))
    return followGenerally(t, y, end);
  if (!isEntered_) {
    if (!enterNumbers(t)) return;
    hasSeries_ = alongSeries_.enter(t, y, series);
    isEntered_ = true;
  }
  if (!hasSeries_ || !alongSeries_.follow(series, end - t, columns_)) return followGenerally(t, y, end);
  hasChanged_ = true;
}

void MotionDerivatives::followGenerally(double t, const VectorXd& y, double end) {
  if (!enterNumbers(t)) return;
  motion(t, y).enter();
  scaleColumns();
  const std::vector<VariedMotion::Column>& columns = general_->motion.columns();
  ode::State& state = general_->state;
  ode::Integrator& steps = *general_->steps;
  state.t = t;
  state.carry.setZero();
  state.y.head(2 * n_) = y.head(2 * n_);
  const auto part = [&](std::size_t k) {
    return state.y.segment(2 * n_ * static_cast<Eigen::Index>(1 + k), 2 * n_);
  };
  for (std::size_t k = 0; k < columns.size(); ++k)
    part(k) = columns_.col(static_cast<Eigen::Index>(k)) / columns[k].scale;
  while (state.t < end) {
    hasChanged_ ? steps.passEvent() : steps.forgetSlope();
    hasChanged_ = false;
    pieceBegan_ = state.t;
    const double next = nextShare(state.t);
    const ode::Outcome outcome = steps.integrate(state, std::min(end, next), effects_.longestStep());
    if (ode::hasFailed(outcome) || !state.y.allFinite())
      return fail(state.t, "they leave the finite numbers, or change too fast");
    hasChanged_ = next <= end;
  }
  for (std::size_t k = 0; k < columns.size(); ++k)
    columns_.col(static_cast<Eigen::Index>(k)) = columns[k].scale * part(k);
}

// ---- A switch ----------------------------------------------------------------------------------------

/// ∇g·along + ∂g/∂t ofTime
double MotionDerivatives::slopeOf(const EventPlace& event, double t, const VectorXd& y, const double* along,
                                  double ofTime) const {
  const Eigen::Map<const VectorXd> direction(along, 2 * n_);
  const double size = std::max(largest(direction), ofTime);
  if (size == 0) return 0;
  constexpr double reach = 1e-4;  // g is linear mostly; rounding is 1e-12
  VectorXd moved = y;
  return differenceOf(
      [&](double h) {
        moved.head(2 * n_) = y.head(2 * n_) + h * direction;
        return event.valueIn(effects_, t + h * ofTime, moved.data());
      },
      size, reach);
}

void MotionDerivatives::meet(double t, const VectorXd& y, const ode::LocatedEvent& located) {
  if (!fault_.empty()) return;
  const EventPlace event(effects_, located, t, y.data());
  VariedMotion& motion = this->motion(t, y);
  const std::vector<VariedMotion::Column>& columns = motion.columns();
  const Evaluation& at = motion.at(t, y.data());
  slopes_ = VectorXd(2 * n_);
  slopes_ << y.segment(n_, n_), Eigen::Map<const VectorXd>(at.slopes(), n_);
  const Couplings& couplings = motion.couplings(t);
  wereHeld_.assign(index(n_), false);
  for (int i = 0; i < n_; ++i) wereHeld_[index(i)] = couplings.joints[index(i)].isPrescribed;
  eventSlope_ = slopeOf(event, t, y, slopes_.data(), 1);
  delays_ = VectorXd::Zero(columns_.cols());
  for (Eigen::Index k = 0; k < columns_.cols(); ++k) {
    double due = slopeOf(event, t, y, columns_.col(k).data(), 0);
    if (const VariedMotion::Column& column = columns[static_cast<std::size_t>(k)]; column.number)
      due += column.number->eventSlope(event, t, y.data());
    delays_[k] = -due / eventSlope_;
  }
  moments_ = Eigen::Map<const VectorXd>(at.moments.data(), n_);
  torqueMoments_ = MatrixXd(n_, n_ + static_cast<int>(lags_.size()));
  VectorXd source(n_);
  for (int i = 0; i < torqueMoments_.cols(); ++i) {
    const VariedMotion::Column& column = columns[index(2 * n_ + i)];
    motion.findSource(column, source.data());
    for (int j = 0; j < n_; ++j) torqueMoments_(j, i) = motion.shareOf(column, t) * motion.moment(j);
  }
}

void MotionDerivatives::pass(double t, const VectorXd& y) {
  if (!fault_.empty()) return;
  VariedMotion& motion = this->motion(t, y);
  motion.enter();
  enter();
  const Evaluation& at = motion.at(t, y.data());
  const VectorXd after = Eigen::Map<const VectorXd>(at.slopes(), n_), jump = slopes_.tail(n_) - after;
  constexpr double rounding = 1e-10;  // of accelerations, where f has but a kink
  if (largest(jump) <= rounding * std::max(largest(after), largest(slopes_.tail(n_)))) return;
  // A torque moves the time at which a joint breaks loose by itself, too.
  for (int i = 0; i < n_; ++i) {
    if (!wereHeld_[index(i)] || motion.couplings(t).joints[index(i)].isPrescribed) continue;
    delays_.segment(2 * n_, torqueMoments_.cols()) -=
        (moments_[i] > 0 ? 1 : -1) / eventSlope_ * torqueMoments_.row(i).transpose();
  }
  if (!(eventSlope_ > 0) || !delays_.allFinite()) return fail(t, "the motion only touches a switch there");
  columns_.bottomRows(n_) += jump * delays_.transpose();
}

// ---- The results -------------------------------------------------------------------------------------

void MotionDerivatives::fail(double t, const std::string& why) {
  if (fault_.empty()) fault_ = "the motion has no derivatives beyond t = " + toText(t) + " s: " + why;
}

Derivatives MotionDerivatives::derivatives(double t, const VectorXd& y) const {
  const Coordinates& coordinates = scene_.chain.coordinates();
  const Eigen::Index states = 2 * n_, lags = static_cast<Eigen::Index>(lags_.size());
  MatrixXd relative = columns_;
  for (Eigen::Index k = 0; k < relative.cols(); ++k) {
    coordinates.toRelative(relative.col(k).data(), relative.col(k).data());
    coordinates.toRelative(relative.col(k).data() + n_, relative.col(k).data() + n_);
  }
  Derivatives all{MatrixXd::Zero(states + lags, states + lags), MatrixXd::Zero(states + lags, n_),
                  relative.rightCols(static_cast<Eigen::Index>(numbers_.size())), notes_};
  all.state.topLeftCorner(states, states) = relative.leftCols(states);
  all.state.topRightCorner(states, lags) = relative.middleCols(states + n_, lags);
  all.torques.topRows(states) = relative.middleCols(states, n_);
  Eigen::Index row = states;
  for (const LinearMotor& motor :
       lags > 0 ? commands_->motorsAt(t, y.data() + n_) : std::vector<LinearMotor>()) {
    if (motor.lag == 0) continue;
    const double acting = t - since_ - commands_->delayOf(motor.joint);
    all.state(row, row) = std::exp((since_ - t) / motor.lag);
    if (!motor.isCutOff && acting > 0) all.torques(row, motor.joint) = -std::expm1(-acting / motor.lag);
    ++row;
  }
  return all;
}

}  // namespace planar_chain
