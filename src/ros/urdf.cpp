#include "planar_chain/ros/urdf.h"

#include <cmath>
#include <sstream>

#include "planar_chain/value.h"

namespace planar_chain {

namespace {

// Sizes of what is drawn, in drawing units.
constexpr double barWidth = 0.09;
constexpr double pinRadius = 0.065;
constexpr double comRadius = 0.07;

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

/// What is drawn scales with the mean length of a link; where links are many and short, with that of the
/// chain, or a rope would be too thin to see.
double drawingUnit(const Chain& chain) {
  double reach = 0;
  for (const Link& link : chain.links()) reach += std::fmax(length(link.pin), length(link.com));
  return reach > 0 ? reach / std::fmin(chain.size(), 8) : 1;
}

/// How far the centre of mass lies from the line between the pins.
double offLine(const Link& link) {
  const double l = length(link.pin);
  if (l == 0) return length(link.com);
  const double along = dot(link.com, link.pin) / l;
  const double beyond = along < 0 ? -along : std::fmax(0.0, along - l);
  return std::hypot(cross(link.pin, link.com) / l, beyond);
}

class Writer {
 public:
  Writer(const Scene& scene, const Frames& frames)
      : chain_(scene.chain), frames_(frames), unit_(drawingUnit(scene.chain)) {}

  std::string text() {
    out_ << "<?xml version=\"1.0\"?>\n<robot name=\"planar_chain\">\n";
    materials();
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
    material("com", "0.85 0.25 0.20 1");
    material("even", "0.20 0.55 0.85 1");
    material("odd", "0.98 0.65 0.15 1");
  }

  void material(const char* name, const char* rgba) {
    out_ << "  <material name=\"" << name << "\"><color rgba=\"" << rgba << "\"/></material>\n";
  }

  /// A bracket above the ground pin, as deep as the bodies.
  void ground() {
    const double w = barWidth * unit_;
    out_ << "  <link name=\"" << escaped(frames_.base) << "\">\n";
    visual({0, 1.25 * w}, 0, box(4 * w, w / 2, w), "ground");
    visual({0, 0.5 * w}, 0, box(w, w, w / 2), "ground");
    out_ << "  </link>\n";
  }

  void link(int i) {
    const Link& body = chain_.links()[static_cast<std::size_t>(i)];
    const double l = length(body.pin);
    const double w = barWidth * unit_;
    // Neighbours differ in depth too, so that faces which overlap at a pin do not flicker.
    const double depth = i % 2 == 0 ? w : 0.8 * w;

    out_ << "  <link name=\"" << escaped(frames_.links[static_cast<std::size_t>(i)]) << "\">\n"
         << "    <inertial>\n"
         << "      <origin xyz=\"" << xyz(body.com) << "\" rpy=\"0 0 0\"/>\n"
         << "      <mass value=\"" << toText(body.mass) << "\"/>\n"
         << "      <inertia ixx=\"" << toText(body.inertia / 2) << "\" ixy=\"0\" ixz=\"0\" iyy=\""
         << toText(body.inertia / 2) << "\" iyz=\"0\" izz=\"" << toText(body.inertia) << "\"/>\n"
         << "    </inertial>\n";
    if (l > 0) {
      visual(0.5 * body.pin, std::atan2(body.pin.y, body.pin.x), box(l, w, depth),
             i % 2 == 0 ? "even" : "odd");
    }
    visual({0, 0}, 0, cylinder(pinRadius * unit_, 1.3 * w), "pin");
    if (offLine(body) > w / 2) visual(body.com, 0, sphere(comRadius * unit_), "com");
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
  double unit_;  ///< m
  std::ostringstream out_;
};

}  // namespace

std::string urdfOf(const Scene& scene, const Frames& frames) {
  return Writer(scene, frames).text();
}

}  // namespace planar_chain
