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
      3,
      2,
      0.435866521508459,
      {0, 0.871733043016918, 0.7315799577888524, 1},
      {0.435866521508459, -0.435866521508459, -0.41333337623388644, 0},
      {{},
       {2},
       {1.4192173174557647, -0.2592322116729697},
       {4.18476048231916, -0.2851920173554959, 2.294280360279042}},
      {{},
       {-4.588560720558084},
       {-4.18476048231916, 0.2851920173554959},
       {-6.368179200128357, -6.795620944466836, 2.870098604331056}},
      {4.18476048231916, -0.2851920173554959, 2.294280360279042, 1},
      {4.18476048231916 - 3.907010534671192, -0.2851920173554959 - 1.1180478778205032,
       2.294280360279042 - 0.5216502326114907, 0.5}};
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
    : ImplicitStepper({table.name, table.order, table.errorOrder}, f),
      table_(checked(table)),
      rows_(table.m.size(), static_cast<std::size_t>(f.arrangedSize())),
      U_(rowsOf(rows_, table.m.size())),
      m_(table.m, 1, {}, U_, 0, f.arrangedSize()),
      e_(table.e, 0, {}, U_, 0, f.arrangedSize()),
      timeSlope_(startSlope_),
      stage_(startSlope_),
      rates_(startSlope_) {
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
  const bool isTimeDependent = f_.timeDerivative(timeSlope_.data());
  f_.factor(1 / (h * table_.gamma));
  const Eigen::Index size = f_.arrangedSize();
  for (std::size_t i = 0; i < U_.size(); ++i) {
    if (i == 0) {
      std::copy_n(startSlope_.data(), size, U_[0]);
    } else {
      findSide(i, t, h, y.data());
    }
    if (isTimeDependent) add(table_.d[i] * h, timeSlope_.data(), U_[i], size);
    f_.solve(U_[i], U_[i]);
  }
  m_.run(1, nullptr, increment_.data(), nullptr);
  e_.run(1, nullptr, error_.data(), nullptr);
}

}  // namespace planar_chain::ode
