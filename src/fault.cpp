#include "planar_chain/fault.h"

#include <utility>

namespace planar_chain {

namespace {

std::string oneLineEach(const std::vector<Fault>& faults) {
  std::string lines;
  for (const Fault& fault : faults) {
    if (!lines.empty()) lines += '\n';
    lines += toString(fault);
  }
  return lines;
}

}  // namespace

std::string toString(const Fault& fault) {
  return fault.path + ": expected " + fault.expected + ", got " + fault.found;
}

Refused::Refused(std::vector<Fault> faults)
    : std::invalid_argument(oneLineEach(faults)), faults_(std::move(faults)) {}

}  // namespace planar_chain
