/// Error at the end against CPU time: every method on scenes of every kind. A program, not a test; see
/// main().

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "counted_system.h"
#include "planar_chain/dynamics.h"
#include "planar_chain/loads.h"
#include "planar_chain/ode/methods.h"
#include "planar_chain/scene_reader.h"

using namespace planar_chain;

namespace {

double cpu() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct TimeIsUp {};

/// Counts, and stops a run that takes too long.
class Counted : public test::CountedSystem {
 public:
  Counted(Dynamics& f, double limit) : CountedSystem(f), limit_(cpu() + limit) {}
  void derivative(double t, const double* y, double* dydt) override {
    if ((++calls_ & 255) == 0 && cpu() > limit_) throw TimeIsUp{};
    CountedSystem::derivative(t, y, dydt);
  }

 private:
  double limit_;
  long long calls_ = 0;
};

struct Case {
  Scene scene;
  double end;
};

Scene chainOf(const std::vector<Link>& links, const std::vector<Joint>& joints, Vec2d gravity) {
  Scene scene{Chain(links, joints, gravity), {}, {}, {}, {}, {}, 0};
  scene.q.assign(links.size(), 0);
  scene.qd.assign(links.size(), 0);
  return scene;
}

/// n uniform rods of length l and mass m; the first joint is free or has k0.
Scene rods(int n, double l, double m, double k0, double k, double d0, double d, Vec2d gravity,
           double tipMass = 0) {
  std::vector<Link> links;
  std::vector<Joint> joints;
  for (int i = 0; i < n; ++i) {
    const std::string name = "rod_" + std::to_string(i + 1);
    Link link{name, m, m * l * l / 12, {l / 2, 0}, {l, 0}};
    if (i == n - 1 && tipMass > 0) link = {name, tipMass, tipMass * l * l / 12, {l / 2, 0}, {l, 0}};
    links.push_back(link);
    joints.push_back({name + "_joint", i == 0 ? k0 : k, i == 0 ? d0 : d, 0});
  }
  return chainOf(links, joints, gravity);
}

constexpr double pi = 3.14159265358979323846;

Case makeCase(const std::string& name) {
  const Vec2d down{0, -9.81};
  if (name == "beam") {
    std::ifstream file(SCENES_DIR "/beam.yaml");
    std::ostringstream text;
    text << file.rdbuf();
    return {readSceneText(text.str()), 5};
  }
  // A bar of n rods that swings from its first, free pin.
  if (name == "bar20") return {rods(20, 1, 1, 0, 1e5, 0, 1e2, down), 3};
  if (name == "stiff_d2") return {rods(4, 1, 1, 0, 1e9, 0, 1e2, down), 1};
  if (name == "stiff_d6") return {rods(4, 1, 1, 0, 1e9, 0, 1e6, down), 1};
  if (name == "undamped") return {rods(4, 1, 1, 0, 1e7, 0, 0, down), 0.1};
  if (name == "rope100") {
    Case c{rods(100, 0.01, 0.01, 0, 0, 0, 0, down), 1};
    double before = 0;
    for (int i = 0; i < 100; ++i) {
      const double theta = -pi / 2 + 0.5 * std::sin(pi * (i + 0.5) / 100);
      c.scene.q[static_cast<std::size_t>(i)] = theta - before;
      before = theta;
    }
    return c;
  }
  if (name == "heavy_tip") {
    Case c{rods(200, 0.005, 0.005, 0, 0, 0, 0, down, 0.005 * 2e5), 0.1};
    c.scene.q[0] = -pi / 2 + 0.1;
    return c;
  }
  if (name == "cantilever1000") {
    // EI = 100 N m², L = 1 m, 1 kg: first mode 35 rad/s; Kelvin–Voigt time 1 ms. Falls under gravity.
    const double k = 100.0 * 1000;
    return {rods(1000, 0.001, 0.001, 2 * k, k, 2e-3 * k, 1e-3 * k, down), 1};
  }
  if (name == "cantilever100") {
    const double k = 100.0 * 100;
    return {rods(100, 0.01, 0.01, 2 * k, k, 2e-3 * k, 1e-3 * k, down), 1};
  }
  throw std::runtime_error("no scene " + name);
}

ode::Tolerance toleranceOf(double value, int n) {
  ode::Tolerance tolerance{value, Eigen::ArrayXd::Constant(2 * n, std::numeric_limits<double>::infinity())};
  tolerance.ceiling.head(n) = pi;
  return tolerance;
}

struct Result {
  bool ok = false;
  double seconds = 0;
  Eigen::VectorXd y;
  long long steps = 0, rejected = 0, evaluations = 0, linearizations = 0, solves = 0, complexSolves = 0;
};

Result run(const Case& c, const std::string& method, double tolerance, double limit) {
  const int n = c.scene.chain.size();
  Scene scene = c.scene;
  Loads loads(scene, 0);
  Dynamics dynamics(scene.chain, loads);
  Counted f(dynamics, limit);
  const auto integrator = ode::makeMethod(method, f, 1e-3, toleranceOf(tolerance, n));
  ode::State state(dynamics.size());
  double theta = 0, omega = 0;
  for (int i = 0; i < n; ++i) {
    state.y[i] = theta += scene.q[static_cast<std::size_t>(i)];
    state.y[n + i] = omega += scene.qd[static_cast<std::size_t>(i)];
  }
  dynamics.enter(0);
  Result result;
  const double start = cpu();
  try {
    result.ok = true;
    while (state.t < c.end && result.ok) {
      const double end = std::min(c.end, loads.until());
      result.ok = integrator->integrate(state, end, loads.longestStep()) == ode::Outcome::arrived;
      if (state.t >= loads.until()) {
        dynamics.enter(state.t);
        integrator->restart();
      }
    }
  } catch (const TimeIsUp&) {
    result.ok = false;
  }
  result.seconds = cpu() - start;
  result.y = state.y.head(2 * n);
  result.steps = integrator->count().accepted;
  result.rejected = integrator->count().rejected;
  result.evaluations = f.evaluations;
  result.linearizations = f.linearizations;
  result.solves = f.solves;
  result.complexSolves = f.complexSolves;
  return result;
}

struct Error {
  double all, angle;
};

/// In units of 1 + |y_i|, angles counted up to π, as the error control does.
Error errorOf(const Eigen::VectorXd& y, const Eigen::VectorXd& reference) {
  const Eigen::Index n = y.size() / 2;
  Error error{0, 0};
  for (Eigen::Index i = 0; i < 2 * n; ++i) {
    const double size = 1 + (i < n ? std::min(std::abs(reference[i]), pi) : std::abs(reference[i]));
    const double ratio = std::abs(y[i] - reference[i]) / size;
    if (std::isnan(ratio)) return {NAN, NAN};
    error.all = std::max(error.all, ratio);
    if (i < n) error.angle = std::max(error.angle, ratio);
  }
  return error;
}

Eigen::VectorXd published() {
  std::ifstream file(REFERENCE_DIR "/beam.csv");
  std::string line;
  std::getline(file, line);
  Eigen::VectorXd y(80);
  for (int i = 0; i < 80 && std::getline(file, line); ++i) {
    y[i] = std::strtod(line.c_str() + line.find(',') + 1, nullptr);
  }
  return y;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

}  // namespace

/// work_precision SCENES METHODS TOLERANCES REPEATS LIMIT, lists with commas, LIMIT in s of CPU time a run.
/// Writes lines of scene, method, tolerance, error, error of the angles, ms (median), ms (least), steps,
/// rejected, evaluations, linearizations, solves, complex solves; lines with # say how the reference agrees
/// with another method. A run that exceeds LIMIT is left out, and so are the method's tighter ones.
int main(int argc, char** argv) {
  if (argc != 6) return 2;
  const std::vector<std::string> methods = split(argv[2]);
  const int repeats = std::atoi(argv[4]);
  const double limit = std::atof(argv[5]);
  for (const std::string& name : split(argv[1])) {
    const Case c = makeCase(name);
    const bool stiff = name != "rope100" && name != "undamped" && name != "beam";
    const Result first = run(c, "radau13", 1e-10, 60), other = run(c, stiff ? "rodas5p" : "dop853", 1e-9, 60);
    const Eigen::VectorXd reference = name == "beam" ? published() : first.y;
    std::printf("# %s: reference, finished %d, and another method, finished %d, agree to %.1e, angles %.1e\n",
                name.c_str(), first.ok, other.ok, errorOf(other.y, reference).all,
                errorOf(other.y, reference).angle);
    std::map<std::string, bool> tooSlow;
    for (const std::string& tolerance : split(argv[3])) {
      std::map<std::string, std::vector<double>> times;
      std::map<std::string, Result> results;
      for (int k = 0; k < repeats; ++k) {
        for (const std::string& method : methods) {
          if (tooSlow[method]) continue;
          const Result r = run(c, method, std::atof(tolerance.c_str()), limit);
          times[method].push_back(r.seconds);
          results[method] = r;
          tooSlow[method] = !r.ok;
        }
      }
      for (const auto& [method, r] : results) {
        if (!r.ok) continue;
        std::vector<double>& t = times[method];
        std::sort(t.begin(), t.end());
        const Error e = errorOf(r.y, reference);
        std::printf("%s,%s,%s,%.4e,%.4e,%.5f,%.5f,%lld,%lld,%lld,%lld,%lld,%lld\n", name.c_str(),
                    method.c_str(), tolerance.c_str(), e.all, e.angle, 1e3 * t[t.size() / 2], 1e3 * t[0],
                    r.steps, r.rejected, r.evaluations, r.linearizations, r.solves, r.complexSolves);
      }
      std::fflush(stdout);
    }
  }
}
