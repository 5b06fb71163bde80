/// Any numbers at all, as many as there are, are a state or are refused by ~equations and ~linearize; an
/// answer is finite.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "bytes.h"
#include "planar_chain/scene_reader.h"
#include "ros/node/queries.h"

namespace planar_chain {
namespace {

bool areFinite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

Simulation& simulation() {
  static Simulation one(
      readSceneText("chain: [a, b]\n"
                    "links:\n"
                    "  a: {mass: 1, inertia: 0.1, com: [0.5, 0.1], pin: [1, 0]}\n"
                    "  b: {mass: 2, inertia: 0, com: [0.3, 0], pin: [0.4, 0.1],\n"
                    "      joint: {stiffness: 3, damping: 0.2, upper: 1, stop_stiffness: 40}}\n"
                    "loads: {wind: {link: b, force: [1, 2], point: [0.2, 0.1]}}\n"),
      1);
  return one;
}

/// torques: of a service that takes them.
template <class Service, class... Torques>
typename Service::Response asked(const std::vector<double>& q, const std::vector<double>& qd,
                                 const Torques&... torques) {
  typename Service::Response response;
  const Answer answered = answer(simulation(), q, qd, torques..., response);
  response.success = answered.success;
  const bool isSound =
      ((q.empty() && qd.empty()) || (q.size() == 2 && qd.size() == 2 && areFinite(q) && areFinite(qd))) &&
      (... && (torques.empty() || (torques.size() == 2 && areFinite(torques))));
  require(!response.success || isSound);
  require(answered.success == answered.message.empty());
  return response;
}

}  // namespace
}  // namespace planar_chain

/// The first byte: how many of the numbers that follow are angles.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace planar_chain;
  if (size == 0) return 0;
  std::vector<double> numbers((size - 1) / sizeof(double));
  if (!numbers.empty()) std::memcpy(numbers.data(), data + 1, numbers.size() * sizeof(double));
  const auto split =
      numbers.begin() + static_cast<std::ptrdiff_t>(std::min<std::size_t>(data[0], numbers.size()));
  const std::vector<double> q(numbers.begin(), split), qd(split, numbers.end());

  const auto equations = asked<Equations>(q, qd);
  for (const auto* numbersOf :
       {&equations.q, &equations.qd, &equations.f, &equations.qdd, &equations.M.data}) {
    require(areFinite(*numbersOf) && numbersOf->empty() != bool(equations.success));
  }
  for (const std::vector<double>& torques : {std::vector<double>(), qd}) {
    const auto linear = asked<Linearize>(q, qd, torques);
    for (const auto* matrix : {&linear.A, &linear.B}) {
      require(areFinite(matrix->data) && matrix->data.size() == std::size_t{matrix->rows} * matrix->columns);
      require(matrix->data.empty() != bool(linear.success));
    }
  }
  return 0;
}
