#pragma once

/// The option --until 'JOINT = ANGLE' of simulate.

#include <optional>
#include <string>

#include "reading/names.h"
#include "tools/common.h"

namespace planar_chain::tools {

struct Until {
  std::string joint;
  double angle;
};

/// Nothing without the option. Records a fault for another text.
inline std::optional<Until> untilOf(const Arguments& given, std::vector<Fault>& faults) {
  const std::optional<std::string> text = given.text("until");
  if (!text) return std::nullopt;
  const std::size_t sign = text->find('=');
  const auto ends = [](const std::string& part) {
    return std::pair(part.find_first_not_of(' '), part.find_last_not_of(' ') + 1);
  };
  if (sign != std::string::npos) {
    const std::string left = text->substr(0, sign), right = text->substr(sign + 1);
    const auto [begin, end] = ends(left);
    char* rest = nullptr;
    const double angle = std::strtod(right.c_str(), &rest);
    const bool isNumber =
        rest != right.c_str() && std::string(rest).find_first_not_of(' ') == std::string::npos;
    if (begin < end && isNumber && std::isfinite(angle)) return Until{left.substr(begin, end - begin), angle};
  }
  faults.push_back(
      {"--until", "JOINT = ANGLE, such as 'upper_joint = 1.57' (rad; m of a prismatic joint)", *text});
  return std::nullopt;
}

/// The event at which the run ends.
/// @throws Refused if the chain has no such joint
inline MotionEvent eventOf(const Until& until, const Chain& chain) {
  Indices joints, links;
  for (const Joint& joint : chain.joints()) joints.emplace(joint.name, static_cast<int>(joints.size()));
  for (const Link& link : chain.links()) links.emplace(link.name, static_cast<int>(links.size()));
  const auto found = joints.find(until.joint);
  if (found == joints.end())
    throw Refused({{"--until", oneOf("joint", until.joint, joints, &links), '"' + until.joint + '"'}});
  MotionEvent event;
  event.terminal = 1;
  event.g = [i = static_cast<std::size_t>(found->second), angle = until.angle](
                double, const std::vector<double>& q, const std::vector<double>&) { return q[i] - angle; };
  return event;
}

}  // namespace planar_chain::tools
