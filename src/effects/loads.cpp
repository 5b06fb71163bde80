#include "effects/loads.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "effects/timed_terms.h"
#include "reading/names.h"

namespace planar_chain {

namespace {

/// @throws std::invalid_argument when a load names a body that the chain does not have
void requireBodies(const Scene& scene) {
  for (const Load& load : scene.loads) {
    for (const int body : {load.link, load.joint}) {
      if (body >= Load::none && body < scene.chain.size()) continue;
      throw std::invalid_argument("load " + load.name + " acts on no body of the chain");
    }
  }
}

class LoadEffect : public TimedTerms {
 public:
  explicit LoadEffect(const Scene& scene)
      : TimedTerms(scene.chain.coordinates(), scene.loads.size(), scene.loads.size()), loads_(scene.loads) {
    requireBodies(scene);
  }

 private:
  void list(double t) override {
    for (const Load& load : loads_) addWithin(load, load.law, t);
  }

  std::vector<Load> loads_;
};

// ---- Reading -------------------------------------------------------------------------------------

/// Takes the force, moment or torque of a load, and the link or joint on which it acts.
void takeAction(const Section& in, const ChainNames* names, Load& load) {
  load.link = takeReference(in, "link", names);
  load.joint = takeReference(in, "joint", names);
  if (names && load.link != Load::none) load.point = names->com[index(load.link)];
  in.take("force", "N", load.force);
  in.take("point", "m", load.point);
  in.take("moment", NumberRule::any("N m"), load.moment);
  in.take("torque", NumberRule::any("N m"), load.torque);

  const bool actsOnLink = in.has("force") || in.has("moment");
  if (in.has("link") && !actsOnLink) in.fault("force", "force or moment, as there is a link");
  if (in.has("point") && !in.has("force") && (actsOnLink || !in.has("link"))) {
    in.fault("force", "a force, as there is a point");
  }
  if (actsOnLink && !in.has("link")) in.fault("link", "the link on which force or moment acts");
  if (in.has("joint") && !in.has("torque")) in.fault("torque", "a torque, as there is a joint");
  if (in.has("torque") && !in.has("joint")) in.fault("joint", "the joint in which the torque acts");
  if (!in.has("link") && !in.has("joint") && !actsOnLink && !in.has("point") && !in.has("torque")) {
    in.fault("link", "a link with force or moment, or a joint with torque");
  }
}

TimeLaw takeSine(const Section& in) {
  Sine sine;
  in.take("frequency", NumberRule::any("Hz"), sine.frequency);
  in.take("phase", phaseRule(), sine.phase);
  return sine;
}

TimeLaw takeRamp(const Section& in) {
  Ramp ramp;
  takeCurve(in, "no unit: factors", ramp.times, ramp.values);
  return ramp;
}

void takeTimeLaw(const Section& in, Load& load) {
  const bool isRamp = in.has("times") || in.has("values");
  const bool isSine = in.has("frequency");
  if (isRamp && isSine) in.fault("frequency", "no frequency beside times and values");
  if (in.has("phase") && !isSine) in.fault("frequency", "a frequency, as there is a phase");
  if (isSine || in.has("phase")) load.law = takeSine(in);
  if (isRamp) load.law = takeRamp(in);

  in.take("start", NumberRule::from(0, "s"), load.start);
  in.take("stop", NumberRule::above(load.start, "s, the start"), load.stop);
}

// ---- The kind ------------------------------------------------------------------------------------

class LoadsKind : public EffectKind {
 public:
  const char* sceneKey() const override { return "loads"; }
  void takeScene(const Section& top, const ChainNames* names, std::vector<Link>& /*links*/,
                 std::vector<Load>& loads) const override {
    const Section all = top.section("loads");
    for (const auto& [name, entry] : all.entries()) {
      if (!isName(name)) all.fault(name, nameInWords, quoted(name));
      const Section in = all.section(name, {"link", "force", "point", "moment", "joint", "torque",
                                            "frequency", "phase", "times", "values", "start", "stop"});
      if (!entry.map()) continue;
      Load load;
      load.name = name;
      takeAction(in, names, load);
      takeTimeLaw(in, load);
      loads.push_back(std::move(load));
    }
  }

  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return scene.loads.empty() ? nullptr : std::make_unique<LoadEffect>(scene);
  }

  /// Steady torques in joints, and nothing else.
  bool runsInLanes(const Scene& scene) const override {
    requireBodies(scene);
    return std::all_of(scene.loads.begin(), scene.loads.end(), [](const Load& load) {
      return load.joint != Load::none && load.link == Load::none &&
             std::holds_alternative<Constant>(load.law) && load.start <= 0 &&
             load.stop == std::numeric_limits<double>::infinity();
    });
  }

  /// A force X at the point x (link frame) has the moment ((x − r) S_i0) × X about the centre of mass.
  void addDense(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& /*qd*/,
                const DenseActions& to) const override {
    requireBodies(scene);
    const double base = scene.base ? scene.base->angle.at(t).value : 0;
    for (const Load& load : scene.loads) {
      const double f = factorAt(load, t);
      if (load.link != Load::none) {
        const Vec2d x = load.point - scene.chain.links()[index(load.link)].com;
        double angle = base;
        for (int i = 0; i <= load.link; ++i) angle += scene.chain.joints()[index(i)].isPrismatic ? 0 : q(i);
        const Vec2d arm = Rotation<double>::of(angle) * x;
        to.F(2 * load.link) += f * load.force.x;
        to.F(2 * load.link + 1) += f * load.force.y;
        to.M(load.link) += f * (load.moment + cross(arm, load.force));
      }
      if (load.joint != Load::none) to.tau(load.joint) += f * load.torque;
    }
  }

  void summarize(const Scene& scene, SceneWords& words) const override {
    words.count(static_cast<int>(scene.loads.size()), "load");
  }
};

}  // namespace

int takeReference(const Section& in, const std::string& key, const ChainNames* names) {
  const Value* value = in.find(key);
  if (!value || !names) return Load::none;
  const bool isLink = key == "link";
  const Indices &own = isLink ? names->links : names->joints, &others = isLink ? names->joints : names->links;
  const auto entry = value->text() ? own.find(*value->text()) : own.end();
  if (entry != own.end()) return entry->second;
  in.fault(key, oneOf(key, value->text() ? *value->text() : "", own, &others));
  return Load::none;
}

const EffectKind& loadKind() {
  static const LoadsKind kind;
  return kind;
}

double factorAt(const Load& load, double t) {
  if (t < load.start || t >= load.stop) return 0;
  if (const auto* sine = std::get_if<Sine>(&load.law)) {
    return std::sin(2 * pi * sine->frequency * t + sine->phase);
  }
  const auto* ramp = std::get_if<Ramp>(&load.law);
  return ramp ? lineAt(*ramp, t).at(t) : 1;
}

}  // namespace planar_chain
