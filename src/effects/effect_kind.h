#pragma once

/// A kind of effect: its keys in the scene with their checks, what energy it stores, its words in the log,
/// and how it is made for a scene that has it. effectKinds() is the one list of kinds.

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "effects/effect.h"
#include "lanes/arrangement.h"
#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

/// The numbers of links and joints by name, and each link's centre of mass, which is a force's default point.
struct ChainNames {
  std::map<std::string, int> links, joints;
  std::vector<Vec2d> com;
};

/// A key below links/NAME/joint. Beside a URDF, which has words for some keys, only the others may stand.
struct JointKey {
  const char* name;
  bool isInUrdf;
};

/// What the start-up line says of a scene.
struct SceneWords {
  std::vector<std::string> runs, leftOut;

  /// "3 springs" to `runs`; or, if there are none, "springs" to `leftOut`.
  void count(int number, const std::string& one);
};

/// What acts in the notes' form: forces F (2n) at the centres of mass, moments M (n) on the bodies, torques τ
/// (n) in the joints.
struct DenseActions {
  Eigen::VectorXd &F, &M, &tau;
};

class EffectKind {
 public:
  virtual ~EffectKind() = default;

  // ---- Keys in the scene ------------------------------------------------------------------------------

  virtual std::vector<JointKey> jointKeys() const { return {}; }
  /// Copies its keys to the joint. What judge() judges may come unjudged.
  virtual void takeJoint(const Section& /*in*/, Joint& /*joint*/) const {}
  /// Adds what is wrong with a joint's values; paths are such as "joint/damping".
  virtual void judge(const Joint& /*joint*/, std::vector<Fault>& /*faults*/) const {}

  /// A key of the scene itself, or nullptr.
  virtual const char* sceneKey() const { return nullptr; }
  /// Reads it. names: nullptr where they are not certain.
  virtual void takeScene(const Section& /*top*/, const ChainNames* /*names*/, std::vector<Load>& /*loads*/,
                         std::vector<Fault>& /*faults*/) const {}

  // ---- What it is ---------------------------------------------------------------------------------------

  /// The effect of this kind in a scene; nullptr if the scene has none. lanes: the order of a long chain, or
  /// nullptr. The scene's chain and `lanes` outlive the effect.
  /// @throws std::invalid_argument when the scene names a body that the chain does not have
  virtual std::unique_ptr<Effect> make(const Scene& scene, const Arrangement* lanes) const = 0;

  /// Adds the same forces as written on paper: the dense road of kane.h, against which the fast one is
  /// tested. q, qd: relative angles and rates.
  virtual void addDense(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd,
                        const DenseActions& to) const = 0;

  /// The energy that it stores in a joint at the angle q, J, and the most that ∂²V/∂q² is, N m/rad: 0 where
  /// it stores none.
  virtual double energyIn(const Joint& /*joint*/, double /*q*/) const { return 0; }
  virtual double stiffnessOf(const Joint& /*joint*/) const { return 0; }

  /// Its part of the start-up line.
  virtual void summarize(const Scene& scene, SceneWords& words) const = 0;
};

/// The list. Each scene asks its kinds in this order; what acts on a body is added up in the reverse order.
/// A program may add kinds of its own before it reads a scene.
std::vector<const EffectKind*>& effectKinds();

}  // namespace planar_chain
