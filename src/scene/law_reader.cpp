#include "scene/law_reader.h"

#include <algorithm>
#include <functional>

namespace planar_chain {

MotionLaw readLaw(const Section& in, const char* key, const char* unit, bool mayHold) {
  const Value* value = in.find(key);
  if (value && value->text() && *value->text() == "hold" && mayHold) return {};
  if (value && !value->map()) {
    in.fault(key, std::string("a map with amplitude and frequency, or with times and values") +
                      (mayHold ? ", or hold" : ""));
    return {};
  }
  const Section law = in.section(key, {"amplitude", "frequency", "phase", "offset", "times", "values"});
  if (law.has("times") || law.has("values")) {
    for (const char* other : {"amplitude", "frequency", "phase", "offset"}) {
      if (law.has(other)) law.fault(other, std::string("no ") + other + " beside times and values");
    }
    std::vector<double> times, values;
    return takeCurve(law, unit, times, values) ? MotionLaw::spline(times, values) : MotionLaw();
  }
  double amplitude = 0, frequency = 0, phase = 0, offset = 0;
  for (const char* needed : {"amplitude", "frequency"}) {
    if (!law.has(needed)) law.fault(needed, std::string("amplitude and frequency, or times and values"));
  }
  law.take("amplitude", NumberRule::any(unit), amplitude);
  law.take("frequency", NumberRule::any("Hz"), frequency);
  law.take("phase", NumberRule::any("rad"), phase);
  law.take("offset", NumberRule::any(unit), offset);
  return MotionLaw::sine(amplitude, frequency, phase, offset);
}

BaseLaws readBase(const Section& base) {
  BaseLaws laws;
  if (base.has("x")) laws.x = readLaw(base, "x", "m", false);
  if (base.has("y")) laws.y = readLaw(base, "y", "m", false);
  if (base.has("angle")) laws.angle = readLaw(base, "angle", "rad", false);
  return laws;
}

}  // namespace planar_chain
