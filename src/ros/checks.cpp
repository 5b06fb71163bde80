#include "planar_chain/ros/checks.h"

#include <cmath>

#include "planar_chain/value.h"

namespace planar_chain {

void checkValues(std::vector<Fault>& faults, const std::string& path, const char* what, const char* unit,
                 const std::vector<double>& values, std::size_t joints) {
  if (values.size() != joints) {
    faults.push_back({path, std::to_string(joints) + " " + what + ", one per joint in chain order",
                      std::to_string(values.size())});
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    faults.push_back(
        {path + "[" + std::to_string(i) + "]", std::string("a finite number, ") + unit, toText(values[i])});
  }
}

}  // namespace planar_chain
