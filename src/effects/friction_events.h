#pragma once

/// The event functions of dry friction: a slipping joint comes to rest, a loose one slips, a stuck one breaks
/// loose.

#include <algorithm>

#include "effects/effect.h"
#include "effects/stick_slip.h"

namespace planar_chain {

/// One function of each joint of the chain: how far a slipping one is past its rest, and how far a loose one
/// has come to slip, rad/s.
class SlipEvents final : public ode::EventFunctions {
 public:
  SlipEvents(const StickSlip& joints, int n) : joints_(joints), n_(n) {}

  int most() const override { return n_; }
  void values(double /*t*/, const double* y, double* g) const override {
    joints_.findSlipPastRest(y + n_, g);
    for (const int i : joints_.loose()) g[i] = joints_.looseDue(i, y + n_);
  }
  void noise(double /*t*/, const double* y, double* of) const override {
    constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
    for (int i = 0; i < n_; ++i) of[i] = rounding * joints_.sumOfSizes(i, y + n_);
    for (const int i : joints_.loose()) of[i] = joints_.looseRate(i);
  }
  bool haveSlopes() const override { return true; }
  void slopes(double /*t*/, const double* y, const double* accelerations, double* slope) const override {
    joints_.findSlipSlope(accelerations, slope);
    for (const int i : joints_.loose()) slope[i] = joints_.looseSlope(i, y + n_, accelerations);
  }

 private:
  const StickSlip& joints_;
  int n_;
};

/// Two functions of each stuck joint, N m: how far its moment exceeds its limit on either side. They evaluate
/// the chain.
class StuckEvents final : public ode::EventFunctions {
 public:
  explicit StuckEvents(const StickSlip& joints) : joints_(joints) {}
  void attach(Mechanics& mechanics) { mechanics_ = &mechanics; }

  int most() const override { return 2 * static_cast<int>(joints_.joints().size()); }
  int count() const override { return 2 * static_cast<int>(joints_.stuck().size()); }
  void values(double t, const double* y, double* g) const override {
    const double* moments = mechanics_->answer(t, y).moments;
    for (const int i : joints_.stuck()) {
      *g++ = moments[i] - joints_.limit(i);
      *g++ = -moments[i] - joints_.limit(i);
    }
  }
  /// Where |μ| reaches the torque of sliding, f has a kink and does not jump: a delay δ changes a rate by δ²
  /// alone. So a share of the breakaway torque far above rounding is enough, or half of the band.
  void noise(double /*t*/, const double* /*y*/, double* of) const override {
    constexpr double ofJump = 1e-11, ofKink = 1e-8;
    for (const int i : joints_.stuck()) {
      const double most = joints_.breakaway(i), band = joints_.limit(i) - most;
      of = std::fill_n(of, 2, joints_.hasBreakaway() ? ofJump * most : std::max(ofKink * most, band / 2));
    }
  }

 private:
  const StickSlip& joints_;
  Mechanics* mechanics_ = nullptr;
};

}  // namespace planar_chain
