#include "lanes/linearized_segments.h"

#include <vector>

#include "lanes/kernel.h"
#include "lanes/segments.h"

namespace planar_chain {

namespace {

using simd::LinearArrays;
constexpr int most = simd::mostLanes;

/// Doubles a number.
template <class Scalar>
constexpr int parts = sizeof(Scalar) / sizeof(double);

template <int count>
constexpr int quantities(simd::Steps<count> LinearArrays::* /*member*/) {
  return count;
}

/// True if all that a solve reads stays in a cache of its own.
bool keepsAll(Kept kept, int places, int parts) {
  if (kept != Kept::whatFits) return kept == Kept::all;
  constexpr std::size_t cache = 2 << 20;
  constexpr int ofNumbers = quantities(&LinearArrays::inward) + quantities(&LinearArrays::handles) +
                            quantities(&LinearArrays::outward) + quantities(&LinearArrays::sweeps) +
                            LinearArrays::sideQuantities;
  const int numbers = quantities(&LinearArrays::state) + ofNumbers * parts;
  return static_cast<std::size_t>(places) * static_cast<std::size_t>(numbers) * sizeof(double) <= cache;
}

template <class Scalar>
const simd::LinearKernel& solverFor(const simd::Kernel& kernel, bool keepsAll) {
  if (parts<Scalar> == 1) return keepsAll ? kernel.real : kernel.realAgain;
  return keepsAll ? kernel.complex : kernel.complexAgain;
}

/// Real parts, each followed by its imaginary part.
template <class Scalar>
const double* partsOf(const Scalar* values) {
  return reinterpret_cast<const double*>(values);
}
template <class Scalar>
double* partsOf(Scalar* values) {
  return reinterpret_cast<double*>(values);
}

}  // namespace

template <class Scalar>
LinearizedSegments<Scalar>::LinearizedSegments(const Chain& chain, const simd::Kernel* kernel, Kept kept)
    : chain_(chain),
      kernel_(kernel ? *kernel : simd::kernelFor(chain.size())),
      arrangement_(chain.size(), kernel),
      keepsAll_(keepsAll(kept, arrangement_.places(), parts<Scalar>)),
      solver_(solverFor<Scalar>(kernel_, keepsAll_)),
      state_(std::make_shared<SegmentsState>()) {
  const auto places = static_cast<std::size_t>(arrangement_.places());
  state_->links = linksArranged(chain, arrangement_);
  state_->bodies = CacheLines(places * quantities(&LinearArrays::state));
  state_->masses = CacheLines(places * quantities(&LinearArrays::masses));
  const std::vector<double> none(places);
  setJoints(none.data(), none.data());
  reserve();
}

template <class Scalar>
template <class Other>
LinearizedSegments<Scalar>::LinearizedSegments(const LinearizedSegments<Other>& other, Kept kept)
    : chain_(other.chain_),
      kernel_(other.kernel_),
      arrangement_(other.arrangement_),
      keepsAll_(keepsAll(kept, arrangement_.places(), parts<Scalar>)),
      solver_(solverFor<Scalar>(kernel_, keepsAll_)),
      state_(other.state_) {
  reserve();
}

template <class Scalar>
void LinearizedSegments<Scalar>::reserve() {
  const auto places = static_cast<std::size_t>(arrangement_.places() * parts<Scalar>);
  inward_ = CacheLines(keepsAll_ ? places * quantities(&LinearArrays::inward) : 0);
  handles_ = CacheLines(places * quantities(&LinearArrays::handles));
  outward_ = CacheLines(places * quantities(&LinearArrays::outward));
  sweeps_ = CacheLines(places);
  int rounds = 0;
  while (1 << rounds < kernel_.lanes) ++rounds;
  pairs_ = CacheLines(static_cast<std::size_t>(rounds * kernel_.lanes * parts<Scalar>) *
                      LinearArrays::pairQuantities);
}

template <class Scalar>
simd::LinearArrays LinearizedSegments<Scalar>::arrays() {
  return {arrangement_.steps(),    state_->links.data(), {state_->bodies.data()},
          {state_->masses.data()}, {inward_.data()},     {handles_.data()},
          {outward_.data()},       {sweeps_.data()},     pairs_.data()};
}

template <class Scalar>
void LinearizedSegments<Scalar>::setJoints(const double* k, const double* d) {
  const auto lanes = static_cast<std::ptrdiff_t>(kernel_.lanes);
  for (int place = 0; place < arrangement_.places(); ++place) {
    double* joint =
        state_->bodies.data() + place / lanes * quantities(&LinearArrays::state) * lanes + place % lanes;
    joint[0] = k[place];
    joint[lanes] = d[place];
  }
}

template <class Scalar>
void LinearizedSegments<Scalar>::linearize(const Rotation<double>* e, const double* omega,
                                           const double* alpha, const Vec2d* F, const double* XF) {
  const simd::LinearState at{&e->c, omega, alpha, F ? &F->x : nullptr, XF};
  double sums[5][most], starts[4][most];
  kernel_.linearizeOutwards(arrays(), at, sums);
  Vec2d a = -1.0 * chain_.gravity();
  for (int s = 0; s < kernel_.lanes; ++s) {
    starts[0][s] = a.x;
    starts[1][s] = a.y;
    a += Vec2d{sums[0][s], sums[1][s]};
  }
  Vec2d outer;
  for (int s = kernel_.lanes - 1; s >= 0; --s) {
    starts[2][s] = outer.x;
    starts[3][s] = outer.y;
    outer += Vec2d{sums[2][s], sums[3][s]} + sums[4][s] * Vec2d{starts[0][s], starts[1][s]};
  }
  kernel_.linearizeInwards(arrays(), at, starts);
}

template <class Scalar>
void LinearizedSegments<Scalar>::factor(Scalar s) {
  s_ = s;
  solver_.factor(arrays(), partsOf(&s_));
}

template <class Scalar>
void LinearizedSegments<Scalar>::solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
  solver_.solve(arrays(), partsOf(&s_), partsOf(rhoQ), partsOf(rhoV), partsOf(u), partsOf(v));
}

template class LinearizedSegments<double>;
template class LinearizedSegments<std::complex<double>>;
template LinearizedSegments<double>::LinearizedSegments(const LinearizedSegments<double>&, Kept);
template LinearizedSegments<std::complex<double>>::LinearizedSegments(const LinearizedSegments<double>&,
                                                                      Kept);

}  // namespace planar_chain
