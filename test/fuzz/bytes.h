#pragma once

/// An input's bytes as numbers and names.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace planar_chain {

inline void require(bool holds, int line = __builtin_LINE()) {
  if (holds) return;
  std::fprintf(stderr, "not true: line %d\n", line);
  std::abort();
}

/// Read from the front; zeros when there are no more.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : at_(data), left_(size) {}

  bool empty() const { return left_ == 0; }

  template <class Number>
  Number take() {
    Number number{};
    const std::size_t size = std::min(left_, sizeof number);
    std::memcpy(&number, at_, size);
    at_ += size;
    left_ -= size;
    return number;
  }

  /// One of these, or any letters.
  std::string name(const char* const (&known)[2]) {
    const auto which = take<std::uint8_t>();
    if (which < 2) return known[which];
    std::string letters;
    for (int k = which % 16; k > 0; --k) letters += take<char>();
    return letters;
  }

 private:
  const std::uint8_t* at_;
  std::size_t left_;
};

}  // namespace planar_chain
