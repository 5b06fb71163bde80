#include "ros/view/drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "effects/effect_kind.h"
#include "planar_chain/fault.h"
#include "scene/urdf_document.h"

namespace planar_chain {

namespace {

constexpr double barWidth = 0.09;       // units
constexpr double leastBar = 0.016;      // reaches
constexpr double leastInView = 0.0128;  // of half the view: as much, without rails and base
constexpr double thin = 0.4;            // share of the width
constexpr int fewLinks = 8;             // a longer chain has units of an eighth of its reach
constexpr double fewWidths = 2;         // links shorter than this are short
constexpr double longest = 1.5;         // units, of an arrow
constexpr double beyond = 0.2;          // spans, from the farthest points of the chain to the rim of the view

// In the URDF, in widths of a link:
constexpr double pinRadius = 0.72, bobRadius = 1.1;
constexpr double carriageHeight = 3.8;                // more than its brake
constexpr double railOffset = 0.75, railWidth = 0.2;  // of the two rails on a link, beside what slides
constexpr int hatches = 5;

constexpr std::array<Paint, 3> paints{
    {{"blue", 0.2, 0.55, 0.85}, {"orange", 0.98, 0.65, 0.15}, {"teal", 0.2, 0.68, 0.6}}};

/// Names contain only letters, digits, _ and /, so nothing is escaped.
class Writer {
 public:
  Writer(const Scene& scene, const Frames& frames)
      : scene_(scene), chain_(scene.chain), frames_(frames), drawing_(scene) {}

  std::string text(int links) {
    line("<?xml version='1.0'?>");
    line("<robot name='planar_chain'>");
    materials();
    // The plane of motion is vertical: y of the base is z of the world.
    line("<link name='", frames_.world, "'/>");
    line("<joint name='", frames_.world, "-", frames_.base, "' type='fixed'><parent link='", frames_.world,
         "'/><child link='", frames_.base, "'/><origin xyz='", scene_.publish.offset.x, " 0 ",
         scene_.publish.offset.y, "' rpy='", std::acos(0.0), " 0 0'/></joint>");
    if (scene_.base) pin();
    line("<link name='", frames_.pin, "'>");
    if (!hasOwnShapes()) line(scene_.appearance.visuals[0]);
    if (hasOwnShapes() && !floats(chain_))
      chain_.coordinates().leading() > 0
          ? rail({}, chain_.joints()[0].axis, railOf(scene_, 0, drawing_.links))
          : ground({});
    if (!scene_.base) tip();
    line("</link>");
    for (int i = 0; i < links; ++i) {
      link(i);
      joint(i);
    }
    for (const Frame& own : frames_.onLinks) {
      if (own.link < links) frame(own);
    }
    line("</robot>");
    std::replace(text_.begin(), text_.end(), '\'', '"');
    return text_;
  }

 private:
  bool hasOwnShapes() const { return scene_.appearance.visuals.empty(); }

  void materials() {
    if (!hasOwnShapes()) return line(scene_.appearance.materials);
    for (const auto& [name, rgba] : {std::pair{"ground", "0.55 0.58 0.62 1"}, {"pin", "0.80 0.82 0.85 1"}}) {
      line("<material name='", name, "'><color rgba='", rgba, "'/></material>");
    }
    for (const auto& [name, red, green, blue] : paints) {
      line("<material name='", name, "'><color rgba='", red, " ", green, " ", blue, " 1'/></material>");
    }
  }

  /// The moving base, where it starts. /tf moves it.
  void pin() {
    const BaseLaws& base = *scene_.base;
    line("<link name='", frames_.base, "'>");
    tip();
    line("</link>");
    line("<joint name='", frames_.base, "-", frames_.pin, "' type='fixed'><parent link='", frames_.base,
         "'/><child link='", frames_.pin, "'/><origin xyz='", Vec2d{base.x.at(0).value, base.y.at(0).value},
         "' rpy='0 0 ", base.angle.at(0).value, "'/></joint>");
  }

  /// Draws the pin or line that holds the tip, if it stands still.
  void tip() {
    if (!scene_.tip || scene_.tip->moves() || !hasOwnShapes()) return;
    const Vec2d at{scene_.tip->x.at(0).value, scene_.tip->y.at(0).value};
    if (!scene_.tip->line) return ground(at);
    rail(at, *scene_.tip->line, lineOf(scene_, drawing_));
  }

