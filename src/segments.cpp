#include "planar_chain/segments.h"

#include "simd/kernel.h"

namespace planar_chain {

namespace {

constexpr std::size_t linkQuantities = simd::SegmentArrays::linkQuantities;
constexpr std::size_t handleQuantities = 8;

/// A 2×2 matrix without symmetry.
struct Matrix {
  double xx = 0, xy = 0, yx = 0, yy = 0;
};

Matrix operator*(const Matrix& A, const Matrix& B) {
  return {A.xx * B.xx + A.xy * B.yx, A.xx * B.xy + A.xy * B.yy, A.yx * B.xx + A.yy * B.yx,
          A.yx * B.xy + A.yy * B.yy};
}

Vec2d operator*(const Matrix& A, Vec2d a) {
  return {A.xx * a.x + A.xy * a.y, A.yx * a.x + A.yy * a.y};
}

Matrix whole(const Sym2<double>& A) {
  return {A.xx, A.xy, A.xy, A.yy};
}

Matrix transposed(const Matrix& A) {
  return {A.xx, A.yx, A.xy, A.yy};
}

/// (1 + B)⁻¹
Matrix inverseOfOnePlus(const Matrix& B) {
  const double inverse = 1 / ((1 + B.xx) * (1 + B.yy) - B.xy * B.yx);
  return {(1 + B.yy) * inverse, -B.xy * inverse, -B.yx * inverse, (1 + B.xx) * inverse};
}

}  // namespace

void rotations(const double* theta, Rotation<double>* e, int n) {
  static_assert(sizeof(Rotation<double>) == 2 * sizeof(double));
  static const auto run = simd::kernels().front()->rotations;
  run(theta, &e->c, n);
}

bool Segments::areWorthwhile(int n) {
  constexpr int leastLinks = 16;
  constexpr int leastLanes = 4;
  return n >= leastLinks && simd::kernels().front()->lanes >= leastLanes;
}

namespace {

/// bodyIn(s, i, steps): the number of the body in lane s of step i.
template <class BodyIn>
CacheLines linksWith(const Chain& chain, int lanes_, BodyIn bodyIn) {
  const auto lanes = static_cast<std::size_t>(lanes_);
  const std::vector<Link>& all = chain.links();
  const std::size_t steps = (all.size() + lanes - 1) / lanes;
  CacheLines links(steps * lanes * linkQuantities);
  for (std::size_t s = 0; s < lanes; ++s) {
    for (std::size_t i = 0; i < steps; ++i) {
      const std::size_t j = bodyIn(s, i, steps);
      double* to = links.data() + i * linkQuantities * lanes + s;
      to[lanes] = 1;  // I of a body beyond the end, which has no more
      if (j >= all.size()) continue;
      const Link& link = all[j];
      to[0] = link.mass;
      to[lanes] = link.inertia;
      to[2 * lanes] = link.com.x;
      to[3 * lanes] = link.com.y;
      to[4 * lanes] = link.pin.x;
      to[5 * lanes] = link.pin.y;
    }
  }
  return links;
}

}  // namespace

CacheLines linksInLanes(const Chain& chain, int lanes) {
  return linksWith(chain, lanes,
                   [](std::size_t s, std::size_t i, std::size_t steps) { return s * steps + i; });
}

CacheLines linksInBlocks(const Chain& chain, int lanes) {
  return linksWith(chain, lanes, [lanes](std::size_t s, std::size_t i, std::size_t) {
    return i * static_cast<std::size_t>(lanes) + s;
  });
}

Segments::Segments(const Chain& chain, const simd::Kernel* kernel)
    : kernel_(kernel ? *kernel : simd::kernelFor(chain.size())),
      n_(chain.size()),
      steps_((n_ + kernel_.lanes - 1) / kernel_.lanes),
      links_(linksInLanes(chain, kernel_.lanes)),
      handles_(static_cast<std::size_t>(steps_ * kernel_.lanes) * handleQuantities) {}

std::string Segments::name() const {
  return "in " + std::to_string(kernel_.lanes) + " segments side by side (" + kernel_.name + ")";
}

void Segments::accelerations(const Rotation<double>* e, const double* omega, const double* N, const Vec2d* F,
                             Vec2d ground, double* alpha) {
  constexpr int most = simd::SegmentHandles::most;
  const simd::SegmentArrays arrays{steps_, n_, links_.data(), handles_.data()};
  simd::SegmentHandles h;
  kernel_.inwards(arrays, &e->c, omega, N, F ? &F->x : nullptr, h);

  // Joined from the tip, outside of which there is nothing.
  const int last = kernel_.lanes - 1;
  Matrix outerA = whole({h.A[0][last], h.A[1][last], h.A[2][last]});
  Vec2d outerb{h.b[0][last], h.b[1][last]};
  Matrix KA[most];
  Vec2d Kb[most];
  for (int s = last - 1; s >= 0; --s) {
    const Matrix G{h.G[0][s], h.G[1][s], h.G[2][s], h.G[3][s]};
    const Matrix C = whole({h.C[0][s], h.C[1][s], h.C[2][s]});
    const Matrix A = whole({h.A[0][s], h.A[1][s], h.A[2][s]});
    const Vec2d c{h.c[0][s], h.c[1][s]};
    const Matrix frame{h.d[0][s], -h.d[1][s], h.d[1][s], h.d[0][s]};
    const Matrix A_ = transposed(frame) * outerA * frame;
    const Matrix K = inverseOfOnePlus(A_ * C);
    KA[s] = K * A_;
    Kb[s] = KA[s] * c + K * (transposed(frame) * outerb);
    const Matrix added = G * KA[s] * transposed(G);
    outerA = {A.xx + added.xx, A.xy + added.xy, A.yx + added.yx, A.yy + added.yy};
    outerb = Vec2d{h.b[0][s], h.b[1][s]} + G * Kb[s];
  }

  // Gone through from the ground.
  double a[2][most], f[2][most];
  Vec2d at = ground;
  for (int s = 0; s < kernel_.lanes; ++s) {
    const Matrix G{h.G[0][s], h.G[1][s], h.G[2][s], h.G[3][s]};
    const Matrix C = whole({h.C[0][s], h.C[1][s], h.C[2][s]});
    const Vec2d carried = transposed(G) * at;
    const Vec2d force = KA[s] * carried + Kb[s];
    a[0][s] = at.x;
    a[1][s] = at.y;
    f[0][s] = force.x;
    f[1][s] = force.y;
    const Rotation<double> frame{h.d[0][s], h.d[1][s]};
    at = frame * (carried - C * force + Vec2d{h.c[0][s], h.c[1][s]});
  }
  kernel_.outwards(arrays, a, f, alpha);
}

}  // namespace planar_chain
