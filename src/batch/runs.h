#pragma once

/// The runs of a batch, as its threads share them.

#include <atomic>
#include <exception>
#include <limits>
#include <optional>
#include <utility>

#include "planar_chain/batch.h"
#include "planar_chain/fault.h"

namespace planar_chain {

class Runs {
 public:
  Runs(const Scene& scene, std::size_t count, const SceneOfRun& sceneOfRun,
       const std::vector<double>& theTimes, const BatchOptions& theOptions)
      : times(theTimes), n(scene.chain.size()), options(theOptions), scene_(scene), sceneOfRun_(sceneOfRun) {
    result.runs.resize(count);
    result.states.assign(count * times.size() * stateSize(), std::numeric_limits<double>::quiet_NaN());
  }

  const std::vector<double>& times;
  const int n;  ///< links
  const BatchOptions& options;
  double duration() const { return times.empty() ? 0 : times.back(); }
  BatchResult result;
  std::atomic<bool> cancelled{false};
  std::atomic<std::size_t> ended{0};

  /// Returns the next run. Returns nothing at the end, and after a cancellation.
  std::optional<std::size_t> takeNext() {
    if (cancelled) return std::nullopt;
    const std::size_t run = next_++;
    if (run >= result.runs.size()) return std::nullopt;
    return run;
  }

  /// Nothing if it is refused: then the run has ended.
  std::optional<Scene> sceneOf(std::size_t run) {
    try {
      Scene scene = scene_;
      sceneOfRun_(run, scene);
      for (const Note& note : newNotes(scene.notes, scene_.notes)) add(run, toString(note));
      if (scene.chain.size() == n) return scene;
      fail(run, "every run must have as many links as the scene of the batch");
    } catch (const std::exception& refusal) {
      fail(run, refusal);
    }
    return std::nullopt;
  }

  /// Adds a note to those of a run.
  void add(std::size_t run, const std::string& note) {
    std::string& notes = result.runs[run].notes;
    notes += (notes.empty() ? "" : "; ") + note;
  }

  std::size_t stateSize() const { return 2 * static_cast<std::size_t>(n); }
  double* stateOf(std::size_t run, std::size_t time) {
    return result.states.data() + (run * times.size() + time) * stateSize();
  }

  bool haveTorques() const { return !options.torques.empty(); }
  /// Those that are held until this time.
  const double* torquesOf(std::size_t run, std::size_t time) const {
    return options.torques.data() + (run * times.size() + time) * static_cast<std::size_t>(n);
  }

  void end(std::size_t run, RunOutcome outcome) {
    result.runs[run].outcome = outcome;
    ++ended;
  }
  void fail(std::size_t run, const std::exception& why) {
    const auto* refused = dynamic_cast<const Refused*>(&why);
    fail(run, refused ? toString(refused->faults()) : why.what());
  }
  void fail(std::size_t run, std::string reason) {
    result.runs[run].reason = std::move(reason);
    end(run, RunOutcome::failed);
  }

 private:
  const Scene& scene_;
  const SceneOfRun& sceneOfRun_;
  std::atomic<std::size_t> next_{0};
};

}  // namespace planar_chain
