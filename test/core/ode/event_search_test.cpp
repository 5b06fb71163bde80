/// The search for the first event within a step, on motions that are known.

#include "ode/event_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace planar_chain::ode {
namespace {

/// A motion q(t), by its value, rate and acceleration. The dense output of a step from 0 to 1 errs by
/// 16 error t² (1 − t)², which no look at its ends shows.
struct Motion : StepStates {
  std::function<Eigen::Vector3d(double)> of;
  double error = 0;
  int made = 0;  ///< states by a step
  Eigen::VectorXd y{2}, accelerations{2}, errors{2};

  double shape(double t) const { return 16 * t * t * (1 - t) * (1 - t); }
  Eigen::VectorXd exactly(double t) const {
    return of(t).head(2) - error * Eigen::Vector2d(shape(t), 32 * t * (1 - t) * (1 - 2 * t));
  }
  const Eigen::VectorXd& at(double t) override {
    y = of(t).head(2);
    return y;
  }
  const Eigen::VectorXd& accelerationsAt(double t) override {
    accelerations << of(t)[2], 0;
    return accelerations;
  }
  const Eigen::VectorXd* errorAt(double t) override {
    errors << error * shape(t), 0;
    return error == 0 ? nullptr : &errors;
  }
  bool make(double t, Eigen::VectorXd& state, Eigen::VectorXd& a) override {
    ++made;
    state = exactly(t);
    a << of(t)[2], 0;
    return true;
  }
};

/// g = q − limit, with slopes or without.
struct Limit : EventFunctions {
  Limit(double limit_, bool hasSlope_, double noise_ = 1e-15)
      : limit(limit_), noise_of_g(noise_), hasSlope(hasSlope_) {}
  int most() const override { return 1; }
  void values(double /*t*/, const double* y, double* g) const override { *g = y[0] - limit; }
  void noise(double /*t*/, const double* /*y*/, double* of) const override { *of = noise_of_g; }
  bool haveSlopes() const override { return hasSlope; }
  void slopes(double /*t*/, const double* y, const double* /*a*/, double* slope) const override {
    *slope = y[1];
  }
  double limit, noise_of_g;
  bool hasSlope;
};

constexpr double nothing = -1;

/// When the first of these limits is passed in a step from t0 to t1; `nothing`: none is.
double firstOf(Motion& motion, const std::vector<Limit>& limits, double t0, double t1) {
  EventList events;
  for (const Limit& limit : limits) events.push_back(&limit);
  EventSearch search(events, 2, 1);
  search.start(t0, motion.exactly(t0), true);
  if (search.search(t1, motion.exactly(t1), motion) != EventSearch::Result::event) return nothing;
  EXPECT_LE(search.before().most(), 1e-15);
  EXPECT_GT(search.behind().most(), 0);
  return search.locate(motion).t;
}

/// a − b (t − m)²
Motion arch(double a, double b, double m) {
  Motion motion;
  motion.of = [=](double t) { return Eigen::Vector3d(a - b * (t - m) * (t - m), -2 * b * (t - m), -2 * b); };
  return motion;
}

Motion sine(double frequency) {
  Motion motion;
  motion.of = [=](double t) {
    const double phase = frequency * t;
    return Eigen::Vector3d(std::sin(phase), frequency * std::cos(phase),
                           -frequency * frequency * std::sin(phase));
  };
  return motion;
}

TEST(EventSearch, FindsASimpleRoot) {
  for (const bool hasSlope : {true, false}) {
    for (const double limit : {-0.9, 0.0, 0.3, 0.8}) {
      Motion motion = sine(1);
      EXPECT_NEAR(firstOf(motion, {{limit, hasSlope}}, -1.5, 1.5), std::asin(limit), 1e-14) << limit;
    }
    Motion back = arch(1, 1, 0);
    EXPECT_EQ(firstOf(back, {{1.5, hasSlope}}, -1, 1), nothing);
    EXPECT_EQ(firstOf(back, {{0.5, hasSlope}}, 0.8, 2), nothing) << "behind the top";
  }
}

// Above 0 within the step and not at its ends: for a share `width` of it.
TEST(EventSearch, FindsADipBetweenTheEnds) {
  for (const bool hasSlope : {true, false}) {
    for (const double middle : {0.5, 0.3, 0.77}) {
      for (const double width : {0.1, 1e-3, 1e-6}) {
        Motion motion = arch(1, 1, middle);
        const double limit = 1 - width * width / 4, late = 3e-15 / width;  // noise over slope
        EXPECT_NEAR(firstOf(motion, {{limit, hasSlope}}, 0, 1), middle - width / 2, late)
            << width << " at " << middle << ", slopes " << hasSlope;
      }
    }
  }
}

// A double root is no event unless it rises above the noise.
TEST(EventSearch, LeavesADoubleRootBelowTheNoise) {
  for (const bool hasSlope : {true, false}) {
    for (const double middle : {0.5, 0.3, 0.77}) {
      Motion motion = arch(1, 1, middle);
      EXPECT_EQ(firstOf(motion, {{1, hasSlope}}, 0, 1), nothing);
      EXPECT_EQ(firstOf(motion, {{1 + 1e-12, hasSlope}}, 0, 1), nothing);
      EXPECT_NEAR(firstOf(motion, {{1 - 1e-10, hasSlope, 1e-12}}, 0, 1), middle, 1.1e-5);
    }
  }
}

// At the start g is 0 or above by rounding; it falls, and may rise again.
TEST(EventSearch, CountsNoEventAtTheStart) {
  for (const double lift : {0.0, 1e-17, -1e-17}) {
    Motion away = arch(1, 1, 0);
    EXPECT_EQ(firstOf(away, {{1 - lift, true}}, 0, 1), nothing) << "at rest";
    EXPECT_EQ(firstOf(away, {{1 - lift, false}}, 0, 1), nothing) << "at rest";
    Motion dip = arch(0, -3, 0.1);
    EXPECT_NEAR(firstOf(dip, {{0.03 - lift, true}}, 0, 0.25), 0.2, 1e-13);
    Motion back = arch(0, 3, 0.1);
    EXPECT_NEAR(firstOf(back, {{-0.03 - lift, true, 1e-15}}, 0, 0.2), 0, 1e-6) << "up at once, and back";
  }
}

// It was lifted since, and falls from there.
TEST(EventSearch, CountsFromWhereTheStartIs) {
  for (const bool hasSlope : {true, false}) {
    Motion away = arch(1, 1, 0);
    Limit limit(1 - 1e-3, hasSlope);
    EventSearch search({&limit}, 2, 1);
    search.start(0, away.exactly(0), true);
    EXPECT_EQ(search.search(1, away.exactly(1), away), EventSearch::Result::nothing);
  }
}

TEST(EventSearch, FindsTheFirstOfSeveral) {
  Motion motion = sine(1);
  EXPECT_NEAR(firstOf(motion, {{0.9, true}, {0.5, false}, {0.7, true}}, 0, 1.5), std::asin(0.5), 1e-14);
  // One is above 0 at the end, another one before it for a moment.
  Motion dip = arch(1, 1, 0.3);
  EXPECT_NEAR(firstOf(dip, {{2, true}, {1 - 1e-8, true}}, 0, 1), 0.3 - 1e-4, 1e-11);
  // Three roots of one function: a step that is far too long.
  Motion fast = sine(5);
  EXPECT_NEAR(firstOf(fast, {{0.2, true}}, 0, 1.5), std::asin(0.2) / 5, 1e-14);
  EXPECT_NEAR(firstOf(fast, {{0.999, true}}, 0, 1.6), std::asin(0.999) / 5, 1e-12);
}

// A dense output that is not exact decides alone where it is far from 0 by its error.
TEST(EventSearch, MakesStepsWhereTheDenseOutputIsNotExact) {
  Motion far = arch(1, 1, 0.5);
  far.error = 1e-3;
  EXPECT_EQ(firstOf(far, {{1.1, true}}, 0, 1), nothing);
  EXPECT_EQ(far.made, 0);
  Motion above = arch(1, 1, 0.5);
  above.error = 1e-3;
  EXPECT_EQ(firstOf(above, {{1 - 5e-4, true}}, 0, 1), nothing) << "the dense output is above it";
  EXPECT_GT(above.made, 0);
  Motion below = arch(1, 1, 0.5);
  for (const double error : {1e-3, 0.2}) {
    below.error = -error;
    EXPECT_NE(firstOf(below, {{1 + error / 2, true}}, 0, 1), nothing) << "the dense output is below it";
  }
}

// Most steps are far from any event: their ends say so.
TEST(EventSearch, LooksAtEndsAloneFarFromEvents) {
  struct Blind : Motion {
    const Eigen::VectorXd& at(double t) override {
      ADD_FAILURE() << t;
      return Motion::at(t);
    }
  } motion;
  motion.of = sine(1).of;
  EXPECT_EQ(firstOf(motion, {{20, true}}, 0, 1), nothing);
}

}  // namespace
}  // namespace planar_chain::ode
