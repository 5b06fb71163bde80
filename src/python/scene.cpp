#include <array>
#include <limits>
#include <map>
#include <utility>

#include "effects/effect_kind.h"
#include "planar_chain/scene_reader.h"
#include "python/bindings.h"
#include "reading/section.h"
#include "scene/shipped_scenes.h"

namespace planar_chain::python {

// ---- Values ------------------------------------------------------------------------------------

namespace {

/// level: the maps and lists around it. A list may hold itself.
Value valueAt(const py::handle& object, const std::string& path, std::size_t level) {
  const auto refuse = [&](const std::string& expected) -> Value {
    throw Refused({{path.empty() ? "scene" : path, expected, shown(object)}});
  };
  if (level >= mostLevels) return refuse("at most " + std::to_string(mostLevels) + " levels");
  const auto below = [&](const py::handle& item, const std::string& key) {
    return valueAt(item, path.empty() ? key : path + "/" + key, level + 1);
  };
  if (object.is_none()) return {};
  if (isBool(object)) return PyObject_IsTrue(object.ptr()) == 1;
  if (py::isinstance<py::str>(object)) {
    const std::optional<std::string> text = textIn(object);
    return text ? Value(*text) : refuse("text");
  }
  if (py::isinstance<py::dict>(object)) {
    Value::Map map;
    for (const auto& [key, item] : py::reinterpret_borrow<py::dict>(object)) {
      const std::optional<std::string> name =
          py::isinstance<py::str>(key) ? textIn(key) : std::optional<std::string>();
      if (!name) return refuse("a dict whose keys are text");
      map.emplace(*name, below(item, *name));
    }
    return map;
  }
  if (isMasked(object)) return refuse("an array without a mask");
  if (isNotReal(object)) return refuse("a real number");
  if (PyNumber_Check(object.ptr()) && !PySequence_Check(object.ptr())) {
    const double number = PyFloat_AsDouble(object.ptr());
    if (!PyErr_Occurred()) return number;
    PyErr_Clear();
    return refuse("a number that fits into a double");
  }
  if (py::hasattr(object, "tolist")) return valueAt(object.attr("tolist")(), path, level + 1);
  const bool isBytes = PyBytes_Check(object.ptr()) || PyByteArray_Check(object.ptr());  // lists, to Python
  if (isBytes || !py::isinstance<py::sequence>(object))
    return refuse("a dict, a list, a number, a bool or text");
  Value::List list;
  for (const py::handle& item : object) list.push_back(below(item, std::to_string(list.size())));
  return list;
}

}  // namespace

Value valueOf(const py::handle& object) {
  return valueAt(object, "", 0);
}

py::object objectOf(const Value& value) {
  if (const bool* flag = value.flag()) return py::bool_(*flag);
  if (const double* number = value.number()) return py::float_(*number);
  if (const std::string* text = value.text()) return py::str(*text);
  if (const Value::List* list = value.list()) {
    py::list items;
    for (const Value& item : *list) items.append(objectOf(item));
    return std::move(items);
  }
  if (const Value::Map* map = value.map()) {
    py::dict items;
    for (const auto& [key, item] : *map) items[py::str(key)] = objectOf(item);
    return std::move(items);
  }
  return py::none();
}

std::string classOf(const py::handle& object) {
  const py::handle type(reinterpret_cast<PyObject*>(Py_TYPE(object.ptr())));
  return py::str(type.attr("__name__")).cast<std::string>();
}

std::string shown(const py::handle& object) {
  try {
    return onOneLine(
        py::str(py::repr(object)).attr("encode")("utf-8", "backslashreplace").cast<std::string>());
  } catch (const py::error_already_set&) {  // such as of a list that is too deep to print
    return "a " + classOf(object);
  }
}

void showFields(const py::object& type, std::initializer_list<const char*> fields) {
  const std::vector<std::string> names(fields.begin(), fields.end());
  py::setattr(type, "__repr__",
              py::cpp_function(
                  [names](const py::object& self) {
                    std::string text;
                    for (const std::string& name : names) {
                      text += (text.empty() ? "" : ", ") + name + "=" + shown(self.attr(name.c_str()));
                    }
                    return classOf(self) + "(" + text + ")";
                  },
                  py::is_method(type)));
}

std::string shapeOf(const Numbers& numbers) {
  if (numbers.ndim() == 0) return "one number";
  std::string shape;
  for (py::ssize_t k = 0; k < numbers.ndim(); ++k) {
    shape += (k > 0 ? " x " : "") + std::to_string(numbers.shape(k));
  }
  if (numbers.ndim() > 1) return shape;
  return shape + (numbers.size() == 1 ? " number" : " numbers");
}

// ---- Scene -------------------------------------------------------------------------------------

namespace {

std::string readAll(const py::object& path) {
  const py::object file = py::module::import("io").attr("open")(path, "rb");
  const py::object text = file.attr("read")(longestYaml + 1);  // the reader refuses more
  file.attr("close")();
  return text.cast<std::string>();
}

/// The path, or that of the scene of this name.
py::object found(const py::object& path) {
  if (py::isinstance<py::bytes>(path) || py::hasattr(path, "__fspath__")) return path;
  if (!py::isinstance<py::str>(path)) {
    throw Refused({{"path", "a path, or the name of a scene that ships", shown(path)}});
  }
  const auto package = py::module::import("planar_chain").attr("__file__").cast<std::string>();
  const auto share = std::filesystem::path(package).parent_path() / PREFIX / "share";
  const py::module os = py::module::import("os");  // a file's name need not be text
  return os.attr("fsdecode")(py::bytes(findScene(os.attr("fsencode")(path).cast<std::string>(), share)));
}

template <class Things>
std::vector<std::string> namesOf(const Things& things) {
  std::vector<std::string> names;
  for (const auto& thing : things) names.push_back(thing.name);
  return names;
}

}  // namespace

TreeAndScene::TreeAndScene(Value from)
    : tree(std::move(from)), scene(released([this] { return readScene(tree); })) {}

const VariedNumber& TreeAndScene::near(const std::string& path) const {
  const auto found = near_.find(path);
  return found != near_.end() ? found->second : near_.emplace(path, variedNumber(tree, path)).first->second;
}

namespace {

void bindFaults(py::module& module) {
  py::class_<Fault>(module, "Fault", "One fault of an input.")
      .def_readonly("path", &Fault::path, "Where it is, such as 'links/lower/mass'.")
      .def_readonly("expected", &Fault::expected, "Such as 'a number > 0 kg'.")
      .def_readonly("found", &Fault::found, "What the input has there.")
      .def_readonly("line", &Fault::line, "The line of the YAML text, from 1 on; 0: unknown.")
      .def_readonly("file", &Fault::file, "The file of that text; empty: unknown.")
      .def(py::pickle(
          [](const Fault& of) { return py::make_tuple(of.path, of.expected, of.found, of.line, of.file); },
          [](const py::tuple& of) {
            return Fault{of[0].cast<std::string>(), of[1].cast<std::string>(), of[2].cast<std::string>(),
                         of[3].cast<int>(), of[4].cast<std::string>()};
          }))
      .def("__repr__", [](const Fault& fault) { return "<Fault " + toString(fault) + ">"; });
  static const py::handle refused = py::exception<Refused>(module, "Refused", PyExc_ValueError).release();
  refused.attr("__doc__") = "Raised for a scene with faults. `faults` lists all of them.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Refused& fault) {
      const py::object error = refused(fault.what());
      error.attr("faults") = fault.faults();
      PyErr_SetObject(refused.ptr(), error.ptr());
    } catch (const std::bad_alloc&) {
      PyErr_SetString(PyExc_MemoryError, "there is not enough memory");
    }
  });
}

