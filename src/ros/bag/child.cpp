#include "ros/bag/child.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

namespace planar_chain {

namespace {

[[noreturn]] void fail(const char* call) {
  throw std::system_error(errno, std::generic_category(), call);
}

/// Returns true if all bytes were written.
bool write(int to, const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t part = ::write(to, bytes.data() + done, bytes.size() - done);
    if (part < 0 && errno != EINTR) return false;
    done += part > 0 ? static_cast<std::size_t>(part) : 0;
  }
  return true;
}

/// Returns all bytes up to the end.
std::string read(int from) {
  std::string bytes;
  std::array<char, 65536> part;
  ssize_t size = 0;
  while ((size = ::read(from, part.data(), part.size())) != 0) {
    if (size < 0 && errno != EINTR) fail("read");
    bytes.append(part.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  }
  return bytes;
}

/// Lets this process take at most so many bytes more.
void limitMemory(std::uintmax_t more) {
  std::uintmax_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  const rlim_t most = pages * static_cast<std::uintmax_t>(sysconf(_SC_PAGESIZE)) + more;
  limit.rlim_cur = std::min(limit.rlim_cur, most);
  setrlimit(RLIMIT_AS, &limit);
}

/// The child's whole life. Nothing of the parent is flushed or destroyed.
[[noreturn]] void runAsChild(const std::function<std::string()>& work, std::uintmax_t memory, int to) {
  const int nowhere = open("/dev/null", O_WRONLY);
  for (const int out : {STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, out);
  limitMemory(memory);
  _exit(write(to, work()) ? 0 : 1);
}

}  // namespace

std::string madeByChild(const std::function<std::string()>& work, std::uintmax_t memory) {
  int ends[2];  // to read, to write
  if (pipe(ends) != 0) fail("pipe");
  const pid_t child = fork();
  if (child < 0) fail("fork");
  if (child == 0) runAsChild(work, memory, ends[1]);
  close(ends[1]);
  const std::string bytes = read(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) fail("waitpid");
  }
  if (WIFSIGNALED(status)) throw Crash(strsignal(WTERMSIG(status)));
  if (WEXITSTATUS(status) != 0) throw Crash("exit status " + std::to_string(WEXITSTATUS(status)));
  return bytes;
}

}  // namespace planar_chain
