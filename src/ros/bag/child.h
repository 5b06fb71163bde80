#pragma once

/// Work that may crash, in a process of its own.

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

namespace planar_chain {

/// A child process that did not end by itself: what() names the signal.
class Crash : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Returns the bytes that `work` makes in a child process. The child takes at most `memory` bytes more than
/// this process has, and what it prints is lost. `work` must not throw, and no other thread may run.
/// @throws Crash
/// @throws std::system_error if there can be no child
std::string madeByChild(const std::function<std::string()>& work, std::uintmax_t memory);

}  // namespace planar_chain
