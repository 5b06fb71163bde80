#pragma once

/// The recursions of a chain in SIMD lanes: sines and cosines, and the recursion of articulated.h for
/// segments of a chain. The same source is compiled once for each kind of CPU (simd/cpu.h). segments.h has
/// the mathematics.

#include <cstddef>
#include <vector>

#include "lanes/motion_series.h"
#include "recursion/acting.h"
#include "simd/cpu.h"

namespace planar_chain::simd {

/// Arrays of `steps` × `lanes` numbers a quantity, in the order of an Arrangement: see arrangement.h.
struct SegmentArrays {
  static constexpr int linkQuantities = 6;  ///< m, I, r, p
  int steps;
  const double* links;
  double* handles;  ///< U/D, u/D, ω², P, g/D: 8 quantities a step
};

/// The recursion link by link, with sines and cosines; see short_chain.h.
struct ShortChains {
  static constexpr int most = 16;          ///< links
  static constexpr int mostUnrolled = 12;  ///< links that have functions without loops
  static constexpr int linkQuantities = SegmentArrays::linkQuantities;
  /// links: body k·lanes + l in lane l of block k; for two links see twoInLanes(). For the other arguments
  /// see ShortChain::derivative.
  using Run = void (*)(int n, const double* links, const Outside& outside, const double* y, double* dydt);

  int lanes;
  Run (*runFor)(int n, Acting acting);
};

/// The most lanes of any CPU.
constexpr int mostLanes = 8;

/// So many quantities a step.
template <int count>
struct Steps {
  static constexpr int quantities = count;
  double* first;
};

/// The same layout, for the exact solve; see linearized_segments.h. A complex number has its real parts
/// first. Nothing else is stored, as long chains wait for memory.
struct LinearArrays {
  static constexpr int jointQuantities = 2;  ///< k, d
  static constexpr int sideQuantities = 2;   ///< ρ_q, ρ_v
  static constexpr int pairQuantities = 74;  ///< d, and eight matrices
  int steps;
  const double* links;  ///< as in SegmentArrays
  Steps<6> state;       ///< k, d, ω, α, P, which a solve reads
  Steps<5> masses;      ///< R, m, J, κ
  Steps<9> inward;      ///< for the way in of a solve: 1/D, U_R, M_v, M_q, E_v, E_q
  Steps<3> handles;     ///< for both ways out: U_L/D, k̂/D; of linearize(), a
  Steps<3> outward;     ///< for the last way out: t/D
  Steps<1> sweeps;      ///< ε/D, which the way in stores
  double* pairs;        ///< the pairs of segments, round by round
};

/// The state at which the chain is linearized. Pairs are interleaved. F and XF may be nullptr.
struct LinearState {
  const double *e, *omega, *alpha, *F, *XF;
};

/// By segment, `mostLanes` at most: quantity q stands in row q.
using Rows = double (*)[mostLanes];
using ConstRows = const double (*)[mostLanes];

/// The solve at s with real or complex numbers. Complex numbers are pairs. The solution may overwrite the
/// right-hand side.
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

/// Storage of a series. `rows` has, for each order, `width` first factors of the products and as many second
/// ones. `known` has the part of the products that follows from lower orders. e is exp(i θ_j), n an order.
struct SeriesArrays {
  int n, width;
  double *rows, *known;
  Rotation<double>* e;
  SeriesLink* links;
};

/// For one body, for two, and for any number.
struct SeriesShape {
  /// c: row k of 2n numbers is order k of θ and ω. Row 0 and order 0 of e are input. N and F are of order 0,
  /// and nullptr if nothing acts. `loads` may be nullptr.
  void (*run)(const SeriesArrays& arrays, int order, const Outside& outside, SeriesLoads* loads, double* c);
  int (*width)(int n);
};

struct Kernel {
  const char* name;
  int lanes;
  /// e = (cos θ, sin θ) of n angles, to about 1 ulp for any finite θ.
  void (*rotations)(const double* theta, double* e, int n);
  const ShortChains* shortChains;
  /// Copies n numbers to the order of the arrays, with 0 beyond the end, and back.
  void (*arrange)(int n, int steps, const double* values, double* arranged);
  void (*restore)(int n, int steps, const double* arranged, double* values);
  /// The recursion in segments. e: pairs; N: or nullptr; F: pairs, or nullptr; ground: a of the inner pin.
  void (*segments)(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                   const double* F, Vec2d ground, double* alpha);

  /// To sums: per segment, as if its inner pin did not accelerate, the acceleration of its outer pin, what
  /// its bodies' inertia and loads add up to, and its mass: 2 + 2 + 1.
  void (*linearizeOutwards)(const LinearArrays& arrays, const LinearState& at, Rows sums);
  /// From starts: the acceleration of the inner pin less gravity, and the force of all outside: 2 + 2.
  void (*linearizeInwards)(const LinearArrays& arrays, const LinearState& at, ConstRows starts);
  LinearKernel real, complex;
  LinearKernel realAgain, complexAgain;  ///< store nothing for the way in, but compute it again
  const SeriesShape* series;             ///< three
};

/// The kernels that this CPU runs, the best first.
const std::vector<const Kernel*>& kernels();

/// The best of them for a chain of so many links. AVX-512 gains 13 % of an evaluation at 100 links, and 36 %
/// at 1000.
const Kernel& kernelFor(int links);

}  // namespace planar_chain::simd
