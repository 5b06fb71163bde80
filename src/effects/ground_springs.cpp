#include "effects/ground_springs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "effects/loads.h"
#include "effects/point_forces.h"

namespace planar_chain {

namespace {

/// The line from the ground to a point.
struct Line {
  Line(const GroundSpring& spring, const PointAt<double>& at) {
    const Vec2d along = at.position - spring.ground;
    L = length(along);
    if (L > 0) u = 1 / L * along;
    rate = dot(u, at.velocity);
    stretch = L - spring.restLength;
  }
  double pull(const GroundSpring& spring) const { return spring.stiffness * stretch + spring.damping * rate; }

  double L, stretch, rate;  ///< m, L − L_0, L̇
  Vec2d u;
};

enum class State { slack, pulls, relaxes };

State stateOn(const GroundSpring& spring, const Line& line) {
  if (!spring.goesSlack) return State::pulls;
  if (!(line.stretch > 0)) return State::slack;
  return line.pull(spring) > 0 ? State::pulls : State::relaxes;
}

class GroundSprings : public PointForces, public Events, private ode::EventFunctions {
 public:
  explicit GroundSprings(const Chain& chain) : PointForces(chain), n_(chain.size()) {
    int last = 0;
    for (int j = 0; j < n_; ++j) {
      for (const GroundSpring& spring : chain.links()[index(j)].springs) {
        if (spring.stiffness == 0 && spring.damping == 0) continue;
        add({j, spring.point});
        springs_.push_back(spring);
        if (!spring.goesSlack) continue;
        slack_.push_back(springs_.size() - 1);
        last = j + 1;
      }
    }
    states_.resize(springs_.size(), State::pulls);
    bodies_.emplace(chain, last);
    size_ = chain.reach();
  }
  bool empty() const { return springs_.empty(); }
  bool dependOnPosition() const override { return true; }
  bool hasPower() const override {
    return std::any_of(springs_.begin(), springs_.end(),
                       [](const GroundSpring& spring) { return spring.damping > 0; });
  }

  PointForce force(std::size_t i, const PointAt<double>& at) const override {
    const GroundSpring& spring = springs_[i];
    const Line line(spring, at);
    const double k = spring.stiffness, d = spring.damping;
    if (spring.restLength == 0) {
      return {-k * (at.position - spring.ground) - d * at.velocity, d * dot(at.velocity, at.velocity)};
    }
    if (states_[i] == State::slack) return {};
    if (states_[i] == State::relaxes) return {{}, -k * line.stretch * line.rate};
    return {-line.pull(spring) * line.u, d * line.rate * line.rate};
  }

  void saveOrRestore(Snapshot& snapshot) override { snapshot(states_); }

  // Slack springs have events.
  void addEvents(ode::EventList& to) const override { to.push_back(this); }
  Events* events() override { return slack_.empty() ? nullptr : this; }
  void takeBase(const BaseLaws* laws) override { base_ = laws; }
  void enterState(double t, const double* y) override {
    find(t, y);
    for (const std::size_t i : slack_) states_[i] = stateOn(springs_[i], lineOf(i));
  }
  void takeFrom(const Events& other) override { states_ = static_cast<const GroundSprings&>(other).states_; }
  void fire(double t, double* y, const ode::LocatedEvent& /*located*/) override {
    find(t, y);
    for (const std::size_t i : slack_) {
      double g[2];
      findEvents(i, g);
      if (g[0] > 0 || g[1] > 0) states_[i] = stateOn(springs_[i], lineOf(i));
    }
  }

 private:
  // Two event functions of each.
  int most() const override { return 2 * static_cast<int>(slack_.size()); }
  void values(double t, const double* y, double* g) const override {
    find(t, y);
    for (std::size_t k = 0; k < slack_.size(); ++k) findEvents(slack_[k], g + 2 * k);
  }
  void noise(double t, const double* y, double* of) const override {
    find(t, y);
    for (const std::size_t i : slack_) of = std::fill_n(of, 2, 2 * noise(i));
  }
  bool changeStiffness() const override { return true; }

