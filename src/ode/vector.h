#pragma once

/// A vector of Eigen's that begins where a cache line does.

#include <Eigen/Core>
#include <utility>

#include "simd/cache_lines.h"

namespace planar_chain::ode {

class Vector : public Eigen::Map<Eigen::VectorXd> {
  using Map = Eigen::Map<Eigen::VectorXd>;

 public:
  /// Zeros.
  explicit Vector(Eigen::Index size = 0) : Map(nullptr, 0), lines_(static_cast<std::size_t>(size)) {
    show(size);
  }
  template <class Derived>
  Vector(const Eigen::MatrixBase<Derived>& values) : Vector(values.size()) {
    Map::operator=(values);
  }
  Vector(const Vector& other) : Vector(static_cast<const Map&>(other)) {}
  Vector(Vector&& other) noexcept : Vector() { *this = std::move(other); }
  ~Vector() = default;

  /// Of the same size.
  using Map::operator=;
  /// Of any size; allocates where it is another.
  Vector& operator=(const Vector& other) {
    if (size() != other.size()) return *this = Vector(other);
    Map::operator=(other);
    return *this;
  }
  Vector& operator=(Vector&& other) noexcept {
    const Eigen::Index here = size(), there = other.size();
    std::swap(lines_, other.lines_);
    show(there);
    other.show(here);
    return *this;
  }

 private:
  void show(Eigen::Index size) { new (static_cast<Map*>(this)) Map(lines_.data(), size); }

  CacheLines lines_;
};

}  // namespace planar_chain::ode
