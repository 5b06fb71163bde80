#pragma once

/// The matrices of the equations at one state, with the letters of the notes: names that tools print.

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "dynamics/given_state.h"
#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"

namespace planar_chain {

/// Calls show(letter, meaning, value) for every matrix and vector of the equations, in the order of the
/// notes.
template <class Show>
void showAll(const ActiveForces& active, const Kane& at, const std::optional<LinearModel>& near,
             const Show& show) {
  show("q", "relative joint angles, rad", at.q);
  show("qd", "their rates, rad/s", at.qd);
  show("S", "rotation matrix: components along the body's axes from those along the ground's", at.S);
  show("T", "[omega_1 ... omega_n] = qd' T", at.T);
  show("V_pd", "partial velocities of the centres of mass, columns x_1 y_1 x_2 y_2 ..., m", at.V_pd);
  show("W_pd", "partial angular velocities", at.W_pd);
  show("A_1", "inertia forces by qd: F_in = -qd' A_1 - qdd' A_2, kg m/s", at.A_1);
  show("A_2", "inertia forces by qdd, kg m", at.A_2);
  show("A_3", "inertia moments: M_in = -qdd' A_3, kg m^2", at.A_3);
  show("F", "active forces at the centres of mass, ground components x_1 y_1 ..., N", active.F);
  show("M_ext", "active moments on the bodies, N m", active.M);
  show("tau", "joint torques of all that acts, drives included, N m", active.tau);
  show("f_ext", "= V_pd F + W_pd M_ext + tau, N m", at.f_ext);
  show("f",
       "= f_ext - V_pd A_1' qd, less the inertia of a moving base and Coriolis' of prismatic joints, N m",
       at.f);
  show("M", "= V_pd A_2' + W_pd A_3' + rotors, kg m^2", at.M_q);
  const bool isClosed = at.J_c.rows() > 0;
  if (isClosed) {
    show("J_c", "a held tip: J_c qdd = c, m", at.J_c);
    show("c", "what its place and the rates leave of it, m/s^2", at.c);
    show("phi", "forces that hold it, along the rows of J_c, N", at.phi);
  }
  show("qdd", isClosed ? "M qdd = f + J_c' phi, rad/s^2" : "M qdd = f, rad/s^2", at.qdd);
  if (!near) return;
  show("A", "dx/dt = A x + B dtau, where x = (dq, dqd) is a small change of this state", near->A);
  show("B",
       isClosed ? "= [0; dqdd/dtau] while the tip is held, where dtau is additional torque in the joints, N m"
                : "= [0; M^-1], where dtau is additional torque in the joints, N m",
       near->B);
  if (near->tau.size() == 0) return;
  show("tau_0", "torques in the joints beside tau, about which A and B are, N m", near->tau);
  show("qdd_0", "accelerations under them, rad/s^2", near->qdd);
}

/// @throws std::overflow_error naming the first letter of showAll() that has a number which is not finite
inline void requireFinite(const ActiveForces& active, const Kane& at,
                          const std::optional<LinearModel>& near) {
  showAll(active, at, near, [](const std::string& letter, const char*, const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::vector<Eigen::Matrix2d>>) {
      for (const Eigen::Matrix2d& each : value) requireFinite("numbers of " + letter, each);
    } else {
      requireFinite("numbers of " + letter, value);
    }
  });
}

}  // namespace planar_chain
