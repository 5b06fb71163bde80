#include "scene/settings_reader.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "dynamics/equilibrium.h"
#include "effects/effects.h"
#include "effects/loads.h"
#include "ode/methods.h"

namespace planar_chain {

MotionLaw readLaw(const Section& in, const char* key, const char* unit, bool mayHold) {
  const Value* value = in.find(key);
  if (value && value->text() && *value->text() == "hold" && mayHold) return {};
  if (value && !value->map() && numberIn(*value)) {
    in.fault(key, "a map, such as {offset: " + toText(*numberIn(*value)) + "}");
    return {};
  }
  if (value && !value->map()) {
    in.fault(key, std::string("a map with amplitude and frequency, with times and values, or with offset") +
                      (mayHold ? ", or hold" : ""));
    return {};
  }
  const auto checked = [&](MotionLaw read) {
    if (read.isModerate()) return read;
    in.fault(key, MotionLaw::moderate(unit));
    return MotionLaw();
  };
  const Section law = in.section(key, {"amplitude", "frequency", "phase", "offset", "times", "values"});
  if (law.has("times") || law.has("values")) {
    for (const char* other : {"amplitude", "frequency", "phase", "offset"}) {
      if (law.has(other)) law.fault(other, std::string("no ") + other + " beside times and values");
    }
    std::vector<double> times, values;
    return takeCurve(law, unit, times, values) ? checked(MotionLaw::spline(times, values)) : MotionLaw();
  }
  double amplitude = 0, frequency = 0, phase = 0, offset = 0;
  const bool stands =
      law.has("offset") && !law.has("amplitude") && !law.has("frequency") && !law.has("phase");
  for (const char* needed : {"amplitude", "frequency"}) {
    if (!law.has(needed) && !stands)
      law.fault(needed, "amplitude and frequency, times and values, or offset");
  }
  law.take("amplitude", NumberRule::any(unit), amplitude);
  law.take("frequency", NumberRule::any("Hz"), frequency);
  law.take("phase", phaseRule(), phase);
  law.take("offset", NumberRule::any(unit), offset);
  return checked(MotionLaw::sine(amplitude, frequency, phase, offset));
}

BaseLaws readBase(const Section& base) {
  BaseLaws laws;
  if (base.has("x")) laws.x = readLaw(base, "x", "m", false);
  if (base.has("y")) laws.y = readLaw(base, "y", "m", false);
  if (base.has("angle")) laws.angle = readLaw(base, "angle", "rad", false);
  return laws;
}

MotionLaw readDrive(const Section& link, const Section& joint, const char* unit, double& q, double& qd) {
  for (const EffectKind* kind : effectKinds()) {
    for (const JointKey& key : kind->jointKeys()) {
      if (key.isAllowedBesideDrive || !joint.has(key.name)) continue;
      joint.fault(key.name, std::string("no ") + key.name + " in a driven joint");
    }
  }
  if (link.has("initial")) link.fault("initial", "no initial state of a driven joint");
  const MotionLaw law = readLaw(joint, "drive", unit, true);
  const GivenMotion start = law.at(0);
  q = start.value;
  qd = start.rate;
  return law;
}

bool readStart(const Section& top) {
  std::string start = "initial";
  const auto isStart = [](const std::string& text) { return text == "initial" || text == "rest"; };
  top.takeText("start", isStart, "initial or rest", start);
  return start == "rest";
}

void requireSeries(const Scene& scene, const Section& top) {
  if (scene.integrator.method != "taylor") return;
  const auto refuse = [&](const std::string& of) {
    top.section("integrator")
        .fault("method", "another method than taylor, as there is no Taylor series " + of, quoted("taylor"));
  };
  const bool isMixed = scene.chain.coordinates().anyIsPrismatic();
  for (const EffectKind* kind : effectKinds()) {
    const std::unique_ptr<Effect> effect = kind->make(scene);
    if (!effect) continue;
    const bool holdsTip = effect->jointConstraint() && effect->jointConstraint()->holdsTip();
    const bool couples = effect->jointConstraint() && (isMixed || !holdsTip);
    if (effect->hasSeries() && !(couples && scene.tip)) continue;
    SceneWords words;
    kind->summarize(scene, words);
    const std::string name = words.runs.empty() ? "what acts" : words.runs.back();
    const char* beside = holdsTip ? " beside a prismatic link" : " beside a held tip";
    refuse("with " + name + (effect->hasSeries() ? beside : ""));
  }
}

void startAtRest(Scene& scene, const Section& top) {
  try {
    scene.q = equilibriumOf(scene, 0, scene.q);
  } catch (const SearchGaveUp& search) {
    top.fault("start", "initial, as no equilibrium was found", search.what());
  } catch (const std::domain_error& none) {
    top.fault("start", "initial, as there is no equilibrium", none.what());
  }
  std::fill(scene.qd.begin(), scene.qd.end(), 0.0);
  for (const Drive& drive : scene.drives) scene.qd[index(drive.joint)] = drive.law.at(0).rate;
}

/// Returns true if the key is absent or an integer from 1 to mostLinks.
bool takeCount(const Section& in, const char* key, int& target) {
  const double count = in.has(key) ? in.uncheckedNumber(key) : target;
  if (!(count >= 1 && count <= mostLinks && count == std::floor(count))) {
    in.fault(key, "an integer from 1 to " + std::to_string(mostLinks));
    return false;
  }
  target = static_cast<int>(count);
  return true;
}

IntegratorSettings readIntegrator(const Section& in) {
  IntegratorSettings settings;
  const std::vector<std::string>& all = ode::methodNames();
  const auto isMethod = [&](const auto& name) { return std::count(all.begin(), all.end(), name) > 0; };
  in.takeText("method", isMethod, "one of " + inCommas(all), settings.method);
  constexpr double finest = IntegratorSettings::finest, coarsest = IntegratorSettings::coarsest;
  constexpr double coarsestOfRates = 1e6;  // rad/s: as good as none
  constexpr double shortestStep = 1e-12;   // s: shorter ones are lost in the rounding of the time
  in.take("tolerance", {" from 1e-15 to 1", finest, coarsest, true}, settings.tolerance);
  if (in.has("rate_tolerance")) {
    in.take("rate_tolerance", {" from 1e-15 to 1000000 rad/s", finest, coarsestOfRates, true},
            settings.rateTolerance.emplace(1));
  }
  if (in.has("loosest_tolerance")) {
    in.take(
        "loosest_tolerance",
        {" from the tolerance, " + toText(settings.tolerance) + ", to 1", settings.tolerance, coarsest, true},
        settings.loosestTolerance.emplace(1));
  }
  in.take("step", NumberRule::from(shortestStep, "s"), settings.step);
  in.take("plain_kernel", settings.plainKernel);
  return settings;
}

void takeFrame(const Section& in, const std::string& key, std::string& target) {
  const auto isFrame = [](const std::string& text) {
    return !text.empty() && text[0] != '/' &&
           std::all_of(text.begin(), text.end(), [](char c) { return isWordCharacter(c) || c == '/'; });
  };
  in.takeText(key, isFrame, "a frame (letters, digits, _ and /; not / first)", target);
}

/// names: nullptr if the links could not be read.
PublishSettings readPublish(const Section& top, const ChainNames* names) {
  const Section in =
      top.section("publish", {"rate", "tf_rate", "status_rate", "tf", "link_states", "frame_every",
                              "frame_prefix", "world_frame", "base_frame", "offset"});
  PublishSettings settings;
  // Rates.
  in.take("rate", {" > 0 Hz and at most " + toText(highestRate), 0, highestRate}, settings.rate);
  settings.tfRate = std::min(settings.tfRate, settings.rate);
  settings.statusRate = std::min(settings.statusRate, settings.rate);
  const NumberRule upToRate{" > 0 Hz and at most the rate, " + toText(settings.rate), 0, settings.rate};
  in.take("tf_rate", upToRate, settings.tfRate);
  in.take("status_rate", upToRate, settings.statusRate);

  // Topics.
  in.take("tf", settings.tf);
  in.take("link_states", settings.linkStates);

  // Frames. The prefix may be empty.
  if (in.has("frame_every")) takeCount(in, "frame_every", settings.frameEvery.emplace(1));
  if (const Value* prefix = in.find("frame_prefix")) {
    settings.framePrefix.emplace();
    if (!prefix->text() || !prefix->text()->empty()) takeFrame(in, "frame_prefix", *settings.framePrefix);
  }
  takeFrame(in, "world_frame", settings.worldFrame);
  takeFrame(in, "base_frame", settings.baseFrame);
  const auto requireOwn = [&](const char* key, const std::string& frame) {
    if (names && names->links.count(frame) != 0) {
      in.fault(key, "a frame that is not a link's", quoted(frame));
    }
  };
  requireOwn("world_frame", settings.worldFrame);
  requireOwn("base_frame", settings.baseFrame);
  if (settings.worldFrame == settings.baseFrame) {
    in.fault("base_frame", "a frame other than world_frame", quoted(settings.baseFrame));
  }
  in.take("offset", "m", settings.offset);
  return settings;
}

}  // namespace planar_chain
