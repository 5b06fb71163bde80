#pragma once

/// The node's health on /diagnostics.

#include <diagnostic_updater/diagnostic_updater.h>
#include <planar_chain/SimStatus.h>

#include <string>

namespace planar_chain {

class Diagnostics {
 public:
  /// status: of the node; must outlive this. clock: the name of the node's clock.
  Diagnostics(const SimStatus& status, std::string clock);

  /// Publishes the status at once. clockFault: a fault of /clock; empty: none.
  void publish(const std::string& clockFault);

 private:
  void report(diagnostic_updater::DiagnosticStatusWrapper& out);

  const SimStatus& status_;
  std::string clock_, clockFault_;
  diagnostic_updater::Updater updater_;
};

}  // namespace planar_chain
