#include "effects/drives.h"

#include <algorithm>
#include <stdexcept>

#include "effects/stick_slip.h"

namespace planar_chain {

namespace {

/// An effect that adds no moment or force of its own.
class CouplingEffect : public Effect, public JointConstraint {
 public:
  LoadKind mostActing() const final { return LoadKind::nothing; }
  Powers apply(const ChainState& /*at*/, const Actions& /*to*/) final { return {}; }
  void addTorques(const ChainState& /*at*/, double* /*tau*/) final {}
  JointConstraint* jointConstraint() final { return this; }
};

// ---- Rotors --------------------------------------------------------------------------------------

constexpr const char* rotorInertia = "rotor_inertia";

class Rotors : public CouplingEffect {
 public:
  explicit Rotors(const Chain& chain) {
    for (const Joint& joint : chain.joints()) inertia_.push_back(joint.other(rotorInertia));
  }
  bool empty() const {
    return std::all_of(inertia_.begin(), inertia_.end(), [](double J) { return J == 0; });
  }
  bool hasPower() const override { return false; }
  void couple(double /*t*/, int /*k*/, Couplings& to) const override {
    for (std::size_t i = 0; i < inertia_.size(); ++i) to.joints[i].armature = inertia_[i];
  }

 private:
  std::vector<double> inertia_;
};

class RotorKind : public EffectKind {
 public:
  const std::vector<JointKey>& jointKeys() const override {
    static const std::vector<JointKey> keys{
        {rotorInertia, nullptr, NumberRule::from(0, "kg m²"), false, true}};
    return keys;
  }
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return makeUnlessEmpty<Rotors>(scene.chain);
  }
  double inertiaIn(const Joint& joint) const override { return joint.other(rotorInertia); }
  void summarize(const Scene& scene, SceneWords& words) const override {
    words.countJoints(
        scene.chain, [](const Joint& joint) { return joint.other(rotorInertia) > 0; }, "rotor");
  }
};

// ---- Laws ----------------------------------------------------------------------------------------

/// A law, and the piece of it that holds now.
struct Running {
  MotionLaw law;
  int piece = 0;

  void enter(double t) { piece = law.pieceAt(t); }
  void saveOrRestore(Snapshot& snapshot) { snapshot(law, piece); }
  double until() const { return law.until(piece); }
  GivenMotion order(int k, double t) const { return k == 0 ? law.at(t, piece) : law.order(k, t, piece); }
};

/// An effect that follows laws of time.
class LawEffect : public CouplingEffect {
 public:
  void enter(double t) final {
    for (Running& running : laws_) running.enter(t);
  }
  void saveOrRestore(Snapshot& snapshot) override { snapshot(laws_); }
  double until() const final {
    double end = std::numeric_limits<double>::infinity();
    for (const Running& running : laws_) end = std::min(end, running.until());
    return end;
  }
  double longestStep() const final {
    double longest = std::numeric_limits<double>::infinity();
    for (const Running& running : laws_) longest = std::min(longest, running.law.longestStep());
    return longest;
  }

 protected:
  std::vector<Running> laws_;
};

class Drives : public LawEffect {
 public:
  explicit Drives(const std::vector<Drive>& drives) {
    for (const Drive& drive : drives) {
      joints_.push_back(drive.joint);
      laws_.push_back({drive.law});
    }
  }
  bool variesWithTime() const override {
    return std::any_of(laws_.begin(), laws_.end(),
                       [](const Running& running) { return running.law.moves(); });
  }
  void follow(int joint, const MotionLaw& law) override {
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      if (joints_[i] == joint) laws_[i] = {law};
    }
  }
  void couple(double t, int k, Couplings& to) const override {
    for (std::size_t i = 0; i < laws_.size(); ++i) {
      const GivenMotion motion = laws_[i].order(k, t);
      to.joints[index(joints_[i])].isPrescribed = true;
      to.joints[index(joints_[i])].acceleration = motion.acceleration;
      to.prescribed[index(joints_[i])] = motion;
    }
  }

 private:
  std::vector<int> joints_;
};

class DriveKind : public EffectKind {
 public:
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return scene.drives.empty() ? nullptr : std::make_unique<Drives>(scene.drives);
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    if (!scene.drives.empty()) words.count(static_cast<int>(scene.drives.size()), "driven joint");
  }
};

// ---- The base ------------------------------------------------------------------------------------

class Base : public LawEffect {
 public:
  explicit Base(const BaseLaws& laws) { followBase(laws); }
  const BaseLaws* base() const override { return &base_; }
  void followBase(const BaseLaws& laws) final {
    base_ = laws;
    laws_ = {{laws.x}, {laws.y}, {laws.angle}};
  }
  void saveOrRestore(Snapshot& snapshot) override {
    LawEffect::saveOrRestore(snapshot);
    snapshot(base_.x, base_.y, base_.angle);
  }
  bool variesWithTime() const override { return true; }
  void couple(double t, int k, Couplings& to) const override {
    to.x = laws_[0].order(k, t);
    to.y = laws_[1].order(k, t);
    to.angle = laws_[2].order(k, t);
  }

 private:
  BaseLaws base_;
};

class BaseKind : public EffectKind {
 public:
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return scene.base ? std::make_unique<Base>(*scene.base) : nullptr;
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    if (scene.base) words.runs.push_back("a moving base");
  }
};

// ---- The tip -------------------------------------------------------------------------------------

class HeldTip : public LawEffect {
 public:
  explicit HeldTip(const TipLaws& laws) : moves_(laws.moves()), tip_(pinnedTip(Vec2d{})) {
    laws_ = {{laws.x}, {laws.y}};
    if (laws.line) tip_ = {1, {perp(*laws.line)}, {}};
  }
  bool hasPower() const override { return moves_; }
  bool holdsTip() const override { return true; }
  bool hasSeries() const override { return !moves_ && tip_.rows == 2; }
  bool variesWithTime() const override { return moves_; }
  void couple(double t, int k, Couplings& to) const override {
    const GivenMotion x = laws_[0].order(k, t), y = laws_[1].order(k, t);
    to.tip = tip_;
    to.tip.acceleration = {x.acceleration, y.acceleration};
    to.tipPosition = {x.value, y.value};
    to.tipVelocity = {x.rate, y.rate};
  }

 private:
  bool moves_;
  Tip<double> tip_;
};

class TipKind : public EffectKind {
 public:
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    if (!scene.tip) return nullptr;
    const auto& joints = scene.chain.joints();
    const auto held =
        std::count_if(joints.begin(), joints.end(), mayStick) + std::ptrdiff_t(scene.drives.size());
    if (std::ptrdiff_t(joints.size()) - held < scene.tip->rows())
      throw std::invalid_argument("drives and friction leave too few joints to hold the tip");
    return std::make_unique<HeldTip>(*scene.tip);
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    if (scene.tip) words.runs.push_back(scene.tip->line ? "a tip on a line" : "a held tip");
  }
};

}  // namespace

const EffectKind& rotorKind() {
  static const RotorKind kind;
  return kind;
}

const EffectKind& driveKind() {
  static const DriveKind kind;
  return kind;
}

const EffectKind& baseKind() {
  static const BaseKind kind;
  return kind;
}

const EffectKind& tipKind() {
  static const TipKind kind;
  return kind;
}

}  // namespace planar_chain
