#include "effects/complementarity.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace planar_chain {

namespace {

/// Rounds in a row that may bring nothing before fronts get wider: so many, in short chains fewer.
constexpr int mostVain = 20;
/// Wrong joints this near to each other are of one front: A falls off by about 4 from joint to joint. The
/// distance doubles each time.
constexpr int nearest = 3;
/// A joint that starts with a smaller share than this of the least q̈ that counts is held. A joint beside
/// others that slip starts with more than a tenth where its band ends.
constexpr double slow = 1. / 16;
constexpr double mostWidened = 256;  ///< a band, at once

bool isWrong(const RestingJoint& joint) {
  return joint.direction == 0 ? joint.excess > 0 && !joint.mustStick : joint.wrong > 0;
}
bool startsWrong(const RestingJoint& joint) {
  return joint.direction != 0 && joint.wrong > 0;
}

class Pivoting {
 public:
  Pivoting(RestingChain& chain, std::vector<RestingJoint>& joints, bool oneByOne)
      : chain_(chain), joints_(joints), oneByOne_(oneByOne) {}

  int run() {
    const int size = static_cast<int>(joints_.size()), most = 2 * size + 100;
    const int patience = std::min(mostVain, size + 4);
    int fewest = std::numeric_limits<int>::max(), vain = 0;
    while (rounds_ < most) {
      const int wrong = solve();
      if (wrong == 0) {
        if (!holdSlow()) return rounds_;
        continue;
      }
      vain = wrong < fewest ? 0 : vain + 1;
      fewest = std::min(fewest, wrong);
      flipped_ = 0;
      const int wider = std::min(vain / patience, 16), apart = nearest << wider;
      if (wider > 0 && (oneByOne_ || apart >= size)) {
        flipFirst();
      } else if (oneByOne_) {
        flipOfAll();
      } else {
        flipOfFronts(apart);
      }
    }
    giveUp();
    return rounds_;
  }

 private:
  /// Returns how many are wrong.
  int solve() {
    chain_.solve(joints_);
    ++rounds_;
    // Changed alone, and wrong the same way again: by rounding. One that came from + may still start in −.
    if (flipped_ == 1 && isWrong(*last_) && (last_->direction != 0 || last_->release == before_)) {
      last_->mustStick = true;
      if (last_->direction != 0) {
        last_->direction = 0;
        chain_.solve(joints_);
        ++rounds_;
      }
    }
    return static_cast<int>(std::count_if(joints_.begin(), joints_.end(), isWrong));
  }

  /// Holds those that hardly start. Returns false if there are none.
  bool holdSlow() {
    bool any = false;
    for (RestingJoint& joint : joints_) {
      if (joint.direction == 0 || joint.start >= slow) continue;
      joint.direction = 0;
      joint.widening = 1 / std::max(joint.start, 1 / mostWidened);
      joint.mustStick = any = true;
    }
    flipped_ = 0;
    return any;
  }

  void flip(RestingJoint& joint) {
    before_ = joint.direction;
    joint.direction = joint.direction == 0 ? joint.release : 0;
    last_ = &joint;
    ++flipped_;
  }

  /// The first one alone, by Murty's scheme: several at once may go round in circles.
  void flipFirst() { flip(*std::find_if(joints_.begin(), joints_.end(), isWrong)); }

  /// Changes all joints that start in the wrong direction, and the most loaded of those that break loose.
  void flipOfAll() {
    RestingJoint* first = nullptr;
    for (RestingJoint& joint : joints_) {
      if (!isWrong(joint)) continue;
      if (joint.direction != 0) {
        flip(joint);
      } else if (!first || joint.load > first->load) {
        first = &joint;
      }
    }
    if (first) flip(*first);
  }

  /// Changes the leading wrong joint of each front.
  void flipOfFronts(int apart) {
    for (RestingJoint& joint : joints_) joint.flips = isWrong(joint) && leadsItsFront(joint, apart);
    for (RestingJoint& joint : joints_) {
      if (joint.flips) flip(joint);
    }
  }

  bool leadsItsFront(const RestingJoint& joint, int apart) const {
    if (joint.direction != 0) return true;
    const auto leads = [&](const RestingJoint& other) {
      return isWrong(other) && (startsWrong(other) || other.load > joint.load ||
                                (other.load == joint.load && other.joint < joint.joint));
    };
    const RestingJoint *begin = joints_.data(), *end = begin + joints_.size();
    for (const RestingJoint* other = &joint; other-- > begin && joint.joint - other->joint <= apart;) {
      if (leads(*other)) return false;
    }
    for (const RestingJoint* other = &joint; ++other < end && other->joint - joint.joint <= apart;) {
      if (leads(*other)) return false;
    }
    return true;
  }

  /// Lets joints that start in the wrong direction stick, until there are none.
  void giveUp() {
    for (flipped_ = 1; flipped_ > 0;) {
      chain_.solve(joints_);
      ++rounds_;
      flipped_ = 0;
      for (RestingJoint& joint : joints_) {
        if (startsWrong(joint)) flip(joint);
      }
    }
  }

  RestingChain& chain_;
  std::vector<RestingJoint>& joints_;
  const bool oneByOne_;
  int rounds_ = 0, flipped_ = 0;
  RestingJoint* last_ = nullptr;  ///< that was changed
  double before_ = 0;             ///< its direction until then
};

}  // namespace

int findWhatSticks(RestingChain& chain, std::vector<RestingJoint>& joints, bool oneByOne) {
  return Pivoting(chain, joints, oneByOne).run();
}

}  // namespace planar_chain
