/// How much memory a simulation takes: so much a link, whatever the length, and no more for what it lacks.

#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdio>
#include <memory>
#include <string>

#include "planar_chain/simulation.h"
#include "support/known_chains.h"

namespace planar_chain {
namespace {

/// In use by this program, bytes.
double inUse() {
#if __GLIBC_PREREQ(2, 33)
  const auto all = mallinfo2();
#else
  const auto all = mallinfo();  // counts to 2 GiB
#endif
  return static_cast<double>(all.uordblks) + static_cast<double>(all.hblkhd);
}

/// What a simulation that has gone a little way has more than its scene, bytes a link.
double bytesPerLink(int n, const std::string& method, bool sprung) {
  Joint joint;
  joint.stiffness = sprung ? 1 : 0;
  joint.damping = sprung ? 0.1 : 0;
  Scene scene = test::uniformChain(n, {"", 1, 0.1, {0.5, 0}, {1, 0}}, joint, joint, {0, -9.81});
  scene.qd[0] = 1e-3;
  scene.integrator.method = method;
  scene.integrator.step = 1e-9;
  const double before = inUse();
  const auto simulation = std::make_unique<Simulation>(scene);
  simulation->advanceTo(1e-9);
  return (inUse() - before) / n;
}

struct Method {
  const char* name;
  double kilobytes;  // a link at most
};

class Memory : public testing::TestWithParam<Method> {};

TEST_P(Memory, IsSoMuchALinkWhateverTheLength) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer has an allocator of its own";
#endif
  const std::string method = GetParam().name;
  for (const bool sprung : {false, true}) {
    const double some = bytesPerLink(1000, method, sprung);
    const double many = bytesPerLink(10'000, method, sprung);
    std::printf("%-14s %-12s %6.0f bytes a link\n", method.c_str(), sprung ? "springs" : "bare", many);
    EXPECT_LT(many, 1.05 * some);
    EXPECT_GT(many, 0.75 * some);  // long chains keep less of complex factorizations
    EXPECT_LT(many, 1024 * GetParam().kilobytes);
    EXPECT_GT(many, 100);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, Memory,
                         testing::Values(Method{"rk4", 1}, Method{"dopri5", 1}, Method{"dop853", 1},
                                         Method{"ros34pw2_fixed", 1.5}, Method{"rodas5p", 1.5},
                                         Method{"radau13", 5}, Method{"taylor", 6}, Method{"auto", 6}),
                         [](const auto& instance) { return std::string(instance.param.name); });

}  // namespace
}  // namespace planar_chain
