#pragma once

/// The Taylor series of the derivatives of a motion, from that of the motion. See column_series.h for the
/// equations. Series of single numbers lie one order after the other; all orders of a product are summed at
/// once, in lanes. Columns lie in lanes, and their orders follow one by one.

#include "lanes/column_arrays.h"
#include "simd/rotation_kernel.h"

namespace planar_chain::simd {
namespace {

using Terms = ColumnArrays::Terms;

class Columns {
 public:
  Columns(const ColumnArrays& of, const double* c) : of_(of), c_(c), n_(of.n), orders_(of.order + 1) {}

  /// n = 0: as many as there are.
  template <int n>
  [[gnu::always_inline]] void find() {
    takeMotion();
    findMatrices();
    findSources();
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j) prepareFactor(i, j);
    }
    invertMasses();
    for (int k = 0; k < of_.order; ++k) {
      findFactors(k);
      for (int at = 0; at < of_.width; at += 2 * laneCount) {
        if (at + laneCount < of_.width) {
          findOrder<n, 2>(k, at);
        } else {
          findOrder<n, 1>(k, at);
        }
      }
    }
  }

 private:
  // ---- Where the series are -----------------------------------------------------------------------------

  double* series(int number) const {
    return of_.series + static_cast<std::ptrdiff_t>(number) * of_.apart + ColumnArrays::before;
  }
  /// The number of the series of ē_i e_j, i < j; that of e_j is j.
  int pair(int i, int j) const { return n_ + j * (j - 1) / 2 + i; }
  double* e(int q, int part) const { return series(5 * q + part); }
  double* slope(int q, int part) const { return series(5 * q + 2 + part); }
  double* turn(int q) const { return series(5 * q + 4); }  ///< how fast it turns
  double* ofJoint(int number) const { return series(5 * pair(0, n_) + number); }
  double* acceleration(int j) const { return ofJoint(j); }
  double* square(int j) const { return ofJoint(n_ + j); }
  double* source(int j) const { return ofJoint(2 * n_ + j); }
  double* matrix(int which, int i, int j) const { return ofJoint(3 * n_ + (which * n_ + i) * n_ + j); }
  /// ē_i F_j
  double* product(int i, int j, int part) const { return matrix(3 + part, i, j); }
  // In place of the products, when nobody needs them any more: the parts of the factors.
  double* constant(int i, int j) const { return product(i, j, 0); }
  double* linear(int i, int j) const { return product(i, j, 1); }
  double* factor(int i, int j) const { return matrix(5, i, j); }
  /// k + 1
  const double* following() const { return matrix(6, 0, 0); }

  bool isPrismatic(int j) const { return j < of_.leading; }
  /// f(k) for each register of orders.
  template <class F>
  [[gnu::always_inline]] void forOrders(F f) const {
    for (int k = 0; k < orders_; k += laneCount) f(k);
  }

  // ---- The motion ---------------------------------------------------------------------------------------

  void takeMotion() {
    for (int j = 0; j < n_; ++j) {
      const double* rate = c_ + n_ + j;
      double *its = turn(j), *next = acceleration(j);
      for (int k = 0; k < of_.order; ++k) next[k] = (k + 1) * rate[2 * n_ * (k + 1)];
      for (int k = 0; k < orders_ && !isPrismatic(j); ++k) its[k] = rate[2 * n_ * k];
      for (int i = 0; i < j; ++i) {
        const int q = pair(i, j);
        forOrders([&](int k) { (Pack::load(its + k) - Pack::load(turn(i) + k)).store(turn(q) + k); });
        // ē_i e_j
        const double ix = e(i, 0)[0], iy = e(i, 1)[0], jx = e(j, 0)[0], jy = e(j, 1)[0];
        e(q, 0)[0] = ix * jx + iy * jy;
        e(q, 1)[0] = ix * jy - iy * jx;
      }
      for (int k = 0; k < orders_ && !isPrismatic(j); k += laneCount) {
        Pack sum;
        for (int m = 0; m < k + laneCount; ++m) sum = mulAdd(Pack(its[m]), Pack::load(its + k - m), sum);
        sum.store(square(j) + k);
      }
    }
    findTurning();
  }

