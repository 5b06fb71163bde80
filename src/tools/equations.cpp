/// equations SCENE.yaml: prints every matrix of Kane's equations at one state. include/planar_chain/kane.h
/// defines the letters.

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <type_traits>

#include "dynamics/equilibrium.h"
#include "dynamics/given_state.h"
#include "dynamics/letters.h"
#include "planar_chain/kinematics.h"
#include "tools/chain_json.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

// ---- Arguments -------------------------------------------------------------------------------

/// The numbers between commas, one for each of n joints.
std::optional<Eigen::VectorXd> vectorArgument(const char* option, const Arguments& arguments, std::size_t n,
                                              std::vector<Fault>& faults) {
  const std::optional<std::string> given = arguments.text(option);
  if (!given) return std::nullopt;
  std::vector<double> numbers;
  std::istringstream list(*given + ',');
  for (std::string part; std::getline(list, part, ',');) {
    part.erase(0, part.find_first_not_of(' '));
    numbers.push_back(numberIn(part).value_or(infinity));
  }
  const auto isFinite = [](double number) { return std::isfinite(number); };
  if (numbers.size() != n || !std::all_of(numbers.begin(), numbers.end(), isFinite)) {
    faults.push_back({std::string("--") + option,
                      std::to_string(n) + " finite numbers with commas between, one per joint in chain order",
                      quoted(*given)});
  }
  return Eigen::Map<Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

// ---- As text ---------------------------------------------------------------------------------

/// Prints the letter, its meaning, and the matrix in columns of one width, without the sign of -0.
void print(const std::string& letter, const std::string& meaning, const Eigen::MatrixXd& matrix) {
  static const Eigen::IOFormat inColumns(6, 0, " ", "\n", "  [ ", " ]");
  std::cout << letter << "   " << meaning << '\n'
            << (matrix.array() == 0).select(0, matrix).format(inColumns) << "\n\n";
}

void printText(const Chain& chain, double t, const ActiveForces& active, const Kane& at,
               const std::optional<LinearModel>& near) {
  std::cout << "M q'' = f(q, q', t) at t = " << t << " s; bodies from the ground outwards:";
  for (const Link& link : chain.links()) std::cout << ' ' << link.name;
  if (chain.coordinates().anyIsPrismatic()) std::cout << "\nprismatic joints, with m and N in their rows:";
  for (const Joint& joint : chain.joints()) std::cout << (joint.isPrismatic ? ' ' + joint.name : "");
  std::cout << "\n\n";
  showAll(active, at, near, [&](const std::string& letter, const std::string& meaning, const auto& value) {
    using Type = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Type, Eigen::VectorXd>) {
      print(letter, meaning, value.transpose());
    } else if constexpr (std::is_same_v<Type, Eigen::MatrixXd>) {
      print(letter, meaning, value);
    } else {  // one matrix a body
      for (std::size_t i = 0; i < value.size(); ++i) {
        print(letter + "_" + std::to_string(i + 1) + "0", meaning + ", of " + chain.links()[i].name,
              value[i]);
      }
    }
  });
}

// ---- As JSON ---------------------------------------------------------------------------------

using Json = nlohmann::json;

template <class Derived>
Json jsonOf(const Eigen::MatrixBase<Derived>& matrix) {
  if constexpr (Derived::ColsAtCompileTime == 1) {
    const double* first = matrix.derived().data();
    return std::vector<double>(first, first + matrix.size());
  }
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) rows.push_back(jsonOf(Eigen::VectorXd(matrix.row(i))));
  return rows;
}

Json jsonOf(const std::vector<Eigen::Matrix2d>& matrices) {
  Json list = Json::array();
  for (const Eigen::Matrix2d& matrix : matrices) list.push_back(jsonOf(matrix));
  return list;
}

void printJson(double t, const ActiveForces& active, const Kane& at, const std::optional<LinearModel>& near) {
  Json all{{"t", t}};
  showAll(active, at, near,
          [&](const char* letter, const char*, const auto& value) { all[letter] = jsonOf(value); });
  std::cout << all << '\n';
}

/// Prints the torques that give these accelerations.
int printInverse(const Scene& scene, double t, const GivenState& state, const Eigen::VectorXd& qdd,
                 bool asJson) {
  const auto& [q, qd] = state;
  const Eigen::VectorXd tau = inverseDynamics(scene, t, q, qd, qdd);
  requireFinite("torques", tau);
  if (asJson) {
    std::cout
        << Json{{"t", t}, {"q", jsonOf(q)}, {"qd", jsonOf(qd)}, {"qdd", jsonOf(qdd)}, {"tau", jsonOf(tau)}}
        << '\n';
    return done;
  }
  print("q", "relative joint angles, rad", q.transpose());
  print("qd", "their rates, rad/s", qd.transpose());
  print("qdd", "their accelerations, rad/s^2", qdd.transpose());
  print("tau", "torques that give these accelerations, beside all that acts, N m", tau.transpose());
  return done;
}

