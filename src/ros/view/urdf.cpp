#include "ros/view/urdf.h"

#include <tinyxml2.h>

#include <cmath>
#include <initializer_list>
#include <utility>

#include "planar_chain/fault.h"
#include "ros/view/drawing.h"

namespace planar_chain {

namespace {

// Sizes, in widths of a link.
constexpr double pinRadius = 0.72;
constexpr double bobRadius = 1.1;
constexpr double hatches = 5;

using Attributes = std::initializer_list<std::pair<const char*, std::string>>;

std::string xyz(Vec2d a) {
  return toText(a.x) + " " + toText(a.y) + " 0";
}

class Writer {
 public:
  Writer(const Scene& scene, const Frames& frames) : chain_(scene.chain), frames_(frames), drawing_(scene) {}

  std::string text() {
    out_.PushHeader(false, true);
    open("robot", {{"name", "planar_chain"}});
    for (const auto& [name, rgba] : {std::pair{"ground", "0.55 0.58 0.62 1"},
                                     {"pin", "0.80 0.82 0.85 1"},
                                     {"even", "0.20 0.55 0.85 1"},
                                     {"odd", "0.98 0.65 0.15 1"}}) {
      open("material", {{"name", name}});
      leaf("color", {{"rgba", rgba}});
      close();
    }
    upright();
    ground();
    for (int i = 0; i < chain_.size(); ++i) {
      link(i);
      joint(i);
    }
    close();
    return out_.CStr();
  }

 private:
  void open(const char* element, Attributes attributes = {}) {
    out_.OpenElement(element);
    for (const auto& [name, value] : attributes) out_.PushAttribute(name, value.c_str());
  }

  void close() { out_.CloseElement(); }

  /// An element without children.
  void leaf(const char* element, Attributes attributes) {
    open(element, attributes);
    close();
  }

  /// The world and the base frame. The plane of motion is vertical: y of the base is z of the world.
  void upright() {
    leaf("link", {{"name", frames_.world}});
    open("joint", {{"name", frames_.world + "-" + frames_.base}, {"type", "fixed"}});
    leaf("parent", {{"link", frames_.world}});
    leaf("child", {{"link", frames_.base}});
    leaf("origin", {{"xyz", "0 0 0"}, {"rpy", toText(std::acos(0.0)) + " 0 0"}});
    close();
  }

  /// A bearing as in engineering drawings: two struts from the pin to a bar, and hatching for the ground.
  void ground() {
    const double w = drawing_.bar;
    open("link", {{"name", frames_.base}});
    for (const double side : {-1.0, 1.0}) {
      box({side * 0.45 * w, 0.8 * w}, std::atan2(1.6, side * 0.9), 1.85 * w, 0.25 * w, 0.4 * w, "ground");
    }
    box({0, 1.7 * w}, 0, 4.4 * w, 0.25 * w, 0.6 * w, "ground");
    for (int k = 0; k < hatches; ++k) {
      box({(k - 1.7) * 0.85 * w, 2.15 * w}, 0.8, 1.1 * w, 0.12 * w, 0.3 * w, "ground");
    }
    close();
  }

  void link(int i) {
    const Link& body = chain_.links()[index(i)];
    const double w = drawing_.bar;
    open("link", {{"name", frames_.links[index(i)]}});

    // Write the mass properties.
    open("inertial");
    leaf("origin", {{"xyz", xyz(body.com)}, {"rpy", "0 0 0"}});
    leaf("mass", {{"value", toText(body.mass)}});
    const std::string half = toText(body.inertia / 2);
    leaf("inertia", {{"ixx", half},
                     {"ixy", "0"},
                     {"ixz", "0"},
                     {"iyy", half},
                     {"iyz", "0"},
                     {"izz", toText(body.inertia)}});
    close();

    // Draw the bars. Neighbours have different depths, so that faces that overlap at a pin do not flicker.
    const double depth = i % 2 == 0 ? w : 0.8 * w;
    const char* const paint = i % 2 == 0 ? "even" : "odd";
    for (const Bar& bar : barsOf(body, drawing_)) {
      const Vec2d along = bar.to - bar.from;
      if (length(along) == 0) continue;
      box(0.5 * (bar.from + bar.to), std::atan2(along.y, along.x), length(along), bar.share * w,
          bar.share * depth, paint);
    }

    // Draw the bob, the rounded tip and the inner pin.
    const bool isBob = isPoint(body, drawing_);
    if (isBob) visual(body.com, 0, "sphere", {{"radius", toText(bobRadius * w)}}, paint);
    if (i == chain_.size() - 1 && length(body.pin) > 0 && !isBob) cylinder(body.pin, w / 2, depth, paint);
    if (i == 0 || !isShort(body, drawing_)) cylinder({0, 0}, pinRadius * w, 1.3 * w, "pin");
    close();
  }

  void joint(int i) {
    const Joint& own = chain_.joints()[index(i)];
    open("joint", {{"name", own.name}, {"type", own.isLimited() ? "revolute" : "continuous"}});
    leaf("parent", {{"link", i == 0 ? frames_.base : frames_.links[index(i - 1)]}});
    leaf("child", {{"link", frames_.links[index(i)]}});
    leaf("origin", {{"xyz", xyz(i == 0 ? Vec2d{} : chain_.links()[index(i - 1)].pin)}, {"rpy", "0 0 0"}});
    leaf("axis", {{"xyz", "0 0 1"}});
    leaf("dynamics", {{"damping", toText(own.damping)}, {"friction", "0"}});
    if (own.isLimited()) {
      // URDF requires all four limits. Those that the scene does not set are never reached.
      constexpr double never = 1e9;
      leaf("limit", {{"lower", toText(std::fmax(own.lower, -never))},
                     {"upper", toText(std::fmin(own.upper, never))},
                     {"effort", toText(never)},
                     {"velocity", toText(never)}});
    }
    close();
  }

  void visual(Vec2d centre, double angle, const char* shape, Attributes size, const char* paint) {
    open("visual");
    leaf("origin", {{"xyz", xyz(centre)}, {"rpy", "0 0 " + toText(angle)}});
    open("geometry");
    leaf(shape, size);
    close();
    leaf("material", {{"name", paint}});
    close();
  }

  void box(Vec2d centre, double angle, double x, double y, double z, const char* paint) {
    visual(centre, angle, "box", {{"size", toText(x) + " " + toText(y) + " " + toText(z)}}, paint);
  }

  void cylinder(Vec2d centre, double radius, double height, const char* paint) {
    visual(centre, 0, "cylinder", {{"radius", toText(radius)}, {"length", toText(height)}}, paint);
  }

  const Chain& chain_;
  const Frames& frames_;
  Drawing drawing_;
  tinyxml2::XMLPrinter out_;
};

}  // namespace

std::string urdfOf(const Scene& scene, const Frames& frames) {
  return Writer(scene, frames).text();
}

}  // namespace planar_chain