  /// (k+1) e_{k+1} = i Σ ω_j e_{k−j}: each order of e is multiplied by all of ω when it is known.
  void findTurning() {
    const int count = pair(0, n_);
    for (int q = of_.leading; q < count; ++q) {
      for (int part = 0; part < 2; ++part) forOrders([&](int k) { Pack().store(slope(q, part) + k); });
    }
    for (int k = 0; k < of_.order; ++k) {
      const double share = of_.inverses[k + 1];
      const int first = k / laneCount * laneCount;
      for (int q = of_.leading; q < count; ++q) {
        double *x = e(q, 0) + k, *y = e(q, 1) + k, *dx = slope(q, 0), *dy = slope(q, 1);
        const double* rates = turn(q) - k;
        const Pack xk(*x), yk(-*y);
        for (int at = first; at < of_.order; at += laneCount) {
          const Pack omega = Pack::load(rates + at);
          mulAdd(omega, yk, Pack::load(dx + at)).store(dx + at);
          mulAdd(omega, xk, Pack::load(dy + at)).store(dy + at);
        }
        x[1] = dx[k] * share;
        y[1] = dy[k] * share;
      }
    }
  }

  // ---- The matrices -------------------------------------------------------------------------------------

  void findMatrices() {
    for (int i = 0; i < n_; ++i) {
      const Pack Gx(of_.own[Terms::weight(i, n_)]), Gy(of_.own[Terms::weight(i, n_) + 1]);
      forOrders([&](int k) {
        Pack().store(matrix(0, i, i) + k);
        Pack().store(matrix(1, i, i) + k);
        Pack stiffness;
        if (!isPrismatic(i)) stiffness = mulAdd(Gx, Pack::load(e(i, 0) + k), Gy * Pack::load(e(i, 1) + k));
        stiffness.store(matrix(2, i, i) + k);
      });
      matrix(0, i, i)[0] = of_.own[Terms::inertia(i)];
    }
    for (int i = 0; i < n_; ++i) {
      for (int j = i + 1; j < n_; ++j) findPair(i, j);
    }
    for (int which = 0; which < 3; ++which) {
      for (int i = n_ - 2; i >= of_.leading; --i) {
        for (int j = 0; j < n_; ++j) addSeries(matrix(which, i + 1, j), matrix(which, i, j));
      }
      for (int j = n_ - 2; j >= of_.leading; --j) {
        for (int i = 0; i < n_; ++i) addSeries(matrix(which, i, j + 1), matrix(which, i, j));
      }
      for (int i = 0; i < n_; ++i) matrix(which, i, i)[0] += of_.own[Terms::joint(i, n_) + which];
    }
  }
  void addSeries(const double* from, double* to) const {
    forOrders([&](int k) { (Pack::load(to + k) + Pack::load(from + k)).store(to + k); });
  }

