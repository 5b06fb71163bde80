#pragma once

/// A chain as MuJoCo's model, joints' springs and dampers included; no loads.

#include <mujoco/mujoco.h>

#include "planar_chain/chain.h"

namespace planar_chain::benchmarks {

/// holdsTip: with a connect, which holds the outer pin where it is at angles 0.
/// @throws std::runtime_error when MuJoCo does not accept it. To be deleted by mj_deleteModel.
mjModel* modelOf(const Chain& chain, bool holdsTip = false);

}  // namespace planar_chain::benchmarks
