#include <algorithm>
#include <cmath>
#include <limits>

#include "ode/events.h"

namespace planar_chain::ode {

Tolerance Tolerance::inLaneOrder(const System& f) const {
  Tolerance result = *this;
  const Eigen::Index others = f.size() - ceiling.size();
  Vector all(f.size()), laneOrdered(f.sizeInLaneOrder());
  for (Eigen::ArrayXd* of : {&result.unit, &result.ceiling}) {
    all.head(of->size()) = *of;
    f.toLaneOrder(all.data(), laneOrdered.data());
    *of = laneOrdered.head(laneOrdered.size() - others);
    *of = (*of > 0).select(*of, 1);  // f may fill gaps between components with 0
  }
  if (firstRate >= f.size()) return result;

  // In lane order the rates follow the angles.
  all.setZero();
  all.tail(f.size() - firstRate).setOnes();
  f.toLaneOrder(all.data(), laneOrdered.data());
  result.firstRate =
      std::find(laneOrdered.data(), laneOrdered.data() + laneOrdered.size(), 1.0) - laneOrdered.data();
  return result;
}

const LocatedEvent& Integrator::event() const {
  static const LocatedEvent none;
  return none;
}

Outcome Integrator::integrate(State& state, double end, double longestStep, int mostSteps) {
  // At 0 s two times can be so close that 1/h overflows. Nothing moves meanwhile.
  constexpr double nothing = 1e-300;  // s
  if (end - state.t < nothing) state.t = std::max(state.t, end);
  Outcome outcome = state.t < end ? Outcome::underway : Outcome::arrived;
  for (int k = 0; outcome == Outcome::underway && k < mostSteps; ++k) {
    outcome = advance(state, end, longestStep);
  }
  return outcome;
}

}  // namespace planar_chain::ode
