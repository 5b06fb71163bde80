#pragma once

namespace planar_chain {

/// value += change, with its rounding error in `carry` (Kahan), which may be nullptr.
inline void addCarried(double change, double& value, double* carry) {
  const double whole = carry ? change + *carry : change, next = value + whole;
  if (carry) *carry = whole - (next - value);
  value = next;
}

}  // namespace planar_chain
