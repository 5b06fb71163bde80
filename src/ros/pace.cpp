#include "planar_chain/ros/pace.h"

#include <cmath>

namespace planar_chain {

std::int64_t Pace::nanosecondsOf(long long tick) const {
  return std::llround(static_cast<long double>(tick) * 1e9L / static_cast<long double>(rate_));
}

long long Pace::due(double now) const {
  return static_cast<long long>(std::floor((now - givenUp_) * rate_));
}

double Pace::giveUp(double now, long long next, double patience) {
  const double behind = now - givenUp_ - timeOf(next);
  if (behind <= patience) return 0;
  givenUp_ += behind;
  return behind;
}

bool Pace::falls(long long tick, double frequency) const {
  // A millionth of a period forgives the rounding of the quotient.
  const auto happened = [&](long long k) {
    return std::floor(static_cast<double>(k) * frequency / rate_ + 1e-6);
  };
  return tick == 0 || happened(tick) > happened(tick - 1);
}

double RealTimeFactor::sample(double simTime, double wallTime) {
  const Sample oldest = ring_[taken_ < ring_.size() ? 0 : taken_ % ring_.size()];
  const bool first = taken_ == 0;
  ring_[taken_++ % ring_.size()] = {simTime, wallTime};
  return first || wallTime <= oldest.wall ? 0 : (simTime - oldest.sim) / (wallTime - oldest.wall);
}

}  // namespace planar_chain
