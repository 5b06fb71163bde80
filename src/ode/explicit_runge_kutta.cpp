#include "ode/explicit_runge_kutta.h"

#include <algorithm>

namespace planar_chain::ode {

const Tableau& rk4() {
  static const Tableau table{{"rk4", 4, 0, 2.828427},
                             {0, 1. / 2, 1. / 2, 1},
                             {{}, {1. / 2}, {0, 1. / 2}, {0, 0, 1}},
                             {1. / 6, 2. / 6, 2. / 6, 1. / 6},
                             {},
                             {},
                             false};
  return table;
}

const Tableau& dopri5() {
  static const Tableau table{
      {"dopri5", 5, 4, 0.99},
      {0, 1. / 5, 3. / 10, 4. / 5, 8. / 9, 1, 1},
      {{},
       {1. / 5},
       {3. / 40, 9. / 40},
       {44. / 45, -56. / 15, 32. / 9},
       {19372. / 6561, -25360. / 2187, 64448. / 6561, -212. / 729},
       {9017. / 3168, -355. / 33, 46732. / 5247, 49. / 176, -5103. / 18656},
       {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84}},
      {35. / 384, 0, 500. / 1113, 125. / 192, -2187. / 6784, 11. / 84, 0},
      {71. / 57600, 0, -71. / 16695, 71. / 1920, -17253. / 339200, 22. / 525, -1. / 40},
      {},
      true};
  return table;
}

const Tableau& dop853() {
  static const Tableau table{
      {"dop853", 8, 7, 5.96},
      {0.0, 0.05260015195876773, 0.0789002279381516, 0.1183503419072274, 0.2816496580927726,
       0.3333333333333333, 0.25, 0.3076923076923077, 0.6512820512820513, 0.6, 0.8571428571428571, 1.0},
      {{},
       {0.05260015195876773},
       {0.0197250569845379, 0.0591751709536137},
       {0.02958758547680685, 0, 0.08876275643042054},
       {0.2413651341592667, 0, -0.8845494793282861, 0.924834003261792},
       {0.037037037037037035, 0, 0, 0.17082860872947386, 0.12546768756682242},
       {3.7109375e-2, 0, 0, 0.17025221101954405, 0.06021653898045596, -1.7578125e-2},
       {0.03709200011850479, 0, 0, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402,
        0.008273789163814023},
       {0.6241109587160757, 0, 0, -3.3608926294469414, -0.868219346841726, 27.59209969944671,
        20.154067550477894, -43.48988418106996},
       {0.47766253643826434, 0, 0, -2.4881146199716677, -0.590290826836843, 21.230051448181193,
        15.279233632882423, -33.28821096898486, -0.020331201708508627},
       {-0.9371424300859873, 0, 0, 5.186372428844064, 1.0914373489967295, -8.149787010746927,
        -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196},
       {2.273310147516538, 0, 0, -10.53449546673725, -2.0008720582248625, -17.9589318631188,
        27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636}},
      {0.054293734116568765, 0, 0, 0, 0, 4.450312892752409, 1.8915178993145003, -5.801203960010585,
       0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259},
      {0.01312004499419488, 0, 0, 0, 0, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864,
       -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294},
      {0.054293734116568765 - 0.2440944881889764, 0, 0, 0, 0, 4.450312892752409, 1.8915178993145003,
       -5.801203960010585, 0.3111643669578199 - 0.7338466882816118, -0.1521609496625161, 0.20136540080403034,
       0.04471061572777259 - 0.022058823529411766},
      false};
  return table;
}

ExplicitRungeKutta::ExplicitRungeKutta(const Tableau& table, System& f)
    : Stepper(table, f),
      table_(table),
      slopes_(checkedStages(table.b.size(), table.name), static_cast<std::size_t>(rates_)) {
  // Nothing depends on the components behind the rates, and their errors do not count.
  const Eigen::Index behind = size_ - 2 * positions_, others = positions_ > 0 ? 0 : behind;
  const auto row = [&](const std::vector<double>& weights, double drift, Eigen::Index count) {
    return NystromRow(vectors_, weights, drift, table.a, k_, positions_, count);
  };
  a_.reserve(table.a.size());
  for (std::size_t i = 0; i < table.a.size(); ++i) a_.push_back(row(table.a[i], table.c[i], others));
  b_ = row(table.b, 1, behind);
  e_ = row(table.e, 0, others);
  coarseRow_ = row(table.coarse, 0, others);
}

const Vector& ExplicitRungeKutta::derivative(double t, const Vector& y) {
  evaluateFirst(t, y.data());
  std::copy_n(y.data() + positions_, positions_, slope_.data());
  std::copy_n(k_.front(), rates_, slope_.data() + positions_);
  return slope_;
}

void ExplicitRungeKutta::step(double t, double h, const Vector& y) {
  const double* start = y.data();
  double* stage = stage_.data();
  const Tableau& table = table_;
  const double* c = table.c.data();

  // Slopes of the stages.
  evaluateFirst(t, start);
  const std::size_t stages = k_.size() - (table.lastIsFirst ? 1 : 0);
  for (std::size_t i = 1; i < stages; ++i) {
    a_[i].run(h, start, nullptr, stage);
    evaluate(t + c[i] * h, stage, k_[i]);
  }

  // The increment. With FSAL, the end of the step is the last stage.
  b_.run(h, start, increment_.data(), table.lastIsFirst ? stage : nullptr);
  if (table.lastIsFirst) evaluate(t + h, stage, k_.back());

  // The error.
  if (!table.e.empty()) e_.run(h, start, error_.data(), nullptr);
  if (!table.coarse.empty()) {
    coarseRow_.run(h, start, coarse_.data(), nullptr);
    vectors_.damp(error_.data(), coarse_.data(), size_);
  }
}

void ExplicitRungeKutta::accept() {
  firstIsKnown_ = table_.lastIsFirst;
  if (table_.lastIsFirst) std::copy_n(k_.back(), rates_, k_.front());
}

}  // namespace planar_chain::ode
