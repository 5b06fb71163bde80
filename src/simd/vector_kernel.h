#pragma once

/// Vectors of the integrators, for `laneCount` lanes: each function reads and writes every component once.

#include <array>
#include <cstddef>
#include <limits>
#include <utility>

#include "simd/pack.h"
#include "simd/vectors.h"

namespace planar_chain::simd {
namespace {

/// f(i, count) for every register's worth of n components, the last of which may be fewer.
template <class F>
[[gnu::always_inline]] inline void forRegisters(std::ptrdiff_t n, F f) {
  std::ptrdiff_t i = 0;
  for (; i + laneCount <= n; i += laneCount) f(i, laneCount);
  if (i < n) f(i, static_cast<int>(n - i));
}

template <int count>
PLANAR_CHAIN_IN_ONE_PIECE void combineOf(double factor, const double* weights, const double* const* terms,
                                         const double* base, double* sum, double* out, std::ptrdiff_t n) {
  Pack weight[count];
  for (int j = 0; j < count; ++j) weight[j] = Pack(factor * weights[j]);
  const auto firstOf = [&](int some, std::ptrdiff_t i, int size) {
    Pack a = weight[0] * loadSome(terms[0] + i, size);
    for (int j = 1; j < some; ++j) a = mulAdd(weight[j], loadSome(terms[j] + i, size), a);
    return a;
  };
  const auto total = [&](std::ptrdiff_t i, int size) { return firstOf(count, i, size); };
  // The last term is the latest: nothing but its own product waits for it.
  const auto stage = [&](std::ptrdiff_t i, int size) {
    Pack a = loadSome(base + i, size);
    if constexpr (count > 1) a += firstOf(count - 1, i, size);
    return mulAdd(weight[count - 1], loadSome(terms[count - 1] + i, size), a);
  };
  if (!out) {
    forRegisters(n, [&](std::ptrdiff_t i, int size) { storeSome(sum + i, total(i, size), size); });
  } else if (!sum) {
    forRegisters(n, [&](std::ptrdiff_t i, int size) { storeSome(out + i, stage(i, size), size); });
  } else {
    forRegisters(n, [&](std::ptrdiff_t i, int size) {
      const Pack a = total(i, size);
      storeSome(sum + i, a, size);
      storeSome(out + i, loadSome(base + i, size) + a, size);
    });
  }
}

/// Nyström's form saves loads of long chains' vectors (src/README.md). The last term is in no position: ā_ij
/// = Σ a_ik a_kj needs a k between i and j.
template <int count>
PLANAR_CHAIN_IN_ONE_PIECE void combineTwiceOf(const NystromSums& given, std::ptrdiff_t n) {
  const NystromSums row = given;  // stays in registers
  constexpr int last = count - 1;
  const Pack drift(row.h * row.drift);
  Pack forRates[count], forPositions[count];
  for (int j = 0; j < count; ++j) {
    forRates[j] = Pack(row.h * row.forRates[j]);
    forPositions[j] = Pack(row.h * row.h * row.forPositions[j]);
  }
  forRegisters(n, [&](std::ptrdiff_t i, int size) {
    const Pack omega = loadSome(row.base + n + i, size);
    Pack rate, position = drift * omega;
    for (int j = 0; j < last; ++j) {
      const Pack term = loadSome(row.terms[j] + i, size);
      rate = j == 0 ? forRates[j] * term : mulAdd(forRates[j], term, rate);
      position = mulAdd(forPositions[j], term, position);
    }
    const Pack latest = loadSome(row.terms[last] + i, size);
    rate = count == 1 ? forRates[last] * latest : mulAdd(forRates[last], latest, rate);
    if (row.sum) {
      storeSome(row.sum + i, position, size);
      storeSome(row.sum + n + i, rate, size);
    }
    if (row.out) {
      storeSome(row.out + i, loadSome(row.base + i, size) + position, size);
      storeSome(row.out + n + i, omega + rate, size);
    }
  });
}

PLANAR_CHAIN_IN_ONE_PIECE void damp(double* error, const double* coarse, std::ptrdiff_t n) {
  forRegisters(n, [&](std::ptrdiff_t i, int count) {
    const Pack fine = loadSome(error + i, count), rough = loadSome(coarse + i, count);
    const Pack size = root(fine * fine + Pack(0.01) * (rough * rough));
    storeSome(error + i, Pack(size.v > 0 ? (fine * (fine / size)).v : size.v), count);
  });
}

/// Each of them.
[[gnu::always_inline]] inline bool isNumber(Pack a) {
  return all(a.v == a.v);
}

PLANAR_CHAIN_IN_ONE_PIECE bool addCarried(double* y, double* carry, const double* increment,
                                          std::ptrdiff_t n) {
  Pack zero;  // NaN, if one sum is not finite
  forRegisters(n, [&](std::ptrdiff_t i, int size) {
    zero = mulAdd(Pack(0), loadSome(y + i, size) + loadSome(increment + i, size), zero);
  });
  if (!isNumber(zero)) return false;
  forRegisters(n, [&](std::ptrdiff_t i, int size) {
    const Pack old = loadSome(y + i, size);
    const Pack whole = loadSome(increment + i, size) + loadSome(carry + i, size);
    const Pack next = old + whole;
    storeSome(carry + i, whole - (next - old), size);
    storeSome(y + i, next, size);
  });
  return true;
}

PLANAR_CHAIN_IN_ONE_PIECE void polynomial(double h, const double* c, int order, double* sum,
                                          std::ptrdiff_t n) {
  const Pack step(h), square(h * h), fourth = square * square;
  const int last = order - 1 + order % 2;
  forRegisters(n, [&](std::ptrdiff_t i, int size) {
    const auto at = [&](int k) { return loadSome(c + k * n + i, size); };
    const auto pair = [&](int k) { return mulAdd(step, at(k + 1), at(k)); };
    // Horner's rule for every other pair of orders: each sum waits for a quarter as many.
    Pack high = last < order ? pair(last) : at(last), low = pair(last - 2);
    int k = last - 4;
    for (; k > 1; k -= 4) {
      high = mulAdd(fourth, high, pair(k));
      low = mulAdd(fourth, low, pair(k - 2));
    }
    if (k == 1) low = mulAdd(fourth, std::exchange(high, low), pair(1));
    storeSome(sum + i, step * mulAdd(square, high, low), size);
  });
}

PLANAR_CHAIN_IN_ONE_PIECE void tail(const std::array<double, VectorKernel::tailOrders>& weights,
                                    const double* c, double* error, std::ptrdiff_t n) {
  forRegisters(n, [&](std::ptrdiff_t i, int size) {
    const auto term = [&](int k) {
      return Pack(weights[static_cast<std::size_t>(k)]) * absolute(loadSome(c + k * n + i, size));
    };
    constexpr int last = VectorKernel::tailOrders - 1;
    Pack largest;
    PLANAR_CHAIN_WRITTEN_OUT
    for (int k = 0; k < last - 1; ++k) largest = larger(term(k), largest);
    storeSome(error + i, larger(largest, term(last - 1) + term(last)), size);
  });
}

/// The largest of all lanes, compared pair by pair.
template <int size = 1>
[[gnu::always_inline]] inline double largestOf(Pack a) {
  if constexpr (size < laneCount) return largestOf<2 * size>(larger(ofInner<size>(a), ofOuter<size>(a)));
  return a.v[0];
}

PLANAR_CHAIN_IN_ONE_PIECE double largestRatio(const ErrorVectors& of, const AllowedErrors& allowances,
                                              std::ptrdiff_t n) {
  Pack largest, zero;  // zero: NaN, if one ratio is not finite
  Integers lanes{};
  PLANAR_CHAIN_WRITTEN_OUT
  for (int s = 0; s < laneCount; ++s) lanes[s] = s;
  forRegisters(n, [&](std::ptrdiff_t i, int count) {
    const Pack y = absolute(loadSome(of.y + i, count));
    const Pack unit = loadSome(of.unit + i, count);
    const Pack angle = smaller(unit + y, loadSome(of.ceiling + i, count));
    const Pack rate =
        smaller(angle, mulAdd(Pack(allowances.slowUnits), unit, Pack(allowances.turningTime) * y));
    const auto isAngle = lanes < allowances.angles - i;
    const Pack most = isAngle ? Pack(allowances.most).v : Pack(allowances.mostOfRates).v;
    const Pack size = isAngle ? angle.v : rate.v;
    const Pack allowed = larger(most * size, Pack(allowances.perNoise) * loadSome(of.noise + i, count));
    const Pack all = absolute(loadSome(of.error + i, count)) / allowed;
    const Pack ratio = {lanes < count ? all.v : Pack(0).v};  // behind the last component: 0/0
    largest = larger(ratio, largest);
    zero = mulAdd(Pack(0), ratio, zero);
  });
  return isNumber(zero) ? largestOf(largest) : std::numeric_limits<double>::quiet_NaN();
}

/// f(count) for each count from 1 on.
template <class F, int... counts>
constexpr auto tableOf(F f, std::integer_sequence<int, counts...>) {
  return std::array{f(std::integral_constant<int, counts + 1>())...};
}

using Terms = std::make_integer_sequence<int, VectorKernel::mostTerms>;

constexpr VectorKernel vectorKernel{tableOf([](auto count) { return combineOf<count>; }, Terms()),
                                    tableOf([](auto count) { return combineTwiceOf<count>; }, Terms()),
                                    damp,
                                    addCarried,
                                    polynomial,
                                    tail,
                                    largestRatio};

}  // namespace
}  // namespace planar_chain::simd
