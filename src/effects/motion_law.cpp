#include "planar_chain/motion_law.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lanes/segments.h"
#include "planar_chain/planar.h"

namespace planar_chain {

MotionLaw MotionLaw::sine(double amplitude, double frequency, double phase, double offset) {
  MotionLaw law;
  law.amplitude_ = amplitude;
  law.frequency_ = frequency;
  law.pulsation_ = 2 * pi * frequency;
  law.phase_ = phase;
  law.pieces_.front().c[0] = offset;
  return law;
}

MotionLaw MotionLaw::spline(const std::vector<double>& times, const std::vector<double>& values) {
  // Rates s_i at the knots: continuous accelerations are a tridiagonal system, solved by Thomas' sweep,
  //
  //     s_{i−1}/h_{i−1} + 2 (1/h_{i−1} + 1/h_i) s_i + s_{i+1}/h_i = 3 (m_{i−1}/h_{i−1} + m_i/h_i)
  //
  // with h the lengths of the pieces, m their slopes, and s = 0 at both ends.
  const std::size_t last = times.size() - 1;
  const auto length = [&](std::size_t i) { return times[i + 1] - times[i]; };
  const auto slope = [&](std::size_t i) { return (values[i + 1] - values[i]) / length(i); };
  std::vector<double> rate(times.size(), 0.0), upper(times.size(), 0.0);
  for (std::size_t i = 1; i < last; ++i) {
    const double before = 1 / length(i - 1), after = 1 / length(i);
    const double pivot = 2 * (before + after) - before * upper[i - 1];
    upper[i] = after / pivot;
    rate[i] = (3 * (slope(i - 1) * before + slope(i) * after) - before * rate[i - 1]) / pivot;
  }
  for (std::size_t i = last; i-- > 1;) rate[i] -= upper[i] * rate[i + 1];

  // Hermite's cubic in each piece.
  std::vector<Piece> pieces{{-std::numeric_limits<double>::infinity(), {values.front()}}};
  for (std::size_t i = 0; i < last; ++i) {
    const double h = length(i), m = slope(i);
    pieces.push_back({times[i],
                      {values[i], rate[i], (3 * m - 2 * rate[i] - rate[i + 1]) / h,
                       (rate[i] + rate[i + 1] - 2 * m) / (h * h)}});
  }
  pieces.push_back({times.back(), {values.back()}});
  return MotionLaw(std::move(pieces));
}

namespace {

constexpr double longestBlend = 0.02;  // s

// Hermite's polynomials: from one motion to another in the time h. With u = s/h, and D, E, F what value and
// derivatives lack at u = 1 without the highest powers,
//
//     cubic      (3 D − E) u² + (E − 2 D) u³
//     quintic    (10 D − 4 E + F/2) u³ + (7 E − 15 D − F) u⁴ + (6 D − 3 E + F/2) u⁵

MotionLaw::Piece cubic(double start, double h, const GivenMotion& from, const GivenMotion& to) {
  const double D = to.value - from.value - from.rate * h, E = (to.rate - from.rate) * h;
  return {start, {from.value, from.rate, (3 * D - E) / (h * h), (E - 2 * D) / (h * h * h)}};
}

MotionLaw::Piece quintic(double start, double h, const GivenMotion& from, const GivenMotion& to) {
  const double c2 = from.acceleration / 2, hhh = h * h * h;
  const double D = to.value - from.value - (from.rate + c2 * h) * h;
  const double E = (to.rate - from.rate - from.acceleration * h) * h;
  const double F = (to.acceleration - from.acceleration) * h * h;
  return {start,
          {from.value, from.rate, c2, (10 * D - 4 * E + F / 2) / hhh, (7 * E - 15 * D - F) / (hhh * h),
           (6 * D - 3 * E + F / 2) / (hhh * h * h)}};
}

}  // namespace

MotionLaw MotionLaw::then(double now, double start, const std::vector<MotionPoint>& points) const {
  // The rest of this law.
  MotionLaw law;
  std::vector<Piece>& pieces = law.pieces_;
  pieces.clear();
  if (start > now) {
    law = *this;
    pieces.erase(pieces.begin() + pieceAt(start) + 1, pieces.end());
    pieces.erase(pieces.begin(), pieces.begin() + pieceAt(now));
    law.swinging_ = std::clamp(swinging_ - pieceAt(now), 0, static_cast<int>(pieces.size()));
  }

  if (law.swinging_ == 0) law.amplitude_ = 0;

  GivenMotion from = at(start);
  bool hasRate = true, hasAcceleration = true;
  double t = start;
  for (const MotionPoint& point : points) {
    const double h = point.time - t, slope = (point.value - from.value) / h;
    const bool isLast = &point == &points.back();
    GivenMotion to{point.value, point.rate.value_or(isLast ? 0 : slope), point.acceleration.value_or(0)};
    if (!hasRate || !point.rate) {
      const double blend = std::min(longestBlend, h / 4);
      const GivenMotion begin{from.value + slope * blend, slope, 0};
      const GivenMotion end{to.value - slope * blend, slope, 0};
      pieces.push_back(quintic(t, blend, from, begin));
      pieces.push_back({t + blend, {begin.value, slope}});
      if (to.rate != slope) pieces.push_back(quintic(point.time - blend, blend, end, to));
    } else if (hasAcceleration && point.acceleration) {
      pieces.push_back(quintic(t, h, from, to));
    } else {
      pieces.push_back(cubic(t, h, from, to));
    }
    hasRate = point.rate.has_value();
    hasAcceleration = point.acceleration.has_value();
    from = to;
    t = point.time;
  }
  pieces.push_back({t, {from.value}});
  return law;
}

MotionLaw MotionLaw::to(double now, double end, double value, double rate) const {
  const double after = std::nextafter(end, std::numeric_limits<double>::infinity());
  return MotionLaw({cubic(now, end - now, at(now), {value, rate, 0}), {after, {value, rate}}});
}

int MotionLaw::pieceAt(double t) const {
  const auto startsLater = [](double time, const Piece& piece) { return time < piece.start; };
  const auto after = std::upper_bound(pieces_.begin() + 1, pieces_.end(), t, startsLater);
  return static_cast<int>(after - pieces_.begin()) - 1;
}

double MotionLaw::until(int piece) const {
  const auto next = static_cast<std::size_t>(piece) + 1;
  return next < pieces_.size() ? pieces_[next].start : std::numeric_limits<double>::infinity();
}

GivenMotion MotionLaw::at(double t, int number) const {
  const Piece& piece = pieces_[static_cast<std::size_t>(number)];
  GivenMotion x{piece.c[0], 0, 0};
  if (std::any_of(piece.c.begin() + 1, piece.c.end(), [](double c) { return c != 0; })) {
    const double s = t - piece.start;
    x = {};
    for (int k = 5; k >= 0; --k) {  // Horner's rule for all three; the acceleration lacks its factorial
      x.acceleration = x.acceleration * s + x.rate;
      x.rate = x.rate * s + x.value;
      x.value = x.value * s + piece.c[static_cast<std::size_t>(k)];
    }
    x.acceleration *= 2;
  }
  if (amplitude_ == 0 || number >= swinging_) return x;
  const double w = pulsation_;
  const Rotation<double> turn = plainRotation(w * t + phase_);
  const double sine = amplitude_ * turn.s, cosine = amplitude_ * turn.c;
  return {x.value + sine, x.rate + w * cosine, x.acceleration - w * w * sine};
}

GivenMotion MotionLaw::order(int k, double t, int number) const {
  const Piece& piece = pieces_[static_cast<std::size_t>(number)];
  const Rotation<double> turn = plainRotation(pulsation_ * t + phase_);
  const double derivatives[]{turn.s, turn.c, -turn.s, -turn.c};  // of the sine
  const auto coefficient = [&](int order) {
    double x = 0, binomial = 1, power = 1;
    for (int j = order; j <= 5; ++j) {
      const double c = piece.c[static_cast<std::size_t>(j)];
      if (c != 0) x += binomial * power * c;  // a piece that stands may start at −∞
      binomial *= (j + 1.0) / (j + 1 - order);
      power *= t - piece.start;
    }
    if (amplitude_ == 0 || number >= swinging_) return x;
    double factor = amplitude_;
    for (int j = 1; j <= order; ++j) factor *= pulsation_ / j;
    return x + factor * derivatives[order % 4];
  };
  return {coefficient(k), (k + 1) * coefficient(k + 1), (k + 1) * (k + 2) * coefficient(k + 2)};
}

double MotionLaw::longestStep() const {
  return amplitude_ != 0 && pulsation_ != 0 ? pi / (2 * std::abs(pulsation_))
                                            : std::numeric_limits<double>::infinity();
}

bool MotionLaw::isModerate() const {
  // m, rad: the rounding of larger positions is above 1e-7. Per s, per s²: squares and their sums stay far
  // below overflow. moderate() has the words.
  constexpr double farthest = 1e9, fastest = 1e15;
  const auto holds = [&](double value, double rate, double acceleration) {
    return std::abs(value) <= farthest && std::abs(rate) <= fastest && std::abs(acceleration) <= fastest;
  };
  bool isIt = holds(std::abs(amplitude_) + std::abs(pieces_[0].c[0]), amplitude_ * pulsation_,
                    amplitude_ * pulsation_ * pulsation_);
  for (std::size_t k = 0; k < pieces_.size(); ++k) {  // elsewhere a piece is not much faster
    if (std::isinf(pieces_[k].start)) continue;       // it stands
    const double start = pieces_[k].start, end = k + 1 < pieces_.size() ? pieces_[k + 1].start : start;
    for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      const GivenMotion motion = at(start + share * (end - start), static_cast<int>(k));
      isIt &= holds(motion.value, motion.rate, motion.acceleration);
    }
  }
  return isIt;
}

std::string MotionLaw::moderate(const std::string& unit) {
  return "values up to 1e9 " + unit + ", rates up to 1e15 " + unit + "/s, accelerations up to 1e15 " + unit +
         "/s²";
}

bool MotionLaw::moves() const {
  const auto stands = [](const Piece& piece) {
    return std::all_of(piece.c.begin() + 1, piece.c.end(), [](double c) { return c == 0; });
  };
  return (amplitude_ != 0 && pulsation_ != 0) || !(pieces_.size() == 1 && stands(pieces_.front()));
}

}  // namespace planar_chain
