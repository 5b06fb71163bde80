#pragma once

/// A state that a user gives: angles and rates in a scene at a time.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene.h"

namespace planar_chain {

constexpr double givenTo = 1e-6;  // rad, rad/s: how closely a state must repeat what is given

struct GivenState {
  Eigen::VectorXd q;   ///< n, rad, of prismatic joints m
  Eigen::VectorXd qd;  ///< n, rad/s, of prismatic joints m/s
};

/// Adds a fault at `path` unless there are n finite numbers. unit: of those of angles. Returns true if there
/// is none.
bool checkNumbers(const char* path, const Scene& scene, const Eigen::VectorXd& numbers, const char* unit,
                  std::vector<Fault>& faults);

/// Adds a fault unless t is finite.
void checkTime(double t, std::vector<Fault>& faults);

/// Returns the state at time t (s). What is not given is as at the start of the scene. Driven joints are
/// where their laws have them at t. A state of a chain whose tip is held is moved to
/// where that is so. Adds the faults of what is given, at the paths "t", "q" and "qd".
GivenState stateOf(const Scene& scene, double t, const std::optional<Eigen::VectorXd>& q,
                   const std::optional<Eigen::VectorXd>& qd, std::vector<Fault>& faults);

/// Says how far a state was moved to where the tip is held, between `before` and `after`; empty: by 1e-6 at
/// most. from, to: relative angles, n each.
std::string movedWords(const char* before, const Chain& chain, const double* from, const double* to,
                       const char* after = "");

/// @throws Refused if the scene has more than 1000 links: its matrices are dense
void requireFewLinks(const Scene& scene);

/// @throws std::overflow_error unless all numbers are finite. what: such as "accelerations"
void requireFinite(const std::string& what, const Eigen::MatrixXd& numbers);

}  // namespace planar_chain
