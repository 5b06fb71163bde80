#include "effects/complementarity.h"

#include <algorithm>
#include <limits>

namespace planar_chain {

namespace {

/// Rounds of block pivoting that may bring nothing before one joint is changed at a time: Júdice and Pires
/// use 10, for problems without a start. Fewer cost rounds in fronts, more cost them where blocks cycle.
constexpr int mostVain = 3;

bool isWrong(const RestingJoint& joint) {
  return joint.direction == 0 ? joint.excess > 0 : joint.wrong > 0;
}

void flip(RestingJoint& joint) {
  joint.direction = joint.direction == 0 ? joint.release : 0;
}

/// Of those that break loose, the one with the most load; and all that start in the wrong direction.
void flipOne(std::vector<RestingJoint>& joints) {
  RestingJoint* first = nullptr;
  for (RestingJoint& joint : joints) {
    if (!isWrong(joint)) continue;
    if (joint.direction != 0) {
      flip(joint);
    } else if (!first || joint.load > first->load) {
      first = &joint;
    }
  }
  if (first) flip(*first);
}

}  // namespace

int findWhatSticks(RestingChain& chain, std::vector<RestingJoint>& joints, bool oneByOne) {
  const int size = static_cast<int>(joints.size()), most = 2 * size + 20;
  int fewest = std::numeric_limits<int>::max(), vain = 0, round = 0;
  while (round < most) {
    chain.solve(joints);
    ++round;
    const int wrong = static_cast<int>(std::count_if(joints.begin(), joints.end(), isWrong));
    if (wrong == 0) return round;
    vain = wrong < fewest ? 0 : vain + 1;
    fewest = std::min(fewest, wrong);
    if (oneByOne) {
      flipOne(joints);
    } else if (vain <= mostVain) {
      for (RestingJoint& joint : joints) {
        if (isWrong(joint)) flip(joint);
      }
    } else {
      flip(*std::find_if(joints.rbegin(), joints.rend(), isWrong));
    }
  }

  // Rounding decides. What starts in the wrong direction sticks, until nothing does.
  for (bool changes = true; changes;) {
    chain.solve(joints);
    ++round;
    changes = false;
    for (RestingJoint& joint : joints) {
      if (joint.direction == 0 || joint.wrong <= 0) continue;
      flip(joint);
      changes = true;
    }
  }
  return round;
}

}  // namespace planar_chain
