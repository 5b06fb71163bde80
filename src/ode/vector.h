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
  explicit Vector(Eigen::Index size = 0) : Map(nullptr, 0), lines_(static_cast<std::size_t>(size)) { show(); }
  template <class Derived>
  Vector(const Eigen::MatrixBase<Derived>& values) : Vector(values.size()) {
    Map::operator=(values);
  }
  Vector(const Vector& other) : Map(nullptr, 0), lines_(other.lines_) { show(); }
  Vector(Vector&& other) noexcept : Vector() { *this = std::move(other); }
  ~Vector() = default;

  /// Of the same size.
  using Map::operator=;
  /// Of any size; allocates where it is larger.
  Vector& operator=(const Vector& other) {
    lines_ = other.lines_;
    show();
    return *this;
  }
  Vector& operator=(Vector&& other) noexcept {
    lines_.swap(other.lines_);
    show();
    other.show();
    return *this;
  }

 private:
  void show() { new (static_cast<Map*>(this)) Map(lines_.data(), static_cast<Eigen::Index>(lines_.size())); }

  CacheLines lines_;
};

}  // namespace planar_chain::ode
