#pragma once

/// The Python module planar_chain._core: the public headers on numpy arrays. It computes nothing itself.
///
/// pybind11 2.4, of Ubuntu 20.04, has all that is used here.

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "planar_chain/derivatives.h"
#include "planar_chain/kinematics.h"
#include "planar_chain/linear_model.h"
#include "planar_chain/scene.h"
#include "planar_chain/simulation.h"
#include "planar_chain/value.h"

namespace planar_chain::python {

namespace py = pybind11;

/// An array of doubles. One of another type or order is converted; others are not copied.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

inline Numbers copyOf(const std::vector<double>& values) {
  return Numbers(static_cast<py::ssize_t>(values.size()), values.data());
}

/// A scene and the tree of values that it was read from.
struct TreeAndScene {
  Value tree;
  Scene scene;

  explicit TreeAndScene(Value from);
  /// variedNumber(), which is found once for each path. Under Python's lock.
  const VariedNumber& near(const std::string& path) const;

 private:
  mutable std::map<std::string, VariedNumber> near_;
};

/// A dict with text as keys, list, tuple, array, number, bool, text or None.
/// @throws Refused for anything else
Value valueOf(const py::handle& object);
py::object objectOf(const Value& value);

/// Returns f() while other threads of Python run. An exception of Python, such as of Ctrl-C, counts before
/// one of f.
template <class F>
auto released(const F& f) {
  try {
    const py::gil_scoped_release others;
    return f();
  } catch (...) {
    if (PyErr_Occurred()) throw py::error_already_set();
    throw;
  }
}

/// The name of an object's class, without its module.
std::string classOf(const py::handle& object);
/// The text that Python prints for it, on one line and in ASCII.
std::string shown(const py::handle& object);

/// Gives a class of results a __repr__: "Energy(kinetic=1.0, ...)", with these attributes.
void showFields(const py::object& type, std::initializer_list<const char*> fields);

/// "2 x 3", "4 numbers" or "one number"
std::string shapeOf(const Numbers& numbers);

// Arguments of any type, by name.
// @throws Refused for a value of another type, shape or range

/// A number; it may be infinite or NaN.
double numberOf(const py::object& given, const char* name);
/// A number that isFactor().
double factorOf(const py::object& given, const char* name);
long long countOf(const py::object& given, const char* name, long long least, long long most);
/// most_steps: None or a number > 0
std::optional<long long> stepsOf(const py::object& given);
/// True for a masked array of numpy, and for numpy.ma.masked.
bool isMasked(const py::handle& given);
/// True for a bool of Python or numpy.
bool isBool(const py::handle& given);
/// True for a complex number of Python or numpy, which numpy would cut to its real part, and for a time of
/// numpy, whose unit would be lost.
bool isNotReal(const py::handle& given);
/// The number of an element; of a larger number, the largest. Nothing for a bool and what is no whole number.
std::optional<py::ssize_t> indexIn(const py::object& given);
Numbers arrayOf(const py::object& given, const char* name);
/// The numbers of an array of one dimension and, if given, this size.
std::vector<double> numbersOf(const py::object& given, const char* name,
                              std::optional<std::size_t> size = std::nullopt);
/// "times", of one dimension
std::vector<double> timesOf(const py::object& given);
std::string textOf(const py::object& given, const char* name);
/// The text, or nothing if it is not valid. Requires a str.
std::optional<std::string> textIn(const py::handle& given);
py::dict dictOf(const py::object& given, const char* name);

/// Gives a warning of Python, unless there are no words.
void warn(const std::string& words);

/// The matrices of the equations, by letter.
py::dict equationsAt(const Scene& scene, double t, const Eigen::VectorXd& q, const Eigen::VectorXd& qd);
/// A and B. Its notes become warnings.
py::tuple shownModel(LinearModel model);

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

struct Run;      // the results of simulate() with derivatives
struct Runs;     // the results of simulate_many()
class Running;   // a Simulation
struct Reading;  // a measurement

template <class T, class... Others>
constexpr bool isOneOf = std::disjunction_v<std::is_same<T, Others>...>;
template <class T>
constexpr bool isBound = isOneOf<T, TreeAndScene, Running, Run, Runs, Fault, Energy, EnergyBalance,
                                 Statistics, Reading, SavedState, FrameMotion>;

/// Arguments of a bound class. An object that __new__ alone made is refused: it holds nothing.
template <class T>
struct InitializedCaster : py::detail::type_caster_base<T> {
  bool load(py::handle from, bool convert) {
    if (py::isinstance<T>(from)) {
      auto* instance = reinterpret_cast<py::detail::instance*>(from.ptr());
      if (!instance->get_value_and_holder(py::detail::get_type_info(typeid(T))).instance_registered()) {
        throw py::type_error(classOf(from) +
                             ": expected an object that __init__() made, got one of __new__() alone");
      }
    }
    if (std::is_same_v<T, TreeAndScene> && !py::isinstance<T>(from)) {
      throw py::type_error("scene: expected a planar_chain.Scene (Scene.from_file(\"…\") reads one), got " +
                           shown(from));
    }
    return py::detail::type_caster_base<T>::load(from, convert);
  }
};

void bindScene(py::module& module);
void bindEquations(py::module& module);
void bindKinematics(py::module& module, py::class_<TreeAndScene>& scene);
void bindSimulation(py::module& module);
void bindMany(py::module& module);
/// Makes every function of the module raise readable errors for wrong arguments.
void explainCalls(py::module& module);

}  // namespace planar_chain::python

namespace pybind11::detail {

template <class T>
struct type_caster<T, std::enable_if_t<planar_chain::python::isBound<T>>>
    : planar_chain::python::InitializedCaster<T> {};

}  // namespace pybind11::detail
