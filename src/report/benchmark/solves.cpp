#include <complex>
#include <memory>
#include <random>
#include <type_traits>

#include "lanes/segments.h"
#include "report/benchmark/measure.h"
#include "report/benchmark/moving_rods.h"

namespace planar_chain::benchmarks {

namespace {

using Complex = std::complex<double>;

constexpr int segmentsFrom = 100;  // links, in the comparison with the solve link by link

// 1/(hγ), 1/s, as in steps of about a millisecond.
template <class Scalar>
const Scalar shift = 5e3;
template <>
const Complex shift<Complex>{5e3, 4e3};

double randomNumber(std::mt19937_64& engine, double) {
  return std::uniform_real_distribution<double>(-1, 1)(engine);
}
Complex randomNumber(std::mt19937_64& engine, Complex) {
  return {randomNumber(engine, 0.0), randomNumber(engine, 0.0)};
}

/// A right-hand side [ρ_q; ρ_v] and room for [u; v], of so many numbers.
template <class Scalar>
struct Sides {
  explicit Sides(int size) : rhs(static_cast<std::size_t>(size)), x(rhs.size()) {
    std::mt19937_64 engine(21);
    for (Scalar& value : rhs) value = randomNumber(engine, Scalar());
  }
  std::vector<Scalar> rhs, x;
};

template <class Work>
void repeat(benchmark::State& state, int n, Work work) {
  work();  // its memory is cold
  for (auto _ : state) {
    work();
    benchmark::ClobberMemory();
  }
  state.counters["ns_per_link"] = perLink(n);
}

/// As the methods call it, by way of Dynamics.
void registerDynamics(int n) {
  using Work = void (*)(benchmark::State&, int, Dynamics&, MovingRods&);
  const std::pair<const char*, Work> works[] = {
      {"linearize",
       [](benchmark::State& state, int size, Dynamics& f, MovingRods& at) {
         repeat(state, size, [&] { f.linearize(0, at.laneOrderedY.data(), at.laneOrderedRates.data()); });
       }},
      {"factor", [](benchmark::State& state, int size, Dynamics& f,
                    MovingRods&) { repeat(state, size, [&] { f.factor(shift<double>); }); }},
      {"solve",
       [](benchmark::State& state, int size, Dynamics& f, MovingRods&) {
         Sides<double> sides(f.sizeInLaneOrder());
         f.factor(shift<double>);
         repeat(state, size, [&] { f.solve(sides.rhs.data(), sides.x.data()); });
       }},
      {"complex factor",
       [](benchmark::State& state, int size, Dynamics& f, MovingRods&) {
         repeat(state, size, [&] { f.factorComplex(0, shift<Complex>); });
       }},
      {"complex solve", [](benchmark::State& state, int size, Dynamics& f, MovingRods&) {
         Sides<Complex> sides(f.sizeInLaneOrder());
         f.factorComplex(0, shift<Complex>);
         repeat(state, size, [&] { f.solveComplex(0, sides.rhs.data(), sides.x.data()); });
       }}};
  for (const auto& [what, work] : works) {
    benchmark::RegisterBenchmark(nameOf("solve", what, n).c_str(), [n, work = work](benchmark::State& state) {
      MovingRods at(n, crooked(n));
      at.dynamics.reserve(1);
      at.dynamics.linearize(0, at.laneOrderedY.data(), at.laneOrderedRates.data());
      work(state, n, at.dynamics, at);
    });
  }
}

/// The rods, linearized by one of the two solvers, each in its order.
template <class Scalar, bool inSegments>
struct SolverAt {
  explicit SolverAt(int n)
      : at(n, crooked(n)),
        real(at.scene.chain, inSegments, simd::kernelFor(n, {})),
        complex(real),
        paddedSize(inSegments ? at.dynamics.sizeInLaneOrder() / 2 : n) {
    at.dynamics.derivative(0, at.y.data(), at.dydt.data());
    at.dynamics.toLaneOrder(at.dydt.data(), at.laneOrderedRates.data());
    const double* y = inSegments ? at.laneOrderedY.data() : at.y.data();
    const double* dydt = inSegments ? at.laneOrderedRates.data() : at.dydt.data();
    std::vector<Rotation<double>> e(static_cast<std::size_t>(paddedSize));
    rotations(y, e.data(), paddedSize);
    real.linearize(e.data(), y + paddedSize, dydt + paddedSize, nullptr, nullptr);
  }
  LinearizedSegments<Scalar>& solver() {
    if constexpr (std::is_same_v<Scalar, Complex>)
      return complex;
    else
      return real;
  }

  MovingRods at;
  LinearizedSegments<double> real;
  LinearizedSegments<Complex> complex;
  int paddedSize;
};

template <class Scalar, bool inSegments>
void registerSolver(const std::string& kind, const std::string& how, int n) {
  benchmark::RegisterBenchmark(nameOf("solver", kind + "factor " + how, n).c_str(),
                               [n](benchmark::State& state) {
                                 SolverAt<Scalar, inSegments> at(n);
                                 repeat(state, n, [&] { at.solver().factor(shift<Scalar>); });
                               });
  benchmark::RegisterBenchmark(
      nameOf("solver", kind + "solve " + how, n).c_str(), [n](benchmark::State& state) {
        SolverAt<Scalar, inSegments> at(n);
        at.solver().factor(shift<Scalar>);
        Sides<Scalar> sides(2 * at.paddedSize);
        const Scalar* rhs = sides.rhs.data();
        Scalar* x = sides.x.data();
        const int paddedSize = at.paddedSize;
        repeat(state, n, [&] { at.solver().solve(rhs, rhs + paddedSize, x, x + paddedSize); });
      });
}

}  // namespace

void registerSolves() {
  for (const int n : sizes()) {
    registerDynamics(n);
    if (n < segmentsFrom) continue;
    registerSolver<double, false>("", "link by link", n);
    registerSolver<double, true>("", "in segments", n);
    registerSolver<Complex, false>("complex ", "link by link", n);
    registerSolver<Complex, true>("complex ", "in segments", n);
  }
}

}  // namespace planar_chain::benchmarks
