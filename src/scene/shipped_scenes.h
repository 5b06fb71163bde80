#pragma once

/// Scenes by their names.

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

}  // namespace planar_chain
