#pragma once

/// The recursions of a chain in SIMD lanes: sines and cosines, and the recursion of articulated.h for
/// segments of a chain. The same source is compiled once for each kind of CPU (simd/cpu.h). segments.h has
/// the mathematics.

#include <cstddef>

#include "lanes/motion_series.h"
#include "recursion/acting.h"
#include "simd/cpu.h"
#include "simd/vectors.h"

namespace planar_chain::simd {

/// Arrays of `steps` × `lanes` numbers a quantity, in the order of an Arrangement: see arrangement.h.
struct SegmentArrays {
  static constexpr int linkQuantities = 6;  ///< m, I, r, p
  int steps;
  const double* links;
  double* handles;  ///< U/D, u/D, ω², P, g/D: 8 quantities a step
};

/// The recursion in a row, sines and cosines included; see short_chain.h.
struct ShortChains {
  static constexpr int most = 16;          ///< links
  static constexpr int mostUnrolled = 12;  ///< links that are written out without loops
  static constexpr int linkQuantities = SegmentArrays::linkQuantities;
  /// links: body k·lanes + l in lane l of block k; or what two have in their place, see twoInLanes(). For the
  /// rest see ShortChain::derivative.
  using Run = void (*)(int n, const double* links, const Outside& outside, const double* y, double* dydt);

  int lanes;
  Run (*runFor)(int n, Acting acting);
};

/// No CPU has more.
constexpr int mostLanes = 8;

/// The same layout, for the exact solve; see linearized_segments.h.
struct LinearArrays {
  static constexpr int jointQuantities = 2;   ///< k, d
  static constexpr int stateQuantities = 6;   ///< those, ω, α, P, which a solve reads
  static constexpr int massQuantities = 5;    ///< R, m, J, κ
  static constexpr int inwardQuantities = 9;  ///< 1/D, U_R, M_v, M_q, E_v, E_q
  static constexpr int sideQuantities = 2;    ///< ρ_q, ρ_v
  static constexpr int handleQuantities = 3;  ///< U_L/D, k̂/D, or 1/D without those inwards; of linearize(), a
  static constexpr int outwardQuantities = 3;  ///< t/D
  static constexpr int pairQuantities = 74;    ///< d, and eight matrices
  int steps;
  const double* links;  ///< as in SegmentArrays
  double *state, *masses;
  /// What the factorization keeps for the way in of a solve, for its ways out and for the last of them, and
  /// ε/D, which the way in keeps for the way out: numbers of the solve, so a complex one has its real parts
  /// first.
  /// No more than that: long chains wait for memory.
  double *inward, *handles, *outward, *sweeps;
  double* pairs;  ///< what is kept of the pairs of segments, round by round
};

/// The state at which the chain is linearized; pairs are interleaved. F and XF may be nullptr.
struct LinearState {
  const double *e, *omega, *alpha, *F, *XF;
};

/// By segment, `mostLanes` at most: quantity q stands in row q.
using Rows = double (*)[mostLanes];
using ConstRows = const double (*)[mostLanes];

/// The solve with real or complex numbers, at s: one number, or its two parts. Right-hand side and solution:
/// pairs, if complex; they may stand in the same place.
struct LinearKernel {
  void (*factor)(const LinearArrays& arrays, const double* s);
  void (*solve)(const LinearArrays& arrays, const double* s, const double* rhoQ, const double* rhoV,
                double* u, double* v);
};

/// A link, for the Taylor series of a motion; see series_links.h.
struct SeriesLink {
  double m, I, J;
  Vec2d mr, p;
  // Of order 0: U/D, 1/D, and the articulated mass at the outer pin.
  Vec2d W;
  double inverseD;
  Sym2<double> A;
  // Of the order in hand, as if its α were 0: a of the inner pin, f on the next link; then b and u/D; z: see
  // Turning.
  Vec2d a, f, b;
  double v;
  Rotation<double> z;
};

/// Where its coefficients stand: for each order a row of `width` first factors of the products, and one of
/// second factors; exp(i θ_j), n an order; and what is known of the products before an order comes.
struct SeriesArrays {
  int n, width;
  double *rows, *known;
  Rotation<double>* e;
  SeriesLink* links;
};

/// For one body, for two, and for any number.
struct SeriesShape {
  /// c: row k of 2n numbers is order k of θ and ω; row 0 is there, as is e of order 0. N and F: order 0, and
  /// nullptr where nothing acts. loads: or nullptr.
  void (*run)(const SeriesArrays& arrays, int order, const Outside& outside, SeriesLoads* loads, double* c);
  int (*width)(int n);
};

struct Kernel {
  const char* name;
  int lanes;
  /// e = (cos θ, sin θ) of n angles, to 1 ulp or so for any finite θ.
  void (*rotations)(const double* theta, double* e, int n);
  const ShortChains* shortChains;
  /// n numbers in the order of the arrays, with 0 beyond the end; and back.
  void (*arrange)(int n, int steps, const double* values, double* arranged);
  void (*restore)(int n, int steps, const double* arranged, double* values);
  /// The recursion in segments. e: pairs; N: or nullptr; F: pairs, or nullptr; ground: a of the inner pin;
  /// ahead: a row whose last term is alpha, or nullptr.
  void (*segments)(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                   const double* F, Vec2d ground, double* alpha, const NystromSums* ahead);

  /// To sums: per segment, as if its inner pin did not accelerate, the acceleration of its outer pin, what
  /// its bodies' inertia and loads add up to, and its mass: 2 + 2 + 1.
  void (*linearizeOutwards)(const LinearArrays& arrays, const LinearState& at, Rows sums);
  /// From starts: the acceleration of the inner pin less gravity, and the force of all outside: 2 + 2.
  void (*linearizeInwards)(const LinearArrays& arrays, const LinearState& at, ConstRows starts);
  LinearKernel real, complex;
  LinearKernel realAgain, complexAgain;  ///< those that keep nothing for the way in, and compute it again
  const SeriesShape* series;             ///< three
};

/// Those that this CPU can run, the best first.
const Kernels<Kernel>& kernels();

/// The best for a chain of this size.
const Kernel& kernelFor(std::ptrdiff_t size);

}  // namespace planar_chain::simd
