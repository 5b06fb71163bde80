#include "ode/rosenbrock.h"

#include "simd/vectors.h"

namespace planar_chain::ode {

const RosenbrockTableau& rodas5p() {
  static const std::vector<double> a6{-7.502846399306121, 2.561846144803919, -11.627539656261098,
                                      -0.18268767659942256, 0.030198172008377946};
  // Stages 7 and 8 and the step add the increments of the stages before.
  static const auto andOne = [](std::vector<double> row) {
    row.push_back(1);
    return row;
  };
  static const std::vector<double> a7 = andOne(a6), a8 = andOne(a7), m = andOne(a8);
  static const RosenbrockTableau table{
      "rodas5p",
      "G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P, BIT 63 (2023) 27, "
      "doi 10.1007/s10543-023-00967-x",
      5,
      4,
      0.21193756319429014,
      {0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1, 1, 1},
      {0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734, 2.325825639765069,
       0, 0, 0},
      {{},
       {3.0},
       {2.849394379747939, 0.45842242204463923},
       {-6.954028509809101, 2.489845061869568, -10.358996098473584},
       {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641},
       a6,
       a7,
       a8},
      {{},
       {-14.155112264123755},
       {-17.97296035885952, -2.859693295451294},
       {147.12150275711716, -1.41221402718213, 71.68940251302358},
       {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306},
       {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471},
       {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
        -28.087943162872662},
       {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
        -54.66780262877968, -9.48861652309627}},
      m,
      {0, 0, 0, 0, 0, 0, 0, 1}};
  return table;
}

const RosenbrockTableau& ros34pw2() {
  static const RosenbrockTableau table{
      "ros34pw2",
      "J. Rang, L. Angermann, New Rosenbrock W-methods of order 3 for partial differential algebraic "
      "equations "
      "of index 1, BIT 45 (2005) 761-787",
      3,
      2,
      4.35866521508459003886e-01,
      {0, 8.71733043016918007773e-01, 7.31579957788852430767e-01, 1},
      {4.35866521508459003886e-01, -4.35866521508459003886e-01, -4.13333376233886440332e-01, 0},
      {{},
       {2},
       {1.41921731745576473749, -2.59232211672969725669e-01},
       {4.18476048231916042397, -2.85192017355495874842e-01, 2.29428036027904180827}},
      {{},
       {-4.58856072055808361654},
       {-4.18476048231916042397, 2.85192017355495874842e-01},
       {-6.36817920012835703147, -6.79562094446683584437, 2.87009860433105590261}},
      {4.18476048231916042397, -2.85192017355495874842e-01, 2.29428036027904180827, 1},
      {4.18476048231916042397 - 3.90701053467119185925, -2.85192017355495874842e-01 - 1.11804787782050318867,
       2.29428036027904180827 - 5.21650232611490682899e-01, 0.5}};
  return table;
}

namespace {

/// The last stage sums all others; the step sums all stages.
const RosenbrockTableau& checked(const RosenbrockTableau& table) {
  static_assert(simd::VectorKernel::mostTermsForTwo < simd::VectorKernel::mostTerms);
  requireAtMost(simd::VectorKernel::mostTermsForTwo + 1, table.m.size(), table.name);
  return table;
}

std::vector<double*> rowsOf(CacheRows& rows, std::size_t count) {
  std::vector<double*> all;
  for (std::size_t i = 0; i < count; ++i) all.push_back(rows.row(i));
  return all;
}

/// y ← y + k x
void add(double k, const double* x, double* y, Eigen::Index size) {
  Eigen::Map<Eigen::VectorXd>(y, size) += k * Eigen::Map<const Eigen::VectorXd>(x, size);
}

}  // namespace

Rosenbrock::Rosenbrock(const RosenbrockTableau& table, LinearizedSystem& f)
    : table_(checked(table)),
      f_(f),
      rows_(table.m.size(), static_cast<std::size_t>(f.arrangedSize())),
      U_(rowsOf(rows_, table.m.size())),
      m_(table.m, U_, f.arrangedSize()),
      e_(table.e, U_, f.arrangedSize()),
      startSlope_(f.arrangedSize()),
      timeSlope_(startSlope_),
      stage_(startSlope_),
      rates_(startSlope_),
      increment_(startSlope_),
      error_(startSlope_) {
  const Eigen::Index positions = f.positions(), rates = f.arrangedSize() - positions;
  for (std::size_t i = 0; i < U_.size(); ++i) {
    positionSums_.emplace_back(table.a[i], table.C[i], U_, 0, positions);
    rateSums_.emplace_back(table.a[i], table.C[i], U_, positions, rates);
  }
  f_.reserve(0);
}

double Rosenbrock::cost() const {
  const LinearCosts linear = f_.linearCosts();
  const auto stages = static_cast<double>(U_.size());
  return linear.factor + stages - 1 + stages * linear.solve;
}

void Rosenbrock::linearize(double t, const Vector& y) {
  if (linearized_) return;
  f_.linearize(t, y.data(), startSlope_.data());
  timeDependent_ = f_.timeDerivative(timeSlope_.data());
  linearized_ = true;
}

const Vector& Rosenbrock::derivative(double t, const Vector& y) {
  linearize(t, y);
  return startSlope_;
}

/// U ← f(t, y + Σ a_ij U_j) + Σ (C_ij/h) U_j. f of the positions is the rates of the stage.
void Rosenbrock::findSide(std::size_t i, double t, double h, const double* y) {
  double* U = U_[i];
  const Eigen::Index positions = f_.positions();
  double* stageRates = stage_.data() + positions;
  rateSums_[i](y + positions, stageRates, 1 / h, nullptr, U + positions);
  if (positions > 0) positionSums_[i](y, stage_.data(), 1 / h, stageRates, U);
  f_.rates(t + table_.c[i] * h, stage_.data(), rates_.data());
  add(1, rates_.data(), U + positions, f_.arrangedSize() - positions);
}

void Rosenbrock::step(double t, double h, const Vector& y) {
  linearize(t, y);
  f_.factor(1 / (h * table_.gamma));
  const Eigen::Index size = f_.arrangedSize();
  for (std::size_t i = 0; i < U_.size(); ++i) {
    if (i == 0) {
      std::copy_n(startSlope_.data(), size, U_[0]);
    } else {
      findSide(i, t, h, y.data());
    }
    if (timeDependent_) add(table_.d[i] * h, timeSlope_.data(), U_[i], size);
    f_.solve(U_[i], U_[i]);
  }
  m_(1, increment_.data());
  e_(1, error_.data());
}

}  // namespace planar_chain::ode
