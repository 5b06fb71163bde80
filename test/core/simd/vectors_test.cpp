/// The integrators' vectors in SIMD lanes: every kernel that this CPU runs, against plain loops, for every
/// number of components that is left over at the end, and nothing written beyond it.

#include "simd/vectors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "simd/elementary.h"
#include "support/random_scene.h"

namespace planar_chain::simd {
namespace {

constexpr double untouched = 12345;
constexpr std::ptrdiff_t most = 19;

struct Vectors : testing::TestWithParam<std::ptrdiff_t> {
  const std::ptrdiff_t n = GetParam();
  test::Random random{static_cast<unsigned>(n)};

  std::vector<double> vector(std::ptrdiff_t size) {
    std::vector<double> values(static_cast<std::size_t>(size));
    for (double& value : values) value = random.between(-2, 2);
    values.push_back(untouched);
    return values;
  }

  template <class F>
  void forKernels(F f) {
    for (const VectorKernel* kernel : vectorKernels()) {
      SCOPED_TRACE(kernel == &vectors({}) ? "the best" : "another");
      f(*kernel);
    }
  }

  static void expectNear(const std::vector<double>& found, const std::vector<double>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-13) << i;
    EXPECT_EQ(found.back(), untouched);
  }
};

TEST_P(Vectors, AreCombined) {
  for (std::size_t count = 1; count <= VectorKernel::mostTerms; ++count) {
    std::vector<std::vector<double>> terms;
    std::vector<const double*> places;
    for (std::size_t j = 0; j < count; ++j) terms.push_back(vector(n));
    for (const auto& term : terms) places.push_back(term.data());
    const std::vector<double> rates = vector(most), base = vector(2 * n);
    std::vector<double> positions = vector(most);
    positions[count - 1] = 0;
    const double h = 0.3, drift = 0.7;

    std::vector<double> sum = base, out = base, sumTwice = base, outTwice = base;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      const std::size_t rate = i + static_cast<std::size_t>(n);
      double byRates = 0, byPositions = h * drift * base[rate];
      for (std::size_t j = 0; j < count; ++j) {
        byRates += h * rates[j] * terms[j][i];
        byPositions += h * h * positions[j] * terms[j][i];
      }
      sum[i] = byRates;
      out[i] = base[i] + byRates;
      sumTwice[i] = byPositions;
      sumTwice[rate] = byRates;
      outTwice[i] = base[i] + byPositions;
      outTwice[rate] = base[rate] + byRates;
    }
    forKernels([&](const VectorKernel& kernel) {
      const auto once = kernel.combine[count - 1];
      const auto twice = kernel.combineTwice[count - 1];
      // Both, the sum alone, or the result alone.
      for (const bool withSum : {true, false}) {
        for (const bool withOut : {true, false}) {
          if (!withSum && !withOut) continue;
          std::vector<double> a = base, b = base, c = base, d = base;
          once(h, rates.data(), places.data(), base.data(), withSum ? a.data() : nullptr,
               withOut ? b.data() : nullptr, n);
          twice({rates.data(), positions.data(), places.data(), drift, h, base.data(),
                 withSum ? c.data() : nullptr, withOut ? d.data() : nullptr},
                n);
          expectNear(a, withSum ? sum : base);
          expectNear(b, withOut ? out : base);
          expectNear(c, withSum ? sumTwice : base);
          expectNear(d, withOut ? outTwice : base);
        }
      }
    });
  }
}

TEST_P(Vectors, FindTheLargestRatio) {
  constexpr double share = 1e-6, ofRates = 3e-6, rounding = 1e3, slowUnits = 1.1, turningTime = 0.3,
                   nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> y = vector(n), noise = vector(n);
  std::vector<double> unit(y.size(), 1), ceiling(y.size(), std::numeric_limits<double>::infinity()),
      error = vector(n);
  ceiling[0] = 1.5;
  unit[unit.size() - 1] = 1e-3;
  const std::size_t angles = y.size() / 2;
  const auto allowed = [&](std::size_t i) {
    const double size = std::min(unit[i] + std::abs(y[i]), ceiling[i]);
    const double ofRate = std::min(size, slowUnits * unit[i] + turningTime * std::abs(y[i]));
    return std::max(i < angles ? share * size : ofRates * ofRate, rounding * noise[i]);
  };
  const auto found = [&](const VectorKernel& kernel) {
    return kernel.largestRatio(
        {error.data(), y.data(), unit.data(), ceiling.data(), noise.data()},
        {share, ofRates, static_cast<std::ptrdiff_t>(angles), rounding, slowUnits, turningTime}, n);
  };
  forKernels([&](const VectorKernel& kernel) {
    // Each component in its turn; up to where products of two such numbers are not finite.
    for (std::size_t worst = 0; worst < static_cast<std::size_t>(n); ++worst) {
      for (const double size : {1e-9, 1.0, -1e200, 1e304}) {
        for (std::size_t i = 0; i < error.size() - 1; ++i) error[i] = 0.7 * allowed(i) * 1e-9;
        error[worst] = size * allowed(worst);
        EXPECT_NEAR(found(kernel) / std::abs(size), 1, 1e-14) << worst << " " << size;
      }
      for (const double bad : {nan, std::numeric_limits<double>::infinity()}) {
        error[worst] = bad;
        EXPECT_TRUE(std::isnan(found(kernel)));
        error[worst] = 0;
      }
    }
  });
}

