#pragma once

/// The report's studies beside error against run time. Each writes a table with a header to standard output.

#include <string>

namespace planar_chain::tools {

/// study,scene,method,setting,value,scale: "order", the error of an angle (rad) of each method with equal
/// steps on the scene `triple`; "energy", by how much the energy balance of `auto` at tolerance 1e-10 does
/// not close (J) and the energy at hand.
void studyConsistency(const std::string& folder, bool quick);
/// scene,links,without,seconds,ratio: an evaluation of each scene that ships, and of the same without one
/// effect; medians of runs in turn.
void studyEffects(const std::string& folder, bool quick);
/// engine,method,links,seconds: one step.
void studyScaling(bool quick);
/// scene,method,setting,t,steps,energy,momentum: relative errors of what no force changes, over long runs. A
/// failed run ends with NaN.
void studyLongRuns(const std::string& folder, bool quick);

}  // namespace planar_chain::tools
