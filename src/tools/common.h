#pragma once

/// Shared by the command-line tools: exit statuses, arguments, scene files.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/value.h"

namespace planar_chain::tools {

enum ExitStatus : int { done = 0, runFailed = 1, badInput = 2 };

/// Runs a tool's body. An exception becomes a message on standard error and an exit status.
template <class Body>
int run(const char* tool, Body&& body) {
  try {
    return body();
  } catch (const Refused& refused) {
    std::cerr << refused.what() << '\n';
    return badInput;
  } catch (const std::exception& error) {
    std::cerr << tool << ": " << error.what() << '\n';
    return runFailed;
  }
}

/// @returns nothing if the tool is to run; the exit status after --help or bad arguments
inline std::optional<int> parseArguments(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? done : badInput;
  }
}

/// The files of a scene.
struct SceneArguments {
  std::optional<std::string> scene;
  std::optional<std::string> urdf;
};

inline void declareScene(CLI::App& app, SceneArguments& to) {
  app.add_option("SCENE", to.scene, "The scene, a YAML file (config/README.md explains it)");
  app.add_option(
      "--urdf", to.urdf,
      "A URDF that is a planar chain, in place of the scene's chain and links; SCENE may add the rest");
}

/// @throws Refused if the file cannot be read
inline std::string loadText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text(longestYaml + 1, '\0');
  file.read(&text[0], static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > longestYaml) {
    throw Refused({{path, "at most " + std::to_string(longestYaml) + " bytes", "more"}});
  }
  if (!file.eof()) {
    throw Refused({{path, "a file that can be read", std::strerror(errno)}});
  }
  return text;
}

/// The tree of a scene file, with the URDF as robot_description.
/// @throws Refused if a file cannot be read, and as parseYaml
inline Value loadScene(const SceneArguments& given) {
  if (!given.scene && !given.urdf)
    throw Refused({{"SCENE", "a scene file, or --urdf with a robot", "neither"}});
  Value scene = given.scene ? parseYaml(loadText(*given.scene)) : Value(Value::Map());
  if (given.urdf && scene.map() && !scene.map()->emplace("robot_description", loadText(*given.urdf)).second) {
    throw Refused({{"robot_description", "nothing beside --urdf", "one in the scene"}});
  }
  return scene;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The number that an argument spells, or `absent` without the argument. Records a fault unless it is finite
/// and > low.
inline double numberArgument(const char* option, const std::optional<std::string>& given,
                             const char* expected, double low, double absent, std::vector<Fault>& faults) {
  if (!given) return absent;
  const std::optional<double> number = numberIn(*given);
  if (number && std::isfinite(*number) && *number > low) return *number;
  faults.push_back({option, expected, quoted(*given)});
  return absent;
}

/// Records a fault if the file `path` cannot be written or is one of `others`. Changes no file.
inline void checkOutput(const char* option, const std::string& path,
                        const std::vector<std::optional<std::string>>& others, std::vector<Fault>& faults) {
  namespace fs = std::filesystem;
  std::error_code none;
  const auto isSame = [&](const std::optional<std::string>& other) {
    return other && (fs::equivalent(path, *other, none) ||
                     fs::weakly_canonical(path, none) == fs::weakly_canonical(*other, none));
  };
  if (std::any_of(others.begin(), others.end(), isSame)) {
    faults.push_back({option, "a file that is not another of the run's", quoted(path)});
    return;
  }
  const bool isNew = !fs::exists(path, none);
  if (!std::ofstream(path, std::ios::app)) {
    const std::string why = std::strerror(errno);
    faults.push_back({option, "a file that can be written", quoted(path) + ": " + why});
  } else if (isNew) {
    fs::remove(path, none);
  }
}

/// Reads the scene. `faults` are those of the arguments; they are reported together with the scene's. `amend`
/// may change the tree before it is read.
/// @throws Refused
template <class Amend>
Scene readScene(const SceneArguments& given, Amend&& amend, std::vector<Fault> faults) {
  try {
    Value value = loadScene(given);
    amend(value);
    Scene scene = planar_chain::readScene(value);
    if (faults.empty()) return scene;
  } catch (const Refused& refused) {
    faults.insert(faults.end(), refused.faults().begin(), refused.faults().end());
  }
  throw Refused(std::move(faults));
}

}  // namespace planar_chain::tools
