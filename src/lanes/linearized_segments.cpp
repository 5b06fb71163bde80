#include "lanes/linearized_segments.h"

#include <utility>

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
bool keepsAll(Kept kept, int paddedSize, int parts) {
  if (kept != Kept::whatFits) return kept == Kept::all;
  constexpr std::size_t cache = 2 << 20;
  constexpr int ofNumbers = quantities(&LinearArrays::inward) + quantities(&LinearArrays::factors) +
                            quantities(&LinearArrays::outward) + quantities(&LinearArrays::sweeps) +
                            LinearArrays::sideQuantities;
  const int numbers = quantities(&LinearArrays::state) + ofNumbers * parts;
  return static_cast<std::size_t>(paddedSize) * static_cast<std::size_t>(numbers) * sizeof(double) <= cache;
}

template <class Scalar>
const simd::LinearKernel& solverFor(const simd::LinearKernels& kernel, bool keepsAll) {
  if (parts<Scalar> == 1) return keepsAll ? kernel.real : kernel.realAgain;
  return keepsAll ? kernel.complex : kernel.complexAgain;
}

}  // namespace

template <class Scalar>
LinearizedSegments<Scalar>::LinearizedSegments(const Chain& chain, bool inSegments,
                                               const simd::Kernel& kernel, Kept kept)
    : LinearizedSegments(chain, inSegments ? kernel.inSegments : kernel.linkByLink,
                         LaneOrder(chain.size(), inSegments ? kernel.lanes : 1), nullptr, kept) {}

template <class Scalar>
LinearizedSegments<Scalar>::LinearizedSegments(const Chain& chain, const simd::LinearKernels& kernels,
                                               const LaneOrder& laneOrder,
                                               std::shared_ptr<SegmentsState> state, Kept kept)
    : chain_(chain), kernels_(kernels), laneOrder_(laneOrder), state_(std::move(state)) {
  const int lanes = laneOrder_.lanes(), ofAll = laneOrder_.paddedSize();
  const bool all = keepsAll(kept, ofAll, parts<Scalar>);
  solver_ = &solverFor<Scalar>(kernels_, all);
  if (!state_) {
    const auto paddedSize = static_cast<std::size_t>(ofAll);
    state_ = std::make_shared<SegmentsState>(SegmentsState{
        linksInLaneOrder(chain, laneOrder_), CacheLines(paddedSize * quantities(&LinearArrays::state)),
        CacheLines(paddedSize * quantities(&LinearArrays::masses))});
  }
  const auto paddedSize = static_cast<std::size_t>(ofAll * parts<Scalar>);
  inward_ = CacheLines(all ? paddedSize * quantities(&LinearArrays::inward) : 0);
  factors_ = CacheLines(paddedSize * quantities(&LinearArrays::factors));
  outward_ = CacheLines(lanes > 1 ? paddedSize * quantities(&LinearArrays::outward) : 0);
  sweeps_ = CacheLines(paddedSize);
  pairs_ = CacheLines(index(laneOrder_.rounds() * lanes * parts<Scalar> * simd::pairQuantities));
  arrays_ = {laneOrder_.steps(),      state_->links.data(), {state_->bodies.data()},
             {state_->masses.data()}, {inward_.data()},     {factors_.data()},
             {outward_.data()},       {sweeps_.data()},     pairs_.data()};
}

template <class Scalar>
void LinearizedSegments<Scalar>::setJoints(const double* k, const double* d) {
  const auto lanes = static_cast<std::ptrdiff_t>(laneOrder_.lanes());
  for (int laneIndex = 0; laneIndex < laneOrder_.paddedSize(); ++laneIndex) {
    double* joint = state_->bodies.data() + laneIndex / lanes * quantities(&LinearArrays::state) * lanes +
                    laneIndex % lanes;
    joint[0] = k[laneIndex];
    joint[lanes] = d[laneIndex];
  }
}

template <class Scalar>
void LinearizedSegments<Scalar>::linearize(const Rotation<double>* e, const double* omega,
                                           const double* alpha, const Vec2d* F, const double* XF) {
  kernels_.linearize(arrays_, {&e->c, omega, alpha, F ? &F->x : nullptr, XF}, -1.0 * chain_.gravity());
}

template <class Scalar>
void LinearizedSegments<Scalar>::factor(Scalar s) {
  s_ = s;
  solver_->factor(arrays_, reinterpret_cast<const double*>(&s_));
}

template <class Scalar>
void LinearizedSegments<Scalar>::solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
  const auto in = [](const Scalar* values) { return reinterpret_cast<const double*>(values); };
  const auto out = [](Scalar* values) { return reinterpret_cast<double*>(values); };
  solver_->solve(arrays_, in(&s_), in(rhoQ), in(rhoV), out(u), out(v));
}

template class LinearizedSegments<double>;
template class LinearizedSegments<std::complex<double>>;

}  // namespace planar_chain
