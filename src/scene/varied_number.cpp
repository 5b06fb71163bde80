#include <algorithm>
#include <cmath>

#include "planar_chain/derivatives.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {

namespace {

/// A difference of sixth order: on both sides of the number, or on one side if the other has no values.
struct Difference {
  std::vector<int> steps;
  std::vector<double> weights;
};
const std::vector<Difference>& differences() {
  static const std::vector<double> oneSided{-147. / 60, 360. / 60, -450. / 60, 400. / 60,
                                            -225. / 60, 72. / 60,  -10. / 60};
  static const std::vector<Difference> all = [] {
    std::vector<Difference> made{
        {{-3, -2, -1, 1, 2, 3}, {-1. / 60, 9. / 60, -45. / 60, 45. / 60, -9. / 60, 1. / 60}},
        {{0, 1, 2, 3, 4, 5, 6}, oneSided}};
    made.push_back(made.back());
    for (int& step : made.back().steps) step = -step;
    for (double& weight : made.back().weights) weight = -weight;
    return made;
  }();
  return all;
}

/// The share of a number by which it is varied: f bends by its sixth power, 1e-14, and rounding grows by one
/// over it.
constexpr double share = 0.005;

}  // namespace

VariedNumber variedNumber(const Value& scene, const std::string& path) {
  requireNumbers(scene, {path});
  const std::optional<double> number = numberAt(scene, path);
  if (!number) throw Refused({{path, "a number that the scene has", "nothing"}});
  const double size = *number == 0 ? 1 : std::abs(*number), step = share * size;
  std::vector<Fault> faults;
  for (const Difference& difference : differences()) {
    VariedNumber varied{path, size, {}, {}};
    try {
      for (const int steps : difference.steps) {
        Value near = scene;
        setNumber(near, path, *number + steps * step);
        varied.scenes.push_back(readScene(near));
      }
    } catch (const Refused& refused) {
      faults = refused.faults();
      continue;
    }
    for (const double weight : difference.weights) varied.weights.push_back(weight / step);
    return varied;
  }
  throw Refused(std::move(faults));
}

}  // namespace planar_chain
