/// Compares q̈ of the C code that `formulas` writes with the kernel that the program runs
/// (lanes/short_chain.h). formulas_speed.py compiles it for 2 and 3 links: LINKS, and QDD, the name of the
/// function.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "lanes/kernel.h"
#include "lanes/short_chain.h"

extern "C" void QDD(double t, const double* q, const double* qd, double* qdd);

namespace {

using namespace planar_chain;

constexpr int n = LINKS, states = 512, rounds = 2001;

/// The mean time of a call of evaluate(k), k = 0 … states − 1, ns.
template <class Evaluate>
double nanoseconds(Evaluate evaluate) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  for (int k = 0; k < states; ++k) evaluate(k);
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count() / states;
}

double median(std::array<double, rounds> values) {
  std::nth_element(values.begin(), values.begin() + rounds / 2, values.end());
  return values[rounds / 2];
}

Chain rods() {
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 0; i < n; ++i) {
    links.push_back({"link_" + std::to_string(i), 1.0, 1.0 / 12, {0.5, 0}, {1, 0}});
    joints.push_back({links.back().name + "_joint"});
  }
  return Chain(links, joints, {0, -9.81});
}

}  // namespace

int main() {
  // Each state in relative angles for C, and in absolute ones for the kernel.
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-3, 3);
  std::array<std::array<double, 2 * n>, states> relative{}, absolute{}, found{}, known{};
  for (int k = 0; k < states; ++k) {
    for (double& x : relative[k]) x = any(random);
    toAbsolute(relative[k].data(), n, absolute[k].data());
    toAbsolute(relative[k].data() + n, n, absolute[k].data() + n);
  }
  const Chain chain = rods();
  ShortChain kernel(chain, simd::kernelFor(n, {}));
  std::vector<Rotation<double>> e(static_cast<std::size_t>(ShortChain::roomFor(n)));
  const Loads external{e.data(), nullptr, nullptr, {0, 9.81}};
  const auto inC = [&](int k) { QDD(0, relative[k].data(), relative[k].data() + n, found[k].data()); };
  const auto inKernel = [&](int k) {
    kernel.derivative(LoadKind::nothing, external, absolute[k].data(), known[k].data());
  };

  std::array<double, rounds> c{}, own{}, ratio{};  // by turns, as CPU speed drifts
  for (int round = 0; round < rounds; ++round) {
    c[round] = nanoseconds(inC);
    own[round] = nanoseconds(inKernel);
    ratio[round] = c[round] / own[round];
  }
  double off = 0, largest = 0;
  for (int k = 0; k < states; ++k) {
    for (int i = 0; i < n; ++i) {
      const double qdd = planar_chain::relative(known[k].data() + n, i);
      off = std::max(off, std::abs(found[k][i] - qdd));
      largest = std::max(largest, std::abs(qdd));
    }
  }
  std::printf("%d links: C %.1f ns; kernel (%s) %.1f ns, ratio %.2f, difference %.1e\n", n, median(c),
              kernel.name().c_str(), median(own), median(ratio), off / largest);
  return off / largest < 1e-12 ? 0 : 1;
}
