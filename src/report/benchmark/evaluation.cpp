#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "report/benchmark/measure.h"
#include "report/benchmark/peer.h"

namespace planar_chain::benchmarks {

namespace {

bool agreed = true;

/// Returns the peer of a kind and length. It is made at the first call, because some take seconds.
Peer* peerOf(const PeerKind& kind, int n) {
  static std::map<std::pair<std::string, int>, std::unique_ptr<Peer>> made;
  const auto [entry, isNew] = made.try_emplace({kind.name, n});
  if (isNew) entry->second = kind.make(rods(n));
  return entry->second.get();
}

std::vector<double> accelerations(const PeerKind& kind, const Posture& posture) {
  std::vector<double> qdd(posture.q.size());
  Peer& peer = *peerOf(kind, static_cast<int>(qdd.size()));
  peer.place(posture);
  peer.evaluate();
  peer.read(qdd.data());
  return qdd;
}

/// The largest difference of two vectors, in units of the second one's largest number.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0, worst = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (!std::isfinite(a[i])) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, std::abs(b[i]));
    worst = std::max(worst, std::abs(a[i] - b[i]));
  }
  return worst / largest;
}

void evaluate(benchmark::State& state, const PeerKind& kind, const Shape& shape, int n) {
  const Posture posture = shape.posture(n);
  const double off = difference(accelerations(kind, posture), accelerations(peers().front(), posture));
  if (!(off <= kind.agreement)) {
    char text[100];
    std::snprintf(text, sizeof text, "%s computes another motion: off by %.1e", kind.name.c_str(), off);
    state.SkipWithError(text);
    agreed = false;
    return;
  }
  Peer& peer = *peerOf(kind, n);
  for (auto _ : state) {
    peer.evaluate();
    benchmark::ClobberMemory();
  }
  state.counters["ns_per_link"] = perLink(n);
  state.counters["difference"] = off;
}

}  // namespace

void registerEvaluations() {
  for (const Shape& shape : shapes()) {
    for (const PeerKind& kind : peers()) {
      for (const int n : sizes()) {
        if (n < kind.shortest || n > kind.longest) continue;
        benchmark::RegisterBenchmark(nameOf("evaluation/" + shape.name, kind.name, n).c_str(),
                                     [&, n](benchmark::State& state) { evaluate(state, kind, shape, n); });
      }
    }
  }
}

bool allAgreed() {
  return agreed;
}

}  // namespace planar_chain::benchmarks
