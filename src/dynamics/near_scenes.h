#pragma once

/// What a number of a scene changes, by differences between scenes that are near in it, at the same states.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "dynamics/general_motion.h"
#include "ode/events.h"
#include "planar_chain/derivatives.h"

namespace planar_chain {

/// An event function among those of the effects of a scene.
struct EventPlace {
  /// The one that was located, or else the one that is most above 0.
  EventPlace(const Effects& effects, const ode::LocatedEvent& located, double t, const double* y);
  double valueIn(const Effects& effects, double t, const double* y) const;

  std::size_t list = 0;
  int which = 0;
};

/// The scenes near one in a number, at the same states.
class NearScenes {
 public:
  /// Allocates.
  explicit NearScenes(const VariedNumber& number);
  /// Takes what acts from t on, with the switches of `effects`. Returns false if more than numbers differ:
  /// other effects, or another time of the next jump.
  bool enter(double t, const Effects& effects);
  /// ∂/∂p of ColumnSeries::termsOf() of the chain.
  Eigen::VectorXd changeOfChain() const;
  /// ∂/∂p of jointTerms(). Returns false if the number moves prescribed joints, or if torques vary with time.
  bool changeOfJoints(double t, const double* y, const Effects& effects, Eigen::Matrix4Xd& to) const;
  /// ∂f/∂p: of the rates, n values.
  void slopes(double t, const double* y, double* to);
  /// ∂g/∂p of an event.
  double eventSlope(const EventPlace& event, double t, const double* y) const;
  /// ∂(θ, ω)/∂p at the start, 2n values.
  Eigen::VectorXd start() const;

 private:
  struct One {
    explicit One(const Scene& near, double weight_);
    Scene scene;
    double weight;
    Effects effects;
    /// Made when rates are first asked for, or when effects couple.
    struct Rates {
      Rates(const Scene& scene, Effects& effects);
      Mechanism mechanism;
      GeneralMotion motion;
      Evaluation at;
    };
    std::unique_ptr<Rates> rates;
    Rates& ratesMade();
  };
  std::vector<std::unique_ptr<One>> all_;
};

/// How the torque in each joint follows from its q: armature, d, k, and the torque at q = q̇ = 0. Exact if no
/// effect is nonlinear and no forces act. Allocates.
Eigen::Matrix4Xd jointTerms(const Effects& effects, const Couplings& couplings,
                            const Coordinates& coordinates, double t, const double* y);

}  // namespace planar_chain
