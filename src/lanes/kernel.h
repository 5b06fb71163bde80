#pragma once

/// The recursions of a chain in SIMD lanes: sines and cosines, and the recursion of articulated.h for
/// segments of a chain. This source is compiled once for each kind of CPU (simd/cpu.h). segments.h has the
/// mathematics.

#include <array>
#include <vector>

#include "planar_chain/planar.h"
#include "recursion/general.h"
#include "recursion/load_kind.h"
#include "simd/cpu.h"

namespace planar_chain {

/// The coefficients of the loads.
class SeriesLoads {
 public:
  virtual ~SeriesLoads() = default;
  /// Writes order k > 0 of N and F in place of order k − 1. Order k of θ, ω and e is written.
  virtual void findOrder(int k) = 0;
};

namespace simd {

/// Arrays of `steps` × `lanes` numbers a quantity, in the order of a LaneOrder: see lane_order.h.
struct SegmentArrays {
  static constexpr int linkQuantities = 6;    ///< m, I, r, p
  static constexpr int factorQuantities = 8;  ///< U/D, u/D, ω², P, g/D
  static constexpr int pinQuantities = 4;     ///< a of the inner pin, F in the outer one
  int steps;
  const double* links;
  double* factors;
};

/// The recursion link by link, with sines and cosines; see short_chain.h.
struct ShortChains {
  static constexpr int most = 12;  ///< links
  static constexpr int linkQuantities = SegmentArrays::linkQuantities;
  /// links: body k·lanes + l in lane l of block k; for two links see twoInLanes(). For the other arguments
  /// see ShortChain::derivative.
  using Run = void (*)(const double* links, const Loads& external, const double* y, double* dydt);

