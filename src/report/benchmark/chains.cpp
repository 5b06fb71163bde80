#include "report/benchmark/chains.h"

#include <random>

namespace planar_chain::benchmarks {

namespace {

Chain uniform(int n, double length, double mass) {
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 1; i <= n; ++i) {
    const std::string name = "rod_" + std::to_string(i);
    links.push_back({name, mass, mass * length * length / 12, {length / 2, 0}, {length, 0}});
    joints.push_back({name + "_joint"});
  }
  return Chain(links, joints, {0, -9.81});
}

Posture within(int n, double angle) {
  std::mt19937_64 engine(20);
  std::uniform_real_distribution<double> theta(-angle, angle), omega(-1, 1);
  Posture posture;
  double thetaBefore = 0, omegaBefore = 0;
  for (int i = 0; i < n; ++i) {
    const double thetaNow = theta(engine), omegaNow = omega(engine);
    posture.q.push_back(thetaNow - thetaBefore);
    posture.qd.push_back(omegaNow - omegaBefore);
    thetaBefore = thetaNow;
    omegaBefore = omegaNow;
  }
  return posture;
}

}  // namespace

const std::vector<int>& sizes() {
  static const std::vector<int> sizes{1, 2, 3, 4, 5, 8, 10, 16, 32, 100, 200, 1000, 10000};
  return sizes;
}

Chain rods(int n) {
  return uniform(n, 1, 1);
}

Posture nearlyStraight(int n) {
  return within(n, 0.1);
}

Posture crooked(int n) {
  return within(n, pi);
}

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> shapes{{"straight", nearlyStraight}, {"crooked", crooked}};
  return shapes;
}

Scene sceneOf(const Chain& chain, const Posture& posture) {
  return {chain, posture.q, posture.qd, {}, {}, {}, 0};
}

Scene hanging(int n) {
  const auto size = static_cast<std::size_t>(n);
  Posture posture{std::vector<double>(size, 0.0), std::vector<double>(size, 0.0)};
  posture.q[0] = -pi / 2 + 0.1;
  return sceneOf(uniform(n, 1.0 / n, 1.0 / n), posture);
}

}  // namespace planar_chain::benchmarks