  /// With E = ē_i e_j: ē_i ė_j = i ω_j E, ē_i ë_j = (i α_j − ω_j²) E, and likewise of Ē.
  [[gnu::always_inline]] void findPair(int i, int j) {
    const double* c = of_.own + Terms::coupling(i, j, n_);
    const Pack cx(c[0]), cy(c[1]), two(2);
    const double *x = e(pair(i, j), 0), *y = e(pair(i, j), 1);
    double* across = slope(pair(i, j), 0);  // Im(c E), in place of what nobody needs any more
    forOrders([&](int k) {
      const Pack mass = mulAdd(cx, Pack::load(x + k), -(cy * Pack::load(y + k)));
      mass.store(matrix(0, i, j) + k);
      mass.store(matrix(0, j, i) + k);
      mulAdd(cx, Pack::load(y + k), cy * Pack::load(x + k)).store(across + k);
    });
    for (int k = 0; k < of_.order; k += laneCount) {
      Pack dampingI, dampingJ, xi, yi, xj, yj, squareXi, squareYi, squareXj, squareYj;
      for (int m = 0; m < k + laneCount; ++m) {
        const Pack ex = Pack::load(x + k - m), ey = Pack::load(y + k - m), z = Pack::load(across + k - m);
        const Pack ai(acceleration(i)[m]), aj(acceleration(j)[m]), si(square(i)[m]), sj(square(j)[m]);
        dampingI = mulAdd(Pack(turn(i)[m]), z, dampingI);
        dampingJ = mulAdd(Pack(turn(j)[m]), z, dampingJ);
        xi = mulAdd(ai, ex, xi);
        yi = mulAdd(ai, ey, yi);
        xj = mulAdd(aj, ex, xj);
        yj = mulAdd(aj, ey, yj);
        squareXi = mulAdd(si, ex, squareXi);
        squareYi = mulAdd(si, ey, squareYi);
        squareXj = mulAdd(sj, ex, squareXj);
        squareYj = mulAdd(sj, ey, squareYj);
      }
      (two * dampingI).store(matrix(1, j, i) + k);
      (-(two * dampingJ)).store(matrix(1, i, j) + k);
      store(i, j, k, mulAdd(cx, -(yj + squareXj), -(cy * (xj - squareYj))), -(yj + squareXj), xj - squareYj);
      store(j, i, k, mulAdd(cx, yi - squareXi, cy * (xi + squareYi)), yi - squareXi, xi + squareYi);
    }
  }
  /// Re(c_ij ē_i F_j), and both parts of ē_i F_j.
  [[gnu::always_inline]] void store(int i, int j, int k, Pack force, Pack x, Pack y) const {
    x.store(product(i, j, 0) + k);
    y.store(product(i, j, 1) + k);
    (isPrismatic(j) ? Pack() : force).store(matrix(2, i, j) + k);
    if (isPrismatic(i)) return;
    double* stiffness = matrix(2, i, i) + k;
    (Pack::load(stiffness) - force).store(stiffness);
  }

  /// The factor of order m of the columns in order k is a polynomial of k + 2: with l = k + 2 − m,
  ///
  ///     m(m−1) M_l + m D_{l−1} + K_{l−2} = (k+2)² M_l + (k+2) (D_{l−1} − (2l+1) M_l) + K_{l−2} − l D_{l−1} +
  ///     l(l+1) M_l
  void prepareFactor(int i, int j) const {
    const double *M = matrix(0, i, j), *D = matrix(1, i, j), *K = matrix(2, i, j);
    for (int at = 0; at <= orders_; at += laneCount) {
      const Pack m = Pack::load(M + at), d = Pack::load(D + at - 1), k = Pack::load(K + at - 2);
      const Pack next = Pack::load(following() + at), l = next - Pack(1);
      (d - (l + next) * m).store(linear(i, j) + at);
      mulAdd(l, mulAdd(next, m, -d), k).store(constant(i, j) + at);
    }
  }

  // ---- What moves the columns besides -------------------------------------------------------------------

  double* columnsOf(int order, int i) const {
    return of_.columns + (static_cast<std::ptrdiff_t>(order) * n_ + i) * of_.width;
  }
  double* sourcesOf(int order, int i) const {
    return of_.sources + (static_cast<std::ptrdiff_t>(order) * n_ + i) * of_.width;
  }

