#include "run/column_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace planar_chain {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The series c of a motion, h later.
void shift(std::vector<double>& c, int order, double h) {
  const std::size_t width = c.size() / index(order + 1);
  for (int k = 0; k < order; ++k) {
    for (std::size_t at = index(order) * width; at-- > index(k) * width;) c[at] += h * c[at + width];
  }
}

}  // namespace

ColumnSteps::ColumnSteps(const Scene& scene, const Effects& effects, const CommandEffect* commands,
                         const std::vector<int>& lags, const Numbers& numbers)
    : scene_(scene),
      effects_(effects),
      commands_(commands),
      lags_(lags),
      numbers_(numbers),
      n_(scene.chain.size()),
      mayBe_(ColumnSeries::areFor(scene.chain) && !effects.base() && !effects.holdTip() &&
             !effects.any(&Effect::isNonlinear)),
      couplings_(n_) {}

bool ColumnSteps::isAlong(const MotionInSeries& motion, double t, const State& y, double end,
                          const State& yEnd, double most) {
  const Eigen::Index size = y.size();
  if (!motion.c || motion.t != t || Eigen::Map<const VectorXd>(motion.c, size) != y) return false;
  for (Eigen::Index i = 0; i < size; ++i) {
    double sum = 0;
    for (Eigen::Index k = motion.order; k >= 0; --k) sum = sum * (end - t) + motion.c[k * size + i];
    if (!(std::abs(sum - yEnd[i]) <= most * (1 + std::abs(yEnd[i])))) return false;
  }
  return true;
}

bool ColumnSteps::enter(double t, const VectorXd& y, const MotionInSeries& motion) {
  if (!mayBe_ || effects_.acting() == LoadKind::forces) return false;
  if (!series_ || series_->order() != motion.order) {
    const auto numbers = static_cast<int>(numbers_.size()), lags = static_cast<int>(lags_.size());
    const simd::ColumnKernel& kernel = *simd::columnKernels({scene_.integrator.plainKernel}).front();
    series_.emplace(scene_.chain, motion.order, 3 * n_ + lags + numbers, numbers, kernel);
    for (int p = 0; p < numbers; ++p) series_->change(p) = numbers_[index(p)]->changeOfChain();
  }
  effects_.couple(t, 0, couplings_);
  const Eigen::Matrix4Xd joints = jointTerms(effects_, couplings_, scene_.chain.coordinates(), t, y.data());
  for (int i = 0; i < n_; ++i) {
    std::copy_n(joints.col(i).data(), 4, series_->joint(i));
    series_->setFree(i, !couplings_.joints[index(i)].isPrescribed);
  }
  return takeTorques() && takeNumbers(t, y);
}

/// The share of a torque must not change with time.
bool ColumnSteps::takeTorques() {
  constexpr double forever = std::numeric_limits<double>::infinity();
  for (int i = 0; i < n_; ++i) {
    const double share = commands_ ? commands_->shareOf(i, 0) : 1;
    if (commands_ && (commands_->delayOf(i) > 0 || share != commands_->shareOf(i, forever))) return false;
    series_->setSource(2 * n_ + i, i, share);
  }
  // On the torque-speed line a lag moves nothing.
  return std::all_of(lags_.begin(), lags_.end(), [this](int i) { return commands_->shareOfLag(i, 0) == 0; });
}

bool ColumnSteps::takeNumbers(double t, const VectorXd& y) {
  Eigen::Matrix4Xd change;
  for (int p = 0; p < static_cast<int>(numbers_.size()); ++p) {
    if (!numbers_[index(p)]->changeOfJoints(t, y.data(), effects_, change)) return false;
    series_->change(p).segment(ColumnSeries::Terms::joint(0, n_), 4 * n_) =
        Eigen::Map<const VectorXd>(change.data(), change.size());
  }
  return true;
}

bool ColumnSteps::follow(const MotionInSeries& motion, double h, MatrixXd& columns) {
  constexpr int mostSteps = 64;
  constexpr double shortest = 1e-3, sure = 0.9;  // s; of the step whose error would just be allowed
  // Tolerances a second, of the last term: what the series leaves out is far less, by the complex steps of
  // derivatives_test a hundredth of a tolerance.
  constexpr double allowed = 4;
  const double most = allowed * scene_.integrator.tolerance;
  write(columns);
  series_->find(motion.c);
  const auto errorOf = [&](double step) {
    return series_->evaluate(step) / (most * std::min(std::max(step, shortest), 1.0));
  };
  double left = h;
  for (int k = 0; k < mostSteps; ++k) {
    double step = left;
    for (double error = errorOf(step); error > 1; error = errorOf(step))
      step *= std::min(sure, sure * std::pow(error, -1.0 / motion.order));
    if (step == left) {
      read(columns);
      return columns.allFinite();
    }
    series_->take();
    if (k == 0) shifted_.assign(motion.c, motion.c + index((motion.order + 1) * 2 * n_));
    shift(shifted_, motion.order, step);
    series_->find(shifted_.data());
    left -= step;
  }
  return false;
}

void ColumnSteps::write(const MatrixXd& columns) {
  const Coordinates& coordinates = scene_.chain.coordinates();
  for (int k = 0; k < static_cast<int>(columns.cols()); ++k) {
    for (int order = 0; order < 2; ++order) {
      const double* x = columns.col(k).data() + order * n_;
      for (int i = 0; i < n_; ++i) series_->start(order, i, k) = coordinates.relative(x, i);
    }
  }
}

void ColumnSteps::read(MatrixXd& columns) const {
  const Coordinates& coordinates = scene_.chain.coordinates();
  for (int k = 0; k < static_cast<int>(columns.cols()); ++k) {
    for (int order = 0; order < 2; ++order) {
      double* x = columns.col(k).data() + order * n_;
      for (int i = 0; i < n_; ++i) x[i] = series_->value(order, i, k);
      coordinates.toAbsolute(x, x);
    }
  }
}

}  // namespace planar_chain
