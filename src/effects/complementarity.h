#pragma once

/// Which of several joints at rest stick, and which way the others start: a linear complementarity problem.
///
/// By Gauss's principle the torques λ of dry friction minimise ½ λᵀ A λ + λᵀ b over |λ_i| ≤ c_i, where
/// q̈ = A λ + b are the accelerations in the joints. A = W M⁻¹ Wᵀ is positive definite. So one solution
/// exists:
///
///     sticks         q̈_i = 0     |λ_i| ≤ c_i
///     starts in +    q̈_i ≥ 0     λ_i = −c_i
///     starts in −    q̈_i ≤ 0     λ_i = +c_i
///
/// A is never formed. An oracle solves the chain for a guess of which joints stick; it returns λ of these and
/// q̈ of the others. Each round changes one wrong joint of each front at once: those that start in the wrong
/// direction, else the one with the most load, for its start relieves its neighbours. If rounds bring no
/// fewer wrong joints, fronts get wider, at last as wide as the chain. Then the first wrong joint alone is
/// changed, until there are fewer: Murty's scheme, which ends.
///
/// Changing one wrong joint alone corrects it, for A is positive definite. A joint that breaks loose starts
/// that way. A joint that stops does not start again the same way, but may start the other way. Otherwise
/// rounding decides: the joint sticks, and is changed no more. At the end, a joint that would start with far
/// less q̈ than counts sticks too.
///
/// If a breakaway torque is larger than the friction of sliding, several solutions may exist. Then all joints
/// stick at first, and only the one with the most torque for its breakaway torque is released each time, for
/// its start may let others hold.
///
/// Source: K. G. Murty, Note on a Bard-type
/// scheme for solving the complementarity problem, Opsearch 11 (1974) 123–130; P. Lötstedt, Mechanical
/// systems of rigid bodies subject to unilateral constraints, SIAM J. Appl. Math. 42 (1982) 281–296.

#include <vector>

namespace planar_chain {

/// A joint at rest: the guess, and the results of the last solve().
struct RestingJoint {
  int joint = 0;
  double direction = 0;    ///< 0: it sticks, else the sign of its q̈
  bool mustStick = false;  ///< it sticks, for rounding alone says otherwise, or it would hardly start
  double widening = 2;     ///< of a stuck joint: by how much its band gets wider than its excess
  // Results of solve():
  double excess = 0;   ///< of a stuck joint: |λ| − the torque that releases it, N m
  double load = 0;     ///< of a stuck joint: |λ| / breakaway torque
  double release = 0;  ///< of a stuck joint: the direction in which it would start
  bool flips = false;  ///< scratch
  double wrong = 0;    ///< of a joint that starts: how much q̈ is against its direction, beyond rounding
  double start = 1;    ///< of a joint that starts: q̈ in its direction over the least one that counts
};

class RestingChain {
 public:
  /// Sets the results of all joints, for their directions.
  virtual void solve(std::vector<RestingJoint>& joints) = 0;

 protected:
  ~RestingChain() = default;
};

/// Solves the problem from the directions given. Afterwards `joints` has a solution with its results. Joints
/// of which rounding decides stick with an excess above 0. Calls solve() at most 3 × size + 110 times: if
/// that is not enough, what starts in the wrong direction sticks. Returns how often. Allocates nothing.
int findWhatSticks(RestingChain& chain, std::vector<RestingJoint>& joints, bool oneByOne);

}  // namespace planar_chain
