#pragma once

/// Arrays that begin where a cache line does, so that no SIMD register is loaded from two lines.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace planar_chain {

template <class Number>
class AlignedArray {
 public:
  explicit AlignedArray(std::size_t size = 0) : storage_(size + line / sizeof(Number)) {
    const auto address = reinterpret_cast<std::uintptr_t>(storage_.data());
    first_ = (line - address % line) % line / sizeof(Number);
  }
  AlignedArray(const AlignedArray&) = delete;
  AlignedArray& operator=(const AlignedArray&) = delete;
  AlignedArray(AlignedArray&&) = default;
  AlignedArray& operator=(AlignedArray&&) = default;

  Number* data() { return storage_.data() + first_; }
  const Number* data() const { return storage_.data() + first_; }

 private:
  static constexpr std::size_t line = 64;  // bytes, some Numbers long; the heap's addresses are too
  static_assert(line % sizeof(Number) == 0 && alignof(std::max_align_t) % sizeof(Number) == 0);
  std::vector<Number> storage_;
  std::size_t first_;
};

using CacheLines = AlignedArray<double>;

/// Rows of `size` doubles. They lie an odd number of cache lines apart, so that they do not compete for the
/// same places of a cache.
class CacheRows {
 public:
  CacheRows(std::size_t rows, std::size_t size) : apart_(((size + 7) / 8 | 1) * 8), lines_(rows * apart_) {}
  double* row(std::size_t i) { return lines_.data() + i * apart_; }

 private:
  std::size_t apart_;
  CacheLines lines_;
};

}  // namespace planar_chain
