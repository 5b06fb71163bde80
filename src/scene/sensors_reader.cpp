#include "scene/sensors_reader.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "reading/names.h"
#include "scene/frames_reader.h"
#include "scene/settings_reader.h"

namespace planar_chain {

namespace {

constexpr double longestDelay = 10;  // s
constexpr double largestSeed = 9007199254740992;

/// The names that a node has below its own.
const std::set<std::string> namesOfTheNode{"base_trajectory",
                                           "base_wrench",
                                           "clear_commands",
                                           "commands_taken",
                                           "equations",
                                           "joint_torque",
                                           "joint_torques",
                                           "joint_trajectory",
                                           "linearize",
                                           "link_force",
                                           "link_states",
                                           "pause",
                                           "reset",
                                           "resume",
                                           "scene",
                                           "set_state",
                                           "settle",
                                           "status",
                                           "step",
                                           "tip_wrench",
                                           "view"};

/// The largest error or position: squares of larger ones, as sums of sensors have them, might overflow.
constexpr double largestSize = 1e100;

NumberRule sized(NumberRule rule) {
  rule.which += ", of size up to 1e100";
  rule.low = std::max(rule.low, -largestSize);
  rule.high = largestSize;
  return rule;
}

void takeJoints(const Section& in, const ChainNames* names, Encoder& encoder) {
  const char* expected = "all, or a list of joints, each once";
  const Value& value = *in.find("joints");
  if (value.text() && *value.text() == "all") {
    for (int i = 0; names && i < static_cast<int>(names->joints.size()); ++i) encoder.joints.push_back(i);
    return;
  }
  if (!value.list() || value.list()->empty()) return in.fault("joints", expected);
  std::set<std::string> listed;
  for (std::size_t i = 0; i < value.list()->size(); ++i) {
    const Value& one = (*value.list())[i];
    const std::string key = "joints/" + std::to_string(i);
    if (!one.text() || !listed.insert(*one.text()).second) {
      in.fault(key, "the name of a joint, each once", describe(one));
    } else if (names) {
      const auto found = names->joints.find(*one.text());
      if (found == names->joints.end()) {
        in.fault(key, oneOf("joint", *one.text(), names->joints, &names->links), describe(one));
      } else {
        encoder.joints.push_back(found->second);
      }
    }
  }
}

Encoder readEncoder(const Section& in, const ChainNames* names) {
  Encoder encoder;
  takeJoints(in, names, encoder);
  in.take("resolution", sized(NumberRule::from(0, "rad (m if prismatic)")), encoder.resolution);
  in.take("noise", sized(NumberRule::from(0, "rad (m if prismatic)")), encoder.noise);
  in.take("bias", sized(NumberRule::any("rad (m if prismatic)")), encoder.bias);
  return encoder;
}

AxesErrors readErrors(const Section& in, const std::string& of, const std::string& unit) {
  AxesErrors errors;
  in.take(of + "_noise", sized(NumberRule::from(0, unit)), errors.noise);
  in.take(of + "_bias", sized(NumberRule::any(unit)), errors.bias);
  in.take(of + "_bias_walk", sized(NumberRule::from(0, unit + "/√s")), errors.walk);
  return errors;
}

Imu readImu(const Section& in, const ChainNames* names) {
  Imu imu;
  imu.link = takeLink(in, names);
  takePointAndAngle(in, imu.point, imu.angle);
  imu.gyro = readErrors(in, "gyro", "rad/s");
  imu.specific = readErrors(in, "accelerometer", "m/s²");
  return imu;
}

Sensor readSensor(const Section& sensors, const std::string& name, const PublishSettings& publish,
                  const ChainNames* names) {
  // The kind.
  Sensor sensor;
  sensor.name = name;
  const Section any = sensors.section(name);
  const bool isImu = any.has("link"), isEncoder = any.has("joints");
  if (!isName(name)) sensors.fault(name, nameInWords, quoted(name));
  if (namesOfTheNode.count(name) != 0) {
    sensors.fault(name, "a name that is not one of the node's topics and services", quoted(name));
  }
  if (isImu == isEncoder) {
    if (sensors.find(name)->map()) {
      sensors.fault(name, "joints (of an encoder) or link (of an IMU)", isImu ? "both" : "neither");
    }
    return sensor;
  }

  // Its keys.
  std::vector<const char*> keys{"rate", "delay"};
  for (const char* key : {"joints", "resolution", "noise", "bias"}) {
    if (isEncoder) keys.push_back(key);
  }
  for (const char* key : {"link", "point", "angle", "gyro_noise", "gyro_bias", "gyro_bias_walk",
                          "accelerometer_noise", "accelerometer_bias", "accelerometer_bias_walk"}) {
    if (isImu) keys.push_back(key);
  }
  const Section in = sensors.section(name, keys);
  in.take("rate", {" > 0 Hz and at most " + toText(highestRate), 0, highestRate}, sensor.rate);
  in.take("delay", {" from 0 to " + toText(longestDelay) + " s", 0, longestDelay, true}, sensor.delay);
  if (isImu) {
    requireOwnFrame(sensors, name, publish, names);
    sensor.kind = readImu(in, names);
  } else {
    sensor.kind = readEncoder(in, names);
  }
  return sensor;
}

}  // namespace

std::vector<Sensor> readSensors(const Section& top, const PublishSettings& publish, const ChainNames* names) {
  std::vector<Sensor> read;
  const Section sensors = top.section("sensors");
  for (const auto& [name, value] : sensors.entries()) {
    read.push_back(readSensor(sensors, name, publish, names));
  }
  return read;
}

long long readSeed(const Section& top) {
  const double seed = top.has("seed") ? top.uncheckedNumber("seed") : 0;
  if (std::abs(seed) <= largestSeed && seed == std::floor(seed)) return static_cast<long long>(seed);
  top.fault("seed", "a whole number from -9007199254740992 to 9007199254740992");
  return 0;
}

}  // namespace planar_chain
