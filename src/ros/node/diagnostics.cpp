#include "ros/node/diagnostics.h"

#include <utility>

namespace planar_chain {

namespace {

constexpr double largestLag = 0.5;  // s

}  // namespace

Diagnostics::Diagnostics(const SimStatus& status, std::string clock)
    : status_(status), clock_(std::move(clock)) {
  updater_.setHardwareID("none");
  updater_.add("simulation", this, &Diagnostics::report);
}

void Diagnostics::publish(const std::string& clockFault) {
  clockFault_ = clockFault;
  // The updater's own period is simulation time, so force it. A message must not have the stamp 0.
  if (!ros::Time::now().isZero()) updater_.force_update();
}

void Diagnostics::report(diagnostic_updater::DiagnosticStatusWrapper& out) {
  using diagnostic_msgs::DiagnosticStatus;
  if (!status_.fault.empty()) {
    out.summary(DiagnosticStatus::ERROR, status_.fault);
  } else if (!clockFault_.empty()) {
    out.summary(DiagnosticStatus::WARN, clockFault_);
  } else if (status_.lag > largestLag) {
    out.summaryf(DiagnosticStatus::WARN, "%.3f s behind %s", status_.lag, clock_.c_str());
  } else {
    out.summary(DiagnosticStatus::OK, status_.standstill.empty() ? "running" : status_.standstill);
  }
  out.add("follows", clock_);
  out.add("sim_time", status_.sim_time);
  out.add("real_time_factor", status_.real_time_factor);
  out.add("lag", status_.lag);
  out.add("overruns", status_.overruns);
  out.add("rejected_commands", status_.rejected_commands);
  out.add("last_rejection", status_.last_rejection);
}

}  // namespace planar_chain
