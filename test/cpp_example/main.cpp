// A pendulum that is let go level: its angle and rate every quarter of a second.
#include <planar_chain/scene_reader.h>
#include <planar_chain/simulation.h>

#include <iostream>

int main() {
  planar_chain::Simulation simulation(planar_chain::readSceneText(R"(
    chain: [rod]
    links: {rod: {mass: 1, inertia: 0, com: [1, 0], pin: [1, 0]}}
    integrator: {tolerance: 1e-10})"));
  for (const double t : {0.25, 0.5, 1.0}) {
    if (!simulation.advanceTo(t)) return std::cerr << simulation.fault() << "\n", 1;
    std::cout << t << " s: " << simulation.q()[0] << " rad, " << simulation.qd()[0] << " rad/s\n";
  }
}
