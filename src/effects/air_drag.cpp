#include "effects/air_drag.h"

#include "effects/point_forces.h"

namespace planar_chain {

namespace {

constexpr const char *x = "drag/point/0", *y = "drag/point/1";

class AirDrags : public PointForces {
 public:
  explicit AirDrags(const Chain& chain) : PointForces(chain) {
    for (int j = 0; j < chain.size(); ++j) {
      const Link& link = chain.links()[index(j)];
      const auto [c, point] = airDragOf(link);
      if (c <= 0) continue;
      add({j, point});
      coefficients_.push_back(c);
    }
  }
  bool empty() const { return coefficients_.empty(); }

  PointForce force(std::size_t i, const PointAt<double>& at) const override {
    const Vec2d v = at.velocity;
    const double cv = coefficients_[i] * length(v);
    return {-cv * v, cv * dot(v, v)};
  }

 private:
  PointTangent tangent(std::size_t i, const PointAt<double>& at) const override {
    const Vec2d v = at.velocity;
    const double c = coefficients_[i], speed = length(v);
    const Vec2d u = speed > 0 ? 1 / speed * v : Vec2d{};
    const double cv = c * speed;
    return {
        {}, {-cv * (1 + u.x * u.x), -cv * u.x * u.y, -cv * u.x * u.y, -cv * (1 + u.y * u.y)}, {}, 3 * cv * v};
  }

  std::vector<double> coefficients_;  ///< c, N s²/m²
};

class AirDragKind : public EffectKind {
 public:
  const char* linkKey() const override { return "drag"; }
  void takeLink(const Section& in, Link& link) const override {
    const bool isMap = in.find("drag")->map();
    Vec2d point;
    double c = 0;
    if (isMap) {
      const Section drag = in.section("drag", {"coefficient", "point"});
      if (!drag.has("coefficient")) drag.fault("coefficient", "the drag's coefficient, in N s²/m²");
      if (drag.take("point", "m", point)) {
        link.others.set(x, point.x);
        link.others.set(y, point.y);
      }
    }
    if (in.take(isMap ? "drag/coefficient" : "drag", range_, c)) link.others.set("drag", c);
  }
  void judge(const Link& link, std::vector<Fault>& faults) const override {
    range_.check(faults, "drag", link.others.of("drag"));
    for (const char* key : {x, y}) NumberRule::any("m").check(faults, key, link.others.of(key));
  }

  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return makeUnlessEmpty<AirDrags>(scene.chain);
  }
  void addDense(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd,
                const DenseActions& to) const override {
    addDenseForces(AirDrags(scene.chain), scene, t, q, qd, to);
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    const auto number = static_cast<int>(AirDrags(scene.chain).points().size());
    if (number > 0) words.count(number, "air drag");
  }

 private:
  const NumberRule range_ = NumberRule::coefficient("N s²/m²");
};

}  // namespace

AirDrag airDragOf(const Link& link) {
  const NamedNumbers& has = link.others;
  return {has.of("drag"), has.has(x) ? Vec2d{has.of(x), has.of(y)} : link.com};
}

const EffectKind& airDragKind() {
  static const AirDragKind kind;
  return kind;
}

}  // namespace planar_chain