  void rail(Vec2d at, Vec2d axis, const Range& rail) {
    const double w = drawing_.bar;
    box(at + 0.5 * (rail.from + rail.to) * axis, std::atan2(axis.y, axis.x),
        rail.to - rail.from + carriageLength * w, 0.5 * w, 0.5 * w, "ground");
  }

  /// A bearing as in engineering drawings: two struts from the pin to a bar, and hatching for the ground.
  void ground(Vec2d at) {
    const double w = drawing_.bar;
    for (const double side : {-1.0, 1.0}) {
      box(at + Vec2d{side * 0.45 * w, 0.8 * w}, std::atan2(1.6, side * 0.9), 1.85 * w, 0.25 * w, 0.4 * w,
          "ground");
    }
    box(at + Vec2d{0, 1.7 * w}, 0, 4.4 * w, 0.25 * w, 0.6 * w, "ground");
    for (int k = 0; k < hatches; ++k) {
      box(at + Vec2d{(k - 1.7) * 0.85 * w, 2.15 * w}, 0.8, 1.1 * w, 0.12 * w, 0.3 * w, "ground");
    }
  }

  void link(int i) {
    const Link& body = chain_.links()[index(i)];
    const double half = body.inertia / 2;
    line("<link name='", frames_.links[index(i)], "'>");
    if (body.mass > 0)
      line("<inertial><origin xyz='", body.com, "' rpy='0 0 0'/><mass value='", body.mass,
           "'/><inertia ixx='", half, "' ixy='0' ixz='0' iyy='", half, "' iyz='0' izz='", body.inertia,
           "'/></inertial>");
    hasOwnShapes() ? shape(i) : line(scene_.appearance.visuals[index(i) + 1]);
    line("</link>");
  }

  void shape(int i) {
    const Link& body = chain_.links()[index(i)];
    const double w = drawing_.bar;
    if (i + 1 < chain_.size() && isInside(chain_, i + 1)) rails(i + 1);
    if (i < chain_.coordinates().leading()) return floats(chain_) ? void() : carriage(i);

    // Draw the bars. Neighbours have different depths, so that faces that overlap at a pin do not flicker.
    const double depth = i % 2 == 0 ? w : 0.8 * w;
    const char* const paint = paintOf(i).name;
    const Figure figure = figureOf(body, drawing_);
    for (const Bar& bar : figure.bars) {
      const Vec2d along = bar.to - bar.from;
      if (length(along) == 0) continue;
      box(0.5 * (bar.from + bar.to), std::atan2(along.y, along.x), length(along), bar.share * w,
          bar.share * depth, paint);
    }

    // Draw the bob, the rounded tip and the pins.
    if (figure.hasBob) visual(body.com, 0, paint, "<sphere radius='", bobRadius * w, "'/>");
    if (i == chain_.size() - 1 && length(body.pin) > 0 && !figure.hasBob)
      cylinder(body.pin, w / 2, depth, paint);
    if (isInside(chain_, i)) {
      const Vec2d axis = chain_.joints()[index(i)].axis;
      box({}, std::atan2(axis.y, axis.x), blockLength * w, 2 * railOffset * w, 1.2 * w, paint);
    } else if (i == 0 || figure.hasPin)
      cylinder({0, 0}, pinRadius * w, 1.3 * w, "pin");
    if (i == chain_.size() - 1 && scene_.tip) cylinder(body.pin, pinRadius * w, 1.3 * w, "pin");
  }

  /// Two rails on the link inside of a prismatic joint. Between them slides a block of the joint's own link.
  void rails(int joint) {
    const Range rail = railOf(scene_, joint, drawing_.links);
    const Vec2d axis = chain_.joints()[index(joint)].axis, pin = chain_.links()[index(joint - 1)].pin;
    const double w = drawing_.bar, half = halfBlock(chain_, joint) * w;
    for (const double side : {-1.0, 1.0}) {
      box(pin + 0.5 * (rail.from + rail.to) * axis + side * railOffset * w * perp(axis),
          std::atan2(axis.y, axis.x), rail.to - rail.from + 2 * half, railWidth * w, 1.4 * w, "ground");
    }
  }

  /// A box on its rail, with the pin on it that carries the next link.
  void carriage(int i) {
    const Vec2d axis = chain_.joints()[index(i)].axis, pin = chain_.links()[index(i)].pin;
    const double w = drawing_.bar, angle = std::atan2(axis.y, axis.x);
    box({}, angle, carriageLength * w, carriageHeight * w, 1.2 * w, paintOf(i).name);
    if (length(pin) > 0)
      box(0.5 * pin, std::atan2(pin.y, pin.x), length(pin), 0.6 * w, 0.6 * w, paintOf(i + 1).name);
    cylinder(pin, pinRadius * w, 1.4 * w, "pin");
  }

