#pragma once

/// The chain: rigid bodies in the plane, connected by pins and numbered from the ground outwards.
///
/// The inner pin of body i is the outer pin of body i−1. The inner pin of body 1 is fixed at the origin of
/// the base frame. Letters of the notes: r^i = com, p^i = pin, m_i = mass, I_i = inertia; k_i, d_i, q0_i of
/// the joint at the inner pin.
///
/// The first link, or the first two, may slide instead: a carriage on a rail, or a table that moves in x and
/// y. A slide does not turn. Its q is a position s in m along the rail.

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

struct Link {
  std::string name;
  double mass = 0;     ///< m, kg, > 0; of a slide ≥ 0
  double inertia = 0;  ///< I, kg m² about the centre of mass, ≥ 0 (0: a point mass)
  Vec2d com;           ///< r, m, link frame, from the inner pin; of a slide base axes, from its own point
  Vec2d pin;           ///< p, m, likewise, to the outer pin

  /// Values of effects, with their keys in the scene.
  NamedNumbers others{};
};

/// The joint at a link's inner pin. Its torque on the link is −stiffness (q − restAngle) − damping q̇. The
/// opposite torque acts on the previous link, or on the ground.
///
/// A joint that slides has the same values in N, N/m, N s/m, m, and m/s: forces along the rail.
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

  bool slides = false;  ///< along the rail
  Vec2d axis{1, 0};     ///< direction of the rail, base axes, not 0. In a Chain its length is 1

  bool isLimited() const { return std::isfinite(lower) || std::isfinite(upper); }
  /// True if `others` has this key.
  bool has(std::string_view key) const { return others.has(key); }
  /// Returns the value of this key in `others`, or 0.
  double other(std::string_view key) const { return others.of(key); }
};

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

/// The coordinates of a chain, one per joint. q_i is relative. States contain x_i = (s_1 …, θ …) instead,
/// with absolute angles. The first angle and positions are measured from the base.
///
///     q_i = x_i − x_{i−1}, or x_i of slides and of the first body that turns            likewise rates
class Coordinates {
 public:
  /// n joints, of which the first `slides` slide.
  Coordinates(int n, int slides) : n_(n), slides_(slides) {}

  int size() const { return n_; }
  int slides() const { return slides_; }
  /// True if coordinate i is a position, false if it is an angle.
  bool slides(int i) const { return i < slides_; }
  /// True if q_i = x_i − x_{i−1}.
  bool isDifference(int i) const { return i > slides_; }

  /// Returns q_i from x, and likewise rates and accelerations.
  double relative(const double* x, int i) const { return isDifference(i) ? x[i] - x[i - 1] : x[i]; }
  /// Writes all q_i from x. Both may be the same array.
  void toRelative(const double* x, double* q) const {
    for (int i = n_ - 1; i >= 0; --i) q[i] = relative(x, i);
  }
  /// Writes x from all q_i. Both may be the same array.
  void toAbsolute(const double* q, double* x) const {
    for (int i = 0; i < n_; ++i) x[i] = isDifference(i) ? x[i - 1] + q[i] : q[i];
  }
  /// Adds a torque or force in joint i: τ to body i, and −τ to the body before, if it turns.
  void addTorque(double tau, int i, double* N) const {
    N[i] += tau;
    if (isDifference(i)) N[i - 1] -= tau;
  }
  /// The unit of q_i: "m" or "rad".
  const char* unit(int i) const { return slides(i) ? "m" : "rad"; }
  const char* rateUnit(int i) const { return slides(i) ? "m/s" : "rad/s"; }

 private:
  int n_, slides_;
};

/// Computes one q_i from x.
struct Coordinate {
  int joint;
  bool isDifference;

  Coordinate(const Coordinates& all, int i) : joint(i), isDifference(all.isDifference(i)) {}
  double operator()(const double* x) const { return isDifference ? x[joint] - x[joint - 1] : x[joint]; }
};

/// Returns the faults in the values of one link or joint. Paths are keys of the scene below the link, such as
/// "mass" or "joint/damping". slides: true for a link that slides.
std::vector<Fault> faultsOf(const Link& link, bool slides = false);
std::vector<Fault> faultsOf(const Joint& joint);

/// A chain whose values have been checked. Immutable. Copies share the values.
class Chain {
 public:
  /// joints[i] is at the inner pin of links[i]. gravity: m/s², base frame.
  /// @throws Refused with every fault: no links; sizes that differ; names that are empty or not unique;
  /// values out of range or not finite; a slide behind a body that turns, three slides, parallel rails or
  /// slides alone; and, at the path `links/<name>`, a mass matrix that is singular in some configuration.
  ///
  /// The test for a singular matrix is exact. The matrix is singular if some motion has no kinetic energy
  /// T = ½ Σ m|v|² + I ω². In such a motion the first body that turns has I = 0 and r = 0. Each body further
  /// out stands still, or has I = 0 and turns about its centre of mass, which stays.
  Chain(std::vector<Link> links, std::vector<Joint> joints, Vec2d gravity);

  int size() const { return static_cast<int>(links().size()); }  ///< n
  int slides() const { return values_->slides; }                 ///< the number of slides: 0, 1 or 2
  Coordinates coordinates() const { return {size(), slides()}; }
  /// Returns the largest distance that a pin or centre of mass can have from the first pin of a link that
  /// turns, m; 1 if that is 0.
  double reach() const;
  /// Returns the links that turn, as a chain on a fixed pin.
  Chain withoutSlides() const;
  const std::vector<Link>& links() const { return values_->links; }
  const std::vector<Joint>& joints() const { return values_->joints; }
  Vec2d gravity() const { return values_->gravity; }

 private:
  struct Values {
    std::vector<Link> links;
    std::vector<Joint> joints;
    Vec2d gravity;
    int slides = 0;
    std::shared_ptr<const Values> turning{};  ///< of the links that turn; nullptr: all do
  };
  explicit Chain(std::shared_ptr<const Values> values) : values_(std::move(values)) {}

  std::shared_ptr<const Values> values_;
};

}  // namespace planar_chain
