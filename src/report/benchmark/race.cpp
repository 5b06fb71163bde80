/// report_peers: other programs as contestants of the report, with the protocol of report_measure; only those
/// that were there when it was built. scaling: one step against the number of links.

#include "report/benchmark/race.h"

#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

namespace planar_chain::benchmarks {

const std::vector<Team>& teams() {
  static const std::vector<Team> teams{
#ifdef WITH_ODEINT
      byHandTeam(),   odeintTeam(),
#endif
#ifdef WITH_SUNDIALS
      sundialsTeam(),
#endif
#ifdef WITH_BULLET
      bulletTeam(),
#endif
#ifdef WITH_DART
      dartTeam(),
#endif
#ifdef WITH_MUJOCO
      mujocoTeam(),
#endif
#ifdef WITH_ODE
      odeTeam(),
#endif
#ifdef WITH_SIMBODY
      simbodyTeam(),
#endif
  };
  return teams;
}

namespace {

/// WHAT --data FOLDER [--quick]
int race(int argc, char** argv) {
  if (argc < 4 || std::strcmp(argv[2], "--data") != 0) return 2;
  const std::string what = argv[1], folder = argv[3];
  const bool quick = argc > 4 && std::strcmp(argv[4], "--quick") == 0;
  std::vector<Contestant> contestants;
  nlohmann::ordered_json versions;
  for (const Team& team : teams()) {
    contestants.insert(contestants.end(), team.contestants.begin(), team.contestants.end());
    versions[team.name] = team.version;
  }
  if (what == "about") {
    std::puts(versions.dump().c_str());
  } else if (what == "list") {
    tools::listPoints(folder, contestants, quick);
  } else if (what == "race") {
    tools::racePoints(folder, contestants, quick);
  } else if (what == "scaling") {
    const std::vector<int> lengths =
        quick ? std::vector<int>{2, 10, 100} : std::vector<int>{1, 2, 5, 10, 20, 50, 100};
    tools::printScaling(contestants, lengths, quick);
  } else {
    return 2;
  }
  return 0;
}

}  // namespace
}  // namespace planar_chain::benchmarks

int main(int argc, char** argv) {
  try {
    return planar_chain::benchmarks::race(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "report_peers: %s\n", error.what());
    return 1;
  }
}
