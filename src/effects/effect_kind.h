#pragma once

/// A kind of effect: its keys in the scene with their checks, its stored energy, its words in the log, and
/// the function that makes the effect for a scene. effectKinds() lists all kinds.

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "effects/effect.h"
#include "model/number_rule.h"
#include "planar_chain/scene.h"
#include "reading/section.h"

namespace planar_chain {

/// The numbers of links and joints by name, and each link's centre of mass, which is a force's default point.
struct ChainNames {
  std::map<std::string, int> links, joints;
  std::vector<Vec2d> com;
};

/// A key below links/NAME/joint, which holds a number. A key in a map, such as "motor/time_constant", has the
/// name of the map as well.
struct JointKey {
  const char* name;
  double Joint::*member;  ///< nullptr: kept in Joint::others
  NumberRule range;
  bool isInUrdf = false;               ///< URDF expresses it: a scene with a URDF may not have it
  bool isAllowedBesideDrive = false;   ///< a driven joint may have it
  const char* urdfDynamics = nullptr;  ///< the attribute of URDF's element <dynamics> that says the same
  const char* map = nullptr;           ///< the map that has it; nullptr: the joint itself

  double of(const Joint& joint) const { return member ? joint.*member : joint.other(name); }
};

/// How rviz draws a joint.
enum class Symbol { none, coil, brake };

/// A body where it is, ground components.
struct PosedBody {
  Vec2d pin;           ///< of the inner pin, m
  Rotation<double> e;  ///< exp(i θ)
};

/// The words of the start-up line about a scene.
struct SceneWords {
  std::vector<std::string> runs, leftOut;

  /// Adds "3 springs" to `runs`; or, if there are none, "springs" to `leftOut`.
  void count(int number, const std::string& one);
  /// Adds "3 rotors", if the chain has such joints.
  void countJoints(const Chain& chain, bool (*are)(const Joint&), const std::string& one);
};

/// The sums of kane.h: forces F (2n) at the centres of mass, moments M (n) on the bodies, torques τ (n) in
/// the joints.
struct DenseActions {
  Eigen::VectorXd &F, &M, &tau;
};

class EffectKind {
 public:
  virtual ~EffectKind() = default;

  // ---- Keys in the scene ------------------------------------------------------------------------------

  /// Made once: every joint of every scene asks for them.
  virtual const std::vector<JointKey>& jointKeys() const;
  /// Adds what is wrong with a joint's values; paths are such as "joint/damping". By default: the numbers
  /// that are out of range, as far as the joint has them.
  virtual void judge(const Joint& joint, std::vector<Fault>& faults) const;

  /// Its key of a link, or nullptr.
  virtual const char* linkKey() const { return nullptr; }
  /// Reads it.
  virtual void takeLink(const Section& /*in*/, Link& /*link*/) const {}
  /// Adds what is wrong with a link's values; paths are such as "drag".
  virtual void judge(const Link& /*link*/, std::vector<Fault>& /*faults*/) const {}

  /// Its key of the scene, or nullptr.
  virtual const char* sceneKey() const { return nullptr; }
  /// Reads it. names: nullptr if the links could not be read; else `links` are those.
  virtual void takeScene(const Section& /*top*/, const ChainNames* /*names*/, std::vector<Link>& /*links*/,
                         std::vector<Load>& /*loads*/) const {}

  // ---- What it is ---------------------------------------------------------------------------------------

  /// Returns the effect of this kind in a scene, or nullptr if the scene has none. The scene's chain outlives
  /// the effect.
  /// @throws std::invalid_argument when the scene names a body that the chain does not have
  virtual std::unique_ptr<Effect> make(const Scene& scene) const = 0;

  /// Adds the same forces in the dense form of kane.h, for reading and for tests of the effect. q, qd:
  /// relative angles and rates. Inertia, and torques that are not functions of the state, such as those of
  /// friction and drives, are not added: the recursion gives them to kane.h.
  virtual void addDense(const Scene& /*scene*/, double /*t*/, const Eigen::VectorXd& /*q*/,
                        const Eigen::VectorXd& /*qd*/, const DenseActions& /*to*/) const {}

