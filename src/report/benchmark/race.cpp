/// report_peers: other programs as contestants of the report, with the protocol of report_measure; only those
/// that were there when it was built.

#include "report/benchmark/race.h"

#include <cstdio>
#include <nlohmann/json.hpp>

namespace planar_chain::benchmarks {

const std::vector<Team>& teams() {
  static const std::vector<Team> teams{
#ifdef WITH_ODEINT
      byHandTeam(),    odeintTeam(),
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
#ifdef WITH_PINOCCHIO
      pinocchioTeam(),
#endif
#ifdef WITH_SIMBODY
      simbodyTeam(),
#endif
  };
  return teams;
}

namespace {

std::vector<Contestant> contestants() {
  std::vector<Contestant> all;
  for (const Team& team : teams()) {
    all.insert(all.end(), team.contestants.begin(), team.contestants.end());
  }
  return all;
}

void describe(const tools::Arguments&) {
  nlohmann::ordered_json versions;
  for (const Team& team : teams()) versions[team.name] = team.version;
  std::puts(versions.dump().c_str());
}

void race(const tools::Arguments& given) {
  tools::race(tools::readContest(given, given.text("scene").value_or("")), contestants(), given.has("quick"));
}

void scale(const tools::Arguments& given) {
  const std::vector<int> lengths =
      given.has("quick") ? std::vector<int>{2, 10, 100} : std::vector<int>{1, 2, 5, 10, 20, 50, 100};
  tools::printScaling(contestants(), lengths, given.has("quick"));
}

}  // namespace
}  // namespace planar_chain::benchmarks

int main(int argc, char** argv) {
  using namespace planar_chain::benchmarks;
  return planar_chain::tools::runStudy("report_peers", argc, argv,
                                       {{"about", describe},
                                        {"race", race},
#ifdef WITH_ODEINT
                                        {"pendulum", pendulum},
#endif
                                        {"scaling", scale}});
}
