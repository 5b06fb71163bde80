#pragma once

/// What the programs of reference trajectories share that know nothing of each other's equations: number
/// types, a scene as bare numbers (written by trajectories.py), its run by extrapolation (Hairer, Nørsett,
/// Wanner I, II.9) with a landing on every start, stop and corner of the loads, and what rounding the scene
/// to double changes.
///
/// Equations<Real>(scene), the system of y = [θ, ω] in absolute angles, has enter(t) and operator()(t, y,
/// dydt).

#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "extrapolation.h"

using Quad = __float128;

inline Quad cosine(Quad x) {
  return cosq(x);
}
inline Quad sine(Quad x) {
  return sinq(x);
}
inline Quad root(Quad x) {
  return sqrtq(x);
}
inline long double cosine(long double x) {
  return std::cos(x);
}
inline long double sine(long double x) {
  return std::sin(x);
}
inline long double root(long double x) {
  return std::sqrt(x);
}

// ---- The scene -----------------------------------------------------------------------------------

template <class Real>
struct Vec {
  Real x{}, y{};
};

template <class Real>
Real dot(Vec<Real> a, Vec<Real> b) {
  return a.x * b.x + a.y * b.y;
}
/// i a
template <class Real>
Vec<Real> turned(Vec<Real> a) {
  return {-a.y, a.x};
}
/// exp(i θ) a
template <class Real>
Vec<Real> rotated(Vec<Real> z, Vec<Real> a) {
  return {z.x * a.x - z.y * a.y, z.y * a.x + z.x * a.y};
}

template <class Real>
struct Body {
  Real m, I;
  Vec<Real> r, p;
  Real k, d, q0;  // of the joint at the inner pin
};

template <class Real>
struct Load {
  int link;  // −1: none
  Vec<Real> force, point;
  Real moment;
  int joint;  // −1: none
  Real torque;
  double start, stop;
  std::string law;                // constant, sine, ramp
  std::vector<Real> numbers;      // frequency, phase; or the values at the corners
  std::vector<double> cornersAt;  // of a ramp
};

template <class Real>
struct Scene {
  Vec<Real> g;
  std::vector<Body<Real>> bodies;
  std::vector<Load<Real>> loads;
  std::vector<Real> y;  // q, q̇ at the start
  double end;
};

template <class Real>
Real number() {
  double value = 0;
  if (!(std::cin >> value)) throw std::runtime_error("number expected");
  return Real(value);
}
template <class Real>
Vec<Real> vec() {
  const Real x = number<Real>();
  return {x, number<Real>()};
}

template <class Real>
Scene<Real> readScene() {
  Scene<Real> scene;
  scene.g = vec<Real>();
  scene.end = number<double>();
  const int n = number<int>();
  scene.y.resize(2 * n);
  for (int i = 0; i < n; ++i) {
    Body<Real> b;
    b.m = number<Real>(), b.I = number<Real>(), b.r = vec<Real>(), b.p = vec<Real>();
    b.k = number<Real>(), b.d = number<Real>(), b.q0 = number<Real>();
    scene.y[i] = number<Real>(), scene.y[n + i] = number<Real>();
    scene.bodies.push_back(b);
  }
  const int loads = number<int>();
  for (int l = 0; l < loads; ++l) {
    Load<Real> load;
    load.link = number<int>(), load.force = vec<Real>(), load.point = vec<Real>();
    load.moment = number<Real>(), load.joint = number<int>(), load.torque = number<Real>();
    load.start = number<double>(), load.stop = number<double>();
    std::cin >> load.law;
    if (load.law == "sine") load.numbers = {number<Real>(), number<Real>()};
    const int corners = load.law == "ramp" ? number<int>() : 0;
    for (int c = 0; c < corners; ++c) {
      load.cornersAt.push_back(number<double>());
      load.numbers.push_back(number<Real>());
    }
    scene.loads.push_back(load);
  }
  return scene;
}
/// The factor of a load at time t, as it acts around time `now`.
template <class Real>
Real factor(const Load<Real>& load, Real t, double now) {
  if (load.law == "sine") {
    const Real twoPi = Real(8 * atanq(1));
    return sine(twoPi * load.numbers[0] * t + load.numbers[1]);
  }
  if (load.law == "ramp") {
    const auto& at = load.cornersAt;
    const std::size_t k = std::size_t(std::upper_bound(at.begin(), at.end(), now) - at.begin());
    if (k == 0) return load.numbers.front();
    if (k == at.size()) return load.numbers.back();
    const Real t0 = Real(at[k - 1]), t1 = Real(at[k]);
    return load.numbers[k - 1] + (load.numbers[k] - load.numbers[k - 1]) * (t - t0) / (t1 - t0);
  }
  return 1;
}
template <class Real>
bool acts(const Load<Real>& load, double now) {
  return now >= load.start && now < load.stop;
}

// ---- A run ----------------------------------------------------------------------------------------

/// Columns of the extrapolation and tolerance of a step.
struct Accuracy {
  int columns;
  double tolerance;
};

