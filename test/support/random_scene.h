#pragma once

/// Random scenes for tests, from fixed seeds: general offsets, springs, dampers, gravity in any direction,
/// loads of every kind.

#include <random>
#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * std::uniform_real_distribution<double>()(engine_);
  }
  Vec2d vector(double size) { return {between(-size, size), between(-size, size)}; }
  int index(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }

 private:
  std::mt19937_64 engine_;
};

struct With {
  bool springs = true;
  bool dampers = true;
  bool loads = true;
};

inline Scene randomScene(int n, unsigned seed, With with = {}) {
  Random random(seed);
  std::vector<Link> links;
  std::vector<Joint> joints;
  Scene scene{Chain({{"only", 1, 1, {}, {1, 0}}}, {{"only_joint"}}, {}), {}, {}, {}, {}, {}, 0};
  for (int i = 0; i < n; ++i) {
    const std::string name = "link_" + std::to_string(i + 1);
    Link link{name, random.between(0.2, 3), random.between(0.01, 0.5), random.vector(0.6), random.vector(1)};
    links.push_back(link);
    Joint joint{name + "_joint"};
    if (with.springs) joint.stiffness = random.between(0, 20);
    if (with.dampers) joint.damping = random.between(0, 2);
    joint.restAngle = random.between(-1, 1);
    joints.push_back(joint);
    scene.q.push_back(random.between(-3, 3));
    scene.qd.push_back(random.between(-2, 2));
  }
  scene.chain = Chain(links, joints, random.vector(10));
  if (with.loads) {
    const std::vector<TimeLaw> laws{Constant{}, Sine{random.between(0.1, 2), random.between(-3, 3)},
                                    Ramp{{0, 0.3, 0.5, 2}, {0, 1, -0.5, 0.25}}};
    for (const TimeLaw& law : laws) {
      Load load;
      load.name = "load_" + std::to_string(scene.loads.size());
      load.link = random.index(n);
      load.force = random.vector(5);
      load.point = random.vector(1);
      load.moment = random.between(-2, 2);
      load.joint = random.index(n);
      load.torque = random.between(-3, 3);
      load.law = law;
      scene.loads.push_back(load);
    }
  }
  return scene;
}

}  // namespace planar_chain::test
