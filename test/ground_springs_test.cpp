/// The general hook for forces: an effect of a program of its own, whose forces depend on place. A spring
/// from the centre of mass of a link to a point of the ground, with keys of links, obeys the laws of
/// effect_laws.h:
///
///     F = −k (x − x0)        V = ½ k |x − x0|²        F_x = −k

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "effect_laws.h"
#include "effects/effect_kind.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

double stiffnessIn(const Link& link) {
  return link.others.of("ground_stiffness");
}
Vec2d stretch(const Link& link, Vec2d pin, Rotation<double> e) {
  return pin + e * link.com - Vec2d{link.others.of("ground_x"), link.others.of("ground_y")};
}

/// A spring in every link, of stiffness 0 where the scene has none.
class GroundSprings : public Effect, public Forces {
 public:
  explicit GroundSprings(const Scene& scene)
      : links_(scene.chain.links()),
        coordinates_(scene.chain.coordinates()),
        hasSeries_(!scene.base),
        F_(links_.size(), std::vector<Vec2d>(mostOrders)) {}

  LoadKind mostActing() const override { return LoadKind::forces; }
  bool hasPower() const override { return false; }
  Forces* forces() override { return this; }
  int reach() const override { return static_cast<int>(links_.size()); }
  bool dependOnMotion() const override { return true; }
  bool dependOnPlace() const override { return true; }

  Powers apply(const ChainState& at, const Actions& to) override {
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const ForceAt force = forceOn(i, at);
      to.F[i] += force.F;
      const int turner = coordinates_.turner(static_cast<int>(i));
      if (turner >= 0) to.N[turner] += cross(force.X, force.F);
    }
    return {};
  }
  void addTorques(const ChainState& /*at*/, double* /*tau*/) override {}
  void addForceTangents(const ChainState& at, ForceTangent* to) override {
    for (std::size_t i = 0; i < links_.size(); ++i) {
      const double rate = coordinates_.angle(at.omega, static_cast<int>(i));
      addForce(forceOn(i, at), rate + at.baseRate, to[i]);
    }
  }

  bool hasSeries() const override { return hasSeries_; }
  /// x_k = Σ p e_k + r e_k, N_k = Σ_j r e_j × F_{k−j}. Order 0 of F is computed anew.
  void addOrder(int k, const Series& known, const Actions& to) override {
    ASSERT_LT(k, mostOrders);
    const auto e = [&](int j, std::size_t i) { return known.rotation(j)[i]; };
    for (int j : {0, k}) {
      Vec2d pin;
      for (std::size_t i = 0; i < links_.size(); ++i) {
        const Vec2d x = j == 0 ? stretch(links_[i], pin, e(0, i)) : pin + e(j, i) * links_[i].com;
        F_[i][index(j)] = -stiffnessIn(links_[i]) * x;
        pin += e(j, i) * links_[i].pin;
      }
    }
    for (std::size_t i = 0; i < links_.size(); ++i) {
      to.F[i] += F_[i][index(k)];
      for (int j = 0; j <= k; ++j) to.N[i] += cross(e(j, i) * links_[i].com, F_[i][index(k - j)]);
    }
  }

 private:
  static constexpr int mostOrders = 40;

  ForceAt forceOn(std::size_t i, const ChainState& at) const {
    const double k = stiffnessIn(links_[i]);
    return {at.e[i] * links_[i].com, -k * stretch(links_[i], at.pin[i], at.e[i]), {-k, 0, 0, -k}, {}, {}};
  }

  const std::vector<Link>& links_;
  const Coordinates& coordinates_;
  bool hasSeries_;
  std::vector<std::vector<Vec2d>> F_;  ///< of each link, its orders
};

class GroundSpringKind : public EffectKind {
 public:
  std::vector<NumberKey> linkKeys() const override {
    return {{"ground_stiffness", NumberRule::from(0, "N/m")},
            {"ground_x", NumberRule::any("m")},
            {"ground_y", NumberRule::any("m")}};
  }
  std::unique_ptr<Effect> make(const Scene& scene) const override {
    for (const Link& link : scene.chain.links()) {
      if (stiffnessIn(link) > 0) return std::make_unique<GroundSprings>(scene);
    }
    return nullptr;
  }
  void addDense(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& /*qd*/,
                const DenseActions& to) const override {
    Vec2d pin;
    double theta = 0;
    if (scene.base) {
      pin = {scene.base->x.at(t).value, scene.base->y.at(t).value};
      theta = scene.base->angle.at(t).value;
    }
    for (int i = 0; i < scene.chain.size(); ++i) {
      const Link& link = scene.chain.links()[index(i)];
      const Joint& joint = scene.chain.joints()[index(i)];
      if (joint.isPrismatic) pin += q(i) * (Rotation<double>::of(theta) * joint.axis);
      const Rotation<double> e = Rotation<double>::of(joint.isPrismatic ? theta : theta += q(i));
      const Vec2d F = -stiffnessIn(link) * stretch(link, pin, e);
      to.F(2 * i) += F.x;
      to.F(2 * i + 1) += F.y;
      pin += e * link.pin;
    }
  }
  double energyOf(const Link& link, const PlacedBody& at) const override {
    const Vec2d x = stretch(link, at.pin, at.e);
    return stiffnessIn(link) / 2 * dot(x, x);
  }
  double stiffnessOf(const Link& link) const override { return stiffnessIn(link); }
  void summarize(const Scene& /*scene*/, SceneWords& /*words*/) const override {}
};

