/// What instructions.py counts: scenes read, simulations made, evaluations, the exact solve and steps, on
/// short and long chains. A program, not a test; it writes what it has called, and how often. With any
/// argument it writes nanoseconds instead, for slowdown.py.

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <complex>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "counted.h"
#include "dynamics/dynamics.h"
#include "lanes/kernel.h"
#include "ode/methods.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/random_scene.h"

using namespace planar_chain;

namespace {

bool isTimed = false;

/// The lower decile of many repetitions, each of about 0.1 ms: what else the machine does meets few of them.
double nanosecondsOf(const std::function<void()>& operation) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::duration<double, std::nano> repetition{1e5};
  int calls = 0;
  for (const auto start = Clock::now(); Clock::now() - start < repetition;) ++calls, operation();
  std::vector<double> times(50);
  for (double& time : times) {
    const auto start = Clock::now();
    for (int k = 0; k < calls; ++k) operation();
    time = std::chrono::duration<double, std::nano>(Clock::now() - start).count() / calls;
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 10];
}

void count(const std::string& what, const char* chain, int links, int times,
           const std::function<void()>& operation) {
  operation();
  if (!isTimed) counted(operation, times);
  std::printf("%s,%s,%d,%g\n", what.c_str(), chain, links, isTimed ? nanosecondsOf(operation) : times);
}

/// fit and derivatives by numbers read many scenes.
void countReading() {
  const Value values = parseScene(
      "{chain: [upper, lower], links: {"
      "upper: {mass: 1, inertia: 0.08, com: [0.5, 0], pin: [1, 0], joint: {damping: 0.05}},"
      "lower: {mass: 1, inertia: 0.08, com: [0.5, 0], pin: [1, 0], joint: {damping: 0.02}}}}");
  count("scene read", "dampers", 2, 50, [&] { readScene(values); });
}

Scene randomScene(int n, bool sprung) {
  return test::randomScene(n, static_cast<unsigned>(n), {sprung, sprung, false});
}

Scene withARotor(Scene scene) {
  std::vector<Joint> joints = scene.chain.joints();
  joints[joints.size() / 2].others.emplace_back("rotor_inertia", 0.1);
  scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  return scene;
}

/// Pinned where its tip is.
Scene withHeldTip(Scene scene) {
  double theta = 0;
  Vec2d tip;
  for (std::size_t i = 0; i < scene.q.size(); ++i) {
    tip += Rotation<double>::of(theta += scene.q[i]) * scene.chain.links()[i].pin;
    scene.qd[i] = 0;
  }
  scene.tip = TipLaws{MotionLaw::sine(0, 0, 0, tip.x), MotionLaw::sine(0, 0, 0, tip.y)};
  return scene;
}

/// On a cart of 1 kg: a link more.
Scene onACart(Scene scene) {
  std::vector<Link> links = scene.chain.links();
  std::vector<Joint> joints = scene.chain.joints();
  links.insert(links.begin(), Link{"cart", 1, 0, {0, 0}, {0, 0.1}});
  joints.insert(joints.begin(), Joint{"cart_joint"});
  joints.front().isPrismatic = true;
  scene.chain = Chain(links, joints, scene.chain.gravity());
  scene.q.insert(scene.q.begin(), 0.3);
  scene.qd.insert(scene.qd.begin(), 0.7);
  return scene;
}

class Chains {
 public:
  /// step: of the time from one evaluation to the next, s. A coupled chain does not evaluate a state again.
  Chains(const char* chain, Scene scene, double step = 0)
      : n_(scene.chain.size()),
        chain_(chain),
        scene_(std::move(scene)),
        step_(step),
        dynamics_(scene_),
        y_(Eigen::VectorXd::Zero(dynamics_.size())),
        slope_(y_),
        rates_(Eigen::VectorXd::Zero(dynamics_.sizeInLaneOrder())),
        solution_(rates_),
        complexRhs_(static_cast<std::size_t>(dynamics_.sizeInLaneOrder()), {1, 1}),
        complexSolution_(complexRhs_) {
    double theta = 0, omega = 0;
    for (int i = 0; i < n_; ++i) {
      y_[i] = theta += scene_.q[static_cast<std::size_t>(i)];
      y_[n_ + i] = omega += scene_.qd[static_cast<std::size_t>(i)];
    }
    start_ = ode::State(dynamics_, y_);
    dynamics_.reserve(1);
  }

