/// The O(n) recursion against the notes' dense matrices: two independent roads to the same q̈.

#include "support/articulated.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "planar_chain/kane.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

namespace planar_chain {
namespace {

using test::randomScene;

Eigen::VectorXd vectorOf(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// How much M_q q̈ = f, row by row, is off, against the size of what is summed in the row.
double residual(const Kane& kane, const Eigen::VectorXd& qdd) {
  const Eigen::VectorXd size = kane.M_q.cwiseAbs() * qdd.cwiseAbs() + kane.f.cwiseAbs();
  return ((kane.M_q * qdd - kane.f).cwiseAbs().array() / size.array().max(1.0)).maxCoeff();
}

TEST(Articulated, AgreesWithKaneOnRandomChains) {
  // Offsets, loads, springs and dampers. The residual is measured in what is summed, so rounding allows some
  // n ulps; 1e-13 is 450.
  for (int n = 1; n <= 50; ++n) {
    const Scene scene = randomScene(n, static_cast<unsigned>(n));
    Simulation simulation(scene);
    Eigen::VectorXd qdd(n);
    simulation.accelerations(qdd.data());
    const Eigen::VectorXd q = vectorOf(scene.q), qd = vectorOf(scene.qd);
    const Kane dense = kane(scene.chain, q, qd, activeForces(scene, 0, q, qd));
    EXPECT_LT(residual(dense, qdd), 1e-13) << "n = " << n;
    if (n <= 10) {
      EXPECT_LT((dense.qdd - qdd).cwiseAbs().maxCoeff(), 1e-10 * qdd.cwiseAbs().maxCoeff()) << "n = " << n;
    }
  }
}

TEST(Articulated, KeepsItsDigitsOnAStraightChainOfAThousand) {
  // In long double the same recursion is 2000 times finer. Dense Cholesky loses all but six digits here.
  constexpr int n = 1000;
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 0; i < n; ++i) {
    links.push_back({"l" + std::to_string(i), 1, 1. / 12, {0.5, 0}, {1, 0}});
    joints.push_back({"j" + std::to_string(i)});
  }
  const Chain chain(links, joints, {0, -9.81});
  std::vector<Rotation<double>> e;
  std::vector<Rotation<long double>> eLong;
  std::vector<double> omega(n), N(n, 0.0), alpha(n);
  std::vector<long double> omegaLong(n), NLong(n, 0.0L), alphaLong(n);
  test::Random random(1);
  for (int i = 0; i < n; ++i) {
    const double theta = random.between(-0.01, 0.01);
    e.push_back(Rotation<double>::of(theta));
    eLong.push_back({static_cast<long double>(e.back().c), static_cast<long double>(e.back().s)});
    omegaLong[static_cast<std::size_t>(i)] = omega[static_cast<std::size_t>(i)] = random.between(-1, 1);
  }
  Articulated<double>(chain).accelerations(e.data(), omega.data(), N.data(), nullptr, {0, 9.81},
                                           alpha.data());
  Articulated<long double>(chain).accelerations(eLong.data(), omegaLong.data(), NLong.data(), nullptr,
                                                {0, 9.81L}, alphaLong.data());
  long double worst = 0, size = 0;
  for (std::size_t i = 0; i < n; ++i) {
    worst = std::max(worst, std::abs(alphaLong[i] - static_cast<long double>(alpha[i])));
    size = std::max(size, std::abs(alphaLong[i]));
  }
  EXPECT_LT(worst / size, 3e-12L);
}

TEST(Articulated, PinForcesBalanceEveryLink) {
  // m a = F_pin − F_pin,next + m g + F, and about the centre of mass I α = moments: Newton and Euler.
  const Scene scene = randomScene(7, 42);
  Simulation simulation(scene);
  std::vector<LinkMotion> motions(7);
  simulation.linkMotions(motions.data());
  const Eigen::VectorXd q = vectorOf(scene.q), qd = vectorOf(scene.qd);
  const ActiveForces active = activeForces(scene, 0, q, qd);
  for (int j = 0; j < 7; ++j) {
    const auto i = static_cast<std::size_t>(j);
    const Link& link = scene.chain.links()[i];
    const auto e = Rotation<double>::of(motions[i].angle);
    const Vec2d outer = j + 1 < 7 ? motions[i + 1].pinForce : Vec2d{};
    const Vec2d force{active.F[2 * j], active.F[2 * j + 1]};
    const Vec2d missing = link.mass * motions[i].acceleration - (motions[i].pinForce - outer + force);
    EXPECT_NEAR(missing.x, 0, 1e-11);
    EXPECT_NEAR(missing.y, 0, 1e-11);
    const Vec2d toInner = e * (-1.0 * link.com);
    const Vec2d toOuter = e * (link.pin - link.com);
    const double moment = active.M[j] + active.tau[j] - (j + 1 < 7 ? active.tau[j + 1] : 0.0) +
                          cross(toInner, motions[i].pinForce) - cross(toOuter, outer);
    EXPECT_NEAR(link.inertia * motions[i].alpha, moment, 1e-11);
  }
}

TEST(Articulated, JointTorquesAreTheNotesTau) {
  const Scene scene = randomScene(5, 3);
  Simulation simulation(scene);
  Eigen::VectorXd tau(5);
  simulation.jointTorques(tau.data());
  const Eigen::VectorXd q = vectorOf(scene.q), qd = vectorOf(scene.qd);
  EXPECT_LT((tau - activeForces(scene, 0, q, qd).tau).cwiseAbs().maxCoeff(), 1e-13);
}

}  // namespace
}  // namespace planar_chain
