#include "ros/view/urdf.h"

#include <cmath>
#include <sstream>

#include "planar_chain/value.h"
#include "ros/view/drawing.h"

namespace planar_chain {

namespace {

// Sizes, in widths of a link.
constexpr double pinRadius = 0.72;
constexpr double bobRadius = 1.1;
constexpr double hatches = 5;

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string xyz(Vec2d a) {
  return toText(a.x) + " " + toText(a.y) + " 0";
}

class Writer {
 public:
  Writer(const Scene& scene, const Frames& frames) : chain_(scene.chain), frames_(frames), drawing_(scene) {}

  std::string text() {
    out_ << "<?xml version=\"1.0\"?>\n<robot name=\"planar_chain\">\n";
    materials();
    upright();
    ground();
    for (int i = 0; i < chain_.size(); ++i) {
      link(i);
      joint(i);
    }
    out_ << "</robot>\n";
    return out_.str();
  }

 private:
  void materials() {
    material("ground", "0.55 0.58 0.62 1");
    material("pin", "0.80 0.82 0.85 1");
    material("even", "0.20 0.55 0.85 1");
    material("odd", "0.98 0.65 0.15 1");
  }

  void material(const char* name, const char* rgba) {
    out_ << "  <material name=\"" << name << "\"><color rgba=\"" << rgba << "\"/></material>\n";
  }

  /// The plane of motion stands upright: y of the base up along z of the world.
  void upright() {
    out_ << "  <link name=\"" << escaped(frames_.world) << "\"/>\n"
         << "  <joint name=\"" << escaped(frames_.world + "-" + frames_.base) << "\" type=\"fixed\">\n"
         << "    <parent link=\"" << escaped(frames_.world) << "\"/>\n"
         << "    <child link=\"" << escaped(frames_.base) << "\"/>\n"
         << "    <origin xyz=\"0 0 0\" rpy=\"" << toText(std::acos(0.0)) << " 0 0\"/>\n"
         << "  </joint>\n";
  }

  /// A bearing as engineers draw it: two struts from the pin to a bar, and hatching where the ground is.
  void ground() {
    const double w = drawing_.bar;
    out_ << "  <link name=\"" << escaped(frames_.base) << "\">\n";
    for (const double side : {-1.0, 1.0}) {
      visual({side * 0.45 * w, 0.8 * w}, std::atan2(1.6, side * 0.9), box(1.85 * w, 0.25 * w, 0.4 * w),
             "ground");
    }
    visual({0, 1.7 * w}, 0, box(4.4 * w, 0.25 * w, 0.6 * w), "ground");
    for (int k = 0; k < hatches; ++k) {
      visual({(k - 1.7) * 0.85 * w, 2.15 * w}, 0.8, box(1.1 * w, 0.12 * w, 0.3 * w), "ground");
    }
    out_ << "  </link>\n";
  }

  void link(int i) {
    const Link& body = chain_.links()[static_cast<std::size_t>(i)];
    const double w = drawing_.bar;
    // Neighbours differ in depth too, so that faces which overlap at a pin do not flicker.
    const double depth = i % 2 == 0 ? w : 0.8 * w;

    out_ << "  <link name=\"" << escaped(frames_.links[static_cast<std::size_t>(i)]) << "\">\n"
         << "    <inertial>\n"
         << "      <origin xyz=\"" << xyz(body.com) << "\" rpy=\"0 0 0\"/>\n"
         << "      <mass value=\"" << toText(body.mass) << "\"/>\n"
         << "      <inertia ixx=\"" << toText(body.inertia / 2) << "\" ixy=\"0\" ixz=\"0\" iyy=\""
         << toText(body.inertia / 2) << "\" iyz=\"0\" izz=\"" << toText(body.inertia) << "\"/>\n"
         << "    </inertial>\n";
    const char* const paint = i % 2 == 0 ? "even" : "odd";
    for (const Bar& bar : barsOf(body, drawing_)) {
      const Vec2d along = bar.to - bar.from;
      if (length(along) == 0) continue;
      visual(0.5 * (bar.from + bar.to), std::atan2(along.y, along.x),
             box(length(along), bar.share * w, bar.share * depth), paint);
    }
    if (isPoint(body, drawing_)) visual(body.com, 0, sphere(bobRadius * w), paint);
    const bool endsInABar = i == chain_.size() - 1 && length(body.pin) > 0 && !isPoint(body, drawing_);
    if (endsInABar) visual(body.pin, 0, cylinder(w / 2, depth), paint);
    if (i == 0 || !isShort(body, drawing_)) visual({0, 0}, 0, cylinder(pinRadius * w, 1.3 * w), "pin");
    out_ << "  </link>\n";
  }

  void joint(int i) {
    const auto at = static_cast<std::size_t>(i);
    const std::string parent = escaped(i == 0 ? frames_.base : frames_.links[at - 1]);
    const Vec2d origin = i == 0 ? Vec2d{} : chain_.links()[at - 1].pin;
    const Joint& own = chain_.joints()[at];
    out_ << "  <joint name=\"" << escaped(own.name) << "\" type=\""
         << (own.isLimited() ? "revolute" : "continuous") << "\">\n"
         << "    <parent link=\"" << parent << "\"/>\n"
         << "    <child link=\"" << escaped(frames_.links[at]) << "\"/>\n"
         << "    <origin xyz=\"" << xyz(origin) << "\" rpy=\"0 0 0\"/>\n"
         << "    <axis xyz=\"0 0 1\"/>\n"
         << "    <dynamics damping=\"" << toText(own.damping) << "\" friction=\"0\"/>\n";
    if (own.isLimited()) {
      // URDF wants both limits and knows none for effort and velocity: numbers that are never reached.
      constexpr double never = 1e9;
      out_ << "    <limit lower=\"" << toText(std::fmax(own.lower, -never)) << "\" upper=\""
           << toText(std::fmin(own.upper, never)) << "\" effort=\"" << toText(never) << "\" velocity=\""
           << toText(never) << "\"/>\n";
    }
    out_ << "  </joint>\n";
  }

  void visual(Vec2d centre, double angle, const std::string& geometry, const char* colour) {
    out_ << "    <visual>\n"
         << "      <origin xyz=\"" << xyz(centre) << "\" rpy=\"0 0 " << toText(angle) << "\"/>\n"
         << "      <geometry>" << geometry << "</geometry>\n"
         << "      <material name=\"" << colour << "\"/>\n"
         << "    </visual>\n";
  }

  static std::string box(double x, double y, double z) {
    return "<box size=\"" + toText(x) + " " + toText(y) + " " + toText(z) + "\"/>";
  }

  static std::string cylinder(double radius, double height) {
    return "<cylinder radius=\"" + toText(radius) + "\" length=\"" + toText(height) + "\"/>";
  }

  static std::string sphere(double radius) { return "<sphere radius=\"" + toText(radius) + "\"/>"; }

  const Chain& chain_;
  const Frames& frames_;
  Drawing drawing_;
  std::ostringstream out_;
};

}  // namespace

std::string urdfOf(const Scene& scene, const Frames& frames) {
  return Writer(scene, frames).text();
}

}  // namespace planar_chain
