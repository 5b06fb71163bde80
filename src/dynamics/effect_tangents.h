#pragma once

/// The terms of the effects in the Jacobian: stiffness k and damping d of the joints, X·F of forces that keep
/// their direction, K and D of forces that depend on the motion. The exact solves, the Taylor series and the
/// linear model use them.

#include <vector>

#include "effects/effects.h"

namespace planar_chain {

struct EffectTangents {
  /// For n bodies; all 0. Allocates. Nothing else does.
  EffectTangents(int n, const Effects& effects)
      : constantK(index(n)), constantD(constantK), k(constantK), d(constantK) {
    if (effects.mostActing() == LoadKind::forces) XF.resize(index(n));
    if (effects.anyForces(&Forces::dependOnMotion)) bodies.resize(index(n));
  }

  /// Takes the parts of k and d that are constant between two switches: after every switch and enter().
  void takeConstant(const Effects& effects) {
    std::fill(constantK.begin(), constantK.end(), 0.0);
    std::fill(constantD.begin(), constantD.end(), 0.0);
    for (const auto& effect : effects.all()) effect->addStiffness(constantK.data(), constantD.data());
  }
  /// Takes k and d at a state.
  void takeJoints(const Effects& effects, const ChainState& at) {
    k = constantK;
    d = constantD;
    for (const Effect* effect : effects.active()) {
      if (effect->isNonlinear()) effect->addTangents(at, k.data(), d.data());
    }
  }
  /// Takes XF and `bodies` at a state.
  void takeForces(const Effects& effects, const ChainState& at) {
    std::fill(XF.begin(), XF.end(), 0.0);
    std::fill(bodies.begin(), bodies.end(), ForceTangent{});
    for (Forces* forces : effects.activeForces()) {
      forces->addForceStiffness(at, XF.data());
      if (forces->dependOnMotion()) forces->addForceTangents(at, bodies.data());
    }
  }

  std::vector<double> constantK, constantD;  ///< the parts that are constant between two switches
  std::vector<double> k, d;                  ///< N m/rad, N m s/rad
  std::vector<double> XF;                    ///< N m of each body; empty if no effect can have forces
  std::vector<ForceTangent> bodies;          ///< K and D; empty if no force depends on the motion
};

}  // namespace planar_chain
