#include "simd/cpu.h"

#include <cstdlib>
#include <cstring>

namespace planar_chain::simd {

namespace {

bool isAsked() {
  const char* value = std::getenv("PLANAR_CHAIN_PLAIN_KERNEL");
  return value && std::strcmp(value, "1") == 0;
}

}  // namespace

#ifdef PLANAR_CHAIN_X86

bool runsAvx2() {
  return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2");
}
bool runsAvx512() {
  return runsAvx2() && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}

#else

bool runsAvx2() {
  return false;
}
bool runsAvx512() {
  return false;
}

#endif

bool allArePlain() {
  static const bool are = isAsked();
  return are;
}

}  // namespace planar_chain::simd