  PointTangent tangent(std::size_t i, const PointAt<double>& at) const override {
    const GroundSpring& spring = springs_[i];
    const Line line(spring, at);
    const auto& [L, stretch, rate, u] = line;
    const double k = spring.stiffness, d = spring.damping;
    if (spring.restLength == 0) return {{-k, 0, 0, -k}, {-d, 0, 0, -d}, {}, 2 * d * at.velocity};
    if (states_[i] == State::slack || L == 0) return {};
    const Vec2d w = 1 / L * (at.velocity - rate * u);  // ∂L̇/∂x
    if (states_[i] == State::relaxes) return {{}, {}, -k * (rate * u + stretch * w), -k * stretch * u};
    const double across = line.pull(spring) / L;
    const Vec2d along = (k - across) * u + d * w;
    return {{-u.x * along.x - across, -u.x * along.y, -u.y * along.x, -u.y * along.y - across},
            {-d * u.x * u.x, -d * u.x * u.y, -d * u.x * u.y, -d * u.y * u.y},
            2 * d * rate * w,
            2 * d * rate * u};
  }

  /// Takes a state for lineOf() and findEvents().
  void find(double t, const double* y) const {
    bodies_->find(base_ ? planar_chain::stateOf(*base_, t) : BaseState{}, y, y + n_);
  }
  Line lineOf(std::size_t i) const { return {springs_[i], bodies_->of(points()[i].body, points()[i].point)}; }
  /// Two event functions, of the stretch and of S/k, m: above 0 if the state ends. Both must be wrong by more
  /// than rounding, as k x and d L̇ may cancel.
  void findEvents(std::size_t i, double* g) const {
    const Line line = lineOf(i);
    const State state = states_[i];
    const double push = line.pull(springs_[i]) / springs_[i].stiffness, least = noise(i);
    g[0] = state == State::pulls ? ode::never : (state == State::slack ? 1 : -1) * line.stretch - least;
    g[1] = state == State::slack ? ode::never : (state == State::relaxes ? 1 : -1) * push - least;
  }
  /// Bounds the rounding of L and S/k, m.
  double noise(std::size_t i) const {
    const double lag = springs_[i].damping / springs_[i].stiffness;
    const PointAt<double> at = bodies_->of(points()[i].body, points()[i].point);
    return 16 * std::numeric_limits<double>::epsilon() *
           (size_ + length(at.position) + length(springs_[i].ground) + lag * length(at.velocity));
  }

  int n_;
  std::vector<GroundSpring> springs_;
  std::vector<std::size_t> slack_;  ///< the numbers of those that go slack
  std::vector<State> states_;
  const BaseLaws* base_ = nullptr;
  double size_;  ///< m
  mutable std::optional<BodyMotions> bodies_;
};

// ---- The kind --------------------------------------------------------------------------------------

class GroundSpringKind : public EffectKind {
 public:
  const char* sceneKey() const override { return "springs"; }
  void takeScene(const Section& top, const ChainNames* names, std::vector<Link>& links,
                 std::vector<Load>& /*loads*/) const override {
    const Section all = top.section("springs");
    for (const auto& [name, entry] : all.entries()) {
      if (!isName(name)) all.fault(name, nameInWords, quoted(name));
      const Section in =
          all.section(name, {"link", "point", "ground", "stiffness", "damping", "rest_length", "slack"});
      if (!entry.map()) continue;
      GroundSpring spring{name, {}, {}};
      if (!in.has("link")) in.fault("link", "the link that the spring pulls");
      const int link = takeReference(in, "link", names);
      if (link != Load::none) spring.point = names->com[index(link)];
      in.take("point", "m", spring.point);
      if (!in.has("ground")) in.fault("ground", "[x, y] in m, the point of the ground");
      in.take("ground", "m", spring.ground);
      in.take("slack", spring.goesSlack);
      if (!in.has("stiffness")) in.fault("stiffness", "a number" + stiffness(spring).which);
      in.take("stiffness", stiffness(spring), spring.stiffness);
      in.take("damping", damping_, spring.damping);
      if (spring.goesSlack && !in.has("rest_length"))
        in.fault("rest_length", "a number" + restLength(spring).which);
      in.take("rest_length", restLength(spring), spring.restLength);
      Link alone;
      alone.springs = {spring};
      std::vector<Fault> faults;  // reported above
      judge(alone, faults);
      if (link != Load::none && faults.empty()) links[index(link)].springs.push_back(spring);
    }
  }
  void judge(const Link& link, std::vector<Fault>& faults) const override {
    for (const GroundSpring& spring : link.springs) {
      const std::string path = "springs/" + spring.name + "/";
      for (const auto& [key, value] : {std::pair("point", spring.point), {"ground", spring.ground}}) {
        NumberRule::any("m").check(faults, path + key + "/0", value.x);
        NumberRule::any("m").check(faults, path + key + "/1", value.y);
      }
      stiffness(spring).check(faults, path + "stiffness", spring.stiffness);
      damping_.check(faults, path + "damping", spring.damping);
      restLength(spring).check(faults, path + "rest_length", spring.restLength);
    }
  }

