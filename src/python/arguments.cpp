/// Arguments from Python, with faults in words.

#include <cmath>
#include <string>

#include "python/bindings.h"

namespace planar_chain::python {

namespace {

[[noreturn]] void refuse(const char* name, const std::string& expected, const py::object& given) {
  throw Refused({{name, expected, shown(given)}});
}

}  // namespace

double numberOf(const py::object& given, const char* name) {
  if (PyNumber_Check(given.ptr()) != 0) {
    const double number = PyFloat_AsDouble(given.ptr());
    if (!PyErr_Occurred()) return number;
    PyErr_Clear();
  }
  refuse(name, "a number", given);
}

double finiteOf(const py::object& given, const char* name) {
  const double number = numberOf(given, name);
  if (!std::isfinite(number)) refuse(name, "a finite number", given);
  return number;
}

long long countOf(const py::object& given, const char* name, long long least, long long most) {
  if (PyIndex_Check(given.ptr()) != 0) {
    const py::ssize_t count = PyNumber_AsSsize_t(given.ptr(), nullptr);  // of larger numbers, the largest
    if (count >= least && count <= most) return count;
  }
  refuse(name, "a whole number >= " + std::to_string(least), given);
}

std::optional<long long> stepsOf(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  return countOf(given, "most_steps", 1, 1'000'000'000'000'000);
}

Numbers arrayOf(const py::object& given, const char* name) {
  const bool isText = py::isinstance<py::str>(given) || py::isinstance<py::bytes>(given);
  if (given.is_none() || isText) refuse(name, "an array of numbers", given);
  const py::array any = py::array::ensure(given);
  if (!any) refuse(name, "an array of numbers", given);
  if (std::string("biufO").find(any.dtype().kind()) == std::string::npos) {  // text, complex, times, records
    throw Refused({{name, "an array of real numbers", "one of " + shown(any.dtype())}});
  }
  Numbers numbers = Numbers::ensure(any);
  if (!numbers) refuse(name, "an array of numbers", given);
  return numbers;
}

std::vector<double> numbersOf(const py::object& given, const char* name, std::optional<std::size_t> size) {
  const Numbers numbers = arrayOf(given, name);
  if (numbers.ndim() != 1 || (size && static_cast<std::size_t>(numbers.size()) != *size)) {
    const std::string expected =
        size ? "an array of " + std::to_string(*size) + " numbers" : "an array of one dimension";
    throw Refused({{name, expected, shapeOf(numbers)}});
  }
  return {numbers.data(), numbers.data() + numbers.size()};
}

std::string textOf(const py::object& given, const char* name) {
  if (!py::isinstance<py::str>(given)) refuse(name, "text", given);
  return given.cast<std::string>();
}

std::string nameIn(const py::object& text) {
  py::ssize_t size = 0;
  const char* const name = PyUnicode_AsUTF8AndSize(text.ptr(), &size);
  if (!name) PyErr_Clear();
  return name ? name : "";
}

py::dict dictOf(const py::object& given, const char* name) {
  if (!py::isinstance<py::dict>(given)) refuse(name, "a dict", given);
  return given;
}

}  // namespace planar_chain::python
