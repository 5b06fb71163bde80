#pragma once

/// Shared by the command-line tools: exit statuses, arguments, scene files.

#include <boost/program_options.hpp>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
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

enum ExitStatus : int { done = 0, runFailed = 1, badInput = 2 };

constexpr double infinity = std::numeric_limits<double>::infinity();

// ---- Arguments ---------------------------------------------------------------------------------

using Options = boost::program_options::options_description;

/// Returns what --help prints, without options yet. unnamed: such as "[SCENE]", or empty.
Options optionsOf(const std::string& tool, const std::string& about, const std::string& unnamed,
                  const std::string& exitStatus);
/// The value of an option: a text.
inline auto* valued() {
  return boost::program_options::value<std::string>()->value_name("TEXT");
}

/// The arguments of one run, by name.
class Arguments : public boost::program_options::variables_map {
 public:
  bool has(const char* name) const { return count(name) != 0; }
  /// The text of an option, or nothing if it is absent.
  std::optional<std::string> text(const std::string& name) const;
  /// The number that it spells, or `absent` without it. Records a fault unless it is finite and > low.
  double number(const std::string& name, const char* expected, double low, double absent,
                std::vector<Fault>& faults) const;
};

/// Flushes standard output.
/// @throws std::runtime_error if what was printed has not arrived, for example on a full disk
void finishOutput();

/// Runs a tool. unnamed: the names of the arguments that are given without. Bad arguments and exceptions
/// become a message on standard error and an exit status.
int run(const Options& options, const std::vector<const char*>& unnamed, int argc, char** argv,
        const std::function<int(const Arguments&)>& body);

// ---- Scenes and files --------------------------------------------------------------------------

/// For tools that read a scene: their unnamed argument, and --urdf.
constexpr const char* sceneInUsage =
    "[SCENE]\nSCENE: a YAML file (config/README.md explains it), or the name of a scene that ships";
void addUrdf(Options& options);

/// @throws Refused if the file cannot be read
std::string loadText(const std::string& path);

/// Records a fault if the file `path` cannot be written or is one of `others`. Changes no file.
void checkOutput(const std::string& option, const std::string& path,
                 const std::vector<std::optional<std::string>>& others, std::vector<Fault>& faults);

/// Reads the scene, with --urdf as robot_description. `faults` are those of the arguments; they are reported
/// together with the scene's. `amend` may change the tree before it is read.
/// @throws Refused
Scene readScene(const Arguments& given, const std::function<void(Value&)>& amend, std::vector<Fault> faults);

}  // namespace planar_chain::tools
