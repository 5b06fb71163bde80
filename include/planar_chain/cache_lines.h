#pragma once

/// Doubles of which the first stands at the beginning of a cache line, so that no SIMD register is loaded
/// from two.

#include <cstddef>
#include <cstdint>
#include <vector>

namespace planar_chain {

class CacheLines {
 public:
  explicit CacheLines(std::size_t size = 0) : storage_(size + line / sizeof(double)) {
    const auto address = reinterpret_cast<std::uintptr_t>(storage_.data());
    first_ = (line - address % line) % line / sizeof(double);
  }
  CacheLines(const CacheLines&) = delete;
  CacheLines& operator=(const CacheLines&) = delete;
  CacheLines(CacheLines&&) = default;
  CacheLines& operator=(CacheLines&&) = default;

  double* data() { return storage_.data() + first_; }

 private:
  static constexpr std::size_t line = 64;  // bytes
  std::vector<double> storage_;
  std::size_t first_;
};

}  // namespace planar_chain