  /// The element of what URDF can say of a joint's effects.
  static std::string dynamicsOf(const Joint& joint) {
    std::map<std::string, double> attributes;
    for (const EffectKind* kind : effectKinds()) {
      for (const JointKey& key : kind->jointKeys()) {
        if (key.urdfDynamics) attributes[key.urdfDynamics] = key.of(joint);
      }
    }
    std::string element = "<dynamics";
    for (const auto& [name, value] : attributes) element += " " + name + "='" + toText(value) + "'";
    return element + "/>";
  }

  /// A link without mass and shape.
  void frame(const Frame& own) {
    const std::string name = frames_.of(own), &link = frames_.of(own.link);
    line("<link name='", name, "'/>");
    line("<joint name='", link, "-", name, "' type='fixed'><parent link='", link, "'/><child link='", name,
         "'/><origin xyz='", own.point, "' rpy='0 0 ", own.angle, "'/></joint>");
  }

  void joint(int i) {
    const Joint& own = chain_.joints()[index(i)];
    line("<joint name='", own.name, "' type='",
         own.isPrismatic   ? "prismatic"
         : own.isLimited() ? "revolute"
                           : "continuous",
         "'>");
    line("<parent link='", i == 0 ? frames_.pin : frames_.links[index(i - 1)], "'/><child link='",
         frames_.links[index(i)], "'/><origin xyz='", i == 0 ? Vec2d{} : chain_.links()[index(i - 1)].pin,
         "' rpy='0 0 0'/>");
    add("<axis xyz='");
    own.isPrismatic ? add(own.axis) : add("0 0 1");
    line("'/>", dynamicsOf(own));
    if (own.isPrismatic || own.isLimited() || own.has("effort_limit") || own.has("velocity_limit")) {
      // URDF requires all four limits. Those that the scene does not set are never reached.
      const auto limit = [&](const char* key) { return own.has(key) ? own.other(key) : noLimit; };
      line("<limit lower='", std::fmax(own.lower, -noLimit), "' upper='", std::fmin(own.upper, noLimit),
           "' effort='", limit("effort_limit"), "' velocity='", limit("velocity_limit"), "'/>");
    }
    line("</joint>");
  }

  template <class... Parts>
  void visual(Vec2d centre, double angle, const char* paint, const Parts&... shape) {
    line("<visual><origin xyz='", centre, "' rpy='0 0 ", angle, "'/><geometry>", shape...,
         "</geometry><material name='", paint, "'/></visual>");
  }

  void box(Vec2d centre, double angle, double x, double y, double z, const char* paint) {
    visual(centre, angle, paint, "<box size='", x, " ", y, " ", z, "'/>");
  }

  void cylinder(Vec2d centre, double radius, double height, const char* paint) {
    visual(centre, 0, paint, "<cylinder radius='", radius, "' length='", height, "'/>");
  }

  template <class... Parts>
  void line(const Parts&... parts) {
    (add(parts), ...);
    add("\n");
  }
  void add(const std::string& text) { text_ += text; }
  void add(double number) { text_ += toText(number); }
  void add(Vec2d a) { text_ += toText(a.x) + " " + toText(a.y) + " 0"; }

  const Scene& scene_;
  const Chain& chain_;
  const Frames& frames_;
  Drawing drawing_;
  std::string text_;
};

}  // namespace

Drawing::Drawing(const Scene& scene) : Extent(scene) {
  double mass = 0, shortest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < scene.chain.size(); ++i) {
    const Link& link = scene.chain.links()[index(i)];
    double pin = length(link.pin);
    if (i + 1 < scene.chain.size() && isInside(scene.chain, i + 1)) pin += travelOf(scene, i + 1, links);
    const double size = std::fmax(pin, length(link.com));
    if (i >= scene.chain.coordinates().leading() && size > 0) shortest = std::fmin(shortest, size);
    mass += link.mass;
  }
  unit = reach / std::min(scene.chain.size(), fewLinks);
  bar = std::fmax(barWidth * std::fmin(unit, shortest), std::fmax(leastBar * reach, leastInView * half));
  force = mass * length(scene.chain.gravity());
  if (force == 0) {
    for (const Load& load : scene.loads) {
      const bool pushes = load.joint != Load::none && scene.chain.joints()[index(load.joint)].isPrismatic;
      force = std::max({force, length(load.force), std::fabs(load.moment) / reach,
                        std::fabs(load.torque) / (pushes ? 1 : reach)});
    }
  }
  if (force == 0) force = 1;
  torque = force * reach / 2;
}

