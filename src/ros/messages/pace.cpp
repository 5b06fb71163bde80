#include "ros/messages/pace.h"

#include <cmath>

namespace planar_chain {

std::int64_t Pace::nanosecondsOf(long long tick) const {
  return std::llround(static_cast<long double>(tick) * 1e9L / static_cast<long double>(rate_));
}

bool Pace::falls(long long tick, double frequency) const {
  // The millionth of a period covers the rounding of the quotient.
  const auto happened = [&](long long k) {
    return std::floor(static_cast<double>(k) * frequency / rate_ + 1e-6);
  };
  return tick == 0 || happened(tick) > happened(tick - 1);
}

bool Every::isDue(double now) {
  if (now < next_) return false;
  next_ += period_;
  if (next_ <= now) next_ = now + period_;
  return true;
}

double RealTimeFactor::sample(double simTime, double wallTime) {
  samples_.push_back({simTime, wallTime});
  if (samples_.size() > most_) samples_.pop_front();
  const auto [sim, wall] = samples_.front();
  return wallTime > wall ? (simTime - sim) / (wallTime - wall) : 0;
}

}  // namespace planar_chain
