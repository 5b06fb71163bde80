#pragma once

/// The chain: rigid bodies in the plane, connected by pins and numbered from the ground outwards.
///
/// The inner pin of body i is the outer pin of body i−1. The inner pin of body 1 is fixed at the origin of
/// the base frame. Letters of the notes: r^i = com, p^i = pin, m_i = mass, I_i = inertia; k_i, d_i, q0_i of
/// the joint at the inner pin.
///
/// A joint may be prismatic instead, at any place: its link slides along an axis of the link inside, and
/// turns with that. Its q is a displacement s in m. So a carriage is a first link on the base, and a
/// telescope or a cylinder a link within the chain.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/planar.h"

namespace planar_chain {

/// Numbers by name, in the order in which they were added.
class NamedNumbers : public std::vector<std::pair<std::string, double>> {
 public:
  using vector::vector;
  bool has(std::string_view name) const {
    return std::any_of(begin(), end(), [name](const auto& entry) { return entry.first == name; });
  }
  /// Returns the number of this name, or 0.
  double of(std::string_view name) const {
    const auto entry = std::find_if(begin(), end(), [name](const auto& one) { return one.first == name; });
    return entry == end() ? 0 : entry->second;
  }
  /// Replaces the number of this name, or adds it.
  void set(const std::string& name, double value) {
    erase(std::remove_if(begin(), end(), [&](const auto& entry) { return entry.first == name; }), end());
    emplace_back(name, value);
  }
};

/// A spring and damper from a point of a link to a point of the ground; see effects/ground_springs.h.
struct GroundSpring {
  std::string name;
  Vec2d point;             ///< m, link frame
  Vec2d ground;            ///< m, base frame
  double stiffness = 0;    ///< k, N/m, ≥ 0; > 0 if it goes slack
  double damping = 0;      ///< d, N s/m, ≥ 0
  double restLength = 0;   ///< L_0, m, ≥ 0
  bool goesSlack = false;  ///< it only pulls
};

struct Link {
  std::string name;
  double mass = 0;     ///< m, kg, > 0; of a carriage (see Chain) ≥ 0
  double inertia = 0;  ///< I, kg m² about the centre of mass, ≥ 0 (0: a point mass)
  Vec2d com;           ///< r, m, link frame, from the inner pin; of a prismatic link from its own point
  Vec2d pin;           ///< p, m, likewise, to the outer pin

  /// Values of effects that have no member here, with their keys in the scene.
  NamedNumbers others{};
  std::vector<GroundSpring> springs{};
};

/// The joint at a link's inner pin. Its torque on the link is −stiffness (q − restAngle) − damping q̇. The
/// opposite torque acts on the previous link, or on the ground.
///
/// A prismatic joint has the same values in N, N/m, N s/m, m, and m/s: forces along its axis.
struct Joint {
  std::string name;
  double stiffness = 0;  ///< k, N m/rad, ≥ 0
  double damping = 0;    ///< d, N m s/rad, ≥ 0
  double restAngle = 0;  ///< q0, rad

  // The limits of q, and their stops, which push q back; see effects/stops.h.
  double lower = -std::numeric_limits<double>::infinity();  ///< rad
  double upper = std::numeric_limits<double>::infinity();   ///< rad
  double stopStiffness = 0;                                 ///< N m/rad, > 0 if there is a limit
  double stopDamping = 0;                                   ///< N m s/rad, ≥ 0

  /// Values of effects that have no member here, with their keys in the scene.
  NamedNumbers others{};

  bool isPrismatic = false;
  /// The direction of a prismatic joint, in the frame of the link inside; not 0. In a Chain its length is 1.
  Vec2d axis{1, 0};

  bool isLimited() const { return std::isfinite(lower) || std::isfinite(upper); }
  /// True if `others` has this key.
  bool has(std::string_view key) const { return others.has(key); }
  /// Returns the value of this key in `others`, or 0.
  double other(std::string_view key) const { return others.of(key); }
};

// For chains whose joints are all revolute:

/// q_i = θ_i − θ_{i−1}, and likewise for rates.
inline double relative(const double* absolute, int i) {
  return i > 0 ? absolute[i] - absolute[i - 1] : absolute[0];
}

/// q_1 … q_n from θ_1 … θ_n, and likewise for rates and accelerations. Both may be the same array.
inline void toRelative(const double* absolute, int n, double* q) {
  for (int i = n - 1; i >= 0; --i) q[i] = relative(absolute, i);
}

/// θ_i = q_1 + … + q_i, and likewise for rates and accelerations. Both may be the same array.
inline void toAbsolute(const double* relative, int n, double* absolute) {
  double sum = 0;
  for (int i = 0; i < n; ++i) absolute[i] = sum += relative[i];
}

/// The position of link or joint i in a std::vector.
constexpr std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// The coordinates of a chain, one per joint. q_i is relative. States contain x_i instead: the angle of a
/// body behind a revolute joint, from the base; the displacement of a prismatic joint.
///
///     q_i = x_i − x_k, or x_i of prismatic joints and of the first revolute one         likewise rates
///
/// x_k is the angle of the body inside of joint i: that of the last revolute joint before. Copies share the
/// numbers and allocate nothing.
class Coordinates {
 public:
  static constexpr int none = -1;

