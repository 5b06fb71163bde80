/// Stiff springs and dampers, up to 1e9 N m/rad: motions against quadruple precision, made by an implicit
/// method (reference/README.md), and against exact solutions.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include "planar_chain/scene_reader.h"
#include "planar_chain/simulation.h"
#include "support/reference_data.h"

namespace planar_chain {
namespace {

// ---- Quadruple precision -------------------------------------------------------------------------

/// A scene of reference/stiff with its springs times k and its dampers times d, and where it ends.
struct Stiff {
  std::string name;
  Scene scene;
  double end = 0;
  std::vector<double> q, qd;

  Stiff(const test::Row& row, double k, double d)
      : name(row.text("scene") + ", k " + row.text("k") + ", d " + row.text("d")),
        scene(test::referenceScene("stiff/" + row.text("scene") + ".yaml")),
        end(row.number("t")) {
    std::vector<Joint> joints = scene.chain.joints();
    for (Joint& joint : joints) joint.stiffness *= k, joint.damping *= d;
    scene.chain = Chain(scene.chain.links(), joints, scene.chain.gravity());
  }
};

/// Those with this k and this share d/k.
std::vector<Stiff> stiffReferences(double k, double share) {
  std::vector<Stiff> references;
  for (const test::Row& row : test::referenceTable("stiff.csv")) {
    if (row.number("k") != k || std::abs(row.number("d") - share * k) > 1e-9 * share * k) continue;
    if (row.text("quantity") == "q" && row.index("index") == 0) {
      references.emplace_back(row, k, row.number("d"));
    }
    Stiff& last = references.back();
    (row.text("quantity") == "q" ? last.q : last.qd).push_back(row.number("value"));
  }
  return references;
}

/// The largest |a − b| over the largest |b − from| or 1. NaN when one is NaN, which no bound passes.
double errorOfTheMotion(const std::vector<double>& a, const std::vector<double>& b,
                        const std::vector<double>& from) {
  double worst = 0, motion = 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(a[i])) return a[i];
    worst = std::max(worst, std::abs(a[i] - b[i]));
    motion = std::max(motion, std::abs(b[i] - from[i]));
  }
  return worst / motion;
}

struct Strength {
  std::string name;
  double k, share;
};

class StiffBar : public testing::TestWithParam<Strength> {};

TEST_P(StiffBar, IsFollowedByAuto) {
  // The motion to a thousand tolerances, angles and rates apart, and so its energy.
  const std::vector<Stiff> references = stiffReferences(GetParam().k, GetParam().share);
  ASSERT_EQ(references.size(), 2U);
  for (Stiff reference : references) {
    for (const double tolerance : {1e-9, 1e-10}) {
      SCOPED_TRACE(reference.name + ", tolerance " + std::to_string(std::log10(tolerance)));
      reference.scene.integrator = {"auto", tolerance, 0};
      Simulation simulation(reference.scene);
      const double scale = 1 + std::abs(simulation.energy().potential) + simulation.energy().kinetic;
      ASSERT_TRUE(simulation.advanceTo(reference.end)) << simulation.fault();
      EXPECT_LE(errorOfTheMotion(simulation.q(), reference.q, reference.scene.q), 1e3 * tolerance);
      EXPECT_LE(errorOfTheMotion(simulation.qd(), reference.qd, reference.scene.qd), 1e3 * tolerance);
      EXPECT_LE(std::abs(simulation.energyBalance().residual), 1e3 * tolerance * scale);
    }
  }
}

// Below 1e-10 rounding keeps the error of a stiff mode above the tolerance for all steps but the shortest:
// these scenes took up to 80 times the evaluations, and machines of some links did not end.
TEST_P(StiffBar, NeedsFewMoreEvaluationsBelowRounding) {
  for (Stiff reference : stiffReferences(GetParam().k, GetParam().share)) {
    for (const char* method : {"auto", "rodas5p"}) {
      double most = std::numeric_limits<double>::infinity();
      for (const double tolerance : {1e-10, 1e-11, 1e-12, 1e-13}) {
        SCOPED_TRACE(reference.name + ", " + method + ", tolerance " + std::to_string(std::log10(tolerance)));
        reference.scene.integrator = {method, tolerance, 0};
        Simulation simulation(reference.scene);
        const auto evaluations = [&] { return static_cast<double>(simulation.statistics().evaluations); };
        ASSERT_TRUE(simulation.advanceTo(reference.end, [&] { return evaluations() < most; }))
            << simulation.fault() << " " << evaluations() << " evaluations";
        if (std::isinf(most)) most = 5 * evaluations();  // measured: at most 3.4 times
        EXPECT_LE(errorOfTheMotion(simulation.q(), reference.q, reference.scene.q), 1e-10);
      }
    }
  }
}

