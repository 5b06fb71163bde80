/// The exact solve of chains that are not bare against differences of the program's own f: rotors, drives,
/// stuck joints, a base that moves; real and complex shifts; angles, rates and works.

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <complex>
#include <fstream>
#include <sstream>
#include <string>

#include "dynamics/dynamics.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

using Complex = std::complex<double>;
using Eigen::VectorXcd;
using Eigen::VectorXd;

Scene sceneOf(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return readSceneText(text.str());
}

class ExactSolves : public ::testing::TestWithParam<const char*> {
 protected:
  const Scene scene_ = sceneOf(REFERENCE_DIR "/machines/" + std::string(GetParam()) + ".yaml");
  Dynamics dynamics_{scene_};
  const int n_ = scene_.chain.size(), size_ = dynamics_.size();
  const double t_ = 0.375;
  VectorXd y_ = VectorXd::Zero(size_);

  void SetUp() override {
    scene_.chain.coordinates().toAbsolute(scene_.q.data(), y_.data());
    scene_.chain.coordinates().toAbsolute(scene_.qd.data(), y_.data() + n_);
    dynamics_.enter(t_);
    dynamics_.enterState(t_, y_.data());
    dynamics_.reserve(1);
    VectorXd slope(size_);
    dynamics_.linearize(t_, y_.data(), slope.data());
  }

  /// J x, by differences of fourth order.
  VectorXd along(const VectorXd& x) {
    const double h = 1e-3 / x.norm();
    const auto slope = [&](double step) {
      const VectorXd at = y_ + step * x;
      VectorXd dydt(size_);
      dynamics_.derivative(t_, at.data(), dydt.data());
      return dydt;
    };
    return (8 * (slope(h) - slope(-h)) - (slope(2 * h) - slope(-2 * h))) / (12 * h);
  }
  VectorXcd along(const VectorXcd& x) {
    return along(VectorXd(x.real())) + Complex(0, 1) * along(VectorXd(x.imag()));
  }

  /// s x − J x gives back the right-hand side, as closely as the differences do.
  template <class Vector, class Scalar>
  void expectSolved(const Vector& x, Scalar s, const Vector& rhs) {
    const Vector product = along(x), rest = s * x - product - rhs;
    EXPECT_LT(rest.norm(), 1e-9 * (product.norm() + (s * x).norm())) << "s = " << s;
  }
};

TEST_P(ExactSolves, InvertsTheJacobian) {
  for (const double s : {1.0, 30.0, 1e3}) {
    for (unsigned seed = 1; seed < 4; ++seed) {
      std::srand(seed);
      const VectorXd rhs = VectorXd::Random(size_);
      VectorXd x(size_);
      dynamics_.factor(s);
      dynamics_.solve(rhs.data(), x.data());
      expectSolved(x, s, rhs);

      const VectorXcd complexRhs = VectorXcd::Random(size_);
      VectorXcd complexX(size_);
      dynamics_.factorComplex(0, {s, 2 * s});
      dynamics_.solveComplex(0, complexRhs.data(), complexX.data());
      expectSolved(complexX, Complex(s, 2 * s), complexRhs);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Machines, ExactSolves,
                         ::testing::Values("all_5", "base_4", "base_turns_3", "drive_2", "falling_2",
                                           "given_2", "holds_3", "robot_4", "rotors_2", "slow_3", "stack_5"));

}  // namespace
}  // namespace planar_chain
