#include "python/bindings.h"

PYBIND11_MODULE(_core, module) {
  using namespace planar_chain::python;
  module.doc() = "The compiled part of planar_chain. Angles are in rad, all else in SI units.";
  bindScene(module);
  bindEquations(module);
  bindSimulation(module);
  bindMany(module);
  explainCalls(module);
}
