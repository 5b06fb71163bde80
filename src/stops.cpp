#include "planar_chain/stops.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain {

Stops::Stops(const Chain& chain) : n_(chain.size()) {
  for (int i = 0; i < n_; ++i) {
    const Joint& joint = chain.joints()[static_cast<std::size_t>(i)];
    for (const double sign : {-1.0, 1.0}) {
      const double limit = sign > 0 ? joint.upper : joint.lower;
      if (std::isfinite(limit)) stops_.push_back({i, limit, sign, joint.stopStiffness, joint.stopDamping});
    }
  }
  active_.reserve(stops_.size());
}

bool Stops::dissipate() const {
  return std::any_of(stops_.begin(), stops_.end(), [](const Stop& stop) { return stop.d > 0; });
}

// ---- Places ----------------------------------------------------------------------------------

double Stops::Stop::due(double x, double xd) const {
  constexpr double rounding = 1e-12;  // a parted stop that is met with next to no speed must not flutter
  const double lag = d / k * xd;
  switch (place) {
    case Place::free:
      return x;
    case Place::pushing:
      return -(x + lag);
    case Place::parted:
      break;
  }
  return std::max(-x, x + lag - rounding * (std::abs(x) + std::abs(lag)));
}

Stops::Place Stops::Stop::next(double x, double xd) const {
  if (!(x > 0)) return Place::free;
  return k * x + d * xd > 0 ? Place::pushing : Place::parted;
}

void Stops::enter(const double* y) {
  for (Stop& stop : stops_) stop.place = stop.next(stop.depth(y), stop.speed(y + n_));
  listActive();
}

void Stops::change(const double* y) {
  for (Stop& stop : stops_) {
    const double x = stop.depth(y);
    const double xd = stop.speed(y + n_);
    if (stop.due(x, xd) > 0) stop.place = stop.next(x, xd);
  }
  listActive();
}

void Stops::listActive() {
  active_.clear();
  for (const Stop& stop : stops_) {
    if (stop.place != Place::free) active_.push_back(&stop);
  }
}

double Stops::due(const Eigen::VectorXd& y) const {
  double most = -std::numeric_limits<double>::infinity();
  for (const Stop& stop : stops_) {
    most = std::max(most, stop.due(stop.depth(y.data()), stop.speed(y.data() + n_)));
  }
  return most;
}

double Stops::nearest(const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const {
  // A free joint that came closer and went away again: the top of the cubic through both ends, if that is
  // near enough to the stop for the cubic's error to matter.
  constexpr double doubt = 0.1;
  double when = -1;
  double closest = -std::numeric_limits<double>::infinity();
  for (const Stop& stop : stops_) {
    const double v0 = stop.speed(y.data() + n_) * h;
    const double v1 = stop.speed(next.data() + n_) * h;
    if (stop.place != Place::free || !(v0 > 0 && v1 < 0)) continue;
    const double x0 = stop.depth(y.data());
    const double rise = stop.depth(next.data()) - x0;
    // x(s) = x0 + v0 s + b s² + c s³, 0 ≤ s ≤ 1; its top at b² − 3 v0 c under the root
    const double b = 3 * rise - 2 * v0 - v1;
    const double c = v0 + v1 - 2 * rise;
    const double root = std::sqrt(std::max(0.0, b * b - 3 * v0 * c));
    const double s = std::min(1.0, v0 / (root - b));
    const double top = x0 + s * (v0 + s * (b + s * c));
    if (s > 0 && top > -doubt * (v0 - v1) && top > closest) {
      closest = top;
      when = s * h;
    }
  }
  return when;
}

// ---- What they do ----------------------------------------------------------------------------

void Stops::addStiffness(double* k, double* d) const {
  for (const Stop* stop : active_) {
    if (stop->place != Place::pushing) continue;
    k[stop->joint] += stop->k;
    d[stop->joint] += stop->d;
  }
}

double Stops::dissipationAlong(const double* theta, const double* omega, const double* u,
                               const double* v) const {
  double change = 0;
  for (const Stop* stop : active_) {
    const double du = stop->sign * relative(u, stop->joint);
    const double dv = stop->sign * relative(v, stop->joint);
    change += stop->place == Place::pushing ? 2 * stop->d * stop->speed(omega) * dv
                                            : -stop->k * (stop->depth(theta) * dv + stop->speed(omega) * du);
  }
  return change;
}

}  // namespace planar_chain
