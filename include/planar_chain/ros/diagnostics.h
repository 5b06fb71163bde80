#pragma once

/// The node's health on /diagnostics.

#include <diagnostic_updater/diagnostic_updater.h>
#include <planar_chain/SimStatus.h>

#include <string>

#include "planar_chain/ros/pace.h"

namespace planar_chain {

class Diagnostics {
 public:
  /// status: what the node knows of itself, which must outlive this; clock: the name of what it follows.
  Diagnostics(const SimStatus& status, std::string clock);

  /// Once a second at most. now: s of wall time.
  void publishNowAndThen(double now);
  void publish();

 private:
  void report(diagnostic_updater::DiagnosticStatusWrapper& out);

  const SimStatus& status_;
  std::string clock_;
  diagnostic_updater::Updater updater_;
  Every period_{1.0};
};

}  // namespace planar_chain
