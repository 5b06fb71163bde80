#pragma once

/// Other programs as contestants of the report: native steppers of multibody programs, and integrators of
/// libraries under this program's equations or under those written by hand.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "report/contest.h"

namespace planar_chain::benchmarks {

using tools::Contest;
using tools::Contestant;
using tools::Progress;

/// A contestant whose runs are made as Made(contest, setting, more...).
template <class Made, class... More>
Contestant contestant(const std::string& engine, const std::string& method, bool hasFixedStep,
                      std::function<bool(const Scene&)> takes, More... more) {
  return {engine, method, hasFixedStep, std::move(takes),
          [=](const Contest& contest, double setting) -> std::unique_ptr<tools::Run> {
            return std::make_unique<Made>(contest, setting, more...);
          }};
}

struct Team {
  std::string name, version;  ///< with the settings that all of its methods have
  std::vector<Contestant> contestants;
};

/// Returns the teams that this program is built with.
const std::vector<Team>& teams();

// Each in a file of its own.
Team byHandTeam();
Team odeintTeam();
/// The study of one pendulum: prints CSV.
void pendulum(const tools::Arguments& given);
Team bulletTeam();
Team dartTeam();
Team mujocoTeam();
Team pinocchioTeam();
Team simbodyTeam();
Team odeTeam();
Team sundialsTeam();

inline bool hasSprings(const Scene& scene) {
  for (const Joint& joint : scene.chain.joints()) {
    if (joint.stiffness != 0 || joint.damping != 0) return true;
  }
  return false;
}

/// The first link hangs on a fixed pin, and the tip is free.
inline bool isPinned(const Scene& scene) {
  return scene.chain.coordinates().leading() == 0 && !scene.tip;
}

/// The tip is free, or held at a point that stands still.
inline bool hasFixedTip(const Scene& scene) {
  return !scene.tip || (!scene.tip->line && !scene.tip->moves());
}

inline Vec2d tipPosition(const Scene& scene) {
  return {scene.tip->x.at(0).value, scene.tip->y.at(0).value};
}

/// Bodies that turn without inertia about their centres of mass.
inline bool hasPoints(const Scene& scene) {
  const auto& links = scene.chain.links();
  return std::any_of(links.begin() + scene.chain.coordinates().leading(), links.end(),
                     [](const Link& link) { return link.inertia == 0; });
}

/// Equal steps of at most h by a program that keeps relative angles: RK4 evaluates four times a step, Euler
/// once.
class NativeRun : public tools::Run {
 public:
  NativeRun(const Contest& contest, double h, int evaluationsPerStep)
      : coordinates_(contest.scene.chain.coordinates()),
        n_(coordinates_.size()),
        last_(static_cast<long long>(std::ceil(contest.end / h - 1e-6))),
        h_(contest.end / static_cast<double>(last_)),
        evaluationsPerStep_(evaluationsPerStep) {}

  Progress step() override {
    if (!stepBy(h_) || !std::isfinite(q(n_ - 1)) || !std::isfinite(qd(n_ - 1))) return Progress::diverged;
    return ++done_ == last_ ? Progress::arrived : Progress::underway;
  }
  tools::Counts counts() const override { return {done_ * evaluationsPerStep_, done_, 0}; }
  void read(double* theta, double* omega) const override {
    for (int i = 0; i < n_; ++i) {
      theta[i] = q(i);
      omega[i] = qd(i);
    }
    coordinates_.toAbsolute(theta, theta);
    coordinates_.toAbsolute(omega, omega);
  }

 protected:
  double h() const { return h_; }
  /// False if the program reports an error.
  virtual bool stepBy(double h) = 0;
  virtual double q(int i) const = 0;
  virtual double qd(int i) const = 0;

 private:
  Coordinates coordinates_;
  int n_;
  long long last_, done_ = 0;
  double h_;
  int evaluationsPerStep_;
};

}  // namespace planar_chain::benchmarks
