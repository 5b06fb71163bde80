#include "lanes/linearized_segments.h"

#include <utility>

#include "lanes/kernel.h"
#include "lanes/segments.h"

namespace planar_chain {

namespace {

using simd::LinearArrays;

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

}  // namespace

template <class Scalar>
LinearizedSegments<Scalar>::LinearizedSegments(const Chain& chain, const simd::Kernel* kernel, Kept kept)
    : LinearizedSegments(chain, kernel ? *kernel : simd::kernelFor(chain.size()),
                         Arrangement(chain.size(), kernel), std::make_shared<SegmentsState>(), kept) {
  const auto places = static_cast<std::size_t>(arrangement_.places());
  state_->links = linksArranged(chain, arrangement_);
  state_->bodies = CacheLines(places * quantities(&LinearArrays::state));
  state_->masses = CacheLines(places * quantities(&LinearArrays::masses));
}

template <class Scalar>
LinearizedSegments<Scalar>::LinearizedSegments(const Chain& chain, const simd::Kernel& kernel,
                                               const Arrangement& arrangement,
                                               std::shared_ptr<SegmentsState> state, Kept kept)
    : chain_(chain), kernel_(kernel), arrangement_(arrangement), state_(std::move(state)) {
  const bool all = keepsAll(kept, arrangement_.places(), parts<Scalar>);
  solver_ = &solverFor<Scalar>(kernel_, all);
  const auto places = static_cast<std::size_t>(arrangement_.places() * parts<Scalar>);
  inward_ = CacheLines(all ? places * quantities(&LinearArrays::inward) : 0);
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
  kernel_.linearize(arrays(), {&e->c, omega, alpha, F ? &F->x : nullptr, XF}, -1.0 * chain_.gravity());
}

template <class Scalar>
void LinearizedSegments<Scalar>::factor(Scalar s) {
  s_ = s;
  solver_->factor(arrays(), reinterpret_cast<const double*>(&s_));
}

template <class Scalar>
void LinearizedSegments<Scalar>::solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
  const auto in = [](const Scalar* values) { return reinterpret_cast<const double*>(values); };
  const auto out = [](Scalar* values) { return reinterpret_cast<double*>(values); };
  solver_->solve(arrays(), in(&s_), in(rhoQ), in(rhoV), out(u), out(v));
}

template class LinearizedSegments<double>;
template class LinearizedSegments<std::complex<double>>;

}  // namespace planar_chain