Vec2d Drawing::arrow(Vec2d f, Vec2d from) const {
  const double size = length(f);
  if (size == 0) return {};
  // Solve |from + room·f/|f|| = rim for the room, which is at least that of a stretched chain.
  from = from - middle;
  const double along = dot(from, f) / size, rim = (1 + beyond) * span;
  const double root = std::sqrt(std::fmax(0, along * along + rim * rim - dot(from, from)));
  const double room = std::fmax(beyond * span, root - along);
  return std::fmin(unit / 2 * size / force, std::fmin(longest * unit, room)) / size * f;
}

double Drawing::push(double f) const {
  return std::fmin(half / 4, span) * std::fmin(1, std::sqrt(std::fabs(f) / force));
}

double halfBlock(const Chain& chain, int joint) {
  return (isInside(chain, joint) ? blockLength : carriageLength) / 2;
}

bool floats(const Chain& chain) {
  return chain.coordinates().leading() == 2 && chain.links()[0].mass == 0 && chain.links()[1].mass == 0;
}

const Paint& paintOf(int link) {
  return paints[index(link) % paints.size()];
}

Figure figureOf(const Link& link, const Drawing& drawing) {
  const double l = length(link.pin), w = drawing.bar;
  if (l > 0 && l < fewWidths * w) return {{{{}, link.pin}}, false, false};
  const Bar pins{{}, link.pin, thin};

  // Is the centre of mass within half a width of the line through the pins?
  const double aside = l > 0 ? std::fabs(cross(link.pin, link.com)) / l : length(link.com);
  if (aside >= w / 2) return {{{{}, link.com}, {link.com, link.pin}, pins}};

  // The uniform rod with this mass and moment of inertia I = m r²/12. A short one is a bob; a bob beyond the
  // outer pin hangs on a longer bar. A rod that would extend beyond both pins ends at the farther one.
  double r = link.mass > 0 ? std::sqrt(12 * link.inertia / link.mass) : 0;
  if (l > 0) r = std::fmin(r, 2 * std::fmax(length(link.com), length(link.pin - link.com)));
  if (r < w) {
    const bool isBeyond = dot(link.com, link.pin) > l * l || l == 0;
    return {{isBeyond ? Bar{{}, link.com, thin} : pins}, true};
  }

  // Place the rod. If it spans the pins, it is the only bar.
  const Vec2d half = r / 2 * (l > 0 ? 1 / l * link.pin : Vec2d{1, 0});
  const Bar rod{link.com - half, link.com + half};
  if (length(rod.from) < w / 2 && length(rod.to - link.pin) < w / 2) return {{{{}, link.pin}}};
  return {{rod, pins}};
}

std::string urdfOf(const Scene& scene, const Frames& frames, bool hasLinks) {
  return Writer(scene, frames).text(hasLinks ? scene.chain.size() : 0);
}

std::vector<std::string> notInUrdf(const Scene& scene) {
  std::set<std::string> keys;
  const auto add = [&](bool isGiven, const char* key) {
    if (isGiven) keys.insert(key);
  };
  const Joint bare;
  for (const Joint& joint : scene.chain.joints()) {
    for (const EffectKind* kind : effectKinds()) {
      for (const JointKey& key : kind->jointKeys())
        add(!key.urdfDynamics && key.of(joint) != key.of(bare), key.name);
    }
  }
  for (const char* limit : {"lower", "upper", "effort_limit", "velocity_limit"}) keys.erase(limit);
  for (const Link& link : scene.chain.links()) {
    for (const auto& other : link.others) keys.insert(other.first.substr(0, other.first.find('/')));
    add(!link.springs.empty(), "springs");
  }
  for (int i = 0; i < scene.chain.size(); ++i) {
    add(scene.q[index(i)] != 0,
        scene.chain.coordinates().isPrismatic(i) ? "initial/position" : "initial/angle");
    add(scene.qd[index(i)] != 0, "initial/velocity");
  }
  add(!(scene.chain.gravity() == Vec2d{0, -9.81}), "gravity");
  add(!scene.drives.empty(), "drive");
  add(!scene.loads.empty(), "loads");
  add(scene.base.has_value(), "base");
  add(scene.tip.has_value(), "tip");
  return {keys.begin(), keys.end()};
}

}  // namespace planar_chain
