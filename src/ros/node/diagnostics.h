#pragma once

/// The node's health on /diagnostics.

#include <diagnostic_updater/diagnostic_updater.h>
#include <planar_chain/SimStatus.h>

#include <string>

namespace planar_chain {

class Diagnostics {
 public:
  /// status: what the node knows of itself, which must outlive this; clock: the name of what it follows.
  Diagnostics(const SimStatus& status, std::string clock);

  /// faultOfClock: what is wrong with /clock, if anything
  void publish(const std::string& faultOfClock);

 private:
  void report(diagnostic_updater::DiagnosticStatusWrapper& out);

  const SimStatus& status_;
  std::string clock_, faultOfClock_;
  diagnostic_updater::Updater updater_;
};

}  // namespace planar_chain
