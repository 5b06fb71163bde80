#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "planar_chain/scene.h"

namespace planar_chain::tools {

/// Returns the chain, its drives, base, tip, springs, frames and loads as an object with the keys of a scene.
/// What is absent is null, or left out.
nlohmann::json chainAsJson(const Scene& scene, const Eigen::VectorXd& q, const Eigen::VectorXd& qd);

}  // namespace planar_chain::tools
