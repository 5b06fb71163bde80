/// report_measure: what `report` measures of this program; it makes the page of it. See report_contest.h and
/// report_studies.h for the tables.

#include <nlohmann/json.hpp>

#include "planar_chain/simulation.h"
#include "report/report_own.h"
#include "report/report_studies.h"
#include "report/stability_scenes.h"
#include "report_build.h"
#include "tools/common.h"

namespace planar_chain::tools {
namespace {

int measureAll(int argc, char** argv) {
  CLI::App app("Measures what `report` needs, as CSV on standard output.", "report_measure");
  std::string what, folder;
  bool quick = false;
  app.add_option("WHAT", what, "about, list, race, consistency, effects, scaling or long")->required();
  app.add_option("--data", folder, "Folder with report/ and config/scenes")->required();
  app.add_flag("--quick", quick, "Fewer and shorter runs");
  app.footer("Exit status: 0 done; 1 it failed; 2 bad arguments.");
  if (const auto status = parseArguments(app, argc, argv)) return *status;

  if (what == "about") {
    nlohmann::ordered_json about{{"commit", PLANAR_CHAIN_COMMIT},
                                 {"compiler", PLANAR_CHAIN_COMPILER},
                                 {"flags", PLANAR_CHAIN_FLAGS},
                                 {"recursion", Simulation(hangingChain(1000)).recursion()}};
    std::puts(about.dump().c_str());
  } else if (what == "list") {
    listPoints(folder, ownContestants(), quick);
  } else if (what == "race") {
    racePoints(folder, ownContestants(), quick);
  } else if (what == "consistency") {
    studyConsistency(folder, quick);
  } else if (what == "effects") {
    studyEffects(folder, quick);
  } else if (what == "scaling") {
    studyScaling(quick);
  } else if (what == "long") {
    studyLongRuns(folder, quick);
  } else {
    throw Refused(
        {{"WHAT", "about, list, race, consistency, effects, scaling or long", describe(Value(what))}});
  }
  return done;
}

}  // namespace
}  // namespace planar_chain::tools

int main(int argc, char** argv) {
  namespace tools = planar_chain::tools;
  return tools::run("report_measure", [&] { return tools::measureAll(argc, argv); });
}