  void findSources() {
    for (int p = 0; p < of_.numbers; ++p) {
      const double* change = of_.changes + static_cast<std::ptrdiff_t>(p) * Terms::count(n_);
      for (int i = 0; i < n_; ++i) findSource(change, i);
      for (int i = n_ - 2; i >= of_.leading; --i) addSeries(source(i + 1), source(i));
      for (int i = 0; i < n_; ++i) {
        const double* joint = change + Terms::joint(i, n_);
        const bool changes = joint[0] != 0 || joint[1] != 0 || joint[2] != 0;
        const int inner = i > of_.leading ? i - 1 : i;
        for (int k = 0; k < of_.order; ++k) {
          const double* c = c_ + 2 * n_ * k;
          const auto relative = [&](const double* x) { return inner < i ? x[i] - x[inner] : x[i]; };
          double sum = source(i)[k];
          if (changes) {
            sum -= joint[0] * (k + 1) * relative(c + 3 * n_) + joint[1] * relative(c + n_) +
                   joint[2] * relative(c);
          }
          sourcesOf(k, i)[of_.firstNumber + p] = sum;
        }
        sourcesOf(0, i)[of_.firstNumber + p] += joint[3];
      }
    }
  }
  void findSource(const double* change, int i) {
    const double* weight = change + Terms::weight(i, n_);
    const Pack J(-change[Terms::inertia(i)]), Gx(weight[0]), Gy(weight[1]);
    forOrders([&](int k) {
      Pack sum = J * Pack::load(acceleration(i) + k);
      sum = mulAdd(Gy, Pack::load(e(i, 0) + k), sum) - Gx * Pack::load(e(i, 1) + k);
      sum.store(source(i) + k);
    });
    for (int j = 0; j < n_; ++j) {
      if (j == i) continue;
      const double* c = change + Terms::coupling(i, j, n_);
      const Pack cx(-c[0]), cy(i < j ? -c[1] : c[1]);
      forOrders([&](int k) {
        const Pack sum = mulAdd(cx, Pack::load(product(i, j, 1) + k), Pack::load(source(i) + k));
        mulAdd(cy, Pack::load(product(i, j, 0) + k), sum).store(source(i) + k);
      });
    }
  }

  // ---- Order by order -----------------------------------------------------------------------------------

  /// By Gauss and Jordan. Of prescribed joints the rows and columns are 0.
  void invertMasses() {
    double* inverse = of_.inverse;
    const auto isFree = [&](int i) { return of_.free[i] != 0; };
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j)
        inverse[i * n_ + j] = isFree(i) && isFree(j) ? matrix(0, i, j)[0] : i == j ? 1.0 : 0.0;
    }
    for (int p = 0; p < n_; ++p) {
      const double pivot = 1 / inverse[p * n_ + p];
      inverse[p * n_ + p] = 1;
      for (int j = 0; j < n_; ++j) inverse[p * n_ + j] *= pivot;
      for (int i = 0; i < n_; ++i) {
        if (i == p) continue;
        const double share = inverse[i * n_ + p];
        inverse[i * n_ + p] = 0;
        for (int j = 0; j < n_; ++j) inverse[i * n_ + j] -= share * inverse[p * n_ + j];
      }
    }
    for (int i = 0; i < n_; ++i) {
      if (!isFree(i)) inverse[i * n_ + i] = 0;
    }
  }

  /// Number l: the factor of order k + 2 − l of the columns.
  void findFactors(int k) {
    const Pack top(k + 2);
    for (int i = 0; i < n_; ++i) {
      for (int j = 0; j < n_; ++j) {
        const double *M = matrix(0, i, j), *D = linear(i, j), *K = constant(i, j);
        double* to = factor(i, j);
        for (int l = 0; l < k + 3; l += laneCount) {
          const Pack rates = mulAdd(top, Pack::load(M + l), Pack::load(D + l));
          mulAdd(top, rates, Pack::load(K + l)).store(to + l);
        }
      }
    }
  }

  template <int fixed, int packs>
  [[gnu::always_inline]] void findOrder(int k, int at) {
    const int n = fixed > 0 ? fixed : n_;
    constexpr int most = fixed > 0 ? fixed : ColumnArrays::most;
    constexpr int rows = fixed > 0 ? fixed : 1;  // at once
    Pack left[most][packs];
    for (int first = 0; first < n; first += rows) {
      Pack sums[2][rows][packs];
      const auto add = [&](int m, auto& sum) {
        PLANAR_CHAIN_WRITTEN_OUT
        for (int j = 0; j < n; ++j) {
          const double* column = columnsOf(m, j) + at;
          Pack u[packs];
          for (int p = 0; p < packs; ++p) u[p] = Pack::load(column + p * laneCount);
          PLANAR_CHAIN_WRITTEN_OUT
          for (int i = 0; i < rows; ++i) {
            const Pack by(factor(first + i, j)[k + 2 - m]);
            PLANAR_CHAIN_WRITTEN_OUT
            for (int p = 0; p < packs; ++p) sum[i][p] = mulAdd(by, u[p], sum[i][p]);
          }
        }
      };
      int m = 0;
      for (; m < k + 1; m += 2) {
        add(m, sums[0]);
        add(m + 1, sums[1]);
      }
      if (m < k + 2) add(m, sums[0]);
      for (int i = 0; i < rows; ++i) {
        for (int p = 0; p < packs; ++p)
          left[first + i][p] =
              Pack::load(sourcesOf(k, first + i) + at + p * laneCount) - (sums[0][i][p] + sums[1][i][p]);
      }
    }
    const double share = of_.inverses[k + 1] * of_.inverses[k + 2];
    for (int i = 0; i < n; ++i) {
      for (int p = 0; p < packs; ++p) {
        Pack sum;
        PLANAR_CHAIN_WRITTEN_OUT
        for (int j = 0; j < n; ++j) sum = mulAdd(Pack(of_.inverse[i * n + j]), left[j][p], sum);
        (Pack(share) * sum).store(columnsOf(k + 2, i) + at + p * laneCount);
      }
    }
  }

  const ColumnArrays& of_;
  const double* c_;
  const int n_, orders_;
};

