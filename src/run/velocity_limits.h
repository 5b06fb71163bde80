#pragma once

/// Counts how often the rate of a joint begins to exceed its `velocity_limit`. The motion does not change.

#include <cmath>
#include <vector>

#include "planar_chain/chain.h"
#include "simd/snapshot.h"

namespace planar_chain {

class VelocityLimits {
 public:
  explicit VelocityLimits(const Chain& chain) : counts_(chain.joints().size()) {
    for (int i = 0; i < chain.size(); ++i) {
      const Joint& joint = chain.joints()[index(i)];
      if (joint.has("velocity_limit")) limits_.push_back({index(i), joint.other("velocity_limit")});
    }
  }

  void update(const std::vector<double>& qd) {
    for (auto& [joint, limit, isExceeded] : limits_) {
      const bool before = isExceeded;
      isExceeded = std::abs(qd[joint]) > limit;
      counts_[joint] += isExceeded && !before;
    }
  }

  const std::vector<long long>& counts() const { return counts_; }  ///< of each joint
  void saveOrRestore(Snapshot& snapshot) { snapshot(limits_, counts_); }

 private:
  struct Limit {
    std::size_t joint;
    double rate;  ///< rad/s
    bool isExceeded = false;
  };
  std::vector<Limit> limits_;
  std::vector<long long> counts_;
};

}  // namespace planar_chain
