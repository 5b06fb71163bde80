#include "dynamics/given_state.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "dynamics/closed_state.h"
#include "effects/effect_kind.h"
#include "model/prismatic.h"

namespace planar_chain {

namespace {

Eigen::VectorXd orElse(const std::optional<Eigen::VectorXd>& given, const std::vector<double>& otherwise) {
  if (given) return *given;
  return Eigen::VectorXd::Map(otherwise.data(), static_cast<Eigen::Index>(otherwise.size()));
}

std::string inUnitsOf(const Joint& joint, const std::string& words) {
  return joint.isPrismatic ? inUnitsOfPrismatic(words) : words;
}

/// Only a turn that is counted exactly is an angle.
void checkAngles(const Scene& scene, const Eigen::VectorXd& q, std::vector<Fault>& faults) {
  for (int i = 0; i < scene.chain.size(); ++i) {
    const Joint& joint = scene.chain.joints()[index(i)];
    const double most = largestAngle(joint);
    if (std::abs(q[i]) <= most) continue;
    faults.push_back(
        {"q", inUnitsOf(joint, "numbers up to " + toText(most) + " rad") + " in the joint " + joint.name,
         toText(q[i])});
  }
}

/// Puts the tip where it is held.
void close(const Scene& scene, double t, GivenState& state, std::vector<Fault>& faults) {
  const auto listOf = [](const Eigen::VectorXd& numbers) {
    return std::vector<double>(numbers.data(), numbers.data() + numbers.size());
  };
  std::vector<double> q = listOf(state.q), qd = listOf(state.qd);
  const Closing closing = closeState(scene, t, q, qd);
  if (closing.isClosed) {
    state = {orElse({}, q), orElse({}, qd)};
  } else {
    faults.push_back({"q", "angles from which the tip gets to where it is held",
                      "a gap of " + toText(closing.gap) + " m that is left"});
  }
}

}  // namespace

bool checkNumbers(const char* path, const Scene& scene, const Eigen::VectorXd& numbers, const char* unit,
                  std::vector<Fault>& faults) {
  const int n = scene.chain.size();
  if (numbers.size() != n) {
    faults.push_back({path, std::to_string(n) + " numbers, one a joint", std::to_string(numbers.size())});
    return false;
  }
  bool areFinite = true;
  for (int i = 0; i < n; ++i) {
    if (std::isfinite(numbers[i])) continue;
    const Joint& joint = scene.chain.joints()[index(i)];
    faults.push_back(
        {path, inUnitsOf(joint, std::string("a finite number, in ") + unit) + ", of the joint " + joint.name,
         toText(numbers[i])});
    areFinite = false;
  }
  return areFinite;
}

void checkTime(double t, std::vector<Fault>& faults) {
  if (!std::isfinite(t)) faults.push_back({"t", "a finite number, in s", toText(t)});
}

GivenState stateOf(const Scene& scene, double t, const std::optional<Eigen::VectorXd>& q,
                   const std::optional<Eigen::VectorXd>& qd, std::vector<Fault>& faults) {
  GivenState state{orElse(q, scene.q), orElse(qd, scene.qd)};
  checkTime(t, faults);
  const bool areAngles = checkNumbers("q", scene, state.q, "rad", faults);
  const bool areRates = checkNumbers("qd", scene, state.qd, "rad/s", faults);
  if (areAngles) checkAngles(scene, state.q, faults);
  if (!areAngles || !areRates || !std::isfinite(t)) return state;

  for (const Drive& drive : scene.drives) {
    const GivenMotion motion = drive.law.at(t);
    const Joint& driven = scene.chain.joints()[index(drive.joint)];
    const std::string joint = " of the driven joint " + driven.name;
    const auto put = [&](const char* path, bool isGiven, const char* unit, double law, double& own) {
      if (isGiven && !(std::abs(own - law) <= givenTo)) {
        faults.push_back({path,
                          toText(law) + " " + inUnitsOf(driven, unit) + joint + " at t = " + toText(t) + " s",
                          toText(own)});
      }
      own = law;
    };
    put("q", q.has_value(), "rad", motion.value, state.q[drive.joint]);
    put("qd", qd.has_value(), "rad/s", motion.rate, state.qd[drive.joint]);
  }
  if (scene.tip && faults.empty()) close(scene, t, state, faults);
  return state;
}

std::string movedWords(const char* before, const Chain& chain, const double* from, const double* to,
                       const char* after) {
  using Angles = Eigen::Map<const Eigen::VectorXd>;
  Eigen::Index most = 0;
  const double moved = (Angles(to, chain.size()) - Angles(from, chain.size())).cwiseAbs().maxCoeff(&most);
  if (!(moved > givenTo)) return {};
  const Joint& joint = chain.joints()[static_cast<std::size_t>(most)];
  return std::string(before) + "the joint " + joint.name + " is moved by " +
         toText(std::round(moved * 1e6) / 1e6) + (joint.isPrismatic ? " m" : " rad") +
         ", and no other by more, to bring the tip to its place" + after;
}

void requireFewLinks(const Scene& scene) {
  if (scene.chain.size() <= 1000) return;
  throw Refused(
      {{"chain", "at most 1000 links, for the matrices are dense", std::to_string(scene.chain.size())}});
}

void requireFinite(const std::string& what, const Eigen::MatrixXd& numbers) {
  if (numbers.allFinite()) return;
  throw std::overflow_error("the " + what + " are not finite: the numbers are too large");
}

}  // namespace planar_chain
