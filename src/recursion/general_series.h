#pragma once

/// The motion of a chain that is not bare (general.h) as a Taylor series: θ(t + h) = Σ θ_k h^k, and so on.
///
/// With e_j = exp(i θ_j), a the acceleration of a body's own point (less gravity) and f the force on the body
/// there,
///
///     ë = i d(ω e)/dt           a_next = a + p ë           f = f_next + m (a + r ë) − F
///     (I + m|r|²) α + e×w = N + μ − μ_next                 w = m r̄ a + p̄ f_next
///
/// Behind a prismatic joint of displacement s along the axis x, the own point is y x from the pin inside,
/// with y = s e. Its body adds its moment and y×g to those on the body whose joint turns it:
///
///     a = a_pin + ÿ x           e·g = N + μ                g = x̄ f
///
/// Order k of a product is Cauchy's sum over the orders of its factors. Only one term of each sum contains
/// α_k or s̈_k, and its factor depends on the present state alone. So all orders have the same matrix, and the
/// recursion of general.h, at rest and without gravity, solves
///
///     M(θ_0, s_0) (α_k, s̈_k) = N_k − the left sides above at α_k = s̈_k = 0      joints with order k of q̈
///
/// Its masses are computed once a series.
///
/// Source: as lanes/motion_series.h, which has the series of bare chains.

#include <algorithm>
#include <vector>

#include "planar_chain/chain.h"
#include "recursion/general.h"

namespace planar_chain {

/// One order of what a chain is given: n values each.
struct GeneralOrder {
  const double* N;
  const Vec2d* F;  ///< nullptr: none
  const JointLaw<double>* joints;
  Vec2d ground;          ///< acceleration of the ground pin, of order 0 less gravity
  double rate, turning;  ///< of the base: angular velocity and acceleration
};

class GeneralSeries {
 public:
  /// For orders 0 … orders − 1 of the accelerations. Allocates.
  GeneralSeries(const Chain& chain, int orders)
      : n_(index(chain.size())),
        orders_(orders),
        omega_(n_, orders),
        e_(n_, orders + 2),
        w_(n_, orders),
        y_(chain.coordinates().anyIsPrismatic() ? n_ : 0, orders + 2),
        g_(chain.coordinates().anyIsPrismatic() ? n_ : 0, orders),
        left_(n_),
        xdd_(n_) {
    for (int j = 0; j < chain.size(); ++j) {
      const Link& link = chain.links()[index(j)];
      const Joint& joint = chain.joints()[index(j)];
      bodies_.push_back({{link.mass, link.inertia, link.com, link.pin},
                         joint.isPrismatic,
                         joint.axis,
                         chain.coordinates().turner(j)});
    }
  }

  int orders() const { return orders_; }
  /// Row k of n values: order k of e.
  const Rotation<double>* rotations() const { return e_[0]; }

  /// Takes order 0: rotations, accelerations of the coordinates (of angles against the ground) and row 0 of
  /// c. Does not read N. Writes row 1 of c. Rows have 2n numbers: orders of the coordinates and of their
  /// rates. c stays in use.
  void begin(const Rotation<double>* e, const double* xdd, double* c, const GeneralOrder& given) {
    c_ = c;
    std::copy_n(e, n_, e_[0]);
    std::copy_n(xdd, n_, xdd_.begin());
    takeRates(0, given.rate);
    for (std::size_t j = 0; j < n_; ++j) {
      e_[1][j] = {-omega_[0][j] * e[j].s, omega_[0][j] * e[j].c};
      if (!bodies_[j].isPrismatic) continue;
      y_[0][j] = c[j] * vector(e[j]);
      y_[1][j] = c[n_ + j] * vector(e[j]) + c[j] * vector(e_[1][j]);
    }
    factor(given.joints);
    turn(0);
    complete(0, given);
  }

  /// Takes order k > 0 of what is given. Reads rows up to k of c, and writes row k + 1.
  void find(int k, const GeneralOrder& given) {
    takeRates(k, given.rate);
    turn(k);
    findForces(k, given);
    findWhatIsLeft(k, given.N);
    solve(given);
    complete(k, given);
  }

 private:
  /// The orders of one value.
  template <class Value>
  struct Orders {
    const Value* first;
    std::size_t apart;
  };
  /// Orders of so many values each.
  template <class Value>
  class Rows {
   public:
    Rows(std::size_t width, int orders) : width_(width), values_(width * index(orders)) {}
    Value* operator[](int k) { return values_.data() + index(k) * width_; }
    const Value* operator[](int k) const { return values_.data() + index(k) * width_; }
    Orders<Value> of(std::size_t j) const { return {values_.data() + j, width_}; }

