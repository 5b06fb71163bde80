/// Commands: torques, forces, and laws that driven joints and the base follow.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "model/number_rule.h"
#include "python/running.h"

namespace planar_chain::python {

namespace {

/// Holds all of them or, with faults, none.
void holdTorques(Simulation& simulation, const std::vector<double>& tau) {
  std::vector<bool> isDriven(tau.size());
  for (const Drive& drive : simulation.scene().drives) isDriven[static_cast<std::size_t>(drive.joint)] = true;
  std::vector<Fault> faults;
  for (std::size_t i = 0; i < tau.size(); ++i) {
    if (isDriven[i] ? tau[i] == 0 : isFactor(tau[i])) continue;
    const std::string expected =
        isDriven[i] ? "0 N m in a driven joint" : factorInWords(tau[i]) + std::string(", in N m");
    faults.push_back({"torques/" + std::to_string(i), expected, toText(tau[i])});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
  for (std::size_t i = 0; i < tau.size(); ++i) {
    if (!isDriven[i]) simulation.holdTorque(static_cast<int>(i), tau[i], forever);
  }
}

void requireTaken(bool isTaken) {
  if (!isTaken) throw std::runtime_error("as many commands as Simulation(commands=...) allows wait already");
}

Vec2d pairOf(const py::object& given, const char* name) {
  const std::vector<double> xy = numbersOf(given, name, 2);
  if (!std::all_of(xy.begin(), xy.end(), isFactor))
    throw Refused({{name, "two numbers from -1e100 to 1e100", shown(given)}});
  return {xy[0], xy[1]};
}

/// A point of a link: its centre of mass, if none is given.
Vec2d pointOf(const py::object& given, const Link& link) {
  return given.is_none() ? link.com : pairOf(given, "point");
}

// ---- Laws ----------------------------------------------------------------------------------------

/// Points in time with one column of values for each motion.
class CommandedTrajectory {
 public:
  /// values, rates and accelerations: times × columns; the last two may be None. One column may be a plain
  /// array. Faults are collected.
  CommandedTrajectory(double now, const py::object& times,
                      const std::array<std::pair<const char*, py::object>, 3>& given, py::ssize_t columns)
      : now_(now), times_(numbersOf(times, "times")) {
    double before = now;
    for (std::size_t k = 0; k < times_.size(); ++k) {
      if (!(std::isfinite(times_[k]) && times_[k] > before)) {
        faults_.push_back({"times/" + std::to_string(k),
                           "a time after " + std::string(k == 0 ? "the present one, " : "the one before, ") +
                               toText(before) + " s",
                           toText(times_[k])});
      }
      before = times_[k];
    }
    if (times_.empty()) faults_.push_back({"times", "at least one time", "none"});
    for (std::size_t order = 0; order < given.size(); ++order) {
      const auto& [name, numbers] = given[order];
      if (order > 0 && numbers.is_none()) continue;
      tables_[order] = tableOf(numbers, name, columns);
    }
    if (tables_[1].size() > 0 && faults_.empty() && !tables_[1].bottomRows<1>().isZero(0)) {
      faults_.push_back({given[1].first, "0 at the last time, where the motion ends", "another rate"});
    }
  }

  /// Returns `law`, continued through a column of the points.
  MotionLaw lead(const MotionLaw& law, Eigen::Index column, const char* unit) {
    if (!faults_.empty()) throw Refused(std::move(faults_));
    std::vector<MotionPoint> points;
    for (std::size_t k = 0; k < times_.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      MotionPoint& to = points.emplace_back();
      to.time = times_[k];
      to.value = tables_[0](row, column);
      if (tables_[1].size() > 0) to.rate = tables_[1](row, column);
      if (tables_[2].size() > 0) to.acceleration = tables_[2](row, column);
    }
    MotionLaw led = law.then(now_, now_, points);
    if (!led.isModerate()) throw Refused({{"times", MotionLaw::moderate(unit), "a faster motion"}});
    return led;
  }

 private:
  Eigen::MatrixXd tableOf(const py::object& given, const char* name, py::ssize_t columns) {
    const Numbers numbers = arrayOf(given, name);
    const auto rows = static_cast<py::ssize_t>(times_.size());
    const bool fits = (numbers.ndim() == 2 && numbers.shape(0) == rows && numbers.shape(1) == columns) ||
                      (numbers.ndim() == 1 && columns == 1 && numbers.shape(0) == rows);
    Eigen::MatrixXd table = Eigen::MatrixXd::Zero(rows, columns);
    if (!fits) {
      faults_.push_back(
          {name, std::to_string(rows) + " x " + std::to_string(columns) + " numbers, a row for each time",
           shapeOf(numbers)});
      return table;
    }
    for (py::ssize_t i = 0; i < rows * columns; ++i) table(i / columns, i % columns) = numbers.data()[i];
    if (!table.allFinite()) faults_.push_back({name, "finite numbers", "another one"});
    return table;
  }

  double now_;
  std::vector<double> times_;
  std::array<Eigen::MatrixXd, 3> tables_;  ///< values, rates, accelerations
  std::vector<Fault> faults_;
};

void follow(Running& self, const py::object& where, const py::object& times, const py::object& angles,
            const py::object& rates, const py::object& accelerations) {
  const int joint = self.joint(where);
  Simulation& simulation = self.idle();
  const std::vector<Drive>& drives = simulation.scene().drives;
  const auto drive =
      std::find_if(drives.begin(), drives.end(), [joint](const Drive& one) { return one.joint == joint; });
  if (drive == drives.end()) {
    std::string driven;
    for (const Drive& one : drives) {
      driven += (driven.empty() ? "" : ", ") +
                simulation.scene().chain.joints()[static_cast<std::size_t>(one.joint)].name;
    }
    throw Refused(
        {{"joint",
          driven.empty() ? "a driven joint, which this scene does not have" : "a driven joint: " + driven,
          shown(where)}});
  }
  CommandedTrajectory trajectory(simulation.time(), times,
                                 {{{"angles", angles}, {"rates", rates}, {"accelerations", accelerations}}},
                                 1);
  simulation.follow(joint, trajectory.lead(drive->law, 0, "rad"));
}

void followBase(Running& self, const py::object& times, const py::object& poses, const py::object& rates,
                const py::object& accelerations) {
  Simulation& simulation = self.idle();
  if (!simulation.scene().base) {
    throw Refused({{"follow_base", "a scene whose base moves (the key `base`)", "one that has none"}});
  }
  const BaseLaws& present = *simulation.scene().base;
  CommandedTrajectory trajectory(simulation.time(), times,
                                 {{{"poses", poses}, {"rates", rates}, {"accelerations", accelerations}}}, 3);
  simulation.followBase({trajectory.lead(present.x, 0, "m"), trajectory.lead(present.y, 1, "m"),
                         trajectory.lead(present.angle, 2, "rad")});
}

}  // namespace

void bindLaws(py::class_<Running>& simulation) {
  const auto times = py::arg("times");
  const auto rates = py::arg("rates") = py::none(), accelerations = py::arg("accelerations") = py::none();
  simulation
      .def(
          "follow", &follow, py::arg("joint"), times, py::arg("angles"), rates, accelerations,
          R"(Moves a driven joint (its name or number) through angles (rad) at times (s), from its present angle on.

The motion is that of the node's joint_trajectory: with rates (rad/s) cubic, with accelerations (rad/s²) as
well quintic, else in straight lines with short bends. It ends at rest in the last angle.)")
      .def("follow_base", &followBase, times, py::arg("poses"), rates, accelerations,
           R"(Moves the base through poses (times × 3: x, y in m, angle in rad), as follow() moves a joint.

The scene must have the key `base`; rates and accelerations, if given, are times × 3 as well.)");
}

void bindCommands(py::class_<Running>& simulation) {
  const auto joint = py::arg("joint"), link = py::arg("link"), torque = py::arg("torque");
  const auto force = py::arg("force"), duration = py::arg("duration");
  const auto point = py::arg("point") = py::none(), moment = py::arg("moment") = 0.0;
  const auto start = py::arg("start") = Simulation::now, until = py::arg("until") = forever;
  using Given = const py::object&;
  simulation
      .def(
          "hold_torques",
          [](Running& self, Given torques) {
            holdTorques(self.idle(), numbersOf(torques, "torques", self.size()));
          },
          py::arg("torques"),
          "Holds these torques, n, N m, in the joints until the next ones: 0 in driven joints.")
      .def(
          "hold_torque",
          [](Running& self, Given where, Given tau, Given end, Given begin) {
            requireTaken(self.idle().holdTorque(self.joint(where), factorOf(tau, "torque"),
                                                numberOf(end, "until"), numberOf(begin, "start")));
          },
          joint, torque, until, start,
          R"(Holds a torque (N m) in a joint (its name or number) until the next such call, or until a time (s).

It acts from `start` (s) on, or at once.)")
      .def(
          "add_torque",
          [](Running& self, Given where, Given tau, Given length, Given begin) {
            requireTaken(self.idle().addTorque(self.joint(where), factorOf(tau, "torque"),
                                               factorOf(length, "duration"), numberOf(begin, "start")));
          },
          joint, torque, duration, start, "Adds a torque (N m) in a joint for exactly this duration (s).")
      .def(
          "hold_force",
          [](Running& self, Given where, Given F, Given X, Given M, Given end, Given begin) {
            const int body = self.link(where);
            requireTaken(self.idle().holdForce(body, pointOf(X, self.linkAt(body)), pairOf(F, "force"),
                                               factorOf(M, "moment"), numberOf(end, "until"),
                                               numberOf(begin, "start")));
          },
          link, force, point, moment, until, start,
          R"(Holds a force (x, y in N, base frame) and a moment (N m) on a link (its name or number).

The force acts at a point of the link: x, y in m, link frame, from its inner pin; by default at its centre of
mass, as a load of a scene does. Both last until the next such call for this link, or until a time (s).)")
      .def(
          "add_force",
          [](Running& self, Given where, Given F, Given X, Given length, Given M, Given begin) {
            const int body = self.link(where);
            const Vec2d pull = pairOf(F, "force"), at = pointOf(X, self.linkAt(body));
            requireTaken(self.idle().addForce(body, at, pull, factorOf(M, "moment"),
                                              factorOf(length, "duration"), numberOf(begin, "start")));
          },
          link, force, point, py::arg("duration") = py::none(), moment, start,
          "Adds a force and a moment, as hold_force(), for exactly this duration (s).")
      .def(
          "clear_commands", [](Running& self) { self.clearCommands(); },
          "Ends all commands. After a failure, advance_to() then goes on from the last good state.");
}

}  // namespace planar_chain::python
