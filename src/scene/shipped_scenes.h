#pragma once

/// Scenes by their names.

#include <filesystem>
#include <set>
#include <string>

#include "reading/section.h"

namespace planar_chain {

/// The path of a scene that is given by its path, or by the name of one that ships. share: the folder of that
/// name in the devel space or install space.
/// @throws Refused if there is neither
inline std::string findScene(const std::string& given, const std::filesystem::path& share) {
  namespace fs = std::filesystem;
  std::error_code none;
  const bool isName = given.find_first_of("./") == std::string::npos;
  if (!isName || fs::exists(given, none)) return given;
  std::set<std::string> names;
  for (const auto& file : fs::directory_iterator(share / "planar_chain/config/scenes", none)) {
    if (file.path().stem() == given) return file.path().string();
    names.insert(file.path().stem().string());
  }
  throw Refused({{given, "a file, or one of the scenes that ship: " + inCommas(names), "neither"}});
}

}  // namespace planar_chain
