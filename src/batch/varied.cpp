#include <algorithm>
#include <utility>

#include "planar_chain/batch.h"
#include "planar_chain/scene_reader.h"

namespace planar_chain {

namespace {

/// True for links/<name>/initial/…
bool isInitial(const std::string& path) {
  const std::size_t name = path.find('/') + 1;
  const std::size_t end = path.find('/', name);
  return path.compare(0, name, "links/") == 0 && end != std::string::npos &&
         path.compare(end, 9, "/initial/") == 0;
}

void requirePaths(const Value& tree, const Varied& varied) {
  std::vector<std::string> paths;
  for (const auto& column : varied.numbers) paths.push_back(column.first);
  std::vector<Fault> faults;
  try {
    requireNumbers(tree, paths);
  } catch (const Refused& refused) {
    faults = refused.faults();
  }
  for (const std::string& path : paths) {
    if (varied.starts.empty() || !isInitial(path)) continue;
    faults.push_back({path, "this number or an array of initial states", "both"});
  }
  if (!faults.empty()) throw Refused(std::move(faults));
}

}  // namespace

SceneOfRun sceneOfRun(const Value& tree, const Varied& varied) {
  requirePaths(tree, varied);
  return [&](std::size_t run, Scene& scene) {
    const auto n = static_cast<std::ptrdiff_t>(scene.q.size());  // of the batch
    if (!varied.numbers.empty()) {
      Value values = tree;
      for (const auto& [path, numbers] : varied.numbers) setNumber(values, path, numbers[run]);
      scene = readScene(values);
    }
    if (varied.starts.empty()) return;
    const auto start = varied.starts.begin() + static_cast<std::ptrdiff_t>(run) * 2 * n;
    scene.q.assign(start, start + n);
    scene.qd.assign(start + n, start + 2 * n);
  };
}

}  // namespace planar_chain
