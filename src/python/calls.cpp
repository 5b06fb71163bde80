/// Calls with the wrong arguments, in words: pybind11 prints every overload with its types, and ignores a
/// second call of __init__(). Each function of the module goes through one that looks at what failed.

#include <algorithm>
#include <deque>
#include <string>
#include <vector>

#include "python/bindings.h"

namespace planar_chain::python {

namespace {

struct Parameter {
  std::string name;
  std::string defaultValue;  ///< empty: none, so that it has to be given
};

/// Returns the parameters in the first line of a function's text, as pybind11 writes it:
/// "f(a: type[x, y], b: type = 3) -> type".
std::vector<Parameter> parametersOf(const std::string& text) {
  std::vector<Parameter> parameters;
  const std::string line = text.substr(0, text.find('\n'));
  std::size_t begin = line.find('(') + 1;
  int depth = 1;
  for (std::size_t k = begin; k < line.size() && depth > 0; ++k) {
    if (line[k] == '(' || line[k] == '[') ++depth;
    if (line[k] == ')' || line[k] == ']') --depth;
    if (depth > 1 || (depth == 1 && line[k] != ',')) continue;
    const std::string one = line.substr(begin, k - begin);
    const std::size_t value = one.find(" = ");
    if (!one.empty()) {
      parameters.push_back(
          {one.substr(0, one.find(':')), value == std::string::npos ? "" : one.substr(value + 3)});
    }
    begin = k + 2;  // beyond ", "
  }
  return parameters;
}

std::string listed(const std::vector<Parameter>& parameters) {
  std::string list;
  for (const Parameter& one : parameters) {
    if (one.name == "self") continue;
    list += (list.empty() ? "" : ", ") + one.name + (one.defaultValue.empty() ? "" : "=" + one.defaultValue);
  }
  return list.empty() ? "none" : list;
}

/// The reason why pybind11 refused a call.
std::string faultOf(const std::vector<Parameter>& parameters, const py::tuple& args, const py::dict& named) {
  const auto at = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find_if(parameters.begin(), parameters.end(),
                                                 [&](const auto& one) { return one.name == name; }) -
                                    parameters.begin());
  };
  for (const auto& [key, value] : named) {
    const std::string name = textIn(key).value_or("");
    const std::size_t place = at(name);
    if (place == parameters.size()) {
      const bool isOfScene = name == "method" || name == "step" || name == "tolerance";
      const std::string cure = " (give it to the scene: Scene({**scene.to_dict(), \"integrator\": {" +
                               shown(key) + ": " + shown(value) + "}}))";
      return "unexpected argument " + shown(key) + (isOfScene ? cure : "");
    }
    if (place < args.size()) return "argument " + shown(key) + " given twice";
  }
  if (args.size() > parameters.size()) {
    const std::size_t more = args.size() - parameters.size();
    return std::to_string(more) + (more == 1 ? " argument" : " arguments") + " too many";
  }
  for (std::size_t k = args.size(); k < parameters.size(); ++k) {
    const Parameter& one = parameters[k];
    if (one.defaultValue.empty() && !named.contains(one.name.c_str()))
      return "no argument '" + one.name + "'";
  }
  return "an argument of another type";
}

/// A function of the module: the function of pybind11, its name for users, and the class that it constructs,
/// or None.
struct Target {
  PyObject* function;
  PyObject* label;
  PyObject* constructed;

  explicit Target(PyObject* tuple)
      : function(PyTuple_GET_ITEM(tuple, 0)),
        label(PyTuple_GET_ITEM(tuple, 1)),
        constructed(PyTuple_GET_ITEM(tuple, 2)) {}

  std::string name() const { return py::str(py::handle(label)); }
};

bool isBuilt(const Target& target, PyObject* args) {
  if (target.constructed == Py_None || PyTuple_GET_SIZE(args) == 0) return false;
  auto* const type = reinterpret_cast<PyTypeObject*>(target.constructed);
  PyObject* const self = PyTuple_GET_ITEM(args, 0);
  if (!PyObject_TypeCheck(self, type)) return false;
  auto* const instance = reinterpret_cast<py::detail::instance*>(self);
  return instance->get_value_and_holder(py::detail::get_type_info(type)).instance_registered();
}

