#include "tools/bags_library.h"

#include <dlfcn.h>

#include <stdexcept>

namespace planar_chain::tools {

namespace {

// PLANAR_CHAIN_BAGS is the library's file name; empty without ROS.
constexpr const char* file = PLANAR_CHAIN_BAGS;

}  // namespace

void checkBags(std::vector<Fault>& faults) {
  if (*file == 0)
    faults.push_back(
        {"--bag, --commands, --write-urdf", "a build with ROS", "one without (PLANAR_CHAIN_ROS=OFF)"});
}

OpenBags* bagsLibrary() {
  void* const library = dlopen(file, RTLD_NOW);
  void* const function = library ? dlsym(library, "openBags") : nullptr;
  if (!function) throw std::runtime_error(dlerror());
  return reinterpret_cast<OpenBags*>(function);
}

}  // namespace planar_chain::tools
