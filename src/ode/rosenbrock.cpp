#include "ode/rosenbrock.h"

#include <algorithm>

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
      {"rodas5p", 5, 4},
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
      {"ros34pw2", 3, 2},
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

Rosenbrock::Rosenbrock(const RosenbrockTableau& table, LinearizedSystem& f)
    : ImplicitStepper(table, f),
      table_(table),
      rows_(checkedStages(table.m.size(), table.name), static_cast<std::size_t>(f.sizeInLaneOrder())),
      m_(vectors_, table.m, U_, f.sizeInLaneOrder()),
      e_(vectors_, table.e, U_, f.sizeInLaneOrder()) {
  for (auto* rows : {&a_, &C_}) rows->reserve(U_.size());
  for (std::size_t i = 0; i < U_.size(); ++i) {
    a_.emplace_back(vectors_, table.a[i], U_, f.sizeInLaneOrder());
    C_.emplace_back(vectors_, table.C[i], U_, f.sizeInLaneOrder());
  }
  f_.reserve(0);
}

void Rosenbrock::step(double t, double h, const Vector& y) {
  linearize(t, y);
  const bool isTimeDependent = f_.timeDerivative(timeSlope_.data());
  f_.factor(1 / (h * table_.gamma));
  const Eigen::Index size = f_.sizeInLaneOrder();
  for (std::size_t i = 0; i < U_.size(); ++i) {
    double* U = U_[i];
    if (i == 0) {
      std::copy_n(startSlope_.data(), size, U);
    } else {
      a_[i].run(1, y.data(), nullptr, stage_.data());
      f_.slope(t + table_.c[i] * h, stage_.data(), slope_.data());
      C_[i].run(1 / h, slope_.data(), nullptr, U);
    }
    if (isTimeDependent) Eigen::Map<Eigen::VectorXd>(U, size) += table_.d[i] * h * timeSlope_;
    f_.solve(U, U);
  }
  m_.run(1, nullptr, increment_.data(), nullptr);
  e_.run(1, nullptr, error_.data(), nullptr);
}

}  // namespace planar_chain::ode