  bool countAll() {
    const double* y = start_.y.data();
    if (n_ <= 11) count("simulation made", [&] { Simulation simulation(scene_); });
    count("evaluation in order", [&] { dynamics_.derivative(time(), y_.data(), slope_.data()); });
    count("evaluation", [&] { dynamics_.rates(time(), y, rates_.data() + dynamics_.positions()); });
    count("linearize", [&] { dynamics_.linearize(time(), y, rates_.data()); });
    count("factor", [&] { dynamics_.factor(1e3); });
    count("solve", [&] { dynamics_.solve(rates_.data(), solution_.data()); });
    count("complex factor", [&] { dynamics_.factorComplex(0, {1e3, 1e3}); });
    count("complex solve", [&] { dynamics_.solveComplex(0, complexRhs_.data(), complexSolution_.data()); });
    bool good = slope_.allFinite() && rates_.allFinite() && solution_.allFinite();
    for (const char* method : {"rk4", "dopri5", "rodas5p"}) good = countSteps(method) && good;
    return good;
  }

 private:
  double time() { return t_ += step_; }

  /// So many that what is done once does not count, but fewer than the steps after which AdaptiveSteps looks
  /// around.
  int times() const { return n_ <= 10 ? 50 : n_ <= 100 ? 10 : 3; }

  void count(const std::string& what, const std::function<void()>& operation) const {
    ::count(what, chain_, n_, times(), operation);
  }

  /// Steps so short that none is rejected.
  bool countSteps(const char* method) {
    constexpr double step = 1e-5;
    constexpr double forever = std::numeric_limits<double>::infinity();
    const ode::Tolerance tolerance{1, Eigen::ArrayXd::Constant(2 * n_, forever)};
    const auto integrator = ode::makeMethod(method, dynamics_, step, tolerance);
    ode::State state = start_;
    bool good = true;
    count(std::string("step of ") + method,
          [&] { good = integrator->advance(state, 1, step) == ode::Outcome::underway && good; });
    return good && integrator->count().rejected == 0;
  }

  int n_;
  const char* chain_;
  Scene scene_;
  double step_;
  Dynamics dynamics_;
  double t_ = 0;
  ode::State start_;
  Eigen::VectorXd y_, slope_, rates_, solution_;
  std::vector<std::complex<double>> complexRhs_, complexSolution_;
};

}  // namespace

int main(int argc, char**) {
  isTimed = argc > 1;
#ifdef __clang__
  const char* compiler = "clang++";
#else
  const char* compiler = "g++";
#endif
  std::printf("%s %s, glibc %d.%d, Eigen %d.%d, %s, kernel %s\n", compiler, __VERSION__, __GLIBC__,
              __GLIBC_MINOR__, EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, BUILD,
              simd::kernels().front()->name);
  countReading();
  for (const bool sprung : {false, true}) {
    for (const int n : {1, 2, 10, 100, 1000}) {
      const char* name = sprung ? "springs and dampers" : "bare";
      if (!Chains(name, randomScene(n, sprung)).countAll()) return 1;
    }
  }
  bool good = true;
  for (const int n : {3, 10, 100, 1000}) {
    const Scene scene = randomScene(n, false);
    good = Chains("one rotor", withARotor(scene), 1).countAll() && good;
    good = Chains("held tip", withHeldTip(scene), 1).countAll() && good;
    good = Chains("on a cart", onACart(scene), 1).countAll() && good;
  }
  return good ? 0 : 1;
}
