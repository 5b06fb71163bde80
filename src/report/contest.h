#pragma once

/// Error against run time: what each contestant does, and how it is measured.
///
/// A contest is a scene and its state at the end, by a reference. A contestant is a program's method, run
/// with a setting: a tolerance, or a step in s. Time is the thread's time on the processor, of stepping
/// alone.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/common.h"

namespace planar_chain::tools {

struct Contest {
  std::string name;
  Scene scene;
  double end = 0;                    ///< s
  std::vector<int> index;            ///< links that are compared: all but of the longest chains
  std::vector<double> theta, omega;  ///< of these, absolute, at the end
};

/// A contest of the folder --data: report/scenes.csv names them, report/NAME.csv holds their ends, their
/// scenes lie in report/ and config/scenes/.
/// @throws std::runtime_error when a file is missing or malformed, or a name is not known
Contest readContest(const Arguments& given, const std::string& name);

/// A chain of 1 m and 1 kg in all, made of n rods, at rest: swung out from hanging by `lean`, with a smooth
/// bend on top, rad. Springs k and dampers d in all joints but the ground's. The last rod is heavier by the
/// ratio `tip`.
Scene uniformChain(int n, double bend, double k = 0, double d = 0, double tip = 1, double lean = 0.1);

enum class Progress {
  underway,
  arrived,
  diverged,  ///< the numbers are no longer finite
  refused,   ///< the method cannot go on
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
  /// So many steps, or those to the end or a failure.
  Progress steps(int most);
  virtual Counts counts() const = 0;
  /// Absolute, n each.
  virtual void read(double* theta, double* omega) const = 0;
};

struct Contestant {
  std::string engine, method;
  bool hasFixedStep = false;
  /// True if it can take part in a scene.
  std::function<bool(const Scene&)> takes;
  /// The contest outlives the run.
  std::function<std::unique_ptr<Run>(const Contest&, double setting)> make;
};

/// The rows of work_precision.csv of one scene. A first run warms up. As many follow as fit into 0.1 s, from
/// ten to 21, or two if a run is long. Short runs are divided among three turns through all contestants,
/// because the speed of a processor drifts. A run that fails is not repeated.
void race(const Contest& contest, const std::vector<Contestant>& contestants, bool quick);

/// Median time of each call, s: batches of so many in turn.
std::vector<double> secondsPerCall(const std::vector<std::function<void()>>& calls, int batch,
                                   int repetitions);

/// engine,method,links,seconds: what one step of each contestant with equal steps takes on a hanging chain.
void printScaling(const std::vector<Contestant>& contestants, const std::vector<int>& lengths, bool quick);

using Studies = std::map<std::string, std::function<void(const Arguments&)>>;
/// The program report_measure or report_peers: it runs --study.
/// @returns the exit status
int runStudy(const char* program, int argc, char** argv, const Studies& studies);

}  // namespace planar_chain::tools