/// [θ, ω] at the scene's end.
template <template <class> class Equations, class Real>
std::vector<Real> run(const Scene<Real>& scene, const Accuracy& accuracy) {
  const std::size_t n = scene.bodies.size();
  std::vector<Real> y = scene.y;
  for (std::size_t i = 1; i < n; ++i) {
    y[i] += y[i - 1];
    y[n + i] += y[n + i - 1];
  }

  std::vector<double> landings{0, scene.end};
  for (const Load<Real>& load : scene.loads) {
    landings.push_back(load.start);
    landings.push_back(load.stop);
    landings.insert(landings.end(), load.cornersAt.begin(), load.cornersAt.end());
  }
  std::sort(landings.begin(), landings.end());

  Equations<Real> f(scene);
  for (std::size_t k = 1; k < landings.size(); ++k) {
    const double from = landings[k - 1], to = landings[k];
    if (from < 0 || to > scene.end || from == to) continue;
    f.enter(from + (to - from) / 2);
    Extrapolation<Real, Equations<Real>>(f, accuracy.columns, accuracy.tolerance).integrate(from, to, y);
  }
  return y;
}

// ---- What double allows --------------------------------------------------------------------------

template <class Real>
Scene<long double> narrowed(const Scene<Real>& s) {
  const auto vec = [](Vec<Real> a) { return Vec<long double>{(long double)a.x, (long double)a.y}; };
  const auto list = [](const std::vector<Real>& a) { return std::vector<long double>(a.begin(), a.end()); };
  Scene<long double> result{vec(s.g), {}, {}, list(s.y), s.end};
  for (const auto& b : s.bodies) {
    result.bodies.push_back({(long double)b.m, (long double)b.I, vec(b.r), vec(b.p), (long double)b.k,
                             (long double)b.d, (long double)b.q0});
  }
  for (const auto& l : s.loads) {
    result.loads.push_back({l.link, vec(l.force), vec(l.point), (long double)l.moment, l.joint,
                            (long double)l.torque, l.start, l.stop, l.law, list(l.numbers), l.cornersAt});
  }
  return result;
}

template <class Real>
void makeRelative(std::vector<Real>& y) {
  const std::size_t n = y.size() / 2;
  for (std::size_t i = n - 1; i > 0; --i) {
    y[i] -= y[i - 1];
    y[n + i] -= y[n + i - 1];
  }
}

/// The effort for a reference: its run, a second one, draws of rounding.
struct Effort {
  Accuracy first, second;
  int draws;
};

/// The largest change of the result over some draws when every parameter is off by a relative ±2^-53 and
/// every initial value by ±2^-53 max(1, |value|): taken 2^20 times as large and scaled back.
template <template <class> class Equations, class Real>
std::vector<double> changeByRounding(const Scene<Real>& scene, bool relative, const Effort& effort) {
  const double enlarged = 0x1p-33, scaleBack = 0x1p-20;
  const Scene<long double> exact = narrowed(scene);
  const auto result = [&](const Scene<long double>& of) {
    std::vector<long double> y = run<Equations>(of, Accuracy{8, std::max(1e-14, effort.second.tolerance)});
    if (relative) makeRelative(y);
    return y;
  };
  const std::vector<long double> y = result(exact);
  std::vector<double> change(y.size(), 0);
  std::mt19937 random(1);
  const auto sign = [&] { return random() % 2 ? enlarged : -enlarged; };
  for (int draw = 0; draw < effort.draws; ++draw) {
    Scene<long double> other = exact;
    const auto disturb = [&](long double& x) { x *= 1 + sign(); };
    const auto disturbVec = [&](Vec<long double>& a) { disturb(a.x), disturb(a.y); };
    disturbVec(other.g);
    for (auto& b : other.bodies) {
      disturb(b.m), disturb(b.I), disturbVec(b.r), disturbVec(b.p);
      disturb(b.k), disturb(b.d), disturb(b.q0);
    }
    for (auto& l : other.loads) {
      disturbVec(l.force), disturbVec(l.point), disturb(l.moment), disturb(l.torque);
    }
    for (auto& value : other.y) value += sign() * std::max(1.0L, magnitude(value));
    const std::vector<long double> disturbed = result(other);
    for (std::size_t i = 0; i < y.size(); ++i) {
      change[i] = std::max(change[i], scaleBack * double(magnitude(disturbed[i] - y[i])));
    }
  }
  return change;
}

/// Reads one scene, writes the state at its end ([q, q̇], or absolute [θ, ω]), the difference to the second
/// run, which takes other steps, and what rounding the scene to double changes.
template <template <class> class Equations, class Real>
void writeReference(bool relative, const Effort& effort) {
  const Scene<Real> scene = readScene<Real>();
  std::vector<Real> y = run<Equations>(scene, effort.first), other = run<Equations>(scene, effort.second);
  if (relative) makeRelative(y), makeRelative(other);
  const std::vector<double> change = changeByRounding<Equations>(scene, relative, effort);
  for (std::size_t i = 0; i < y.size(); ++i) {
    char text[64];
    quadmath_snprintf(text, sizeof text, "%.20Qg", Quad(y[i]));
    std::printf("%s %.2e %.2e\n", text, double(magnitude(y[i] - other[i])), change[i]);
  }
}
