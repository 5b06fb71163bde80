#pragma once

/// The unknowns of an equilibrium. Bodies behind driven joints turn with the body inside: they are one group.
/// Group −1 is the ground. A displacement is a group of its own; those come first. Displacements of carriages
/// are no groups if angles do not depend on them: without a held tip, and forces that depend on position.

#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain {

class BodyGroups {
 public:
  BodyGroups(const Scene& scene, bool forcesDependOnPosition)
      : coordinates_(scene.chain.coordinates()), dependOnPosition_(forcesDependOnPosition) {
    const int n = scene.chain.size();
    isDriven_.resize(index(n), false);
    for (const Drive& drive : scene.drives) isDriven_[index(drive.joint)] = true;
    groups_.assign(index(n), -1);
    for (int j = 0; j < n; ++j) {
      const bool isApart = coordinates_.turner(j) < 0 && !scene.tip && !dependOnPosition_;
      if (!coordinates_.isPrismatic(j) || isDriven(j) || isApart) continue;
      groups_[index(j)] = size();
      firsts_.push_back(j);
    }
    displacements_ = size();
    int last = -1;
    for (int j = 0; j < n; ++j) {
      if (coordinates_.isPrismatic(j)) continue;
      if (!isDriven(j)) {
        last = size();
        firsts_.push_back(j);
      }
      groups_[index(j)] = last;
    }
  }

  /// True if forces depend on position.
  bool dependOnPosition() const { return dependOnPosition_; }
  int size() const { return static_cast<int>(firsts_.size()); }
  /// The number of groups that are displacements.
  int displacements() const { return displacements_; }
  bool isDriven(int joint) const { return isDriven_[index(joint)]; }
  /// The group of coordinate j.
  int of(int j) const { return groups_[index(j)]; }
  /// The first body of a group.
  int first(int group) const { return firsts_[index(group)]; }
  /// The group with which body j turns.
  int turner(int j) const {
    const int turner = coordinates_.turner(j);
    return turner >= 0 ? groups_[index(turner)] : -1;
  }

 private:
  const Coordinates coordinates_;
  const bool dependOnPosition_;
  std::vector<bool> isDriven_;
  std::vector<int> groups_, firsts_;
  int displacements_ = 0;
};

}  // namespace planar_chain
