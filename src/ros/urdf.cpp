#include "planar_chain/ros/urdf.h"

#include <cmath>
#include <sstream>

#include "planar_chain/value.h"

namespace planar_chain {

namespace {

// Sizes of what is drawn, in mean lengths of a link.
constexpr double kWidth = 0.08;
constexpr double kPinRadius = 0.055;
constexpr double kComRadius = 0.06;

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

double length(Vec2d a) {
  return std::hypot(a.x, a.y);
}

/// Links without length count with the arm of their centre of mass; a point at the pin not at all.
double meanLength(const Chain& chain) {
  double sum = 0;
  int counted = 0;
  for (const Link& link : chain.links()) {
    const double size = std::fmax(length(link.pin), length(link.com));
    sum += size;
    if (size > 0) ++counted;
  }
  return counted > 0 ? sum / counted : 1.0;
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
  explicit Writer(const Scene& scene)
      : scene_(scene), unit_(meanLength(scene.chain)), base_(escaped(scene.publish.baseFrame)) {}

  std::string text() {
    out_ << "<?xml version=\"1.0\"?>\n<robot name=\"planar_chain\">\n";
    materials();
    ground();
    for (int i = 0; i < scene_.chain.size(); ++i) {
      link(i);
      joint(i);
    }
    out_ << "</robot>\n";
    return out_.str();
  }

 private:
  void materials() {
    material("ground", "0.25 0.27 0.30 1");
    material("pin", "0.16 0.18 0.22 1");
    material("com", "0.85 0.25 0.20 1");
    material("even", "0.16 0.47 0.71 1");
    material("odd", "0.95 0.62 0.15 1");
  }

  void material(const char* name, const char* rgba) {
    out_ << "  <material name=\"" << name << "\"><color rgba=\"" << rgba << "\"/></material>\n";
  }

  /// A bracket above the ground pin, as deep as the bodies.
  void ground() {
    const double w = kWidth * unit_;
    out_ << "  <link name=\"" << base_ << "\">\n";
    visual({0, 1.25 * w}, 0, box(4 * w, w / 2, w), "ground");
    visual({0, 0.5 * w}, 0, box(w, w, w / 2), "ground");
    out_ << "  </link>\n";
  }

  void link(int i) {
    const Link& body = scene_.chain.links()[static_cast<std::size_t>(i)];
    const double l = length(body.pin);
    const double w = kWidth * unit_;
    // Neighbours differ in depth too, so that faces which overlap at a pin do not flicker.
    const double depth = i % 2 == 0 ? w : 0.8 * w;

    out_ << "  <link name=\"" << escaped(body.name) << "\">\n"
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
    visual({0, 0}, 0, cylinder(kPinRadius * unit_, 1.3 * w), "pin");
    if (offLine(body) > w / 2) visual(body.com, 0, sphere(kComRadius * unit_), "com");
    out_ << "  </link>\n";
  }

  void joint(int i) {
    const auto at = static_cast<std::size_t>(i);
    const Chain& chain = scene_.chain;
    const std::string parent = i == 0 ? base_ : escaped(chain.links()[at - 1].name);
    const Vec2d origin = i == 0 ? Vec2d{} : chain.links()[at - 1].pin;
    out_ << "  <joint name=\"" << escaped(chain.joints()[at].name) << "\" type=\"continuous\">\n"
         << "    <parent link=\"" << parent << "\"/>\n"
         << "    <child link=\"" << escaped(chain.links()[at].name) << "\"/>\n"
         << "    <origin xyz=\"" << xyz(origin) << "\" rpy=\"0 0 0\"/>\n"
         << "    <axis xyz=\"0 0 1\"/>\n"
         << "    <dynamics damping=\"" << toText(chain.joints()[at].damping) << "\" friction=\"0\"/>\n"
         << "  </joint>\n";
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

  const Scene& scene_;
  double unit_;  ///< mean length of a link, m
  std::string base_;
  std::ostringstream out_;
};

}  // namespace

std::string urdfOf(const Scene& scene) {
  return Writer(scene).text();
}

}  // namespace planar_chain
