#include "scene/frames_reader.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "reading/names.h"

namespace planar_chain {

void requireOwnFrame(const Section& in, const std::string& name, const PublishSettings& publish,
                     const ChainNames* names) {
  const bool isTaken = name == publish.worldFrame || name == publish.baseFrame || name == movingFrame ||
                       (names && names->links.count(name) != 0);
  if (isTaken) in.fault(name, "a name that no other frame has", quoted(name));
}

int takeLink(const Section& in, const ChainNames* names) {
  const Value* link = in.find("link");
  if (!link || !link->text()) {
    in.fault("link", "the name of a link");
    return 0;
  }
  if (!names) return 0;
  const auto found = names->links.find(*link->text());
  if (found != names->links.end()) return found->second;
  in.fault("link", oneOf("link", *link->text(), names->links, &names->joints));
  return 0;
}

void takePointAndAngle(const Section& in, Vec2d& point, double& angle) {
  constexpr double farthest = 1e100;  // m: squares of it do not overflow
  if (in.take("point", "m", point); !(std::hypot(point.x, point.y) <= farthest)) {
    in.fault("point", "a place within 1e100 m of the inner pin");
  }
  in.take("angle", NumberRule::any("rad"), angle);
}

std::vector<Frame> readFrames(const Section& top, const std::vector<Sensor>& sensors,
                              const PublishSettings& publish, const ChainNames* names) {
  std::vector<Frame> frames;
  const Section all = top.section("frames");
  for (const auto& [name, value] : all.entries()) {
    if (!isName(name)) all.fault(name, nameInWords, quoted(name));
    requireOwnFrame(all, name, publish, names);
    const std::string& own = name;
    const bool isSensors = std::any_of(sensors.begin(), sensors.end(), [&own](const Sensor& sensor) {
      return sensor.name == own && std::holds_alternative<Imu>(sensor.kind);
    });
    if (isSensors) all.fault(name, "a name that no other frame has, such as that of an IMU", quoted(name));
    const Section in = all.section(name, {"link", "point", "angle"});
    if (!value.map()) continue;
    Frame& frame = frames.emplace_back();
    frame.name = name;
    frame.link = takeLink(in, names);
    takePointAndAngle(in, frame.point, frame.angle);
  }
  return frames;
}

}  // namespace planar_chain