   private:
    std::size_t width_;
    std::vector<Value> values_;
  };

  struct SweptBody {
    Body<double> of;
    bool isPrismatic;
    Vec2d axis;
    int turner;  ///< the coordinate that turns it, or −1

    // At the present state.
    Vec2d P{};
    Displacement<double> by{};
    JointNumbers<double> law{};
    JointTerms<double> terms{};

    // One order.
    Vec2d z{}, edd{}, ydd{}, a{};  ///< edd: ë; ydd: ÿ, of a prismatic joint
  };

  /// Order k of the coordinates, and then of their rates.
  double* row(int k) { return c_ + index(2 * k) * n_; }

  // Vectors as complex numbers.
  static Vec2d vector(Rotation<double> e) { return {e.c, e.s}; }
  static Vec2d vector(Vec2d a) { return a; }
  static Vec2d times(Vec2d a, Vec2d b) { return {a.x * b.x - a.y * b.y, a.y * b.x + a.x * b.y}; }
  static Vec2d conjugateTimes(Vec2d a, Vec2d b) { return {dot(a, b), cross(a, b)}; }
  static Vec2d scale(double x, Rotation<double> e) { return x * vector(e); }

  /// Σ f(x_i, y_{k−i}) over first ≤ i ≤ last. Begins in the middle, as the last orders have hardly been
  /// stored.
  template <class X, class Y, class F>
  [[gnu::always_inline]] static auto sumOf(int k, int first, int last, Orders<X> x, Orders<Y> y, F f) {
    int low = (first + last) / 2;
    const X *xLow = x.first + index(low) * x.apart, *xHigh = xLow + x.apart;
    const Y *yLow = y.first + index(k - low) * y.apart, *yHigh = yLow - y.apart;
    decltype(f(*xLow, *yLow)) sum{}, other{};
    for (int high = low + 1; high <= last; --low, ++high) {
      sum += f(*xLow, *yLow);
      other += f(*xHigh, *yHigh);
      xLow -= x.apart;
      yLow += y.apart;
      xHigh += x.apart;
      yHigh -= y.apart;
    }
    if (low >= first) sum += f(*xLow, *yLow);
    return sum + other;
  }

  /// Takes order k of the bodies' rates against the ground. Writes order k + 1 of the coordinates.
  void takeRates(int k, double ofBase) {
    const double* rates = row(k) + n_;
    double *next = row(k + 1), *omega = omega_[k];
    for (std::size_t j = 0; j < n_; ++j) {
      const int turner = bodies_[j].turner;
      omega[j] = (turner >= 0 ? rates[turner] : 0) + ofBase;
      next[j] = rates[j] / (k + 1);
    }
  }

  /// Order k of ë and ÿ, as if α_k and s̈_k were 0:
  ///
  ///     ë_k = i (α_k e_0 + (k+1) z)                        z = Σ_{j≤k} ω_j e_{k+1−j}
  ///     ÿ_k = s̈_k e_0 + s_0 ë_k + (k+1) (k+2) Σ_{0<j<k+2} s_j e_{k+2−j}
  void turn(int k) {
    for (std::size_t j = 0; j < n_; ++j) {
      SweptBody& body = bodies_[j];
      body.z = sumOf(k + 1, 0, k, omega_.of(j), e_.of(j), scale);
      body.edd = (k + 1.0) * perp(body.z);
      if (!body.isPrismatic) continue;
      const Vec2d sum = sumOf(k + 2, 1, k + 1, Orders<double>{c_ + j, 2 * n_}, e_.of(j), scale);
      body.ydd = (k + 1.0) * (k + 2) * sum + c_[j] * body.edd;
    }
  }

  /// Adds what the accelerations of order k change, and writes the orders that follow:
  ///
  ///     (k+2) e_{k+2} = i (z + ω_{k+1} e_0)                (k+1) (k+2) y_{k+2} = ÿ_k
  void complete(int k, const GeneralOrder& given) {
    const double share = 1.0 / (k + 1), part = 1.0 / (k + 2);
    double* rates = row(k + 1) + n_;
    for (std::size_t j = 0; j < n_; ++j) {
      SweptBody& body = bodies_[j];
      const Vec2d e = vector(e_[0][j]);
      const Vec2d byAlpha = (body.turner >= 0 ? xdd_[index(body.turner)] : given.turning) * perp(e);
      const Vec2d next = part * (share * byAlpha + perp(body.z));
      e_[k + 2][j] = {next.x, next.y};
      body.edd += byAlpha;
      rates[j] = share * (body.isPrismatic ? xdd_[j] : xdd_[j] - given.turning);
      if (!body.isPrismatic) continue;
      body.ydd += xdd_[j] * e + c_[j] * byAlpha;
      y_[k + 2][j] = share * part * body.ydd;
    }
    findForces(k, given);
  }

