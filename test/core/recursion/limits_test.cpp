/// Frequencies of small vibrations, from the program's own Jacobian, against exact ones: of chains of any
/// number of links, and of the thread and the beam that these tend to.

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "support/known_chains.h"
#include "support/linearized.h"

namespace planar_chain {
namespace {

using Complex = std::complex<double>;

/// ω of the mode i ω of J nearest to i times the guess, where every link has the angle θ and turns steadily:
/// inverse iteration, x ← (s − J)⁻¹ x.
double frequency(const Chain& chain, double theta, double spin, double guess) {
  const auto n = static_cast<std::size_t>(chain.size());
  const std::vector<Rotation<double>> e(n, Rotation<double>::of(theta));
  const std::vector<double> omega(n, spin), alpha(n, 0.0);
  std::vector<double> k, d;
  for (const Joint& joint : chain.joints()) k.push_back(joint.stiffness), d.push_back(joint.damping);
  Linearized<Complex> linearized(chain);
  linearized.setJoints(k.data(), d.data());
  linearized.linearize(e.data(), omega.data(), alpha.data(), nullptr, nullptr);
  std::vector<Complex> x(2 * n, 1), next(2 * n);
  for (std::size_t i = 0; i < n; ++i) x[i] += std::sin(1.0 + 7.0 * static_cast<double>(i));
  Complex s{0, guess};
  for (const int iterations : {6, 4, 4}) {
    linearized.factor(s);
    Complex mu;
    for (int iteration = 0; iteration < iterations; ++iteration) {
      linearized.solve(x.data(), x.data() + n, next.data(), next.data() + n);
      Complex product = 0;
      double size = 0, newSize = 0;
      for (std::size_t i = 0; i < 2 * n; ++i) {
        product += std::conj(x[i]) * next[i];
        size += std::norm(x[i]);
        newSize += std::norm(next[i]);
      }
      mu = product / size;
      for (std::size_t i = 0; i < 2 * n; ++i) x[i] = next[i] / std::sqrt(newSize);
    }
    const Complex eigenvalue = s - 1.0 / mu;
    if (iterations == 4 && s.real() != 0) return eigenvalue.imag();
    // Not onto it, where the factors would be singular.
    s = eigenvalue + 1e-5 * guess;
  }
  return 0;
}

constexpr Vec2d gravity{9.81, 0};  // along the chain

/// f at n → ∞, if f differs from it by c/n² + O(1/n⁴), from f(n) and f(2n)
double extrapolated(double f, double fOfTwice) {
  return (4 * fOfTwice - f) / 3;
}

// ---- Exact for any number of links -----------------------------------------------------------------
// Roundings grow with the number of links: measured at 10,000 links, 5e-13; below a thousand, 1e-13.

TEST(Exact, HangingBeadsVibrateAtTheZerosOfLaguerresPolynomial) {
  for (const int n : {3, 10, 100, 1000, 10000}) {
    for (const long double j : test::besselZeros) {
      const auto exact = static_cast<double>(std::sqrt(test::hangingFrequencySquared(n, j) * 9.81L * n));
      const double w = frequency(test::beads(n, 1. / n, gravity).chain, 0, 0, exact * 1.001);
      EXPECT_NEAR(w / exact, 1, 2e-12) << n << " beads";
    }
  }
}

TEST(Exact, SpinningBeadsVibrateAtTheFrequenciesOfTheThread) {
  // In zero gravity the pin turns n beads with Ω. With T_j = m Ω² l (n (n + 1) − j (j − 1))/2 the recursion
  // of their deflections takes polynomials of degree d in j into such, so (ω/Ω)² = d (d + 1)/2 − 1, d odd.
  const double spin = 3;
  for (const int n : {4, 10, 100, 1000, 10000}) {
    for (const double square : {5., 14., 27.}) {
      const double exact = spin * std::sqrt(square);
      const double w = frequency(test::beads(n, 1. / n, {}).chain, 0.5, spin, exact * 1.001);
      EXPECT_NEAR(w / exact, 1, 2e-12) << n << " beads";
    }
  }
}

TEST(Exact, JointedBarsVibrateAsTheirDifferenceEquationSays) {
  for (const int n : {2, 10, 100, 1000, 10000}) {
    for (const double beam : {3.516015, 22.034492, 61.697214}) {
      if (n == 2 && beam > 30) continue;
      const auto exact = static_cast<double>(test::barFrequency(n, beam));
      const double w = frequency(test::jointedBar(n, 0).chain, 0, 0, exact * 1.001);
      EXPECT_NEAR(w / exact, 1, 2e-12) << n << " rods";
    }
  }
}

TEST(Exact, TwoHangingRods) {
  const Scene rods = test::uniformChain(2, {"", 1, 1. / 12, {0.5, 0}, {1, 0}}, {}, {}, {1, 0});
  for (const double sign : {-1., 1.}) {
    const double exact = std::sqrt(3 * (1 + sign * 2 / std::sqrt(7.)));
    EXPECT_NEAR(frequency(rods.chain, 0, 0, exact * 1.001), exact, 1e-14);
    EXPECT_NEAR(exact, sign < 0 ? 0.855694549 : 2.295165972, 1e-9);
  }
}

// ---- Published limits ----------------------------------------------------------------------------

TEST(Limit, OfHangingRodsIsTheThread) {
  // j_{0,k}/2 √(g/L); for a hundred rods: published. The error falls as 1/n².
  const double thread[] = {3.766067, 8.644696, 13.552136}, hundred[] = {3.766079, 8.645587, 13.558182};
  const auto rods = [](int n) {
    const double l = 1. / n;
    return test::uniformChain(n, {"", l, l * l * l / 12, {l / 2, 0}, {l, 0}}, {}, {}, gravity).chain;
  };
  for (const int k : {0, 1, 2}) {
    const double limit = static_cast<double>(test::besselZeros[k]) / 2 * std::sqrt(9.81);
    EXPECT_NEAR(limit, thread[k], 5e-7);
    EXPECT_NEAR(frequency(rods(100), 0, 0, limit), hundred[k], 5e-7);
    const double w = frequency(rods(200), 0, 0, limit), twice = frequency(rods(400), 0, 0, limit);
    EXPECT_NEAR(extrapolated(w, twice), limit, 1e-6);
    EXPECT_NEAR((w - limit) / (twice - limit), 4, 0.01);
  }
}

TEST(Limit, OfHangingBeadsIsTheThreadWithItsSlope) {
  // A thread of length L = (n + ½) l, so that the last bead is the middle of its piece:
  // ω → j/2 √(g/L) (1 + (j² − 2)/(96 (n + ½)²)).
  for (const long double j : test::besselZeros) {
    for (const int n : {100, 200}) {
      const double limit = static_cast<double>(j) / 2 * std::sqrt(9.81), middle = n + 0.5;
      const double w = frequency(test::beads(n, 1 / middle, gravity).chain, 0, 0, limit);
      const double slope = static_cast<double>(j * j - 2) / 96;
      EXPECT_NEAR((w / limit - 1) * middle * middle, slope, 1e-3 * slope);
    }
  }
}

TEST(Limit, OfJointedBarsIsTheCantilever) {
  // (β L)², published to six decimals; extrapolated, the third one is off by 9e-7.
  for (const double beam : {3.516015, 22.034492, 61.697214}) {
    const double w = frequency(test::jointedBar(100, 0).chain, 0, 0, beam);
    const double twice = frequency(test::jointedBar(200, 0).chain, 0, 0, beam);
    const double limit = extrapolated(w, twice);
    EXPECT_NEAR(limit, beam, 1e-6);
    EXPECT_NEAR((w - limit) / (twice - limit), 4, 0.01);
  }
}

}  // namespace
}  // namespace planar_chain