  explicit Coordinates(const std::vector<Joint>& joints);

  int size() const { return size_; }
  /// True if coordinate i is a displacement, false if it is an angle.
  bool isPrismatic(int i) const { return turner_[i] != i; }
  bool anyIsPrismatic() const { return anyIsPrismatic_; }
  /// True if a joint behind a revolute one is prismatic.
  bool anyIsInside() const { return anyIsInside_; }
  /// The number of prismatic joints before the first revolute one.
  int leading() const { return leading_; }
  /// The k of q_i = x_i − x_k, or `none`.
  int inner(int i) const { return inner_[i]; }
  /// The coordinate that is the angle of body i; `none`: that of the base.
  int turner(int i) const { return turner_[i]; }

  /// Returns q_i from x, and likewise rates and accelerations.
  double relative(const double* x, int i) const {
    const int k = inner_[index(i)];
    return k >= 0 ? x[i] - x[k] : x[i];
  }
  /// Writes all q_i from x. Both may be the same array.
  void toRelative(const double* x, double* q) const {
    for (int i = size() - 1; i >= 0; --i) q[i] = relative(x, i);
  }
  /// Writes x from all q_i. Both may be the same array.
  void toAbsolute(const double* q, double* x) const {
    for (int i = 0; i < size(); ++i) x[i] = inner(i) >= 0 ? x[inner(i)] + q[i] : q[i];
  }
  /// Adds a torque or force in joint i: τ to its coordinate, and −τ to that of the body inside.
  void addTorque(double tau, int i, double* N) const {
    N[i] += tau;
    if (inner(i) >= 0) N[inner(i)] -= tau;
  }
  /// Returns the angle of body i, or its rate, from x; `ofBase` if no joint turns it.
  double angle(const double* x, int i, double ofBase = 0) const {
    const int k = turner(i);
    return k >= 0 ? x[k] : ofBase;
  }
  /// The unit of q_i: "m" or "rad".
  const char* unit(int i) const { return isPrismatic(i) ? "m" : "rad"; }

 private:
  int size_, leading_ = 0;
  std::shared_ptr<const int[]> numbers_;  ///< both of these, one behind the other
  const int *inner_, *turner_;
  bool anyIsPrismatic_ = false, anyIsInside_ = false;
};

/// Computes one q_i from x.
struct Coordinate {
  int joint = 0, inner = Coordinates::none;  ///< inner: see Coordinates

  Coordinate() = default;
  Coordinate(const Coordinates& all, int i) : joint(i), inner(all.inner(i)) {}
  double operator()(const double* x) const { return inner >= 0 ? x[joint] - x[inner] : x[joint]; }
};

/// Returns the faults in the values of one link or joint. Paths are keys of the scene below the link, such as
/// "mass" or "joint/damping".
std::vector<Fault> faultsOf(const Link& link, bool isPrismatic = false);
std::vector<Fault> faultsOf(const Joint& joint);
/// Returns the faults in the values of effects alone.
std::vector<Fault> faultsOfEffects(const Link& link);

/// A chain whose values have been checked. Immutable. Copies share the values.
class Chain {
 public:
  /// joints[i] is at the inner pin of links[i]. gravity: m/s², base frame.
  /// @throws Refused with every fault: no links; sizes that differ; names that are empty or not unique;
  /// values out of range or not finite; and, at the path `links/<name>`, a mass matrix that is singular in
  /// some configuration.
  ///
  /// The matrix is singular if some motion has no kinetic energy T = ½ Σ m|v|² + I ω². The first body that
  /// moves in such a motion has no mass behind a prismatic joint, or I = 0 and r = 0 behind a revolute one.
  /// Only the first two links may be prismatic without mass: carriages. Then, and for I = 0 and r = 0 where
  /// no prismatic joint follows, the test is exact; where one follows, a link with I > 0 must turn with the
  /// body.
  Chain(std::vector<Link> links, std::vector<Joint> joints, Vec2d gravity);

  int size() const { return static_cast<int>(links().size()); }  ///< n
  const Coordinates& coordinates() const { return values_->coordinates; }
  /// Returns the largest distance that a pin or centre of mass can have from the first pin of a link that
  /// turns, m; 1 if that is 0. Displacements count up to their limits; without limits they do not count.
  double reach() const;
  const std::vector<Link>& links() const { return values_->links; }
  const std::vector<Joint>& joints() const { return values_->joints; }
  Vec2d gravity() const { return values_->gravity; }

 private:
  struct Values {
    std::vector<Link> links;
    std::vector<Joint> joints;
    Vec2d gravity;
    Coordinates coordinates;
  };

  std::shared_ptr<const Values> values_;
};

}  // namespace planar_chain
