#pragma once

/// Arrays that begin where a cache line does, so that no SIMD register is loaded from two lines.

#include <cstddef>
#include <new>
#include <vector>

namespace planar_chain {

template <class Element>
struct OnCacheLines {
  static constexpr std::align_val_t line{64};  // bytes
  using value_type = Element;

  OnCacheLines() = default;
  template <class Other>
  OnCacheLines(const OnCacheLines<Other>&) {}

  Element* allocate(std::size_t n) {
    return static_cast<Element*>(::operator new(n * sizeof(Element), line));
  }
  void deallocate(Element* first, std::size_t) { ::operator delete(first, line); }
  bool operator==(const OnCacheLines&) const { return true; }
  bool operator!=(const OnCacheLines&) const { return false; }
};

template <class Element>
using AlignedArray = std::vector<Element, OnCacheLines<Element>>;
using CacheLines = AlignedArray<double>;

/// Rows of `size` doubles. They lie an odd number of cache lines apart, so that they do not compete for the
/// same places of a cache.
class CacheRows {
 public:
  CacheRows(std::size_t rows, std::size_t size) : apart_(((size + 7) / 8 | 1) * 8), lines_(rows * apart_) {}
  std::vector<double*> rows() {
    std::vector<double*> all;
    for (std::size_t at = 0; at < lines_.size(); at += apart_) all.push_back(lines_.data() + at);
    return all;
  }

 private:
  std::size_t apart_;
  CacheLines lines_;
};

}  // namespace planar_chain
