#include "planar_chain/fault.h"

#include <utility>

namespace planar_chain {

std::string toString(const Fault& fault) {
  return fault.path + ": expected " + fault.expected + ", got " + fault.found;
}

std::string toString(const std::vector<Fault>& faults, const char* between) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += between;
    text += toString(fault);
  }
  return text;
}

Refused::Refused(std::vector<Fault> faults)
    : std::invalid_argument(toString(faults, "\n")), faults_(std::move(faults)) {}

}  // namespace planar_chain
