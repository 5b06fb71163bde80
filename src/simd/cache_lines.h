#pragma once

/// Arrays that begin where a cache line does, so that no SIMD register is loaded from two lines.

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace planar_chain {

template <class Element>
struct OnCacheLines {
  static constexpr std::size_t line = 64;  // bytes
  using value_type = Element;

  OnCacheLines() = default;
  template <class Other>
  OnCacheLines(const OnCacheLines<Other>&) {}

  /// A line more than the array, and in it, before the array, where the memory begins: glibc takes several
  /// times as long for an aligned one.
  Element* allocate(std::size_t n) {
    static_assert(__STDCPP_DEFAULT_NEW_ALIGNMENT__ >= sizeof(void*) && alignof(Element) <= line);
    void* const memory = ::operator new(n * sizeof(Element) + line);
    void* const first = static_cast<char*>(memory) + line - reinterpret_cast<std::uintptr_t>(memory) % line;
    static_cast<void**>(first)[-1] = memory;
    return static_cast<Element*>(first);
  }
  void deallocate(Element* first, std::size_t) {
    ::operator delete(static_cast<void**>(static_cast<void*>(first))[-1]);
  }
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
