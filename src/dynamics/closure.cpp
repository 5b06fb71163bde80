#include "dynamics/closure.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/add_carried.h"
#include "dynamics/inner_end.h"

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
      recursion_(mechanism.bodies()),
      joints_(index(n_)),
      e_(index(ShortChain::roomFor(n_))),
      change_(index(n_)),
      none_(change_),
      moments_(change_) {}

double Closure::sizeAt(const Couplings& at) const {
  return reach_ + length(at.tipPlace);
}

Vec2d Closure::alongRows(const Couplings& at, Vec2d a) const {
  if (at.tip.rows == 2) return a;
  return at.tip.rows == 1 ? dot(at.tip.row[0], a) * at.tip.row[0] : Vec2d{};
}

Vec2d Closure::gap(const Couplings& at, const double* y) {
  mechanism_.rotate(y, at.angle.value, e_.data());
  Vec2d x = at.base().pin + firstPin(at, y).place;
  for (int j = mechanism_.slides(); j < n_; ++j) x += e_[index(j)] * mechanism_.chain().links()[index(j)].pin;
  return alongRows(at, at.tipPlace - x);
}

Vec2d Closure::rateGap(const Couplings& at, const double* y) {
  mechanism_.rotate(y, at.angle.value, e_.data());
  const BaseState base = at.base();
  Vec2d v = base.velocity + firstPin(at, y).velocity;
  for (int j = mechanism_.slides(); j < n_; ++j)
    v += (y[n_ + j] + base.rate) * perp(e_[index(j)] * mechanism_.chain().links()[index(j)].pin);
  return alongRows(at, at.tipVelocity - v);
}

void Closure::couple(const Couplings& at) {
  for (std::size_t j = 0; j < joints_.size(); ++j) joints_[j] = {at.joints[j].rotor, at.joints[j].isHeld, 0};
  recursion_.couple(joints_.data() + mechanism_.slides());
  inner_ = innerEndOf(mechanism_.chain(), joints_.data());
  if (at.angle.value == 0) return;
  const Rotation<double> turn = plainRotation(at.angle.value);
  for (Slide<double>& slide : inner_.slide) slide.d = turn * slide.d;
}

/// The first pin of a link that turns, from the ground pin.
RailPoint<double> Closure::firstPin(const Couplings& at, const double* y) const {
  if (mechanism_.slides() == 0) return {};
  const BaseTurn<double> base{plainRotation(at.angle.value), at.angle.rate, 0};
  return railsOf(mechanism_.chain(), base, y, y + n_).first;
}

/// The impulse on the chain at rest that moves the tip by so much, and change_, of which it is the cause.
EndsMotion<double> Closure::impulse(Tip<double> tip) {
  const int slides = mechanism_.slides();
  EndsMotion<double> motion;
  recursion_.accelerations({e_.data() + slides, none_.data(), nullptr, {}}, nullptr, none_.data(), 0, inner_,
                           tip, change_.data() + slides, moments_.data(), motion);
  std::copy_n(motion.acceleration.begin(), slides, change_.begin());
  return motion;
}

double Closure::spread(const Couplings& at, const double* y) {
  couple(at);
  mechanism_.rotate(y, at.angle.value, e_.data());
  const EndsMotion<double> one = impulse(pinnedTip(Vec2d{1, 0})), other = impulse(pinnedTip(Vec2d{0, 1}));
  const Vec2d row = at.tip.row[0];
  const auto square = [](double a) { return a * a; };
  if (one.acting.rows < 2) return one.acting.rows == at.tip.rows ? square(dot(row, one.acting.row[0])) : 0;
  // Of the inverse of the answer, in whose eigenvectors the answer to `row` is a sum of two.
  const Sym2<double> inverse{one.tipForce.x, (one.tipForce.y + other.tipForce.x) / 2, other.tipForce.y};
  const auto [value, vector] = eigen(inverse);
  const double share = std::max(value[1] / value[0], 0.0);
  if (at.tip.rows == 2) return share;
  return square(dot(row, vector[1])) + share * square(dot(row, vector[0]));
}

/// Moves the tip by so much, as far as no angle turns by more than `most`.
void Closure::move(const Couplings& at, Vec2d tip, double most, double* values, double* carry) {
  const int slides = mechanism_.slides();
  impulse({at.tip.rows, at.tip.row, tip});
  double largest = 0;
  for (int j = 0; j < n_; ++j)
    largest = std::max(largest, std::abs(change_[index(j)]) / (j < slides ? reach_ : 1));
  const double share = largest > most ? most / largest : 1;
  for (int j = 0; j < n_; ++j) addCarried(share * change_[index(j)], values[j], carry ? carry + j : nullptr);
}

/// An angle of many turns has a rounding of its own, which no change of it can take away.
double Closure::leastGap(const double* y) const {
  double largest = 0;
  for (int j = mechanism_.slides(); j < n_; ++j) largest = std::max(largest, std::abs(y[j]));
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
  return isClosed;
}

}  // namespace planar_chain