  /// Order k of w and g.
  void findForces(int k, const GeneralOrder& given) {
    Vec2d a = given.ground;
    for (SweptBody& body : bodies_) {
      if (body.isPrismatic) a += times(body.ydd, body.axis);
      body.a = a;
      a += times(body.edd, body.of.p);
    }
    Vec2d f;
    for (std::size_t j = n_; j-- > 0;) {
      const SweptBody& body = bodies_[j];
      w_[k][j] = body.of.m * conjugateTimes(body.of.r, body.a) + conjugateTimes(body.of.p, f);
      f += body.of.m * (body.a + times(body.edd, body.of.r));
      if (given.F) f -= given.F[j];
      if (body.isPrismatic) g_[k][j] = conjugateTimes(body.axis, f);
    }
  }

  /// N_k less the left sides.
  void findWhatIsLeft(int k, const double* N) {
    const auto crossed = [](auto a, Vec2d b) { return cross(vector(a), b); };
    const auto along = [](Rotation<double> a, Vec2d b) { return dot(vector(a), b); };
    std::copy_n(N, n_, left_.begin());
    for (std::size_t j = 0; j < n_; ++j) {
      const SweptBody& body = bodies_[j];
      double moment = sumOf(k, 0, k, e_.of(j), w_.of(j), crossed);
      if (body.isPrismatic) {
        moment += sumOf(k, 0, k, y_.of(j), g_.of(j), crossed);
        left_[j] -= sumOf(k, 0, k, e_.of(j), g_.of(j), along);
      }
      if (body.turner >= 0) left_[index(body.turner)] -= moment;
    }
  }

  // ---- The recursion --------------------------------------------------------------------------------------

  void factor(const JointLaw<double>* laws) {
    ArticulatedTerms<double> articulated;
    for (std::size_t j = n_; j-- > 0;) {
      SweptBody& body = bodies_[j];
      const BodyPose<double> at = bodyPose(body.of, e_[0][j], 0.0);
      body.P = at.P;
      body.law = numbersOf(JointLaw<double>{laws[j].armature, laws[j].isPrescribed, 0});
      addBody(at, articulated);
      if (body.isPrismatic) {
        const Vec2d d = e_[0][j] * body.axis;
        body.by = {d, c_[j] * d, {}};
        body.terms = passPrismatic(0.0, body.law, d, articulated);
        stepInwards(body.by, articulated);
      } else {
        body.terms = passRevolute(0.0, body.law, articulated);
      }
    }
  }

  /// At rest and without gravity, where only joints have loads.
  void solve(const GeneralOrder& given) {
    Vec2d b;
    double c = 0;
    for (std::size_t j = n_; j-- > 0;) {
      SweptBody& body = bodies_[j];
      body.law.acceleration = given.joints[j].acceleration;
      c += dot(perp(body.P), b);
      if (body.isPrismatic) {
        biasPrismatic(left_[j], body.law, body.by.d, body.terms, b, c);
        c += dot(perp(body.by.S), b);
      } else {
        biasRevolute(left_[j], body.law, body.terms, b, c);
      }
    }
    Moved<double> moved{{}, given.turning};
    for (std::size_t j = 0; j < n_; ++j) {
      const SweptBody& body = bodies_[j];
      if (body.isPrismatic) {
        outwardsPrismatic(body.terms, body.law, body.by, moved, xdd_[j]);
      } else {
        outwardsRevolute(body.terms, body.law, moved);
        xdd_[j] = moved.alpha;
      }
      toOuterPin(body.P, 0.0, moved);
    }
  }

  std::size_t n_;
  int orders_;
  Rows<double> omega_;  ///< of the bodies
  Rows<Rotation<double>> e_;
  Rows<Vec2d> w_, y_, g_;  ///< y, g: of prismatic joints
  std::vector<double> left_, xdd_;
  std::vector<SweptBody> bodies_;
  double* c_ = nullptr;
};

}  // namespace planar_chain
