#include <stdexcept>
#include <string>

#include "python/bindings.h"

namespace planar_chain::python {

namespace {

/// NumPy 2 stores the size of an element elsewhere. pybind11 before 2.12 reads 0 there, and makes arrays with
/// strides of 0.
void requireKnownNumpy() {
#if PYBIND11_VERSION_MAJOR == 2 && PYBIND11_VERSION_MINOR < 12
  const std::string version = py::str(py::module::import("numpy").attr("__version__"));
  if (std::stoi(version) < 2) return;
  throw std::runtime_error("planar_chain was built with pybind11 2." +
                           std::to_string(PYBIND11_VERSION_MINOR) +
                           ", which gives wrong numbers with NumPy 2, and NumPy " + version +
                           " is installed. Either install NumPy 1 (pip install \"numpy<2\"), or build with "
                           "pybind11 2.12 or later:\n"
                           "  pip install \"pybind11>=2.12\"\n"
                           "  cmake build -Dpybind11_DIR=\"$(python3 -m pybind11 --cmakedir)\"\n"
                           "  cmake --build build");
#endif
}

}  // namespace

}  // namespace planar_chain::python

PYBIND11_MODULE(_core, module) {
  using namespace planar_chain::python;
  requireKnownNumpy();
  module.doc() = "The compiled part of planar_chain. Angles are in rad, all else in SI units.";
  bindScene(module);
  bindEquations(module);
  bindSimulation(module);
  bindMany(module);
  explainCalls(module);
}
