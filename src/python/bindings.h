#pragma once

/// The Python module planar_chain._core: the public headers on numpy arrays. It computes nothing by itself.
///
/// pybind11 2.4, of Ubuntu 20.04, has all that is used here.

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <string>
#include <vector>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain::python {

namespace py = pybind11;

/// An array of doubles. One of another type or order is converted; others are not copied.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A scene and the tree of values that it was read from.
struct TreeAndScene {
  Value tree;
  Scene scene;

  explicit TreeAndScene(Value from);
};

/// A dict with text as keys, list, tuple, array, number, bool, text or None.
/// @throws Refused for anything else
Value valueOf(const py::handle& object);
py::object objectOf(const Value& value);

/// Sets a number of a scene at a path such as "links/lower/com/0". Maps on the way are made.
/// @throws Refused if the path leads through a number or out of a list
void setAt(Value& tree, const std::string& path, double number);

/// The numbers of an array of one dimension.
/// @throws std::invalid_argument unless it has `size` of them
std::vector<double> vectorOf(const Numbers& numbers, std::size_t size, const char* name);

/// The matrices of the equations, by letter.
py::dict equationsAt(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd);
/// A and B.
py::tuple linearizedAt(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd);

/// True until Ctrl-C, at which it looks every twentieth of a second. It may be called without the GIL.
class Uninterrupted {
 public:
  bool operator()() {
    const auto now = std::chrono::steady_clock::now();
    if (now < due_) return true;
    due_ = now + period;
    const py::gil_scoped_acquire gil;
    return PyErr_CheckSignals() == 0;
  }

 private:
  static constexpr std::chrono::milliseconds period{50};
  std::chrono::steady_clock::time_point due_ = std::chrono::steady_clock::now() + period;
};

void bindScene(py::module& module);
void bindEquations(py::module& module);
void bindSimulation(py::module& module);
void bindMany(py::module& module);

}  // namespace planar_chain::python
