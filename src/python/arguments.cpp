/// Arguments from Python, with faults in words.

#include <cmath>
#include <string>

#include "model/number_rule.h"
#include "python/bindings.h"

namespace planar_chain::python {

namespace {

[[noreturn]] void refuse(const char* name, const std::string& expected, const py::object& given) {
  throw Refused({{name, expected, shown(given)}});
}

/// A masked array, or one in a list: numpy forgets the masks of these.
void requireNoMask(const py::handle& given, const char* name) {
  const auto refuseMask = [name] {
    throw Refused({{name, "an array without a mask (filled(numpy.nan) makes gaps)", "a masked array"}});
  };
  if (isMasked(given)) refuseMask();
  if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given)) return;
  for (const py::handle& item : given) {
    if (isMasked(item)) refuseMask();
  }
}

}  // namespace

double numberOf(const py::object& given, const char* name) {
  if (PyNumber_Check(given.ptr()) != 0 && !isMasked(given) && !isBool(given) && !isNotReal(given)) {
    const double number = PyFloat_AsDouble(given.ptr());
    if (!PyErr_Occurred()) return number;
    PyErr_Clear();
  }
  refuse(name, "a number", given);
}

bool isMasked(const py::handle& given) {
  static const py::handle type = py::object(py::module::import("numpy.ma").attr("MaskedArray")).release();
  return py::isinstance(given, type);
}

bool isBool(const py::handle& given) {
  static const py::handle type = py::object(py::module::import("numpy").attr("bool_")).release();
  return py::isinstance<py::bool_>(given) || py::isinstance(given, type);
}

bool isNotReal(const py::handle& given) {
  static const py::handle types = [] {
    const py::module numpy = py::module::import("numpy");
    return py::make_tuple(numpy.attr("complexfloating"), numpy.attr("timedelta64"), numpy.attr("datetime64"))
        .release();
  }();
  return PyComplex_Check(given.ptr()) || py::isinstance(given, types);
}

std::optional<py::ssize_t> indexIn(const py::object& given) {
  if (isBool(given) || PyIndex_Check(given.ptr()) == 0) return std::nullopt;
  const py::ssize_t index = PyNumber_AsSsize_t(given.ptr(), nullptr);
  if (!PyErr_Occurred()) return index;
  PyErr_Clear();
  return std::nullopt;
}

double factorOf(const py::object& given, const char* name) {
  const double number = numberOf(given, name);
  if (!isFactor(number)) refuse(name, factorInWords(number), given);
  return number;
}

long long countOf(const py::object& given, const char* name, long long least, long long most) {
  const std::optional<py::ssize_t> count = indexIn(given);
  if (count && *count >= least && *count <= most) return *count;
  refuse(name,
         count && *count > most ? "at most " + std::to_string(most)
                                : "a whole number >= " + std::to_string(least),
         given);
}

std::optional<long long> stepsOf(const py::object& given) {
  if (given.is_none()) return std::nullopt;
  return countOf(given, "most_steps", 1, 1'000'000'000'000'000);
}

Numbers arrayOf(const py::object& given, const char* name) {
  const bool isText = py::isinstance<py::str>(given) || py::isinstance<py::bytes>(given);
  if (given.is_none() || isText) refuse(name, "an array of numbers", given);
  requireNoMask(given, name);
  const py::array any = py::array::ensure(given);
  if (!any) refuse(name, "an array of numbers", given);
  // Others are bools, text, complex numbers, times, records.
  if (std::string("iufO").find(any.dtype().kind()) == std::string::npos)
    throw Refused({{name, "an array of real numbers", "one of " + shown(any.dtype())}});
  if (any.dtype().kind() == 'O') {
    for (const py::handle& item : any.attr("ravel")())
      numberOf(py::reinterpret_borrow<py::object>(item), name);
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

std::vector<double> timesOf(const py::object& given) {
  if (arrayOf(given, "times").ndim() != 1)
    refuse("times", "an array of one dimension, such as numpy.linspace(0, 10, 1001)", given);
  return numbersOf(given, "times");
}

std::string textOf(const py::object& given, const char* name) {
  const std::optional<std::string> text =
      py::isinstance<py::str>(given) ? textIn(given) : std::optional<std::string>();
  if (!text) refuse(name, "text", given);
  return *text;
}

std::optional<std::string> textIn(const py::handle& given) {
  py::ssize_t size = 0;
  if (const char* const text = PyUnicode_AsUTF8AndSize(given.ptr(), &size))
    return std::string(text, static_cast<std::size_t>(size));
  PyErr_Clear();  // half of a character
  return std::nullopt;
}

py::dict dictOf(const py::object& given, const char* name) {
  if (!py::isinstance<py::dict>(given)) refuse(name, "a dict", given);
  return given;
}

}  // namespace planar_chain::python
