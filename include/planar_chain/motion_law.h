#pragma once

/// A motion as a function of time: the angle of a driven joint, or a coordinate of the base.
///
///     sine     x = offset + amplitude sin(2π frequency t + phase)
///     pieces   x = Σ_k c_k (t − start)^k, k ≤ 5, in each piece; constant before the first, after the last
///
/// At the start of each piece a derivative may jump. A step ends there, and uses the piece on its own side.

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "planar_chain/planar.h"

namespace planar_chain {

/// x and its first two derivatives: m or rad, per s, s².
struct GivenMotion {
  double value = 0, rate = 0, acceleration = 0;
};

/// A point of a motion at a time, s.
struct MotionPoint {
  double time = 0, value = 0;
  std::optional<double> rate, acceleration;
};

class MotionLaw {
 public:
  struct Piece {
    double start = 0;  ///< s
    std::array<double, 6> c{};
  };

  /// x = 0 for ever.
  MotionLaw() : pieces_(1) {}
  static MotionLaw sine(double amplitude, double frequency, double phase, double offset);
  /// The cubic spline through (times, values) with continuous acceleration inside, and rate 0 at both ends.
  /// times increase strictly, at least two; as many values. Source: C. de Boor, A Practical Guide to Splines
  /// (2001), ch. IV, with clamped ends.
  static MotionLaw spline(const std::vector<double>& times, const std::vector<double>& values);
  /// The first piece also holds before its start, the last one for ever. Not empty.
  explicit MotionLaw(std::vector<Piece> pieces) : pieces_(std::move(pieces)) {}

  /// Returns this law from `now` until `start`, and then a motion through the points, as ros_control's
  /// joint_trajectory_controller: by a quintic between two points with rates and accelerations, else by a
  /// cubic between two with rates, else by a straight line. At `start` both are known, from this law. It ends
  /// at rest in the last point, whose rate is nothing or 0.
  ///
  /// A line differs from the controller's near its ends: the rate of a driven joint must not jump. A quintic
  /// leads onto the line from the motion before, in a quarter of its time or 20 ms, if that is less. Another
  /// one leads to the rate of the point at its end, where that is given. So all points are met at their
  /// times.
  ///
  /// now ≤ start < the times of the points, which increase strictly; at least one.
  MotionLaw then(double now, double start, const std::vector<MotionPoint>& points) const;

  /// Returns the cubic from this law's value and rate at `now` to those at `end` > now. At `end` the cubic
  /// still holds, so its acceleration can be read there. After that the rate is constant.
  MotionLaw to(double now, double end, double value, double rate) const;

  /// The number of the piece that holds in [t, until(piece)).
  int pieceAt(double t) const;
  double until(int piece) const;
  GivenMotion at(double t, int piece) const;
  /// Coefficient k of the Taylor series around t of x, ẋ and ẍ.
  GivenMotion order(int k, double t, int piece) const;
  GivenMotion at(double t) const { return at(t, pieceAt(t)); }
  /// Returns the longest step that resolves the motion, s: a quarter of the period of a sine.
  double longestStep() const;
  bool moves() const;
  /// True if the energies and forces of the motion are far from overflow. moderate() returns the condition in
  /// words.
  bool isModerate() const;
  static std::string moderate(const std::string& unit);

  // The constructor's arguments: a sine, if there is one piece.
  double amplitude() const { return amplitude_; }
  double frequency() const { return frequency_; }  ///< Hz
  double phase() const { return phase_; }
  const std::vector<Piece>& pieces() const { return pieces_; }

  /// For states that are saved (Simulation::save()).
  template <class Snapshot>
  void saveOrRestore(Snapshot& snapshot) {
    snapshot(amplitude_, frequency_, pulsation_, phase_, swinging_, pieces_);
  }

 private:
  double amplitude_ = 0, frequency_ = 0, pulsation_ = 0, phase_ = 0;
  int swinging_ = std::numeric_limits<int>::max();  ///< number of pieces to which the sine is added
  std::vector<Piece> pieces_;
};

/// The motion of the ground pin, m, and of the direction from which joint 1 is measured, rad; base frame.
struct BaseLaws {
  MotionLaw x, y, angle;
};

/// Holds the tip, the outer pin of the last link, at a point that moves by these laws, m, or on the fixed
/// line through it in this direction. Both belong to the ground, also if the base moves.
struct TipLaws {
  MotionLaw x, y;
  std::optional<Vec2d> line{};  ///< length 1; nothing: the tip is pinned to the point

  bool moves() const { return x.moves() || y.moves(); }
  /// The number of conditions.
  int rows() const { return line ? 1 : 2; }
};

}  // namespace planar_chain