/// The torques of --tau, and whether joints slip.
OperatingPoint pointOf(const Arguments& given, std::size_t n, std::vector<Fault>& faults) {
  OperatingPoint about;
  const std::string friction = given.text("friction").value_or("acts");
  about.slips = friction == "slips";
  if (!about.slips && friction != "acts") faults.push_back({"--friction", "acts or slips", quoted(friction)});
  about.isHeld = given.text("tau") == "holding";
  if (!about.isHeld) about.tau = vectorArgument("tau", given, n, faults);
  for (const char* option : {"tau", "friction"}) {
    if (given.has(option) && !given.has("linearize"))
      faults.push_back({std::string("--") + option, "--linearize beside it", "nothing"});
  }
  return about;
}

/// A and B. Writes their notes.
LinearModel linearized(const Scene& scene, double t, const GivenState& state, const OperatingPoint& about) {
  LinearModel model = linearModel(scene, t, state.q, state.qd, about);
  for (const std::string& note : model.notes) std::cerr << "note: " << note << '\n';
  return model;
}

/// The point of --point: LINK,x,y, or a frame.
std::optional<Frame> frameOf(const Arguments& given, const Scene& scene, std::vector<Fault>& faults) {
  const std::optional<std::string> text = given.text("point");
  if (!text) return std::nullopt;
  const std::size_t comma = text->find(','), second = text->find(',', comma + 1);
  try {
    if (comma == std::string::npos) return frameNamed(scene, *text);
    const std::string name = text->substr(0, comma);
    const auto& links = scene.chain.links();
    const auto link =
        std::find_if(links.begin(), links.end(), [&](const Link& one) { return one.name == name; });
    const auto numberAt = [&](std::size_t from, std::size_t to) {
      return from == std::string::npos ? infinity
                                       : numberIn(text->substr(from + 1, to - from - 1)).value_or(infinity);
    };
    const double x = numberAt(comma, second), y = numberAt(second, std::string::npos);
    if (link != links.end() && std::isfinite(x) && std::isfinite(y))
      return Frame{name, static_cast<int>(link - links.begin()), {x, y}};
  } catch (const Refused&) {  // no frame
  }
  faults.push_back({"--point", "LINK,x,y, the name of a frame of the scene, or tip", quoted(*text)});
  return std::nullopt;
}

/// Prints how a point moves, at the accelerations of this state.
int printPoint(const Scene& scene, const Frame& frame, double t, const GivenState& state, bool asJson) {
  const auto& [q, qd] = state;
  const Eigen::VectorXd qdd = kane(scene.chain, q, qd, activeForces(scene, t, q, qd)).qdd, none = 0 * qdd;
  const FrameMotion now = motionOf(scene, frame, t, q, qd, qdd),
                    coasting = motionOf(scene, frame, t, q, qd, none);
  const auto three = [](Vec2d v, double angle) { return Eigen::VectorXd(Eigen::Vector3d(v.x, v.y, angle)); };
  Json all{{"t", t}, {"q", jsonOf(q)}, {"qd", jsonOf(qd)}};
  const auto show = [&](const char* letter, const char* meaning, const Eigen::MatrixXd& value) {
    requireFinite(std::string("numbers of ") + letter, value);
    if (!asJson)
      return print(letter, meaning, value.cols() == 1 ? Eigen::MatrixXd(value.transpose()) : value);
    all[letter] = value.cols() == 1 ? jsonOf(Eigen::VectorXd(value)) : jsonOf(value);
  };
  show("position", "x and y, m, and the angle of the link or frame, rad", three(now.position, now.angle));
  show("velocity", "m/s, and rad/s", three(now.velocity, now.rate));
  show("acceleration", "m/s^2, and rad/s^2", three(now.acceleration, now.angularAcceleration));
  show("J", "velocity = J qd, on a base at rest", jacobianOf(scene, frame, t, q));
  show("Jdot_qd", "acceleration at qdd = 0", three(coasting.acceleration, coasting.angularAcceleration));
  if (asJson) std::cout << all << '\n';
  return done;
}

void moveToEquilibrium(const Scene& scene, double t, GivenState& state) {
  auto& [q, qd] = state;
  const std::vector<double> rest = equilibriumOf(scene, t, {q.data(), q.data() + q.size()});
  q = Eigen::Map<const Eigen::VectorXd>(rest.data(), q.size());
  qd.setZero();
  for (const Drive& drive : scene.drives) qd[drive.joint] = drive.law.at(t).rate;
}

