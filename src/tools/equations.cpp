/// equations SCENE.yaml: prints every matrix of Kane's equations at one state, by its letter in the notes
/// (include/planar_chain/kane.h writes them down).

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "planar_chain/kane.h"
#include "planar_chain/linear_model.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

// ---- Arguments -------------------------------------------------------------------------------

struct Arguments {
  SceneArguments scene;
  std::optional<std::string> q;
  std::optional<std::string> qd;
  std::string t = "0";
  bool linearize = false;
  bool json = false;
};

void declare(CLI::App& app, Arguments& to) {
  declareScene(app, to.scene);
  app.add_option("--q", to.q, "Relative angles, rad, such as 0.1,0.2; the scene's initial ones if absent");
  app.add_option("--qd", to.qd, "Rates, rad/s, such as 0,0; the scene's initial ones if absent");
  app.add_option("--t", to.t, "Time, s, for loads that depend on it")->capture_default_str();
  app.add_flag("--linearize", to.linearize,
               "Also A and B of dx/dt = A x + B dtau, x = (dq, dqd) off the state");
  app.add_flag("--json", to.json, "For programs: one JSON object, matrices as arrays of rows");
  app.footer("Exit status: 0 done; 1 no finite solution; 2 bad arguments or scene.");
}

/// n finite numbers between commas.
Eigen::VectorXd vectorArgument(const char* option, const std::optional<std::string>& given,
                               const std::vector<double>& absent, std::vector<Fault>& faults) {
  std::vector<double> numbers = absent;
  if (given) {
    numbers.clear();
    std::istringstream list(*given + ',');
    bool areSound = true;
    for (std::string part; std::getline(list, part, ',');) {
      part.erase(0, part.find_first_not_of(' '));
      const std::optional<double> number = numberIn(part);
      areSound &= number && std::isfinite(*number);
      numbers.push_back(number.value_or(0));
    }
    if (!areSound || numbers.size() != absent.size()) {
      faults.push_back(
          {option,
           std::to_string(absent.size()) + " finite numbers with commas between, one a joint in chain order",
           describe(Value(*given))});
      numbers = absent;
    }
  }
  return Eigen::Map<Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

// ---- For a person ----------------------------------------------------------------------------

std::string shown(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", number == 0 ? 0.0 : number);
  return text;
}

void print(const std::string& letter, const std::string& meaning, const Eigen::MatrixXd& matrix) {
  std::printf("%s   %s\n", letter.c_str(), meaning.c_str());
  std::size_t width = 0;
  for (Eigen::Index k = 0; k < matrix.size(); ++k) {
    width = std::max(width, shown(matrix(k % matrix.rows(), k / matrix.rows())).size());
  }
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    std::printf("  [");
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      std::printf(" %*s", static_cast<int>(width), shown(matrix(i, j)).c_str());
    }
    std::printf(" ]\n");
  }
  std::printf("\n");
}

void printText(const Scene& scene, double t, const ActiveForces& active, const Kane& at,
               const std::optional<LinearModel>& near) {
  std::printf("M q'' = f(q, q', t) at t = %s s; bodies from the ground outwards:", shown(t).c_str());
  for (const Link& link : scene.chain.links()) std::printf(" %s", link.name.c_str());
  std::printf("\n\n");

  print("q", "relative joint angles, rad", at.q.transpose());
  print("qd", "their rates, rad/s", at.qd.transpose());
  for (std::size_t i = 0; i < at.S.size(); ++i) {
    print("S_" + std::to_string(i + 1) + "0",
          "shifter of " + scene.chain.links()[i].name + ": body from ground components", at.S[i]);
  }
  print("T", "[omega_1 ... omega_n] = qd' T", at.T);
  print("V_pd", "partial velocities of the centres of mass, columns x_1 y_1 x_2 y_2 ..., m", at.V_pd);
  print("W_pd", "partial angular velocities", at.W_pd);
  print("A_1", "inertia forces by qd: F_in = -qd' A_1 - qdd' A_2, kg m/s", at.A_1);
  print("A_2", "inertia forces by qdd, kg m", at.A_2);
  print("A_3", "inertia moments: M_in = -qdd' A_3, kg m^2", at.A_3);
  print("F", "active forces at the centres of mass, ground components x_1 y_1 ..., N", active.F.transpose());
  print("M_ext", "active moments on the bodies, N m", active.M.transpose());
  print("tau", "joint torques, springs and dampers included, N m", active.tau.transpose());
  print("f_ext", "= V_pd F + W_pd M_ext + tau, N m", at.f_ext.transpose());
  print("f", "= f_ext - V_pd A_1' qd, N m", at.f.transpose());
  print("M", "= V_pd A_2' + W_pd A_3', kg m^2", at.M_q);
  print("qdd", "M qdd = f, rad/s^2", at.qdd.transpose());
  if (!near) return;
  print("A", "dx/dt = A x + B dtau, x = (dq, dqd) off this state", near->A);
  print("B", "= [0; M^-1], dtau more torque in the joints", near->B);
}