py::array_t<double> stateOf(const TreeAndScene& of) {
  const auto n = static_cast<py::ssize_t>(of.scene.q.size());
  py::array_t<double> state(2 * n);
  std::copy(of.scene.q.begin(), of.scene.q.end(), state.mutable_data());
  std::copy(of.scene.qd.begin(), of.scene.qd.end(), state.mutable_data() + n);
  return state;
}

}  // namespace

void warn(const std::string& words) {
  if (!words.empty() && PyErr_WarnEx(PyExc_UserWarning, words.c_str(), 1) != 0) throw py::error_already_set();
}

namespace {

/// A scene that the user gives, with one warning of Python for each of its notes. file: that it came from.
TreeAndScene read(Value tree, const std::string& file = "") {
  TreeAndScene made(std::move(tree));
  for (const Note& note : withFiles(made.scene.notes, file, file)) warn(toString(note));
  return made;
}

TreeAndScene withValues(const TreeAndScene& scene, const py::object& given) {
  std::map<std::string, double> numbers;
  for (const auto& [key, number] : dictOf(given, "numbers")) {
    const std::string path = textOf(py::reinterpret_borrow<py::object>(key), "numbers");
    numbers[path] = numberOf(py::reinterpret_borrow<py::object>(number), path.c_str());
  }
  std::vector<std::string> paths;
  for (const auto& entry : numbers) paths.push_back(entry.first);
  requireNumbers(scene.tree, paths);
  Value tree = scene.tree;
  for (const auto& [path, number] : numbers) setNumber(tree, path, number);
  TreeAndScene made(std::move(tree));
  for (const Note& note : newNotes(made.scene.notes, scene.scene.notes)) warn(toString(note));
  return made;
}

TreeAndScene fromFile(const py::object& given) {
  const py::object path = found(given);
  const std::string text = readAll(path);
  const py::object decoded = py::module::import("os").attr("fsdecode")(path);  // its name need not be text
  const auto name = decoded.attr("encode")("utf-8", "backslashreplace").cast<std::string>();
  try {
    return read(parseScene(text), name);
  } catch (const Refused& refused) {
    throw Refused(withFiles(refused.faults(), name, name));
  }
}

TreeAndScene fromUrdf(const py::object& text, const py::object& rest) {
  if (!py::isinstance<py::str>(text) || textOf(text, "text").find('<') == std::string::npos)
    throw Refused({{"text", "the text of a URDF, as of open(path).read()", shown(text)}});
  return read(valueOf(py::dict(**dictOf(rest, "rest"), py::arg("robot_description") = text)));
}

TreeAndScene fromValues(const py::object& values) {
  if (!py::isinstance<py::dict>(values)) {
    throw Refused({{"scene", "a dict (Scene.from_file reads a file, from_yaml text)", shown(values)}});
  }
  return read(valueOf(values));
}

/// A vector of each link or joint: n × 2.
template <class Things, class Member>
py::array_t<double> vectorsOf(const Things& things, Member member) {
  py::array_t<double> vectors({static_cast<py::ssize_t>(things.size()), py::ssize_t{2}});
  double* to = vectors.mutable_data();
  for (const auto& thing : things) {
    const Vec2d& vector = thing.*member;
    *to++ = vector.x;
    *to++ = vector.y;
  }
  return vectors;
}

/// A number of each link: n.
py::array_t<double> numbersOfLinks(const TreeAndScene& self, double Link::*member) {
  py::array_t<double> numbers(self.scene.chain.size());
  double* to = numbers.mutable_data();
  for (const Link& link : self.scene.chain.links()) *to++ = link.*member;
  return numbers;
}

/// Infinite where there is none.
py::array_t<double> effortLimitsOf(const TreeAndScene& self) {
  py::array_t<double> limits(self.scene.chain.size());
  double* limit = limits.mutable_data();
  for (const Joint& joint : self.scene.chain.joints()) {
    constexpr double none = std::numeric_limits<double>::infinity();
    *limit++ = joint.has("effort_limit") ? joint.other("effort_limit") : none;
  }
  return limits;
}

/// The first names, and how many there are if that is not all.
template <class Things>
std::string listed(const Things& things) {
  constexpr std::size_t most = 8;
  std::vector<std::string> names = namesOf(things);
  if (names.size() > most) {
    names.resize(most);
    names.push_back("... (" + std::to_string(things.size()) + ")");
  }
  return inCommas(names);
}

std::string summaryOf(const TreeAndScene& self) {
  const Chain& chain = self.scene.chain;
  SceneWords words = wordsOf(self.scene);
  words.count(static_cast<int>(self.scene.sensors.size()), "sensor");
  const std::string has = words.runs.empty() ? "" : "\n " + inCommas(words.runs);
  return "<Scene, n = " + std::to_string(chain.size()) + ", links: " + listed(chain.links()) +
         "; joints: " + listed(chain.joints()) + has + ">";
}

/// Binds the values of links and joints that formulas need.
void bindBodies(py::class_<TreeAndScene>& scene) {
  scene
      .def_property_readonly(
          "axes", [](const TreeAndScene& self) { return vectorsOf(self.scene.chain.joints(), &Joint::axis); },
          "Axes of the n joints, n × 2, each in the frame of the link inside. Only prismatic joints use "
          "them.")
      .def_property_readonly(
          "pins", [](const TreeAndScene& self) { return vectorsOf(self.scene.chain.links(), &Link::pin); },
          "Outer pins in the link frames, n × 2, m. The last one is the tip.")
      .def_property_readonly(
          "coms", [](const TreeAndScene& self) { return vectorsOf(self.scene.chain.links(), &Link::com); },
          "Centres of mass in the link frames, n × 2, m.")
      .def_property_readonly(
          "masses", [](const TreeAndScene& self) { return numbersOfLinks(self, &Link::mass); },
          "Masses of the n links, kg.")
      .def_property_readonly(
          "inertias", [](const TreeAndScene& self) { return numbersOfLinks(self, &Link::inertia); },
          "Moments of inertia of the n links about their centres of mass, kg m².")
      .def_property_readonly(
          "gravity",
          [](const TreeAndScene& self) {
            const Vec2d gravity = self.scene.chain.gravity();
            return std::array<double, 2>{gravity.x, gravity.y};
          },
          "[x, y], m/s².");
}

}  // namespace

