#pragma once

/// The CSV file of a motion: t, q_<joint>…, qd_<joint>…, energy.

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "planar_chain/simulation.h"

namespace planar_chain::tools {

inline void writeHeader(std::FILE* csv, const Chain& chain) {
  std::fputs("t", csv);
  for (const char* prefix : {"q_", "qd_"}) {
    for (const Joint& joint : chain.joints()) std::fprintf(csv, ",%s%s", prefix, joint.name.c_str());
  }
  std::fputs(",energy\n", csv);
}

/// t: of the run, s, which goes on where a service sets the state or the scene's time.
inline void writeRow(std::FILE* csv, double t, const Simulation& simulation) {
  std::fprintf(csv, "%.17g", t);
  for (const double q : simulation.q()) std::fprintf(csv, ",%.17g", q);
  for (const double qd : simulation.qd()) std::fprintf(csv, ",%.17g", qd);
  std::fprintf(csv, ",%.17g\n", simulation.energy().total());
}

/// The CSV file, if one is wanted. "-" is standard output.
class Csv {
 public:
  Csv(const std::optional<std::string>& path, const Chain& chain)
      : name_(path == "-" ? "standard output" : path.value_or("")) {
    if (!path) return;
    file_.reset(path == "-" ? fdopen(dup(STDOUT_FILENO), "w") : std::fopen(path->c_str(), "w"));
    require(file_ != nullptr);
    writeHeader(file_.get(), chain);
  }
  void write(double t, const Simulation& simulation) {
    if (!file_) return;
    writeRow(file_.get(), t, simulation);
    require(std::ferror(file_.get()) == 0);
  }
  void close() {
    if (file_) require(std::fclose(file_.release()) == 0);
  }
  bool isOnTerminal() const { return file_ && isatty(fileno(file_.get())) == 1; }

 private:
  void require(bool isGood) const {
    if (!isGood) throw std::runtime_error("cannot write " + name_ + ": " + std::strerror(errno));
  }

  const std::string name_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_{nullptr, std::fclose};
};

}  // namespace planar_chain::tools
