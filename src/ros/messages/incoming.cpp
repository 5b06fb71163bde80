#include "ros/messages/incoming.h"

#include <cmath>

namespace planar_chain {

void checkFinite(std::vector<Fault>& faults, const std::string& path, const char* unit, double value) {
  if (std::isfinite(value)) return;
  faults.push_back({path, std::string("a finite number, ") + unit, toText(value)});
}

void checkValues(std::vector<Fault>& faults, const std::string& path, const char* what, const char* unit,
                 const std::vector<double>& values, std::size_t joints) {
  if (values.size() != joints) {
    faults.push_back({path, std::to_string(joints) + " " + what + ", one per joint in chain order",
                      std::to_string(values.size())});
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    checkFinite(faults, path + "[" + std::to_string(i) + "]", unit, values[i]);
  }
}

}  // namespace planar_chain
