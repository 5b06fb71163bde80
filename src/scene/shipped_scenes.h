#pragma once

/// Scenes by their names, and their files in faults.

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "reading/names.h"
#include "reading/section.h"

namespace planar_chain {

/// The path of a scene that is given by its path, or by the name of one that ships. share: the folder of that
/// name in the devel space or install space.
/// @throws Refused if there is neither
inline std::string findScene(const std::string& given, const std::filesystem::path& share) {
  namespace fs = std::filesystem;
  std::error_code none;
  const bool isName = given.find_first_of("./") == std::string::npos;
  if (!isName || (fs::exists(given, none) && !fs::is_directory(given, none))) return given;
  std::vector<std::string> names;
  for (const auto& file : fs::directory_iterator(share / "planar_chain/config/scenes", none)) {
    if (file.path().stem() == given) return file.path().string();
    names.push_back(file.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  throw Refused(
      {{given.empty() ? quoted(given) : onOneLine(given),
        orClosest("a file, or one of the scenes that ship: " + inCommas(names), given, names), "neither"}});
}

/// Faults or notes of a scene with their files: `urdf` of those in a robot_description, else `scene`. Those
/// that no text gave, such as of a tool's option, have none.
template <class Finding>
std::vector<Finding> withFiles(std::vector<Finding> findings, const std::string& scene,
                               const std::string& urdf) {
  for (Finding& finding : findings) {
    const bool isInUrdf = finding.path.rfind("robot_description", 0) == 0;
    if (isInUrdf || finding.line > 0 || finding.path == "scene") finding.file = isInUrdf ? urdf : scene;
  }
  return findings;
}

}  // namespace planar_chain
