#include "planar_chain/fault.h"

#include <utility>

namespace planar_chain {

namespace {

constexpr std::size_t mostFaults = 1000;

std::vector<Fault>& shorten(std::vector<Fault>& faults) {
  if (faults.size() <= mostFaults) return faults;
  const std::string all = std::to_string(faults.size());
  faults.resize(mostFaults);
  faults.push_back({"input", "at most " + std::to_string(mostFaults) + " faults", all});
  return faults;
}

}  // namespace

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
    : std::invalid_argument(toString(shorten(faults), "\n")), faults_(std::move(faults)) {}

}  // namespace planar_chain