  int lanes;
  Run (*runFor)(int n, LoadKind acting);
};

/// The numbers that the exact solve and the general recursion store for a pair of segments (LinearPairs): d,
/// and eight matrices.
constexpr int pairQuantities = 2 + 8 * 9;

/// How the general recursion takes a joint, link by link.
enum class JointKind : char {
  bare,      ///< revolute and free, without armature; and so is the next one
  revolute,  ///< any
  prismatic,
  carriage,  ///< prismatic, and nothing inside of it turns or has a wrench that anybody asks for
};

/// The general recursion; see general_chain.h. Joint by joint, or step by step in lanes: J, 1 if prescribed
/// or else 0, q̈.
struct GeneralArrays {
  static constexpr int jointQuantities = 3;
  static constexpr int displacementQuantities = 7;  ///< 1 if prismatic or else 0, d, S, γ
  static constexpr int termQuantities = 12;
  static constexpr int most = ShortChains::most;  ///< links, link by link
  static constexpr int rows = 15, width = 16;     ///< of their numbers
  int n, steps;
  const double *links, *joints;
  const JointKind* kinds;                 ///< link by link
  const Displacement<double>* displaced;  ///< link by link: of prismatic joints
  const double* displacedInLanes;         ///< in segments; nullptr: all joints are revolute
  double* terms;
  double* pairs;  ///< the pairs of segments, round by round
};

/// The ends of a chain: what is inside of the bodies of the kernel, and the held tip.
struct GeneralEnds;
/// The most joints inside of the segments.
constexpr int mostLeading = ShortChains::most;
/// Solves for the force on the tip, which is returned, and for the motion of the pin that shows this.
Vec2d meet(const ArticulatedTerms<double>& articulated, const TipTerms<double>& ofTip,
           const GeneralEnds& ends, Moved<double>& pin);

/// Results. ends: nullptr if nobody asks for them.
struct GeneralResults {
  double *xdd, *moments;
  const GeneralEnds* ends;
};

/// theta: angles of the bodies, or nullptr if e is given, as it is in segments.
using GeneralRun = void (*)(const GeneralArrays& arrays, const Loads& external, const double* theta,
                            const double* omega, double turning, GeneralResults to);

/// For chains without ends, with the wrench of the base, and with a held tip, which alone pays for it.
struct GeneralKernel {
  GeneralRun plain, withWrench, holdingTip;
};

/// So many quantities a step.
template <int count>
struct Steps {
  static constexpr int quantities = count;
  double* first;
};

/// Arrays in that layout for the exact solve; see linearized_segments.h. A complex number has its real parts
/// first. Nothing else is stored, as long chains wait for memory.
struct LinearArrays {
  static constexpr int jointQuantities = 2;  ///< k, d
  static constexpr int sideQuantities = 2;   ///< ρ_q, ρ_v
  int steps;
  const double* links;  ///< as in SegmentArrays
  Steps<6> state;       ///< k, d, ω, α, P, which a solve reads
  Steps<5> masses;      ///< R, m, J, κ
  Steps<9> inward;      ///< for the way in of a solve: 1/D, U_R, M_v, M_q, E_v, E_q
  Steps<3> factors;     ///< for both ways out: U_L/D, k̂/D; of linearize(), a
  Steps<3> outward;     ///< for the last way out: t/D
  Steps<1> sweeps;      ///< ε/D, which the way in stores
  double* pairs;        ///< the pairs of segments, round by round
};

/// The state at which the chain is linearized. Pairs are interleaved. F and XF may be nullptr.
struct LinearState {
  const double *e, *omega, *alpha, *F, *XF;
};

/// The solve at s with real or complex numbers. Complex numbers are pairs. The solution may overwrite the
/// right-hand side.
struct LinearKernel {
  void (*factor)(const LinearArrays& arrays, const double* s);
  void (*solve)(const LinearArrays& arrays, const double* s, const double* rhoQ, const double* rhoV,
                double* u, double* v);
};

struct LinearKernels {
  /// ground: the acceleration of the ground pin less gravity.
  void (*linearize)(const LinearArrays& arrays, LinearState at, Vec2d ground);
  LinearKernel real, complex;
  LinearKernel realAgain, complexAgain;  ///< store nothing for the way in, but compute it again
};

/// A link, for the Taylor series of a motion; see series_links.h.
template <class Real>
struct SeriesLink {
  Real m, I, J;
  Vec2<Real> mr, p;
};

/// A carriage and one body on it, for the Taylor series of a motion; see series_cart.h.
struct SeriesCart {
  double mass, perMass;   ///< of both, and 1 over it
  double moment;          ///< σ
  double least;           ///< Δ − σ² c_0²
  Rotation<double> turn;  ///< e times it is c + i s
  Vec2d axis;
};

/// Storage of a series. `rows` has, for each order, `width` first factors of the products and as many second
/// ones. `known` has the part of the products that follows from lower orders. e is exp(i θ_j), n pairs an
/// order. links: SeriesLinks. With a chain in each lane, every number stands there once a lane.
/// One body has rows of its own: see series_one.h.
struct SeriesArrays {
  static constexpr int columns = 6;  ///< products a link
  static constexpr int chunk = 8;    ///< the width of one link and of two, and a divisor of all others
  static constexpr int bodyNumbers = 15, tipNumbers = 6;
  static constexpr int knownOrders = 4;  ///< found at a time, of chains in lanes
  int n, width;
  double *rows, *known, *bodies, *tip, *e;
  const double* links;
  const double* inverses = nullptr;  ///< of one body: for k = 0, 1 … 1/k in two parts, each of them twice
};

/// c: row k of 2n numbers is order k of θ and ω. Row 0 and order 0 of e are input. N and F are of order 0,
/// and nullptr if nothing acts. `loads` may be nullptr.
using SeriesRun = void (*)(const SeriesArrays& arrays, int order, const Loads& external, SeriesLoads* loads,
                           double* c);

/// Taylor steps of as many chains of equal length as there are lanes. Every number of these arrays stands
/// there once a lane, one chain after the other, and no lane reads another one.
struct EnsembleArrays {
  static constexpr int jointQuantities = 3;  ///< stiffness, damping, torque at q = 0
  SeriesArrays arrays;
  int order;
  const double* ground;  ///< the acceleration of the ground pin less gravity
  const double* joints;  ///< nullptr: none has any
  double* N;             ///< moments, n
  double* c;             ///< order k of θ and ω, 2n numbers each, k = 0 … order; order 0 is the state
  double* carry;         ///< the rounding of the state, 2n
  double* h;             ///< the last step proposed
  double* turning;       ///< T of ode/integrator.h, less its part h/2: s
  double *direction, *scratch;  ///< of the measurement of λ, 2n; 6n
};

/// The error control of ode/integrator.h, for the tail of a series (ode/taylor.h).
struct StepControl {
  double most, least, shortest;  ///< an angle's error is at most max(most × clamp(h, shortest, 1 s), least)
  double mostOfRates;            ///< likewise, and 1 s/T times as much
  double leastTurning;           ///< of T, s; 1: rates count by themselves
  double ceiling, slowUnits;     ///< of the size of angles, of rates
  std::array<double, 6> tail;    ///< factors of the last terms of the series; the last two are added
};

struct EnsembleKernel {
  /// Measures λ and computes T in the lanes whose `due` is 1, as LocalStiffness does.
  void (*findTurning)(const EnsembleArrays& of, const StepControl& control, const double* due);
  /// Computes the series, and the next step: at most ten times the last one, 0 if there is none.
  void (*find)(const EnsembleArrays& of, const StepControl& control);
  /// The states h later.
  void (*evaluate)(const EnsembleArrays& of, const double* h, double* y);
  /// Also the power that the dampers take then, W.
  void (*dissipation)(const EnsembleArrays& of, const double* h, double* y, double* power);
  /// Makes them the present ones.
  void (*take)(const EnsembleArrays& of, const double* h);
};

struct Kernel {
  const char* name;
  int lanes;
  /// e = (cos θ, sin θ) of n angles, to about 1 ulp for any finite θ.
  void (*rotations)(const double* theta, double* e, int n);
  const ShortChains* shortChains;
  /// The recursion in segments. e: pairs; N: or nullptr; F: pairs, or nullptr; ground: a of the inner pin.
  void (*segments)(const SegmentArrays& arrays, const double* e, const double* omega, const double* N,
                   const double* F, Vec2d ground, double* alpha);
  /// Writes a of each body's inner pin, and the force on the next body in its outer pin. Returns that on the
  /// first body.
  Vec2d (*pins)(const SegmentArrays& arrays, const double* e, const double* omega, const double* alpha,
                Vec2d ground, double* pins);
  GeneralKernel generalLinks, generalSegments;
  LinearKernels inSegments, linkByLink;
  SeriesRun series[5];  ///< for one body, for two, for any number; with a held tip; for one on a carriage
  EnsembleKernel ensemble[3];  ///< for one body, for two, for any number
};

extern const Kernel kernelBaseline, kernelAvx2, kernelAvx512;
extern const ShortChains shortChainsAvx2;

/// The kernels that this CPU runs, the best first.
const std::vector<const Kernel*>& kernels(KernelChoice choice = {});

/// The best of them for a chain of so many links. AVX-512 gains more the more links there are
/// (src/README.md).
const Kernel& kernelFor(int links, KernelChoice choice);

}  // namespace simd

}  // namespace planar_chain
