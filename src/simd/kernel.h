#pragma once

/// What runs in SIMD lanes: sines and cosines, and the recursion of articulated.h for segments of a chain.
/// The same source is compiled once for each kind of CPU; which one runs is found out at run time, so a
/// binary built anywhere runs everywhere. Internal to the core; see segments.h for the mathematics.

#include <array>

namespace planar_chain::simd {

/// Arrays of `steps` × `lanes` numbers a quantity: lane s of step i is body s·steps + i, from the ground.
struct SegmentArrays {
  int steps;
  int bodies;           ///< n ≤ steps × lanes; those beyond are without mass and length
  const double* links;  ///< m, I, r, p: 6 quantities a step
  double* handles;      ///< U, u, 1/D, g, P, ω²: 9 quantities a step
};

/// What a segment shows at its two pins; one number a lane, `most` at most.
struct SegmentHandles {
  static constexpr int most = 8;
  double d[2][most];              ///< first axis of the outer pin's frame
  double A[3][most], b[2][most];  ///< xx, xy, yy; x, y
  double G[4][most];              ///< xx, xy, yx, yy
  double C[3][most], c[2][most];
};

struct Kernel {
  const char* name;
  int lanes;
  /// e = (cos θ, sin θ) of n angles, to 1 ulp or so for any finite θ.
  void (*rotations)(const double* theta, double* e, int n);
  /// Towards the ground, every segment by itself. e: pairs; F: pairs, or nullptr.
  void (*inwards)(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                  const double* F, SegmentHandles& handles);
  /// Outwards, from the acceleration a of each segment's inner pin and the force f on its outer one.
  void (*outwards)(const SegmentArrays& arrays, const double (*a)[SegmentHandles::most],
                   const double (*f)[SegmentHandles::most], double* alpha);
};

/// Those that this CPU can run, the best first; the last one runs on every CPU. Null pointers fill up.
const std::array<const Kernel*, 3>& kernels();

}  // namespace planar_chain::simd