int equations(const Arguments& given) {
  // The scene and the state.
  std::vector<Fault> faults;
  const double t = given.number("t", "a finite number, in s", -infinity, 0, faults);
  const bool onlyChain = given.has("chain");
  checkAlone(given, "chain", {"json", "linearize", "inverse"}, faults);
  checkAlone(given, "inverse", {"linearize"}, faults);
  checkAlone(given, "point", {"chain", "inverse", "linearize"}, faults);
  const Scene scene = readScene(
      given, [](Value&) {}, std::move(faults));
  if (!onlyChain) requireFewLinks(scene);
  std::vector<Fault> stateFaults;
  const std::size_t n = scene.q.size();
  const auto givenQ = vectorArgument("q", given, n, stateFaults);
  const auto givenQd = vectorArgument("qd", given, n, stateFaults);
  // Driven joints are where their laws put them at t.
  GivenState state;
  if (stateFaults.empty()) state = stateOf(scene, t, givenQ, givenQd, stateFaults);
  for (Fault& fault : stateFaults) {
    if (fault.path[0] != '-') fault.path.insert(0, "--");
  }
  auto& [q, qd] = state;
  if (stateFaults.empty() && givenQ)
    std::cerr << movedWords("note: --q: ", scene.chain, givenQ->data(), q.data(), "\n");
  const std::optional<Eigen::VectorXd> givenQdd = vectorArgument("qdd", given, n, stateFaults);
  if (givenQdd && !given.has("inverse")) stateFaults.push_back({"--qdd", "--inverse beside it", "nothing"});
  if (givenQd && !givenQd->isZero(0) && given.has("equilibrium")) {
    stateFaults.push_back(
        {"--qd", "0 or none beside --equilibrium, which is at rest", quoted(*given.text("qd"))});
  }
  const OperatingPoint about = pointOf(given, n, stateFaults);
  const std::optional<Frame> frame = frameOf(given, scene, stateFaults);
  if (!stateFaults.empty()) throw Refused(std::move(stateFaults));
  if (given.has("equilibrium")) moveToEquilibrium(scene, t, state);

  // The output: the chain, torques, or the equations.
  requireFinite("angles", q);
  requireFinite("rates", qd);
  if (onlyChain) {
    std::cout << chainAsJson(scene, q, qd) << '\n';
    return done;
  }
  if (frame) return printPoint(scene, *frame, t, state, given.has("json"));
  if (given.has("inverse")) {
    return printInverse(scene, t, state, givenQdd.value_or(Eigen::VectorXd::Zero(q.size())),
                        given.has("json"));
  }
  const ActiveForces active = activeForces(scene, t, q, qd);
  const Kane at = kane(scene.chain, q, qd, active);
  std::optional<LinearModel> near;
  if (given.has("linearize")) near = linearized(scene, t, state, about);
  if (near && !given.has("tau")) near->tau.resize(0);  // not shown
  requireFinite(active, at, near);
  if (given.has("json")) {
    printJson(t, active, at, near);
  } else {
    printText(scene.chain, t, active, at, near);
  }
  return done;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  using namespace planar_chain::tools;
  return run(
      {"equations",
       "Prints the matrices of Kane's equations at one state.",
       "0 done; 1 no finite solution; 2 bad arguments or scene.",
       true,
       {{"q",
         "Relative angles, rad (prismatic joints: m), such as 0.1,0.2 (default: the scene's initial ones)"},
        {"qd", "Rates, rad/s (m/s), such as 0,0 (default: the scene's initial ones)"},
        {"t", "Time, s, for loads that depend on it (default 0)"},
        {"linearize",
         "Also A and B of dx/dt = A x + B dtau, where x = (dq, dqd) is a small change of the state and dtau "
         "of the torques that act: lags, torque-speed lines of motors and command delays are left out. Of a "
         "closed chain they are for all n coordinates: reduce them to what the tip allows before a control "
         "design",
         false},
        {"tau",
         "With --linearize: the torques in the joints, N m, about which A and B are, beside all else that "
         "acts, such "
         "as 1.5,0 (default 0); `holding`: those that hold the state"},
        {"friction",
         "With --linearize: `slips` takes a joint at rest for one that slips, without friction; with `acts`, "
         "the "
         "default, it may stick, and its column of B is 0"},
        {"point",
         "Only the position, velocity, acceleration and Jacobian of a point: LINK,x,y with x and y in m in "
         "the frame of "
         "the link; or the name of a frame of the scene, or tip"},
        {"equilibrium", "At rest in the static equilibrium, searched from --q", false},
        {"inverse",
         "Only the torques tau that give the accelerations --qdd, beside all that acts but drives (with a "
         "held tip: those of smallest norm)",
         false},
        {"qdd", "Accelerations, rad/s^2, for --inverse (default 0)"},
        {"json", "One JSON object for programs, matrices as arrays of rows", false},
        {"chain",
         "Only the chain, as one JSON object: gravity, q, qd, every link with its joint, loads and base, "
         "with "
         "repeated links, a URDF and defaults written out; not with --linearize, --inverse or --json",
         false}},
       equations},
      argc, argv);
}
