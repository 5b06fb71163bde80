#include "planar_chain/kinematics.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "dynamics/given_state.h"
#include "python/running.h"

namespace planar_chain::python {

namespace {

using Given = py::object;  // an array, or None

/// A frame, and the angles of the joints.
struct FrameAt {
  Frame frame;
  Eigen::VectorXd q;
};

py::array arrayOf(Vec2d v) {
  return py::cast(Eigen::Vector2d(v.x, v.y));
}

Vec2d pointOf(const Given& given, const char* name) {
  const std::vector<double> numbers = numbersOf(given, name, 2);
  for (const double number : numbers) {
    if (!std::isfinite(number)) throw Refused({{name, "two finite numbers, in m", toText(number)}});
  }
  return {numbers[0], numbers[1]};
}

/// The frame of a point of a link, or of this name.
Frame frameOf(const Scene& scene, const py::object& of, const Given& point) {
  const std::vector<Link>& links = scene.chain.links();
  const std::string name = py::isinstance<py::str>(of) ? textIn(of).value_or("") : "";
  const bool isLink =
      std::any_of(links.begin(), links.end(), [&](const Link& link) { return link.name == name; });
  if (py::isinstance<py::str>(of) && !isLink) {
    const bool isFrame = name == "tip" || std::any_of(scene.frames.begin(), scene.frames.end(),
                                                      [&](const Frame& one) { return one.name == name; });
    if (!isFrame) throw Refused({{"link", "a link, a frame of the scene, or tip", shown(of)}});
    const Frame frame = frameNamed(scene, name);
    if (!point.is_none())
      throw Refused({{"point", "no point beside a frame, which has its own", shown(point)}});
    return frame;
  }
  const int link = numberOf(of, links, "link", scene.chain.joints());
  return {links[index(link)].name, link, point.is_none() ? Vec2d{} : pointOf(point, "point")};
}

Eigen::VectorXd vectorOf(const Given& given, const char* name) {
  const std::vector<double> numbers = numbersOf(given, name);
  return Eigen::VectorXd::Map(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

/// The numbers that are given, or these.
Eigen::VectorXd orElse(const Given& given, const char* name, const std::vector<double>& otherwise) {
  if (!given.is_none()) return vectorOf(given, name);
  return Eigen::VectorXd::Map(otherwise.data(), static_cast<Eigen::Index>(otherwise.size()));
}

/// If `of` is a frame, its point is known, and the argument after it is q.
FrameAt frameAt(const Scene& scene, const py::object& of, Given point, Given q) {
  const std::vector<Link>& links = scene.chain.links();
  const bool isNamed = py::isinstance<py::str>(of) &&
                       std::none_of(links.begin(), links.end(),
                                    [&](const Link& link) { return of.equal(py::str(link.name)); });
  if (isNamed && q.is_none()) std::swap(point, q);
  return {frameOf(scene, of, point), orElse(q, "q", scene.q)};
}

Eigen::VectorXd position(const TreeAndScene& scene, const py::object& of, const Given& point, const Given& q,
                         const py::object& t, bool withAngle) {
  const auto [frame, at] = frameAt(scene.scene, of, point, q);
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(at.size());
  const FrameMotion found = motionOf(scene.scene, frame, numberOf(t, "t"), at, still, still);
  return Eigen::Vector3d(found.position.x, found.position.y, found.angle).head(withAngle ? 3 : 2);
}

Eigen::MatrixXd jacobian(const TreeAndScene& scene, const py::object& of, const Given& point, const Given& q,
                         const py::object& t, bool withAngle) {
  const auto [frame, at] = frameAt(scene.scene, of, point, q);
  return jacobianOf(scene.scene, frame, numberOf(t, "t"), at).topRows(withAngle ? 3 : 2);
}

FrameMotion motion(const TreeAndScene& scene, const py::object& of, const Given& point, const Given& q,
                   const Given& qd, const Given& qdd, const py::object& t) {
  const auto [frame, at] = frameAt(scene.scene, of, point, q);
  const std::vector<double> none(scene.scene.q.size(), 0.0);
  return motionOf(scene.scene, frame, numberOf(t, "t"), at, orElse(qd, "qd", scene.scene.qd),
                  orElse(qdd, "qdd", none));
}

Eigen::VectorXd inverse(const TreeAndScene& of, const py::object& what, const Given& target,
                        const Given& angle, const Given& start, const Given& point, const py::object& t) {
  std::optional<double> turned;
  if (!angle.is_none()) turned = numberOf(angle, "angle");
  std::optional<Eigen::VectorXd> from;
  if (!start.is_none()) from = vectorOf(start, "start");
  const Frame frame = frameOf(of.scene, what, point);
  const Vec2d place = pointOf(target, "target");
  const double when = numberOf(t, "t");
  const Reached reached =
      released([&] { return inverseKinematics(of.scene, frame, place, turned, from, when); });
  if (reached.isReached) return reached.q;
  std::string words = "the nearest place is " + toText(reached.distance) + " m from [" + toText(place.x) +
                      ", " + toText(place.y) + "]";
  if (turned) words += ", and " + toText(reached.turn) + " rad from the angle";
  const py::object type = py::module::import("planar_chain").attr("NotReached");
  py::object error = type(words);
  error.attr("distance") = reached.distance;
  error.attr("turn") = reached.turn;
  error.attr("q") = reached.q;
  PyErr_SetObject(type.ptr(), error.ptr());
  throw py::error_already_set();
}

constexpr const char* frames = R"(

link: the name or number of a link, with a point (m, link frame; default: the inner pin); or the name of a frame of
the scene, or 'tip', the outer pin of the last link, without one. q: n, rad (prismatic: m); default: the first
state. If the base moves, it is where its laws have it at t, s.)";

}  // namespace

void bindKinematics(py::module& module, py::class_<TreeAndScene>& scene) {
  const auto none = [](const char* name) { return py::arg(name) = py::none(); };
  const auto link = py::arg("link");
  const auto t = py::arg("t") = 0.0, withAngle = py::arg("with_angle") = false;
  const auto withFrames = [](const char* words) { return words + std::string(frames); };
  const auto motionOfFrame =
      py::class_<FrameMotion>(module, "FrameMotion", "The motion of a point and of its axes, base frame.")
          .def_property_readonly(
              "position", [](const FrameMotion& self) { return arrayOf(self.position); }, "x and y, m.")
          .def_readonly("angle", &FrameMotion::angle, "rad, not wrapped.")
          .def_property_readonly(
              "velocity", [](const FrameMotion& self) { return arrayOf(self.velocity); }, "m/s")
          .def_readonly("rate", &FrameMotion::rate, "rad/s")
          .def_property_readonly(
              "acceleration", [](const FrameMotion& self) { return arrayOf(self.acceleration); }, "m/s²")
          .def_readonly("angular_acceleration", &FrameMotion::angularAcceleration, "rad/s²");
  showFields(motionOfFrame,
             {"position", "angle", "velocity", "rate", "acceleration", "angular_acceleration"});
  scene
      .def("position", &position, link, none("point"), none("q"), t, withAngle,
           withFrames("Returns [x, y] of a point, m; with_angle: and its angle, rad.").c_str())
      .def("jacobian", &jacobian, link, none("point"), none("q"), t, withAngle,
           withFrames(
               "Returns J, 2 × n, of a point: its velocity on a base at rest is J q̇. with_angle: 3 × n, "
               "with the row of the\nrate, rad/s.")
               .c_str())
      .def("motion", &motion, link, none("point"), none("q"), none("qd"), none("qdd"), t,
           withFrames("Returns the FrameMotion of a point at the rates qd (n, default: the first state) and "
                      "accelerations qdd (n, default: 0).\nWith qdd = 0 its acceleration is J̇ q̇.")
               .c_str());
  static py::exception<std::runtime_error> notReached(module, "NotReached", PyExc_RuntimeError);
  notReached.attr("__doc__") =
      "Raised by inverse_kinematics(). distance: what is left, m; turn: of the angle, rad; q: the nearest "
      "angles.";
  module.def(
      "inverse_kinematics", &inverse, py::arg("scene"), link, py::arg("target"), none("angle"), none("start"),
      none("point"), t,
      withFrames(
          "Returns joint angles, n, at which a point is at the target [x, y], m, and has the angle, rad, if "
          "it "
          "is given.\n\nJoints stay within their limits, and driven ones where they are at t. Searched from "
          "`start` (n; default: the first state), then\nfrom other angles, the same ones each time. Raises "
          "NotReached, with `distance` and the nearest `q`.")
          .c_str());
}

void bindMotion(py::class_<Running>& simulation) {
  simulation.def(
      "motion",
      [](Running& self, const py::object& link, const Given& point) {
        return self.idle().motion(frameOf(self.idle().scene(), link, point));
      },
      py::arg("link"), py::arg("point") = py::none(),
      "Returns the present FrameMotion of a point of a link, given by name or number; or of a frame of the "
      "scene, or "
      "'tip', given\nby name, without a point.");
}

}  // namespace planar_chain::python
