#include "scene/settings_reader.h"

#include <algorithm>
#include <cmath>

#include "ode/methods.h"

namespace planar_chain {

namespace {

constexpr double highestRate = 10000;

void takeFrame(const Section& in, const std::string& key, std::string& target) {
  const auto isFrame = [](const std::string& text) {
    return !text.empty() && text[0] != '/' &&
           std::all_of(text.begin(), text.end(), [](char c) { return isWordCharacter(c) || c == '/'; });
  };
  in.takeText(key, isFrame, "a frame (letters, digits, _ and /; not / first)", target);
}

}  // namespace

bool takeCount(const Section& in, const char* key, int& target) {
  const double count = in.unchecked(key, 1.0);
  const bool isCount = count >= 1 && count <= mostLinks && count == std::floor(count);
  if (isCount) {
    target = static_cast<int>(count);
  } else {
    in.fault(key, "an integer from 1 to " + std::to_string(mostLinks));
  }
  return isCount;
}

IntegratorSettings readIntegrator(const Section& in) {
  IntegratorSettings settings;
  const std::vector<std::string>& methods = ode::methodNames();
  const auto isMethod = [&](const std::string& name) {
    return std::find(methods.begin(), methods.end(), name) != methods.end();
  };
  in.takeText("method", isMethod, "one of " + inCommas(methods), settings.method);
  in.take("tolerance", {" from 1e-15 to 1", 1e-15, 1, true}, settings.tolerance);
  in.take("step", NumberRule::above(0, "s"), settings.step);
  in.take("plain_kernel", settings.plainKernel);
  return settings;
}

PublishSettings readPublish(const Section& in, const ChainNames* names) {
  PublishSettings settings;
  // Rates.
  in.take("rate", {" > 0 Hz and at most " + toText(highestRate), 0, highestRate, false}, settings.rate);
  settings.tfRate = std::min(settings.tfRate, settings.rate);
  settings.statusRate = std::min(settings.statusRate, settings.rate);
  const NumberRule upToRate{" > 0 Hz and at most the rate, " + toText(settings.rate), 0, settings.rate,
                            false};
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
  return settings;
}

}  // namespace planar_chain