// ---- For a program ---------------------------------------------------------------------------

using Json = nlohmann::json;

Json listOf(const Eigen::VectorXd& vector) {
  return std::vector<double>(vector.data(), vector.data() + vector.size());
}

Json rowsOf(const Eigen::MatrixXd& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) rows.push_back(listOf(matrix.row(i)));
  return rows;
}

void printJson(double t, const ActiveForces& active, const Kane& at, const std::optional<LinearModel>& near) {
  Json shifters = Json::array();
  for (const Eigen::Matrix2d& S : at.S) shifters.push_back(rowsOf(S));
  // One key a line: a matrix stays readable, and a diff small.
  const char* before = "{";
  const auto put = [&before](const char* key, const Json& entry) {
    std::printf("%s\n  \"%s\": %s", before, key, entry.dump().c_str());
    before = ",";
  };
  put("t", t);
  put("q", listOf(at.q));
  put("qd", listOf(at.qd));
  put("S", shifters);
  put("T", rowsOf(at.T));
  put("V_pd", rowsOf(at.V_pd));
  put("W_pd", rowsOf(at.W_pd));
  put("A_1", rowsOf(at.A_1));
  put("A_2", rowsOf(at.A_2));
  put("A_3", rowsOf(at.A_3));
  put("F", listOf(active.F));
  put("M_ext", listOf(active.M));
  put("tau", listOf(active.tau));
  put("f_ext", listOf(at.f_ext));
  put("f", listOf(at.f));
  put("M", rowsOf(at.M_q));
  put("qdd", listOf(at.qdd));
  if (near) {
    put("A", rowsOf(near->A));
    put("B", rowsOf(near->B));
  }
  std::printf("\n}\n");
}

int equations(int argc, char** argv) {
  CLI::App app("Prints the matrices of Kane's equations at one state.", "equations");
  Arguments given;
  declare(app, given);
  if (const auto status = parseArguments(app, argc, argv)) return *status;

  std::vector<Fault> faults;
  const auto isAny = [](double) { return true; };
  const double t = numberArgument("--t", given.t, "a finite number, in s", isAny, faults);
  const Scene scene = readScene(
      given.scene, [](Value&) {}, std::move(faults));
  constexpr int mostLinks = 1000;
  if (scene.chain.size() > mostLinks) {
    throw Refused(
        {{"chain", "at most 1000 links, for the matrices are dense", std::to_string(scene.chain.size())}});
  }
  std::vector<Fault> stateFaults;
  const Eigen::VectorXd q = vectorArgument("--q", given.q, scene.q, stateFaults);
  const Eigen::VectorXd qd = vectorArgument("--qd", given.qd, scene.qd, stateFaults);
  if (!stateFaults.empty()) throw Refused(std::move(stateFaults));

  const ActiveForces active = activeForces(scene, t, q, qd);
  const Kane at = kane(scene.chain, q, qd, active);
  std::optional<LinearModel> near;
  if (given.linearize) near = linearModel(scene, t, q, qd);
  if (given.json) {
    printJson(t, active, at, near);
  } else {
    printText(scene, t, active, at, near);
  }
  if (at.qdd.allFinite()) return done;
  std::cerr << "equations: the accelerations are not finite: the numbers are too large\n";
  return runFailed;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  namespace tools = planar_chain::tools;
  return tools::run("equations", [&] { return tools::equations(argc, argv); });
}
