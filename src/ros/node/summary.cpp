#include "ros/node/summary.h"

#include <sstream>
#include <vector>

#include "effects/effect_kind.h"
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
  std::ostringstream held;
  held << "commands that ";
  if (scene.commandTimeout > 0) {
    held << "lapse after " << scene.commandTimeout << " s";
  } else {
    held << "hold until replaced";
  }

  SceneWords words;
  (scene.chain.gravity() == Vec2d{} ? words.leftOut : words.runs).push_back("gravity");
  for (const EffectKind* kind : effectKinds()) kind->summarize(scene, words);
  words.runs.push_back("energy guard");
  words.runs.push_back(held.str());

  const IntegratorSettings& integrator = scene.integrator;
  const bool hasFixedStep = ode::hasFixedStep(integrator.method);
  std::ostringstream line;
  line << count(scene.chain.size(), "link") << " (" << simulation.recursion() << ") by " << integrator.method
       << (hasFixedStep ? ", step " : ", tolerance ")
       << (hasFixedStep ? integrator.step : integrator.tolerance) << "; runs: " << listed(words.runs)
       << "; left out: " << listed(words.leftOut);
  return line.str();
}

std::string whatIsPublished(const PublishSettings& settings, const Frames& frames) {
  std::ostringstream line;
  line << "publishes on demand: joint_states";
  if (settings.linkStates) line << " and link_states";
  line << " at " << settings.rate << " Hz, ";
  if (settings.tf) line << "tf at " << settings.tfRate << " Hz below " << frames.base << ", ";
  line << "status at " << settings.statusRate << " Hz, views at " << settings.tfRate << " Hz";

  std::vector<std::string> disabled;
  if (!settings.linkStates) disabled.push_back("link_states");
  if (!settings.tf) disabled.push_back("tf");
  if (!disabled.empty()) line << "; disabled: " << listed(disabled);
  return line.str();
}

}  // namespace planar_chain