void bindScene(py::module& module) {
  module.attr("_prefix") = PREFIX;
  bindFaults(module);
  py::class_<TreeAndScene> scene(module, "Scene",
                                 R"(A scene: the chain, its first state, loads and settings. Immutable.

config/README.md explains every key. Raises Refused, with all faults, for a scene that has any.)");
  bindBodies(scene);
  scene
      .def(py::init(&fromValues), py::arg("values"),
           "From a dict with the keys of a YAML scene. The text of a URDF may be its 'robot_description'.")
      .def_static(
          "from_yaml", [](const py::object& text) { return read(parseScene(textOf(text, "text"))); },
          py::arg("text"), "From the text of a YAML scene, or of a URDF.")
      .def_static(
          "from_file", &fromFile, py::arg("path"),
          R"(From a YAML file or a URDF, or by the name of a scene that ships, such as 'double_pendulum'.

Raises OSError if the file cannot be read.)")
      .def_static(
          "from_urdf", &fromUrdf, py::arg("text"), py::arg("rest") = py::dict(),
          "From the text of a URDF that is a planar chain. rest: what else a scene may have, such as loads.")
      .def(
          "to_dict", [](const TreeAndScene& self) { return objectOf(self.tree); },
          "Returns a dict with the values as they were given.")
      .def("with_values", &withValues, py::arg("numbers"),
           "Returns a copy with other numbers, by their paths, such as {'links/lower/mass': 2.0}.")
      .def(py::pickle([](const TreeAndScene& self) { return objectOf(self.tree); },
                      [](const py::object& values) { return TreeAndScene(valueOf(values)); }))
      .def(
          "__len__", [](const TreeAndScene& self) { return self.scene.chain.size(); },
          "Returns n, the number of links.")
      .def_property_readonly(
          "links", [](const TreeAndScene& self) { return namesOf(self.scene.chain.links()); },
          "Names of the n links, from the ground outwards.")
      .def_property_readonly(
          "joints", [](const TreeAndScene& self) { return namesOf(self.scene.chain.joints()); },
          "Names of the n joints. Joint i is at the inner pin of link i.")
      .def_property_readonly(
          "prismatic",
          [](const TreeAndScene& self) {
            std::vector<bool> are;
            for (const Joint& joint : self.scene.chain.joints()) are.push_back(joint.isPrismatic);
            return are;
          },
          "True for each of the n joints that is prismatic: its q is in m.")
      .def_property_readonly("effort_limits", &effortLimitsOf,
                             "Largest commanded torques of the n joints, N m (prismatic: N); inf: no limit.")
      .def_property_readonly("state", &stateOf,
                             "The first state, 2n: relative angles q (rad), then rates q̇ (rad/s).")
      .def("__repr__", &summaryOf);
  bindKinematics(module, scene);
}

}  // namespace planar_chain::python
