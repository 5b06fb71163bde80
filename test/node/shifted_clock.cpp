/// Preloaded into a node: shifts its time of day by the seconds in the file $CLOCK_SHIFT, an int64. The
/// steady clock stays.

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <time.h>

#include <cstdint>
#include <cstdlib>

extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
  using Function = int (*)(clockid_t, timespec*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "clock_gettime"));
  static const auto* const shift = static_cast<const volatile std::int64_t*>(mmap(
      nullptr, sizeof(std::int64_t), PROT_READ, MAP_SHARED, open(std::getenv("CLOCK_SHIFT"), O_RDONLY), 0));
  const int result = real(clock, now);
  if (clock == CLOCK_REALTIME) now->tv_sec += *shift;
  return result;
}