/// Puts our words in the place of an error that pybind11 itself raised.
void explain(const Target& target, PyObject* args, PyObject* named) {
  py::error_already_set raised;
  const bool isOfArguments =
      raised.matches(PyExc_TypeError) &&
      std::string(py::str(raised.value())).find("(): incompatible ") != std::string::npos;
  if (!isOfArguments) {
    raised.restore();
    return;
  }
  const auto parameters = parametersOf(py::str(py::handle(target.function).attr("__doc__")));
  const auto keywords = named ? py::reinterpret_borrow<py::dict>(named) : py::dict();
  const std::string fault = faultOf(parameters, py::reinterpret_borrow<py::tuple>(args), keywords);
  PyErr_SetString(
      PyExc_TypeError,
      (target.name() + ": expected the arguments " + listed(parameters) + ", got " + fault).c_str());
}

PyObject* call(PyObject* tuple, PyObject* args, PyObject* named) {
  const Target target(tuple);
  try {
    if (isBuilt(target, args)) {
      PyErr_SetString(PyExc_TypeError,
                      (target.name() + ": this object is built already; build another one").c_str());
      return nullptr;
    }
    PyObject* const result = PyObject_Call(target.function, args, named);
    if (!result) explain(target, args, named);
    return result;
  } catch (py::error_already_set& other) {
    other.restore();
  } catch (const std::exception& other) {
    PyErr_SetString(PyExc_RuntimeError, other.what());
  }
  return nullptr;
}

/// The function through call(), with the same name and text.
py::object through(const py::handle& function, const std::string& label, const py::object& constructed) {
  static auto* const all = new std::deque<PyMethodDef>;  // as long as the process
  const PyMethodDef& its = *reinterpret_cast<PyCFunctionObject*>(function.ptr())->m_ml;
  auto* const entry = reinterpret_cast<PyCFunction>(reinterpret_cast<void (*)()>(&call));
  all->push_back({its.ml_name, entry, METH_VARARGS | METH_KEYWORDS, its.ml_doc});
  const py::tuple target = py::make_tuple(function, label, constructed);
  const py::object module = py::str("planar_chain._core");
  return py::reinterpret_steal<py::object>(PyCFunction_NewEx(&all->back(), target.ptr(), module.ptr()));
}

void explainMembers(const py::object& type, const std::string& label) {
  const py::dict members = py::dict(type.attr("__dict__"));
  for (const auto& [key, member] : members) {
    const std::string name = py::str(key);
    const bool constructs = name == "__init__" || name == "__setstate__";
    if (name[0] == '_' && !constructs) continue;
    const std::string called = constructs ? label : label + "." + name;
    if (PyInstanceMethod_Check(member.ptr()) &&
        PyCFunction_Check(PyInstanceMethod_GET_FUNCTION(member.ptr()))) {
      const py::object made = through(PyInstanceMethod_GET_FUNCTION(member.ptr()), called,
                                      constructs ? type : py::object(py::none()));
      py::setattr(type, key, py::reinterpret_steal<py::object>(PyInstanceMethod_New(made.ptr())));
    } else if (py::isinstance<py::staticmethod>(member)) {
      py::setattr(type, key, py::staticmethod(through(member.attr("__func__"), called, py::none())));
    }
  }
}

}  // namespace

void explainCalls(py::module& module) {
  const py::dict things = py::dict(module.attr("__dict__"));
  for (const auto& [key, thing] : things) {
    const std::string label = "planar_chain." + std::string(py::str(key));
    if (PyCFunction_Check(thing.ptr())) {
      py::setattr(module, key, through(thing, label, py::none()));
    } else if (PyObject_TypeCheck(thing.ptr(), py::detail::get_internals().default_metaclass)) {
      explainMembers(py::reinterpret_borrow<py::object>(thing), label);
    }
  }
}

}  // namespace planar_chain::python