  std::unique_ptr<Effect> make(const Scene& scene) const override {
    return makeUnlessEmpty<GroundSprings>(scene.chain);
  }
  void addDense(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd,
                const DenseActions& to) const override {
    GroundSprings springs(scene.chain);
    if (springs.empty()) return;
    const Coordinates& coordinates = scene.chain.coordinates();
    Eigen::VectorXd y(2 * q.size());
    coordinates.toAbsolute(q.data(), y.data());
    coordinates.toAbsolute(qd.data(), y.data() + q.size());
    springs.takeBase(scene.base ? &*scene.base : nullptr);
    springs.enterState(t, y.data());
    addDenseForces(springs, scene, t, q, qd, to);
  }
  void summarize(const Scene& scene, SceneWords& words) const override {
    std::size_t number = 0;
    for (const Link& link : scene.chain.links()) number += link.springs.size();
    if (number > 0) words.count(static_cast<int>(number), "ground spring");
  }

  double energyOf(const Link& link, const PosedBody& at) const override {
    double energy = 0;
    for (const GroundSpring& spring : link.springs) {
      const Line line(spring, {at.pin + at.e * spring.point, {}});
      const double stretch = spring.goesSlack ? std::max(0.0, line.stretch) : line.stretch;
      energy += 0.5 * (spring.stiffness * stretch * stretch);
    }
    return energy;
  }
  double stiffnessOf(const Link& link) const override {
    double sum = 0;
    for (const GroundSpring& spring : link.springs) sum += spring.stiffness;
    return sum;
  }

 private:
  const NumberRule& stiffness(const GroundSpring& spring) const {
    return spring.goesSlack ? slackStiffness_ : stiffness_;
  }
  const NumberRule& restLength(const GroundSpring& spring) const {
    return spring.goesSlack ? slackLength_ : length_;
  }

  const NumberRule stiffness_ = NumberRule::coefficient("N/m");
  const NumberRule slackStiffness_{" > 0 N/m of a slack spring", 0, largestFactor, false, ", at most 1e100"};
  const NumberRule damping_ = NumberRule::coefficient("N s/m");
  const NumberRule length_ = NumberRule::from(0, "m"),
                   slackLength_ = NumberRule::above(0, "m of a slack spring");
};

}  // namespace

const EffectKind& groundSpringKind() {
  static const GroundSpringKind kind;
  return kind;
}

double pullOf(const GroundSpring& spring, Vec2d x, Vec2d v) {
  if (spring.restLength == 0) return length(spring.stiffness * (x - spring.ground) + spring.damping * v);
  const Line line(spring, {x, v});
  return stateOn(spring, line) == State::pulls ? line.pull(spring) : 0;
}

}  // namespace planar_chain
