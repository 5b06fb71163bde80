#pragma once

/// What callgrind counts: see callgrind.py.

#include <functional>

/// Calls it so many times. In a file of its own, so that no compiler makes another function of it.
extern "C" void counted(const std::function<void()>& operation, int times);
