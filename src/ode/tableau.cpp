#include "planar_chain/ode/tableau.h"

namespace planar_chain::ode {

const Tableau& rk4() {
  static const Tableau table{
      "rk4",
      "Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, table II.1.2",
      4,
      0,
      {0, 1. / 2, 1. / 2, 1},
      {{}, {1. / 2}, {0, 1. / 2}, {0, 0, 1}},
      {1. / 6, 2. / 6, 2. / 6, 1. / 6},
      {},
      false};
  return table;
}

const Tableau& dopri5() {
  static const Tableau table{
      "dopri5",
      "Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, table II.5.2",
      5,
      4,
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
      true};
  return table;
}

}  // namespace planar_chain::ode
