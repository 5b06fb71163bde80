#pragma once

/// The search for the first event within a step (events.h).
///
/// An interval 0 ≤ s ≤ 1 is judged by the cubic through values and slopes of g at its ends, and by the
/// quartic that g differs from it, 16 e s² (1 − s)², whose height is e at most. In the Bézier coefficients
/// c_0 … c_4 of their sum e stands in the middle alone: c_2 ± 8 e/3. Less what g is above 0 at the start:
///
///     c_4 ≤ 0 and the others ≤ noise              nothing happens
///     c_4 > 0, and they change their sign once    one event
///     else                                        the interval is cut
///
/// (A polynomial lies between its largest and least coefficient, and has no more zeros than they change their
/// sign: G. Farin, Curves and Surfaces for CAGD, 2002, §5.2, §5.3.)
///
/// There are four looks, each at what the one before leaves open. The first two close EventFunctions as a
/// whole:
///
///     1. at the ends of the step, with accelerations by the cubic through positions and rates there. Those
///     are
///        closed that stay below 0 if they go four times as far beyond their ends as values and slopes tell.
///        Most steps end here.
///     2. by halves, with the accelerations of the dense output. Those are closed that are as far below 0 as
///        the coefficients of both cubics are apart.
///     3. of the whole. e is the difference to the value in the middle, and what the error of the dense
///        output changes there.
///     4. at cuts, behind an event or where the cubic is highest, with real values: by the dense output if it
///        is exact there, else by a step of the method. e is what these differ from the cubic of the interval
///        that is cut. In its parts it is sixteen times smaller, or more, and counts as it is.
///
/// A function without slopes has those of the parabola through both ends and the middle. It is closed if it
/// stays as far below 0 as these three values are apart. Until a cut shows its e, c_2 is uncertain by the
/// height of the parabola over its chord.

#include <array>
#include <vector>

#include "ode/events.h"

namespace planar_chain::ode {

/// The states within a step, in chain order. References are valid until the next call.
class StatesWithin {
 public:
  virtual const Eigen::VectorXd& at(double t) = 0;

 protected:
  ~StatesWithin() = default;
};

/// The states within a step by the dense output.
class StepStates : public StatesWithin {
 public:
  virtual const Eigen::VectorXd& accelerationsAt(double t) = 0;
  /// The error of at(); nullptr: it is exact.
  virtual const Eigen::VectorXd* errorAt(double t) = 0;
  /// Writes state and accelerations by a step that ends at t. Returns false if they are not finite.
  virtual bool make(double t, Eigen::VectorXd& y, Eigen::VectorXd& accelerations) = 0;

 protected:
  ~StepStates() = default;
};

/// Only the constructor allocates.
class EventSearch {
 public:
  /// A state, and the functions there.
  struct Sample {
    double t = 0;
    Eigen::VectorXd y;
    Eigen::ArrayXd g, slope;
    double most() const { return g.size() > 0 ? g.maxCoeff() : never; }
  };
  enum class Result { nothing, event, notFinite };

  /// size: of states; n: of q. The functions must outlive this object.
  EventSearch(const EventList& events, Eigen::Index size, Eigen::Index n);

  /// Sets the start of the next interval. Unless `anew`, values of the same state are kept.
  void start(double t, const Eigen::VectorXd& y, bool anew);
  /// Searches from the start to this state, which is the next start if there is nothing. Otherwise no event
  /// has happened at before(), and one has at behind().
  Result search(double t, const Eigen::VectorXd& y, StepStates& states);
  /// Searches as search(), but by both ends alone.
  Result look(double t, const Eigen::VectorXd& y);
  /// Moves behind() to this state. Returns false, and changes nothing, if no event has happened there.
  bool shorten(double t, const Eigen::VectorXd& y);
  /// The first event between before() and behind(), by the states given.
  LocatedEvent locate(StatesWithin& states);

  /// The values that start() keeps.
  void saveOrRestore(Snapshot& snapshot) { snapshot(isKnown_, from_.t, from_.y, from_.g, from_.slope); }

  const Sample& before() const { return from_; }
  const Sample& behind() const { return to_; }

 private:
  using Numbers = Eigen::ArrayXd;
  struct Group {
    const EventFunctions* functions;
    Eigen::Index first, count;
    bool isOpen;
    auto of(Numbers& all) const { return all.segment(first, count); }
    auto of(const Numbers& all) const { return all.segment(first, count); }
  };

  void setCounts();
  void evaluate(Sample& at, bool openOnly);
  void findSlopes(Sample& at, const Eigen::VectorXd& accelerations);
  bool isQuiet(StepStates& states);
  bool isQuietByHalves(StepStates& states);
  void setMiddle(StepStates& states);
  void findErrors(StepStates& states);
  Eigen::Index firstOpen(const Sample& a, const Sample& b, const Numbers& errors) const;
  double mostOfOpen(const Sample& at) const;
  Result resolve(Sample& a, Sample& b, std::size_t depth, StepStates& states);
  double shareOfCut(const Sample& a, const Sample& b, Eigen::Index open) const;
  bool cut(const Sample& a, const Sample& b, Eigen::Index open, std::size_t depth, StepStates& states);
  Result setBracket(Sample& a, Sample& b);
  double valueAt(double t, const Group& group, Eigen::Index i, StatesWithin& states);
  LocatedEvent root(const Group& group, Eigen::Index i, double last, StatesWithin& states);

  std::vector<Group> groups_;
  const Eigen::Index n_;
  Sample from_, to_, middle_;
  bool isKnown_ = false;                    ///< values of from_
  const StatesWithin* middleBy_ = nullptr;  ///< what middle_ is by; nullptr: it is unknown
  Numbers noise_, values_;
  Eigen::VectorXd accelerations_;
  struct Cut {
    Sample sample;
    Numbers e;  ///< of both parts
  };
  // An interval of 1/2^deepest of a step moves nothing. The others bound the cost of a step: few need more
  // than three cuts.
  static constexpr std::size_t mostCuts = 24, deepest = 12, mostSteps = 8;
  std::array<Cut, deepest + 1> cuts_;         ///< the first one: e of the whole
  std::size_t cutsMade_ = 0, stepsMade_ = 0;  ///< in this search
};

}  // namespace planar_chain::ode