  /// Its part of the start-up line.
  virtual void summarize(const Scene& scene, SceneWords& words) const = 0;
  virtual Symbol symbolOf(const Joint& /*joint*/) const { return Symbol::none; }

  /// True if SIMD lanes may compute this scene in a batch (batch.h), as far as this kind is concerned: they
  /// know pins, gravity, linear springs and dampers, and steady torques in joints. By default only a scene in
  /// which the kind does not act.
  virtual bool runsInLanes(const Scene& scene) const { return make(scene) == nullptr; }

  // ---- Energy and sizes ---------------------------------------------------------------------------------

  /// The energy V that it stores in a joint at the angle q, J. Energy that depends on the past is power:
  /// Powers::supplied is τ q̇ then, with its sign, and stiffnessOf() is > 0, or whole turns of the joint are
  /// taken to change nothing.
  virtual double energyIn(const Joint& /*joint*/, double /*q*/) const { return 0; }
  /// A typical ∂²V/∂q² in a joint, N m/rad: > 0 where it stores energy, else energyIn() is not called. The
  /// guard allows more error of the energy for a larger value.
  virtual double stiffnessOf(const Joint& /*joint*/) const { return 0; }
  /// A typical moment in a joint, N m: what residuals of an equilibrium are compared with.
  virtual double momentOf(const Joint& joint) const { return stiffnessOf(joint); }

  /// The energy V that it stores in a body by its position, J.
  virtual double energyOf(const Link& /*link*/, const PosedBody& /*at*/) const { return 0; }
  /// A typical ∂²V/∂x² of a body, N/m: > 0 where it stores energy, else energyOf() is not called.
  virtual double stiffnessOf(const Link& /*link*/) const { return 0; }

  /// The inertia that resists q̈ of a joint besides the links', kg m².
  virtual double inertiaIn(const Joint& /*joint*/) const { return 0; }
  /// The torque that opposes any motion of a joint, whatever its rate, N m.
  virtual double dryFrictionIn(const Joint& /*joint*/) const { return 0; }
  /// False if a static equilibrium is found without it.
  virtual bool isInEquilibrium() const { return true; }
};

/// Makes an effect, or returns nullptr if it is empty().
template <class Made, class... Of>
std::unique_ptr<Effect> makeUnlessEmpty(const Of&... of) {
  auto effect = std::make_unique<Made>(of...);
  return effect->empty() ? nullptr : std::move(effect);
}

/// All kinds, in the order in which effects act, which fixes how sums are rounded. Keys are read in this
/// order.
const std::vector<const EffectKind*>& effectKinds();

/// While it exists, these are all kinds: with some of a program's own, or without one. Before a scene is
/// read, and while no other thread uses one.
class OtherEffectKinds {
 public:
  explicit OtherEffectKinds(std::vector<const EffectKind*> kinds);
  /// All kinds that there are, and this one, which acts first.
  explicit OtherEffectKinds(const EffectKind& more);
  ~OtherEffectKinds();
  OtherEffectKinds(const OtherEffectKinds&) = delete;
  OtherEffectKinds& operator=(const OtherEffectKinds&) = delete;

 private:
  std::vector<const EffectKind*> before_;
};

/// The words of all kinds, after those of gravity.
SceneWords wordsOf(const Scene& scene);

// Sums over all kinds.
double inertiaIn(const Joint& joint);      ///< kg m²
double dryFrictionIn(const Joint& joint);  ///< N m
double stiffnessOf(const Joint& joint);    ///< N m/rad
double stiffnessOf(const Link& link);      ///< N/m
double momentOf(const Joint& joint);       ///< N m

/// The tolerance of rates, per second; 0 with fixed steps.
double toleranceOfRates(const IntegratorSettings& settings);

/// True if a kind draws the joint so.
bool hasSymbol(const Joint& joint, Symbol symbol);

/// True if a kind stores energy in the joint. If not, whole turns of the joint change no effect.
bool storesEnergy(const Joint& joint);

/// The largest |q| of a joint, rad or m: the number of turns is exact, or, if the joint stores energy or
/// is prismatic, q is to 1e-10.
double largestAngle(const Joint& joint);
/// largestAngle() as a fault says it: "a number from … to …".
const char* anglesInWords(const Joint& joint);

}  // namespace planar_chain
