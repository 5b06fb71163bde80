#pragma once

/// Uniform chains whose vibrations are known exactly, for any number of links.

#include <cmath>
#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain::test {

constexpr double pi = 3.14159265358979323846;

/// Of J_0.
constexpr long double besselZeros[] = {2.404825557695772768622L, 5.520078110286310649597L,
                                       8.653727912911012216954L};

/// n equal links along +x, at rest.
inline Scene uniformChain(int n, const Link& link, Joint first, Joint joint, Vec2d gravity) {
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 1; i <= n; ++i) {
    links.push_back(link);
    links.back().name = "link_" + std::to_string(i);
    joints.push_back(i == 1 ? first : joint);
    joints.back().name = "joint_" + std::to_string(i);
  }
  const std::vector<double> zero(static_cast<std::size_t>(n), 0.0);
  return {Chain(links, joints, gravity), zero, zero, {}, {}, {}, 0};
}

/// n beads of 1 kg on a thread, l apart, the last at its end.
inline Scene beads(int n, double l, Vec2d gravity) {
  return uniformChain(n, {"", 1, 0, {l, 0}, {l, 0}}, {}, {}, gravity);
}

/// A bar of 1 m, 1 kg and bending stiffness 1 N m² as n rods: each joint bends like one link, the first one
/// like half.
inline Scene jointedBar(int n, double damping) {
  const double l = 1. / n, m = 1. / n;
  return uniformChain(n, {"", m, m * l * l / 12, {l / 2, 0}, {l, 0}}, {"", 2. * n, 2. * n * damping, 0},
                      {"", 1. * n, 1. * n * damping, 0}, {});
}

/// Laguerre's polynomials L_0(x) … L_n(x). Let bead i of a hanging thread, counted from its end, be off by
/// u_i: then
///
///     −ω² l/g u_i = (i + 1) (u_{i+1} − u_i) − i (u_i − u_{i−1}),      u_n = 0 at the pin,
///
/// which is the recursion of u_i = L_i(x), x = ω² l/g, a zero of L_n.
inline std::vector<long double> laguerre(int n, long double x) {
  std::vector<long double> L{1, 1 - x};
  for (int i = 1; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    L.push_back(((2 * i + 1 - x) * L[k] - i * L[k - 1]) / (i + 1));
  }
  return L;
}

/// ω² l/g of n hanging beads, n > 1: the zero of L_n that tends to j²/(4 n + 2), j a zero of J_0.
inline long double hangingFrequencySquared(int n, long double j) {
  const long double nu = 4 * n + 2;
  long double x = j * j / nu * (1 + (j * j - 2) / (3 * nu * nu));
  for (int k = 0; k < 5; ++k) {
    const std::vector<long double> L = laguerre(n, x);
    const auto last = static_cast<std::size_t>(n);
    x -= x * L[last] / (n * (L[last] - L[last - 1]));  // x L_n' = n (L_n − L_{n−1})
  }
  return x;
}

/// ω, rad/s, of the jointed bar, below what the guess says of the beam. With w_j the deflection of joint j, D
/// w its second difference, k = n the joint's stiffness, l = m = 1/n,
///
///     k/l² (D D w)_j = ω² m/6 (w_{j−1} + 4 w_j + w_{j+1}),
///
/// so w is made of cos β_1 j, sin β_1 j, cosh β_2 j, sinh β_2 j with u = 1 − cos β of either sign,
/// 4 k/l² u² = ω² m (1 − u/3). At the clamp w_0 = 0 and w_{−1} = w_1 (which is why that joint has stiffness
/// 2 k); at the end (D w)_n = 0 and k/l² (D w)_{n−1} = ω² m/6 (2 w_n + w_{n−1}).
inline long double barFrequency(int n, long double guess) {
  const auto determinant = [n](long double w) {
    using std::sqrt;
    const long double stiffness = static_cast<long double>(n) * n * n, inertia = w * w / n;
    const long double half = inertia / 24 / stiffness;
    const long double root = sqrt(half * half + inertia / 4 / stiffness);
    const long double u1 = inertia / 4 / stiffness / (root + half), u2 = -half - root;
    const long double b1 = 2 * std::asin(sqrt(u1 / 2)), b2 = 2 * std::asinh(sqrt(-u2 / 2));
    const long double ratio = std::sin(b1) / std::sinh(b2);
    long double conditions[2][2];
    for (const int which : {0, 1}) {
      // w = cos β_1 j − cosh β_2 j; and sin β_1 j − ratio sinh β_2 j
      const auto trig = [&](int j) { return which == 0 ? std::cos(b1 * j) : std::sin(b1 * j); };
      const auto hyper = [&](int j) { return which == 0 ? -std::cosh(b2 * j) : -ratio * std::sinh(b2 * j); };
      const auto bend = [&](int j) { return -2 * u1 * trig(j) - 2 * u2 * hyper(j); };
      conditions[0][which] = bend(n) / u1;
      conditions[1][which] =
          stiffness * bend(n - 1) - inertia / 6 * (2 * (trig(n) + hyper(n)) + trig(n - 1) + hyper(n - 1));
    }
    return conditions[0][0] * conditions[1][1] - conditions[0][1] * conditions[1][0];
  };
  long double low = 0.6L * guess, high = 1.01L * guess;
  const bool risesFromBelow = determinant(low) < 0;
  for (int k = 0; k < 80; ++k) {
    const long double middle = (low + high) / 2;
    ((determinant(middle) < 0) == risesFromBelow ? low : high) = middle;
  }
  return low;
}

}  // namespace planar_chain::test
