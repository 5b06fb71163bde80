#include "planar_chain/linearized_segments.h"

#include <Eigen/LU>

#include "planar_chain/segments.h"
#include "simd/kernel.h"

namespace planar_chain {

namespace {

using simd::LinearArrays;
constexpr int most = simd::mostLanes;
constexpr int joined = 9;  // elements of one of the four matrices that a segment shows

const simd::LinearKernel& solverFor(const simd::Kernel& kernel, double) {
  return kernel.real;
}
const simd::LinearKernel& solverFor(const simd::Kernel& kernel, std::complex<double>) {
  return kernel.complex;
}

/// Doubles a number.
template <class Scalar>
constexpr int parts = sizeof(Scalar) / sizeof(double);

const double* partsOf(const double* values) {
  return values;
}
const double* partsOf(const std::complex<double>* values) {
  return reinterpret_cast<const double*>(values);
}
double* partsOf(double* values) {
  return values;
}
double* partsOf(std::complex<double>* values) {
  return reinterpret_cast<double*>(values);
}

/// Quantity q of segment s in rows.
template <class Scalar>
Scalar element(const double (*rows)[most], int q, int s) {
  if constexpr (parts<Scalar> == 1) {
    return rows[q][s];
  } else {
    return {rows[2 * q][s], rows[2 * q + 1][s]};
  }
}

template <class Scalar>
void setElement(double (*rows)[most], int q, int s, Scalar value) {
  for (int k = 0; k < parts<Scalar>; ++k) rows[q * parts<Scalar> + k][s] = partsOf(&value)[k];
}

template <class Matrix>
Matrix matrixFrom(const double (*rows)[most], int first, int s) {
  Matrix matrix;
  int q = first;
  for (int i = 0; i < matrix.rows(); ++i) {
    for (int j = 0; j < matrix.cols(); ++j) matrix(i, j) = element<typename Matrix::Scalar>(rows, q++, s);
  }
  return matrix;
}

}  // namespace

template <class Scalar>
LinearizedSegments<Scalar>::LinearizedSegments(const Chain& chain, const simd::Kernel* kernel)
    : chain_(chain),
      kernel_(kernel ? *kernel : simd::kernelFor(chain.size())),
      solver_(solverFor(kernel_, Scalar())),
      n_(chain.size()),
      steps_((n_ + kernel_.lanes - 1) / kernel_.lanes),
      state_(std::make_shared<SegmentsState>()) {
  const auto places = static_cast<std::size_t>(steps_ * kernel_.lanes);
  state_->links = linksInLanes(chain, kernel_.lanes);
  state_->joints = CacheLines(places * LinearArrays::jointQuantities);
  state_->bodies = CacheLines(places * LinearArrays::stateQuantities);
  state_->frames.resize(static_cast<std::size_t>(kernel_.lanes));
  const std::vector<double> none(static_cast<std::size_t>(n_));
  setJoints(none.data(), none.data());
  reserve();
}

template <class Scalar>
template <class Other>
LinearizedSegments<Scalar>::LinearizedSegments(const LinearizedSegments<Other>& other)
    : chain_(other.chain_),
      kernel_(other.kernel_),
      solver_(solverFor(kernel_, Scalar())),
      n_(other.n_),
      steps_(other.steps_),
      state_(other.state_) {
  reserve();
}

template <class Scalar>
bool LinearizedSegments<Scalar>::areWorthwhile(int n) {
  constexpr int leastLinks = 48;  // the segments must be worth joining
  return n >= leastLinks && Segments::areWorthwhile(n);
}

template <class Scalar>
void LinearizedSegments<Scalar>::reserve() {
  const auto places = static_cast<std::size_t>(steps_ * kernel_.lanes * parts<Scalar>);
  inward_ = CacheLines(places * LinearArrays::inwardQuantities);
  handles_ = CacheLines(places * LinearArrays::handleQuantities);
  outward_ = CacheLines(places * LinearArrays::outwardQuantities);
  sweeps_ = CacheLines(places * LinearArrays::sweepQuantities);
  joined_.resize(static_cast<std::size_t>(kernel_.lanes));
}

template <class Scalar>
simd::LinearArrays LinearizedSegments<Scalar>::arrays() {
  return {steps_,
          n_,
          state_->links.data(),
          state_->joints.data(),
          state_->bodies.data(),
          inward_.data(),
          handles_.data(),
          outward_.data(),
          sweeps_.data()};
}

template <class Scalar>
void LinearizedSegments<Scalar>::setJoints(const double* k, const double* d) {
  const auto lanes = static_cast<std::ptrdiff_t>(kernel_.lanes);
  for (int place = 0; place < steps_ * kernel_.lanes; ++place) {
    const int i = place / kernel_.lanes, lane = place % kernel_.lanes, j = lane * steps_ + i;
    double* joint = state_->joints.data() + i * LinearArrays::jointQuantities * lanes + lane;
    joint[0] = state_->links.data()[i * simd::SegmentArrays::linkQuantities * lanes + lane];
    joint[lanes] = j < n_ ? k[j] : 0;
    joint[2 * lanes] = j < n_ ? d[j] : 0;
  }
}

template <class Scalar>
void LinearizedSegments<Scalar>::linearize(const Rotation<double>* e, const double* omega,
                                           const double* alpha, const Vec2d* F, const double* XF) {
  const simd::LinearState at{&e->c, omega, alpha, F ? &F->x : nullptr, XF};
  double sums[7][most], starts[4][most];
  kernel_.linearizeOutwards(arrays(), at, sums);
  Vec2d a = -1.0 * chain_.gravity();
  for (int s = 0; s < kernel_.lanes; ++s) {
    starts[0][s] = a.x;
    starts[1][s] = a.y;
    state_->frames[static_cast<std::size_t>(s)] = {sums[5][s], sums[6][s]};
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
  double shown[4 * joined * parts<Scalar>][most];
  solver_.factor(arrays(), partsOf(&s), shown);
  Matrix K = Matrix::Zero();
  for (int lane = kernel_.lanes - 1; lane >= 0; --lane) {
    Joined& segment = joined_[static_cast<std::size_t>(lane)];
    const Rotation<double> d = state_->frames[static_cast<std::size_t>(lane)];
    segment.frame << d.c, -d.s, 0, d.s, d.c, 0, 0, 0, 1;
    segment.H = matrixFrom<Matrix>(shown, joined, lane);
    segment.G = matrixFrom<Matrix>(shown, 2 * joined, lane);
    segment.C = matrixFrom<Matrix>(shown, 3 * joined, lane);
    K = segment.frame.transpose() * K * segment.frame;
    segment.S = (Matrix::Identity() + K * segment.C).inverse();
    segment.SK = segment.S * K;
    K = matrixFrom<Matrix>(shown, 0, lane) + segment.G * segment.SK * segment.H;
  }
}

template <class Scalar>
void LinearizedSegments<Scalar>::solve(const Scalar* rhoQ, const Scalar* rhoV, Scalar* u, Scalar* v) {
  double shown[6 * parts<Scalar>][most], ends[6 * parts<Scalar>][most];
  solver_.inwards(arrays(), partsOf(&s_), partsOf(rhoQ), partsOf(rhoV), shown);
  Vector y = Vector::Zero();
  for (int lane = kernel_.lanes - 1; lane >= 0; --lane) {
    Joined& segment = joined_[static_cast<std::size_t>(lane)];
    segment.c = matrixFrom<Vector>(shown, 3, lane);
    segment.y = segment.SK * segment.c + segment.S * (segment.frame.transpose() * y);
    y = matrixFrom<Vector>(shown, 0, lane) + segment.G * segment.y;
  }
  Vector X = Vector::Zero();
  for (int lane = 0; lane < kernel_.lanes; ++lane) {
    const Joined& segment = joined_[static_cast<std::size_t>(lane)];
    const Vector carried = segment.H * X;
    const Vector Y = segment.SK * carried + segment.y;
    for (int q = 0; q < 3; ++q) {
      setElement<Scalar>(ends, q, lane, X[q]);
      setElement<Scalar>(ends, 3 + q, lane, Y[q]);
    }
    X = segment.frame * (carried - segment.C * Y + segment.c);
  }
  solver_.outwards(arrays(), partsOf(&s_), partsOf(rhoQ), ends, partsOf(u), partsOf(v));
}

template class LinearizedSegments<double>;
template class LinearizedSegments<std::complex<double>>;
template LinearizedSegments<std::complex<double>>::LinearizedSegments(const LinearizedSegments<double>&);

}  // namespace planar_chain
