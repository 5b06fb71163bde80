#include "report/families.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace planar_chain::tools {

namespace {

/// A chain of 1 m in all, made of n rods, at rest. mass(i), kg; lean(x): angle of the link at x, from 0
/// (ground) to 1 (tip), against straight down. Springs k and dampers d in all joints but the ground's.
struct Recipe {
  int n = 10;
  std::function<double(int)> mass;
  std::function<double(double)> lean;
  double k = 0, d = 0;
};

Scene make(const Recipe& recipe) {
  const double length = 1.0 / recipe.n;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<double> q;  // absolute until all are known
  for (int i = 0; i < recipe.n; ++i) {
    const std::string name = "link_" + std::to_string(i + 1);
    const double mass = recipe.mass(i);
    links.push_back({name, mass, mass * length * length / 12, {length / 2, 0}, {length, 0}});
    Joint joint{name + "_joint"};
    if (i > 0) {
      joint.stiffness = recipe.k;
      joint.damping = recipe.d;
    }
    joints.push_back(joint);
    q.push_back(-pi / 2 + recipe.lean((i + 0.5) / recipe.n));
  }
  toRelative(q.data(), recipe.n, q.data());
  std::vector<double> qd(q.size(), 0.0);
  return {Chain(std::move(links), std::move(joints), {0, -9.81}), std::move(q), std::move(qd), {}, {}, {}, 0};
}

/// Swung out by 0.1 rad, and a smooth bend on top.
std::function<double(double)> leanWithBend(double bend) {
  return [bend](double x) { return 0.1 + bend * std::sin(pi * x); };
}

/// Ten links with springs k and dampers d in the inner joints.
Scene springyBar(double k, double d) {
  // Bent as a moment of about 1 N m would, if that is little.
  const double bend = 0.02 * std::min(1.0, 10 / k);
  return make({10, [](int) { return 0.1; }, leanWithBend(bend), k, d});
}

/// Twenty links, the last one heavier by this ratio.
Scene heavyTip(double ratio, double bend) {
  return make({20, [ratio](int i) { return 0.05 * (i == 19 ? ratio : 1); }, leanWithBend(bend)});
}

/// Twenty links, first over last mass as given.
Scene tapered(double ratio) {
  return make({20, [ratio](int i) { return 0.05 * std::pow(ratio, -i / 19.0); }, leanWithBend(0.02)});
}

/// Let go straight and level.
Scene whip(int n) {
  return make({n, [n](int) { return 1.0 / n; }, [](double) { return pi / 2; }});
}

/// Without gravity about the ground pin: only tension holds it straight.
Scene spinning(double rate) {
  Scene scene = make({10, [](int) { return 0.1; }, leanWithBend(0.02)});
  scene.chain = Chain(scene.chain.links(), scene.chain.joints(), {});
  scene.qd[0] = rate;
  return scene;
}

template <class MakeScene>
Family family(const std::string& name, std::string story, std::string varied,
              const std::vector<double>& values, MakeScene&& makeScene, double horizon = 0,
              double smallest = 1e-9, bool isNearRest = true) {
  Family result{name, std::move(story), std::move(varied), {}};
  for (const double value : values) {
    result.cases.push_back({name, value, makeScene(value), horizon, smallest, isNearRest});
  }
  return result;
}

}  // namespace

Scene hangingChain(int n) {
  return make({n, [n](int) { return 1.0 / n; }, leanWithBend(0.02)});
}

std::vector<Family> stabilityFamilies(bool quick) {
  using Numbers = std::vector<double>;
  const Numbers stiffnesses =
      quick ? Numbers{1, 1e3, 1e6, 1e9} : Numbers{1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
  const Numbers ratios = quick ? Numbers{1, 1e4, 1e8} : Numbers{1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8};
  const Numbers lengths = quick ? Numbers{10, 50} : Numbers{1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 10000};
  const Numbers whips = quick ? Numbers{10} : Numbers{10, 20, 50, 100};
  const Numbers spins = quick ? Numbers{1, 100} : Numbers{1, 10, 100, 1e3, 1e4};
  const std::string bar =
      "A bar of 1 m and 1 kg, ten links, springs k in its nine inner joints, swung out by 0.1 rad and bent";
  const std::string swung = ", swung out by 0.1 rad and bent a little";

  return {
      family("stiff", bar + "; no dampers", "k, N m/rad", stiffnesses,
             [](double k) { return springyBar(k, 0); }),
      family("stiff_damped", bar + "; dampers d = 1e-3 s · k beside the springs", "k, N m/rad", stiffnesses,
             [](double k) { return springyBar(k, 1e-3 * k); }),
      family("damped", "The same with k = 100 N m/rad and dampers d of their own", "d, N m s/rad",
             stiffnesses, [](double d) { return springyBar(100, d); }),
      family("heavy_tip",
             "Twenty links, 1 m, the last one heavier than the others, swung out straight by 0.1 rad",
             "ratio of masses", ratios, [](double ratio) { return heavyTip(ratio, 0); }),
      family("slack_tip", "The same, and bent by 0.01 rad: the light links are flung between pin and tip",
             "ratio of masses", ratios, [](double ratio) { return heavyTip(ratio, 0.01); }),
      family(
          "light_tip",
          "Twenty links, 1 m, each lighter than the one before by the same factor, first to last as given" +
              swung,
          "ratio of masses", ratios, tapered),
      family("long", "A uniform chain of 1 m and 1 kg" + swung, "links", lengths,
             [](double n) { return hangingChain(static_cast<int>(n)); }),
      family(
          "whip", "The same, let go straight and level: it falls, and its tip cracks like a whip", "links",
          whips, [](double n) { return whip(static_cast<int>(n)); }, 2, 1e-4, false),
      family("spin", "Ten links of 1 m and 1 kg in all, bent a little, turning about the pin without gravity",
             "rad/s", spins, spinning, 0, 1e-9, false),
  };
}

}  // namespace planar_chain::tools