std::vector<Strength> strengths() {
  std::vector<Strength> all;
  for (const char* k : {"1e3", "1e5", "1e7", "1e9"}) {
    all.push_back({std::string(k) + "_undamped", std::stod(k), 0});
    all.push_back({std::string(k) + "_damped", std::stod(k), 1e-3});
    all.push_back({std::string(k) + "_overdamped", std::stod(k), 1});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Springs, StiffBar, testing::ValuesIn(strengths()),
                         [](const auto& strength) { return strength.param.name; });

// ---- Exact ---------------------------------------------------------------------------------------

TEST(OneStiffLink, VibratesAndCreepsAsTheFormulaSays) {
  // J q̈ + d q̇ + k q = 0, J = 1/3, let go at 0.5. Undamped for a thousand radians; else critically damped or
  // with d = k/10, until q is down to e⁻² or so. Rates, in units of the largest one.
  for (const double k : {1e3, 1e5, 1e7, 1e9}) {
    const double J = 1. / 3, w0 = std::sqrt(k / J), q0 = 0.5;
    for (const double d : {0., 2 * std::sqrt(k * J), 0.1 * k}) {
      const double a = d / (2 * J), root = std::sqrt(std::abs(a * a - w0 * w0));
      const bool critical = std::abs(a / w0 - 1) < 1e-9;
      const double t = d == 0 ? 1000 / w0 : critical ? 3 / w0 : 0.2;
      double q, qd;
      if (d == 0) {
        q = q0 * std::cos(w0 * t);
        qd = -q0 * w0 * std::sin(w0 * t);
      } else if (critical) {
        q = q0 * (1 + w0 * t) * std::exp(-w0 * t);
        qd = -q0 * w0 * w0 * t * std::exp(-w0 * t);
      } else {
        const double slow = -w0 * w0 / (a + root), fast = -(a + root);
        q = q0 * (fast * std::exp(slow * t) - slow * std::exp(fast * t)) / (fast - slow);
        qd = q0 * slow * fast * (std::exp(slow * t) - std::exp(fast * t)) / (fast - slow);
      }
      Scene scene{Chain({{"rod", 1, 1. / 12, {0.5, 0}, {1, 0}}}, {{"joint", k, d, 0}}, {}),
                  {q0},
                  {0},
                  {},
                  {"auto", 1e-9, 0},
                  {},
                  0};
      Simulation simulation(scene);
      ASSERT_TRUE(simulation.advanceTo(t)) << simulation.fault();
      EXPECT_NEAR(simulation.q()[0], q, 1e-6) << "k " << k << ", d " << d;
      EXPECT_NEAR(simulation.qd()[0], qd, 1e-6 * q0 * w0) << "k " << k << ", d " << d;
    }
  }
}

/// A blow excites the modes of a stiff bar, and friction within the bar damps them. A step of dop853 that
/// follows them is then a quarter of the longest stable one, and radau13 needs a fortieth of the evaluations.
TEST(StruckBar, DoesNotKeepAutoWithAnExplicitMethod) {
  std::ifstream file(SCENES_DIR "/struck_bar.yaml");
  Scene scene = readSceneText({std::istreambuf_iterator<char>(file), {}});
  scene.integrator.tolerance = 1e-9;
  const auto evaluationsBy = [&](const char* method) {
    scene.integrator.method = method;
    Simulation simulation(scene);
    for (const double t : {0.5, 1.0, 1.5, 2.0}) EXPECT_TRUE(simulation.advanceTo(t)) << simulation.fault();
    return static_cast<double>(simulation.statistics().evaluations);
  };
  // auto makes two thirds of its evaluations before it has tried the others.
  EXPECT_LT(evaluationsBy("auto"), 5 * evaluationsBy("radau13"));
}

}  // namespace
}  // namespace planar_chain
