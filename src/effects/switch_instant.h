#pragma once

/// The search for the instant at which a joint with friction sticks, turns or breaks loose, in a stretch of a
/// step (ode/switches.h).
///
/// It is found as exactly as time and the rounding of rates and moments allow.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "effects/effect.h"
#include "effects/first_due.h"
#include "effects/passing.h"
#include "effects/stick_slip.h"

namespace planar_chain {

/// Only the constructor allocates.
class SwitchInstant {
 public:
  explicit SwitchInstant(const StickSlip& joints, int n) : joints_(joints), n_(n) {
    for (Seen& seen : seen_) {
      seen.y = Numbers(2 * n);
      seen.moments = seen.dues = Numbers(n);
    }
    for (Numbers& slope : slopes_) slope = Numbers(n);
    due_.reserve(joints.joints().size());
    forget();
  }
  void attach(Mechanics& mechanics) { mechanics_ = &mechanics; }
  /// Call it when the joints or what acts on them has changed: forgets what is known of states.
  void forget() {
    for (Seen& seen : seen_) seen.t = std::numeric_limits<double>::quiet_NaN();
  }

  // As ode::Switches.
  double due(double t, const double* y) const { return duesAt(t, y).maxCoeff(); }
  double nearest(const ode::Stretch& of) const {
    const double middle = of.t + of.h / 2;
    const Eigen::VectorXd& between = of.course->at(middle);
    double first = slidesPassing(of, duesAt(of.t, of.y.data()), duesAt(middle, between.data()),
                                 duesAt(of.t + of.h, of.next.data()));
    if (!joints_.stuck().empty()) {
      const auto [begin, half, end] = momentsAlong(of);
      for (const int i : joints_.stuck()) {
        for (const double sign : {-1.0, 1.0}) {
          const auto over = [&](const double* mu) { return sign * mu[i] - joints_.limit(i); };
          first = std::min(first, passing(over(begin), over(half), over(end)));
        }
      }
    }
    return first < 1 ? first * of.h : -1;
  }
  /// True if a stuck joint comes nearer to its limit than its moment changes in the stretch.
  bool isNear(const ode::Stretch& of) const {
    if (joints_.stuck().empty()) return false;
    const std::array<const double*, 3> at = momentsAlong(of);
    return std::any_of(joints_.stuck().begin(), joints_.stuck().end(), [&](int i) {
      const auto [least, most] = std::minmax({at[0][i], at[1][i], at[2][i]});
      return std::max(most, -least) + (most - least) > joints_.limit(i);
    });
  }
  /// The joint is its `which`.
  ode::Crossing crossing(const ode::Stretch& of) const {
    // The joint that changes first along the chord, then those that change before.
    const double last = of.t + of.h;
    const Numbers &atBegin = duesAt(of.t, of.y.data()), &atEnd = duesAt(last, of.next.data());
    int likely = 0;
    double least = std::numeric_limits<double>::infinity();
    due_.clear();
    for (const int i : joints_.joints()) {
      if (atEnd[i] <= 0) continue;
      due_.push_back(i);
      const double ratio = -atBegin[i] / atEnd[i];
      if (ratio < least) likely = i;
      least = std::min(least, ratio);
    }
    ode::Crossing first = crossingOf(likely, of, last);
    for (const int i : due_) {
      if (i != likely && dueAt(i, first.t, of) > 0) first = crossingOf(i, of, first.t);
    }
    return first;
  }

  /// The moments in the joints at a state. Valid until forget(), or for some more states.
  const double* momentsAt(double t, const double* y) const {
    Seen& seen = this->seen(t, y);
    if (!seen.hasMoments) std::copy_n(mechanics_->answer(t, y).moments, n_, seen.moments.data());
    seen.hasMoments = true;
    return seen.moments.data();
  }

