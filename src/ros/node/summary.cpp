#include "ros/node/summary.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "ode/methods.h"

namespace planar_chain {

namespace {

std::string count(int number, const std::string& one) {
  return std::to_string(number) + " " + one + (number == 1 ? "" : "s");
}

/// "a, b, c"; "nothing".
std::string listed(const std::vector<std::string>& items) {
  std::string list;
  for (const std::string& item : items) list += (list.empty() ? "" : ", ") + item;
  return list.empty() ? "nothing" : list;
}

}  // namespace

std::string whatRuns(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  int springs = 0, dampers = 0, limits = 0;
  for (const Joint& joint : scene.chain.joints()) {
    springs += joint.stiffness > 0;
    dampers += joint.damping > 0;
    limits += std::isfinite(joint.lower) + std::isfinite(joint.upper);
  }
  std::ostringstream held;
  held << "commands that ";
  if (scene.commandTimeout > 0) {
    held << "lapse after " << scene.commandTimeout << " s";
  } else {
    held << "hold until replaced";
  }

  std::vector<std::string> runs, leftOut;
  const auto tell = [&](int number, const std::string& one) {
    (number > 0 ? runs : leftOut).push_back(number > 0 ? count(number, one) : one + "s");
  };
  if (scene.chain.gravity() == Vec2d{}) {
    leftOut.push_back("gravity");
  } else {
    runs.push_back("gravity");
  }
  // With dampers, the springs that are missing run along at 0 N m/rad: not left out.
  if (springs > 0 || dampers == 0) tell(springs, "spring");
  tell(dampers, "damper");
  tell(static_cast<int>(scene.loads.size()), "load");
  tell(limits, "limit");
  runs.push_back("energy guard");
  runs.push_back(held.str());

  const IntegratorSettings& integrator = scene.integrator;
  const bool hasFixedStep = ode::hasFixedStep(integrator.method);
  std::ostringstream line;
  line << count(scene.chain.size(), "link") << " (" << simulation.recursion() << ") by " << integrator.method
       << (hasFixedStep ? ", step " : ", tolerance ")
       << (hasFixedStep ? integrator.step : integrator.tolerance) << "; runs: " << listed(runs)
       << "; left out: " << listed(leftOut);
  return line.str();
}

std::string whatIsPublished(const PublishSettings& settings, const Frames& frames) {
  std::ostringstream line;
  line << "made while somebody listens: joint_states";
  if (settings.linkStates) line << " and link_states";
  line << " at " << settings.rate << " Hz, ";
  if (settings.tf) line << "tf at " << settings.tfRate << " Hz below " << frames.base << ", ";
  line << "status at " << settings.statusRate << " Hz, views at " << settings.tfRate << " Hz";

  std::vector<std::string> never;
  if (!settings.linkStates) never.push_back("link_states");
  if (!settings.tf) never.push_back("tf");
  if (!never.empty()) line << "; never: " << listed(never);
  return line.str();
}

}  // namespace planar_chain
