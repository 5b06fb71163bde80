#include "dynamics/closure.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/add_carried.h"

namespace planar_chain {

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double rounding = 4 * epsilon;  // of the size: a smaller gap is none
constexpr double longestTurn = 0.5;       // rad in one iteration

}  // namespace

Closure::Closure(const Mechanism& mechanism)
    : mechanism_(mechanism),
      n_(mechanism.size()),
      reach_(mechanism.chain().reach()),
      recursion_(mechanism.makeGeneralRecursion(false)),
      laws_(index(n_)),
      e_(index(ShortChain::roomFor(n_))),
      displaced_(index(n_)),
      omega_(index(n_)),
      change_(omega_),
      none_(omega_),
      moments_(omega_) {}

double Closure::sizeAt(const Couplings& at) const {
  return reach_ + length(at.tipPosition);
}

Vec2d Closure::alongRows(const Couplings& at, Vec2d a) const {
  if (at.tip.rows == 2) return a;
  return at.tip.rows == 1 ? dot(at.tip.row[0], a) * at.tip.row[0] : Vec2d{};
}

/// The rotations of the bodies, and prismatic joints as of a chain at rest.
void Closure::pose(const Couplings& at, const double* y) {
  const Chain& chain = mechanism_.chain();
  mechanism_.rotate(y, at.angle.value, e_.data());
  for (int j = 0; j < n_ && chain.coordinates().anyIsPrismatic(); ++j) {
    if (chain.coordinates().isPrismatic(j))
      displaced_[index(j)] = displacementOf(chain.joints()[index(j)].axis, e_[index(j)], 0.0, y[j], 0.0);
  }
}

/// Call pose() before.
PointAt<double> Closure::tip(const Couplings& at, const double* y) {
  const BaseState base = at.base();
  mechanism_.toBodies(y + n_, base.rate, omega_.data());
  return sweepOutwards(mechanism_.chain(), PointAt<double>{base.pin, base.velocity}, e_.data(), omega_.data(),
                       y, y + n_, [](int, const PointAt<double>&) {});
}

Vec2d Closure::gap(const Couplings& at, const double* y) {
  pose(at, y);
  return alongRows(at, at.tipPosition - tip(at, y).position);
}

Vec2d Closure::rateGap(const Couplings& at, const double* y) {
  pose(at, y);
  return alongRows(at, at.tipVelocity - tip(at, y).velocity);
}

void Closure::couple(const Couplings& at) {
  for (std::size_t j = 0; j < laws_.size(); ++j)
    laws_[j] = {at.joints[j].armature, at.joints[j].isPrescribed, 0};
  recursion_.take(laws_.data());
}

/// The impulse on the chain at rest that moves the tip by so much, and change_, of which it is the cause.
/// Call pose() before.
TipReaction<double> Closure::impulse(Tip<double> tip) {
  EndForces<double> ends;
  recursion_.accelerations({e_.data(), none_.data(), nullptr, {}}, nullptr, none_.data(), displaced_.data(),
                           0, tip, change_.data(), moments_.data(), ends);
  answer_ = ends.tip.answer;
  return ends.tip;
}

double Closure::spread(const Couplings& at, const double* y) {
  couple(at);
  pose(at, y);
  impulse({at.tip.rows, at.tip.row, {}});
  return lastSpread(at);
}

double Closure::lastSpread(const Couplings& at) const {
  const auto [value, vector] = eigen(answer_);
  if (!(value[0] > 0)) return 0;
  const Vec2d row = at.tip.row[0];
  const double least = at.tip.rows == 2 ? value[1] : dot(row, answer_ * row);
  return std::max(least / value[0], 0.0);
}

/// Moves the tip by so much, as far as no angle turns by more than `most`.
void Closure::move(const Couplings& at, Vec2d tip, double most, double* values, double* carry) {
  const Coordinates& coordinates = mechanism_.coordinates();
  impulse({at.tip.rows, at.tip.row, tip});
  double largest = 0;
  for (int j = 0; j < n_; ++j)
    largest = std::max(largest, std::abs(change_[index(j)]) / (coordinates.isPrismatic(j) ? reach_ : 1));
  const double share = largest > most ? most / largest : 1;
  for (int j = 0; j < n_; ++j) addCarried(share * change_[index(j)], values[j], carry ? carry + j : nullptr);
}

/// An angle of many turns has a rounding of its own, which no change of it can take away.
double Closure::leastGap(const double* y) const {
  double largest = 0;
  for (int j = 0; j < n_; ++j) {
    if (!mechanism_.coordinates().isPrismatic(j)) largest = std::max(largest, std::abs(y[j]));
  }
  return std::max(closed, rounding * largest);
}

bool Closure::close(const Couplings& at, double* y, double* carry) {
  constexpr int mostIterations = 100;
  const double size = sizeAt(at), enough = leastGap(y) * size;
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < mostIterations; ++k) {
    const Vec2d missing = gap(at, y);
    const double left = length(missing);
    if (left <= rounding * size || (left <= enough && left > before / 2)) return true;
    if (!std::isfinite(left)) return false;
    before = left;
    move(at, missing, longestTurn, y, carry);
  }
  return length(gap(at, y)) <= enough;
}

bool Closure::project(const Couplings& at, double* y, double* carry) {
  couple(at);
  answer_ = {};
  const bool isClosed = close(at, y, carry);
  // One impulse is exact, a second one takes the rounding of the first.
  constexpr double most = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 2; ++k) {
    const Vec2d missing = rateGap(at, y);
    double fastest = 0;
    for (int j = 0; j < n_; ++j) fastest = std::max(fastest, std::abs(y[n_ + j]));
    if (length(missing) <= rounding * sizeAt(at) * fastest) break;
    move(at, missing, most, y + n_, carry ? carry + n_ : nullptr);
  }
  if (answer_.xx + answer_.yy == 0) impulse({at.tip.rows, at.tip.row, {}});  // for lastSpread()
  return isClosed;
}

}  // namespace planar_chain
