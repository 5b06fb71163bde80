#pragma once

/// Which numbers a scene has.

#include <set>
#include <string>

#include "planar_chain/scene.h"
#include "planar_chain/value.h"

namespace planar_chain {

/// As readScene(). `numbers`, if given, collects the path of each number that the reader looked for, whether
/// it was there or not, also when the scene is refused.
Scene readSceneAndNote(const Value& value, std::set<std::string>* numbers);

}  // namespace planar_chain