std::string chainOf(int links, const std::string& rest) {
  return "chain: [a, b]\n"
         "links:\n"
         "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0], ground_stiffness: 30, ground_y: -1,\n"
         "      initial: {angle: 0.4, velocity: 2}}\n"
         "  b: {mass: 0.5, inertia: 0.05, com: [0.3, -0.05], pin: [0.6, 0.1], ground_stiffness: 5,\n"
         "      ground_x: 0.3, initial: {angle: -0.5, velocity: -0.7}, repeat: " +
         std::to_string(links - 1) + "}\n" + rest;
}

class ForcesOfPlace : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    static const GroundSpringKind kind;
    effectKinds().push_back(&kind);
  }
};

TEST_F(ForcesOfPlace, ObeyTheLaws) {
  for (const int links : {2, 5, 20}) {
    SCOPED_TRACE(links);
    test::EffectLaws(readSceneText(chainOf(links, "")), 0.1).expectAll();
  }
}

TEST_F(ForcesOfPlace, ObeyThemOnAMovingBase) {
  const char* base =
      "base: {x: {amplitude: 0.2, frequency: 1.1, phase: 0.4}, angle: {amplitude: 0.3, frequency: 0.8}}\n";
  test::EffectLaws(readSceneText(chainOf(5, base)), 0.1).expectAll();
}

/// On carts, and beside them.
TEST_F(ForcesOfPlace, ObeyThemWithSlides) {
  const std::string rails =
      "chain: [x, a, b]\nlinks:\n"
      "  x: {mass: 2, pin: [0.2, -0.1], inertia: 0.4, ground_stiffness: 40, ground_x: 0.3,\n"
      "      joint: {type: prismatic, axis: [1, 0.5], damping: 0.3}, initial: {position: 0.2, velocity: "
      "1}}\n";
  const std::string plane =
      "chain: [x, y, a, b]\nlinks:\n"
      "  x: {mass: 2, pin: [0.2, -0.1], ground_stiffness: 40, ground_x: 0.3,\n"
      "      joint: {type: prismatic, stiffness: 20}, initial: {position: 0.2, velocity: 1}}\n"
      "  y: {mass: 0.7, pin: [0, 0.3], ground_stiffness: 25, ground_y: 0.2,\n"
      "      joint: {type: prismatic, axis: [0.2, 1], damping: 2}, initial: {position: -0.1, velocity: "
      "-2}}\n";
  const std::string driven =
      "chain: [x, y, a, b]\nlinks:\n"
      "  x: {mass: 2, pin: [0.2, -0.1], ground_stiffness: 40, ground_x: 0.3,\n"
      "      joint: {type: prismatic, drive: {amplitude: 0.2, frequency: 1.3}}}\n"
      "  y: {mass: 0.7, pin: [0, 0.3], ground_stiffness: 25, ground_y: 0.2,\n"
      "      joint: {type: prismatic, axis: [0.2, 1], damping: 2}, initial: {position: -0.1, velocity: "
      "-2}}\n";
  const std::string loads =
      "loads: {push: {link: x, force: [3, -1], frequency: 0.3}, wind: {link: b, force: [1, 2], point: [0.1, "
      "0.2], frequency: 0.8}}\n";
  const std::string moves =
      "base: {x: {amplitude: 0.2, frequency: 1.1, phase: 0.4}, angle: {amplitude: 0.6, frequency: 0.8, "
      "offset: 0.3}}\n";
  for (const std::string& slides : {rails, plane, driven}) {
    for (const std::string& base : {std::string(), moves}) {
      SCOPED_TRACE(slides + base);
      const std::string bodies = chainOf(2, loads + base);
      test::EffectLaws(readSceneText(slides + bodies.substr(bodies.find("  a:"))), 0.1).expectAll();
    }
  }
}

TEST_F(ForcesOfPlace, LetNoEquilibriumBeSought) {
  try {
    readSceneText(chainOf(3, "start: rest\n"));
    FAIL() << "an equilibrium is sought";
  } catch (const Refused& refused) {
    EXPECT_EQ(toString(refused.faults()),
              "start: expected initial, as there is no equilibrium, got forces that depend on place, beside "
              "which none is sought");
  }
}

}  // namespace
}  // namespace planar_chain
