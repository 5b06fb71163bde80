#pragma once

/// Written by make.py: q and q̇ of its scenes after 3 s.

#include <vector>

namespace planar_chain::reference {

inline const std::vector<double> level{0.901003441884501,   -1.47675862300671, 0.344262844715541,
                                       -0.0249870158868998, 1.02383727279703,  4.51867058065115};
inline const std::vector<double> tilted{0.359648732753462, -0.881347712428182, 0.38360408395226,
                                        0.473930350408715, 0.0774537549212531, -0.237058043004348};
inline const std::vector<double> plane{-0.344432102865322, -0.314553186667791, -1.42163504709037,
                                       0.418160934769759,  -0.356287410729683, 0.0990272777826342,
                                       0.528432805804128,  5.04501177844255};
inline const std::vector<double> massless{1.7648203884269,    -2.01273578320458, -0.127724666008295,
                                          -0.756791821940967, 2.28144862527063,  -2.89313290203108};

}  // namespace planar_chain::reference