PLANAR_CHAIN_IN_ONE_PIECE void columnSeries(const ColumnArrays& of, const double* c) {
  Columns columns(of, c);
  if (of.n == 1) return columns.find<1>();
  if (of.n == 2) return columns.find<2>();
  columns.find<0>();
}

/// Horner's rule, and the last terms for the error.
PLANAR_CHAIN_IN_ONE_PIECE double columnsAt(const ColumnArrays& of, double h, const double* weights,
                                           double* to) {
  const int top = of.order + 1;
  const std::ptrdiff_t row = of.n * of.width;
  double worst = 0;
  for (int at = 0; at < of.width; at += laneCount) {
    Pack most, size(1e-300);
    for (int i = 0; i < of.n; ++i) {
      const double* first = of.columns + i * of.width + at;
      Pack value, rate, tail, rateTail;
      for (int m = top; m > 0; --m) {
        const Pack term = Pack::load(first + m * row);
        value = mulAdd(value, Pack(h), term);
        rate = mulAdd(rate, Pack(h), Pack(m) * term);
      }
      const Pack begin = Pack::load(first), beginRate = Pack::load(first + row);
      value = mulAdd(value, Pack(h), begin);
      PLANAR_CHAIN_WRITTEN_OUT
      for (int j = 0; j < ColumnArrays::tail; ++j) {
        const Pack term = absolute(Pack::load(first + (top - j) * row)) * Pack(weights[j]);
        tail = mulAdd(term, Pack(h), tail);
        rateTail = mulAdd(term, Pack(top - j), rateTail);
      }
      most = larger(most, larger(tail, rateTail));
      size = larger(size, larger(absolute(begin), absolute(beginRate)));
      size = larger(size, larger(absolute(value), absolute(rate)));
      size = larger(size, absolute(Pack::load(first + 2 * row)));
      value.store(to + i * of.width + at);
      rate.store(to + row + i * of.width + at);
    }
    const Pack ratio = most / size;
    for (int s = 0; s < laneCount; ++s) worst = ratio.v[s] > worst ? ratio.v[s] : worst;
  }
  return worst;
}

constexpr ColumnKernel columnKernel{laneCount, columnSeries, columnsAt, rotations};

}  // namespace
}  // namespace planar_chain::simd
