#pragma once

/// Error against run time: what everyone who takes part in the report has to do, and how it is measured.
///
/// A contest is a scene and where it truly ends. A contestant is a program's method with a setting (a
/// tolerance, or a step in s); it is asked for one of its own steps at a time. Time is that of the process's
/// thread on the processor, of stepping alone: what is made before the first step does not count.

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "planar_chain/scene.h"

namespace planar_chain::tools {

struct Contest {
  std::string name;
  Scene scene;
  double end = 0;                ///< s
  std::vector<int> index;        ///< links that are compared: all but of the longest chains
  Eigen::VectorXd theta, omega;  ///< of these, absolute, at the end
};

/// Those of a folder: report/scenes.csv names them, report/NAME.csv holds their ends; scenes lie in report/
/// and config/scenes/. Without names: all of them.
/// @throws std::runtime_error when a file is not there or not as expected, or a name is not known
std::vector<std::string> contestNames(const std::string& folder);
Contest readContest(const std::string& folder, const std::string& name);

enum class Progress {
  underway,
  arrived,
  diverged,  ///< the numbers are no longer finite
  refused,   ///< the method says that it cannot go on
};

struct Counts {
  long long evaluations = 0;  ///< of the accelerations
  long long steps = 0, rejected = 0;
};

/// One run of a contestant, at time 0.
class Run {
 public:
  virtual ~Run() = default;
  /// One step of its own.
  virtual Progress step() = 0;
  virtual Counts counts() const = 0;
  /// Absolute, n each.
  virtual void read(double* theta, double* omega) const = 0;
};

struct Contestant {
  std::string engine, method;
  bool hasFixedStep = false;
  /// Those who cannot take part in a scene leave it out.
  std::function<bool(const Scene&)> takes;
  /// The contest outlives the run.
  std::function<std::unique_ptr<Run>(const Contest&, double setting)> make;
};

/// Loosest first.
std::vector<double> settingsFor(const Contestant& contestant, const Contest& contest, bool quick);

/// How long a setting is measured. A first run, which warms up, is followed by as many as the budget allows,
/// but at least `fewest` and at most 21; by two where a run is long. Short runs are divided among turns, each
/// of which warms up. Who does not arrive is not asked again.
struct Effort {
  double budget;  ///< s a setting
  int fewest;     ///< runs
  int turns;
  double isLong;  ///< s a run
  double limit;   ///< s a run: longer ones are given up
};
Effort effortFor(const Contest& contest, bool quick);

struct Result {
  const char* outcome = "ok";             ///< or "diverged", "refused", "timed out"
  double thetaError = 0, omegaError = 0;  ///< largest of a link; NaN where there is none
  double median = 0, least = 0;           ///< s, of the runs
  double worstStep = 0;  ///< s: of each step the least over up to three runs, of these the largest
  int runs = 0;
  int turns = 1;  ///< in which the point is to be measured, this one among them
  Counts counts;
};

/// "diverged" also where an angle ends more than 1 rad off: that run has nothing to do with the motion any
/// more.
Result measure(const Contest& contest, const Contestant& contestant, double setting, const Effort& effort);

/// The protocol of report_measure and report_peers. list: a line "scene,engine,method,setting" for each
/// point. race: for each such line on standard input the columns of work_precision.csv, then runs, the
/// least time and turns.
void listPoints(const std::string& folder, const std::vector<Contestant>& contestants, bool quick);
void racePoints(const std::string& folder, const std::vector<Contestant>& contestants, bool quick);

/// @throws std::runtime_error when the file cannot be read
Scene sceneOfFile(const std::string& path);

}  // namespace planar_chain::tools
