#include "ros/messages/pace.h"

#include <cmath>

namespace planar_chain {

std::int64_t Pace::nanosecondsOf(long long tick) const {
  return std::llround(static_cast<long double>(tick) * 1e9L / static_cast<long double>(rate_));
}

bool Pace::falls(long long tick, double frequency) const {
  // A millionth of a period forgives the rounding of the quotient.
  const auto happened = [&](long long k) {
    return std::floor(static_cast<double>(k) * frequency / rate_ + 1e-6);
  };
  return tick == 0 || happened(tick) > happened(tick - 1);
}

bool Every::falls(double now) {
  if (now < next_) return false;
  next_ += period_;
  if (next_ <= now) next_ = now + period_;
  return true;
}

double RealTimeFactor::sample(double simTime, double wallTime) {
  const Sample oldest = ring_[taken_ < ring_.size() ? 0 : taken_ % ring_.size()];
  const bool first = taken_ == 0;
  ring_[taken_++ % ring_.size()] = {simTime, wallTime};
  return first || wallTime <= oldest.wall ? 0 : (simTime - oldest.sim) / (wallTime - oldest.wall);
}

}  // namespace planar_chain
