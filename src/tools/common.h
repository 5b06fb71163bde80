#pragma once

/// Shared by the command-line tools: exit statuses, arguments, scene files.

#include <boost/program_options.hpp>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/value.h"

namespace planar_chain::tools {

enum ExitStatus : int { done = 0, runFailed = 1, badInput = 2, doneInPart = 3 };

constexpr double infinity = std::numeric_limits<double>::infinity();

// ---- Arguments ---------------------------------------------------------------------------------

/// The arguments of one run, by name.
class Arguments : public boost::program_options::variables_map {
 public:
  bool has(const char* name) const { return count(name) != 0; }
  /// The text of an option, or nothing if it is absent.
  std::optional<std::string> text(const std::string& name) const;
  /// The file of an option. Nothing if it is absent or "-", standard output.
  std::optional<std::string> file(const std::string& name) const;
  /// The number that it spells, or `absent` without it. Records a fault unless it is finite and > low.
  double number(const std::string& name, const char* expected, double low, double absent,
                std::vector<Fault>& faults) const;
};

/// Adds a fault for each of the others that is given beside `option`.
void checkAlone(const Arguments& given, const char* option, std::initializer_list<const char*> others,
                std::vector<Fault>& faults);

/// Flushes standard output, which may be a file of this name.
/// @throws std::runtime_error if output was lost, for example on a full disk
void finishOutput(const std::string& name = "standard output");

struct Option {
  const char *name, *meaning;
  bool hasText = true;
};

struct Tool {
  const char *name, *about, *exitStatus;
  bool hasScene;  ///< it reads one: the unnamed argument SCENE, and --urdf
  std::vector<Option> options;
  std::function<int(const Arguments&)> body;  ///< returns the exit status
};
/// Runs a tool. Bad arguments and exceptions become a message on standard error and an exit status.
int run(const Tool& tool, int argc, char** argv);

// ---- Scenes and files --------------------------------------------------------------------------

/// @throws Refused if the file cannot be read
std::string loadText(const std::string& path);

/// The file of SCENE: a path, or the name of a scene that ships. Empty without SCENE.
/// @throws Refused if there is none
std::string scenePath(const Arguments& given);

/// Records a fault for each of these options whose file cannot be written, or is by any name one of `inputs`
/// or of another option. Devices and pipes may be given twice. Changes no file.
void checkOutputs(const Arguments& given, const std::vector<std::string>& options,
                  const std::vector<std::string>& inputs, std::vector<Fault>& faults);

/// Reads the scene, with --urdf as robot_description. `faults` are those of the arguments; they are reported
/// together with the scene's. `amend` may change the tree before it is read. Prints the scene's notes to
/// standard error.
/// @throws Refused
Scene readScene(const Arguments& given, const std::function<void(Value&)>& amend, std::vector<Fault> faults);

}  // namespace planar_chain::tools