 private:
  using Numbers = Eigen::ArrayXd;
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  /// The same at the begin, in the middle and at the end of a stretch.
  std::array<const double*, 3> momentsAlong(const ode::Stretch& of) const {
    const double middle = of.t + of.h / 2;
    return {momentsAt(of.t, of.y.data()), momentsAt(middle, of.course->at(middle).data()),
            momentsAt(of.t + of.h, of.next.data())};
  }
  /// How much the change of each joint is due at a state. Valid as momentsAt().
  const Numbers& duesAt(double t, const double* y) const {
    Seen& seen = this->seen(t, y);
    if (seen.hasDues) return seen.dues;
    joints_.findSlidesDue(y + n_, seen.dues);
    const double* moments = joints_.stuck().empty() ? nullptr : momentsAt(t, y);
    for (const int i : joints_.stuck()) seen.dues[i] = joints_.stickDue(i, moments);
    for (const int i : joints_.loose()) seen.dues[i] = joints_.looseDue(i, y + n_);
    seen.hasDues = true;
    return seen.dues;
  }
  /// The share of the stretch at which a sliding joint may first pass its rest; 1: nowhere. By a cubic
  /// through the rates and accelerations at the ends of each half: a joint that rests for a small part of a
  /// step, or near an end of it, is seen by these alone.
  double slidesPassing(const ode::Stretch& of, const Numbers& begin, const Numbers& half,
                       const Numbers& end) const {
    const double times[] = {of.t, of.t + of.h / 2, of.t + of.h};
    for (std::size_t k = 0; k < slopes_.size(); ++k) {
      joints_.findSlidesSlope(of.course->accelerationsAt(times[k]).data(), slopes_[k]);
      slopes_[k] *= of.h / 2;
    }
    const auto& [atBegin, atHalf, atEnd] = slopes_;
    // A cubic stays below its Bézier points.
    const auto above = (begin + atBegin / 3).max(half + atHalf.abs() / 3).max(end - atEnd / 3);
    if ((2 * above - begin.min(half).min(end)).maxCoeff() <= 0) return 1;
    double first = 1;
    for (const int i : joints_.joints()) {
      if (!joints_.slides(i)) continue;
      first = std::min(first, passing(Due{begin[i], 2 * atBegin[i]}, Due{half[i], 2 * atHalf[i]},
                                      Due{end[i], 2 * atEnd[i]}));
    }
    return first;
  }
  /// The same of one joint at t within the stretch.
  double dueAt(int joint, double t, const ode::Stretch& of) const {
    const Eigen::VectorXd& y = stateAt(t, of);
    if (joints_.isLoose(joint)) return joints_.looseDue(joint, y.data() + n_);
    return joints_.slides(joint) ? joints_.slideDue(joint, y.data() + n_)
                                 : joints_.stickDue(joint, momentsAt(t, y.data()));
  }
  /// How far above 0 due() of a joint may be where a step ends, of which it has these values at the begin, in
  /// the middle and at the end.
  /// What rounding of t, rates and moments asks for. Where |μ| reaches the torque of sliding, f bends and
  /// does not jump: a delay δ changes a rate by δ² alone, and `late` of the step's change is enough. Its
  /// bounds are shares of the breakaway torque: far above rounding, far below the torque.
  double mostBeyond(int joint, const ode::Stretch& of, double begin, double half, double end) const {
    const double ofTime = changeWithinRounding(of, begin, half, end), most = joints_.breakaway(joint);
    constexpr double ofRates = 32 * epsilon, ofMoments = 1e-11, late = 1e-5, leastLate = 1e-8,
                     mostLate = 1e-6;
    if (joints_.isLoose(joint)) return ofTime + joints_.looseRate(joint);
    if (joints_.slides(joint)) {
      return ofTime + ofRates * joints_.sumOfSizes(joint, of.next.data() + n_);
    }
    if (joints_.hasBreakaway()) return ofTime + ofMoments * most;
    return ofTime + std::max(std::clamp(late * (end - begin), leastLate * most, mostLate * most),
                             (joints_.limit(joint) - most) / 2);
  }
  /// firstDue() of a joint.
  ode::Crossing crossingOf(int joint, const ode::Stretch& of, double last) const {
    return firstDue(
        of, last, joint, [&](double t) { return dueAt(joint, t, of); },
        [&](double begin, double half, double end) { return mostBeyond(joint, of, begin, half, end); });
  }

  const StickSlip& joints_;
  int n_;
  Mechanics* mechanics_ = nullptr;

  /// What is known of some states. The one that was asked for longest ago is replaced first, so references to
  /// the last few stay valid. A cache alone: results depend on t and y, whatever was asked before.
  struct Seen {
    long long asked = 0;
    double t;
    Numbers y, moments, dues;
    bool hasMoments, hasDues;
  };
  Seen& seen(double t, const double* y) const {
    Seen* oldest = &seen_.front();
    for (Seen& seen : seen_) {
      if (seen.t == t && std::memcmp(seen.y.data(), y, sizeof(double) * index(2 * n_)) == 0) {
        seen.asked = ++asked_;
        return seen;
      }
      if (seen.asked < oldest->asked) oldest = &seen;
    }
    Seen& seen = *oldest;
    seen.asked = ++asked_;
    seen.t = t;
    std::copy_n(y, 2 * n_, seen.y.data());
    seen.hasMoments = seen.hasDues = false;
    return seen;
  }
  mutable std::array<Seen, 8> seen_;
  mutable long long asked_ = 0;
  mutable std::vector<int> due_;           ///< scratch of crossing()
  mutable std::array<Numbers, 3> slopes_;  ///< scratch of slidesPassing()
};

}  // namespace planar_chain