TEST_P(Vectors, SumAPolynomial) {
  constexpr double h = 0.7;
  for (const int order : {3, 4, 5, 6, 21, 22}) {
    const std::vector<double> c = vector(n * (order + 1));
    std::vector<double> sum = vector(n), expected = sum;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
      expected[i] = 0;
      for (int k = order; k > 0; --k)
        expected[i] = h * (c[static_cast<std::size_t>(k * n) + i] + expected[i]);
    }
    forKernels([&](const VectorKernel& kernel) {
      kernel.polynomial(h, c.data(), order, sum.data(), n);
      expectNear(sum, expected);
    });
  }
}

TEST_P(Vectors, FindTheTailOfASeries) {
  const auto count = static_cast<std::size_t>(n);
  const std::array<double, VectorKernel::tailOrders> weights{1, 2, 3, 4, 5, 6};
  std::vector<double> c = vector(n * VectorKernel::tailOrders), error = vector(n);
  const auto size = [&](std::size_t k, std::size_t i) { return weights.at(k) * std::abs(c[k * count + i]); };
  forKernels([&](const VectorKernel& kernel) {
    std::vector<double> expected = error;
    for (std::size_t i = 0; i < count; ++i) {
      expected[i] = size(4, i) + size(5, i);
      for (std::size_t k = 0; k < 4; ++k) expected[i] = std::max(expected[i], size(k, i));
    }
    kernel.tail(weights, c.data(), error.data(), n);
    expectNear(error, expected);
    for (const std::size_t k : {4, 5}) {
      const double good = std::exchange(c[k * count], std::numeric_limits<double>::quiet_NaN());
      kernel.tail(weights, c.data(), error.data(), n);
      EXPECT_TRUE(std::isnan(error.front()));
      c[k * count] = good;
    }
  });
}

TEST_P(Vectors, DampErrorsByCoarserOnes) {
  std::vector<double> fine = vector(n), coarse = vector(n), expected = fine;
  fine[0] = coarse[0] = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    const double size = std::sqrt(fine[i] * fine[i] + 0.01 * coarse[i] * coarse[i]);
    expected[i] = size > 0 ? fine[i] * fine[i] / size : 0;
  }
  forKernels([&](const VectorKernel& kernel) {
    std::vector<double> damped = fine;
    kernel.damp(damped.data(), coarse.data(), n);
    expectNear(damped, expected);
    damped = fine;
    damped[static_cast<std::size_t>(n) - 1] = std::numeric_limits<double>::infinity();
    kernel.damp(damped.data(), coarse.data(), n);
    EXPECT_FALSE(std::isfinite(damped[static_cast<std::size_t>(n) - 1]));
  });
}

/// Errors of a step are next to 1, of a first step anywhere.
TEST(Elementary, RoughPowersAreAsExactAsTheySay) {
  for (double log = -300; log < 300; log += 0.0137) {
    const double x = std::exp2(log);
    for (double y : {-1. / 2, -1. / 14, -1. / 34, 1. / 14, 1. / 2}) {
      EXPECT_NEAR(roughPower(x, y) / std::pow(x, y), 1, 0.061 * std::abs(y) + 0.0002) << x << " ^ " << y;
    }
  }
  EXPECT_GT(roughPower(0, -1. / 14), 1e20);
}

INSTANTIATE_TEST_SUITE_P(OfEveryLength, Vectors, testing::Range<std::ptrdiff_t>(1, most));

}  // namespace
}  // namespace planar_chain::simd
