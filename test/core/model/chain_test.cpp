/// The chain refuses what has no motion: values out of range, and a mass matrix that is singular in some
/// configuration. That rule is held against the mass matrix itself.

#include "planar_chain/chain.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace planar_chain {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double notANumber = std::numeric_limits<double>::quiet_NaN();

Link rod(const std::string& name) {
  return {name, 1, 1.0 / 12, {0.5, 0}, {1, 0}};
}

std::vector<Joint> jointsFor(const std::vector<Link>& links) {
  std::vector<Joint> joints;
  for (const Link& link : links) joints.push_back({link.name + "_joint", 0, 0, 0});
  return joints;
}

std::vector<Fault> faultsOfChain(const std::vector<Link>& links, const std::vector<Joint>& joints) {
  try {
    Chain(links, joints, {0, -9.81});
  } catch (const Refused& refused) {
    return refused.faults();
  }
  return {};
}

std::vector<std::string> pathsOf(const std::vector<Fault>& faults) {
  std::vector<std::string> paths;
  for (const Fault& fault : faults) paths.push_back(fault.path);
  return paths;
}

using Paths = std::vector<std::string>;

TEST(Chain, KeepsWhatItIsGiven) {
  const std::vector<Link> links{rod("a"), rod("b")};
  const Chain chain(links, {{"p", 1, 2, 3}, {"q", 4, 5, 6}}, {1, 2});
  EXPECT_EQ(chain.size(), 2);
  EXPECT_EQ(chain.links()[1].name, "b");
  EXPECT_EQ(chain.joints()[0].damping, 2);
  EXPECT_EQ(chain.gravity(), (Vec2d{1, 2}));
}

TEST(Chain, SharesItsValuesWithItsCopies) {
  const std::vector<Link> links{rod("a"), rod("b")};
  const Chain chain(links, jointsFor(links), {}), copy = chain;
  EXPECT_EQ(&copy.links(), &chain.links());
  EXPECT_EQ(&copy.joints(), &chain.joints());
  EXPECT_EQ(&copy.coordinates(), &chain.coordinates());
}

TEST(Chain, RefusesEveryValueOutOfRangeAtOnce) {
  std::vector<Link> links{rod("a"), rod("b"), rod("c")};
  links[0].mass = 0;
  links[0].inertia = -1;
  links[1].com.y = notANumber;
  links[2].pin.x = infinity;
  std::vector<Joint> joints = jointsFor(links);
  joints[0].stiffness = -1;
  joints[1].damping = infinity;
  joints[2].restAngle = notANumber;
  EXPECT_EQ(pathsOf(faultsOfChain(links, joints)),
            (Paths{"links/a/mass", "links/a/inertia", "links/a/joint/stiffness", "links/b/com",
                   "links/b/joint/damping", "links/c/pin", "links/c/joint/rest_angle"}));
}

TEST(Chain, SaysWhatItExpectedAndFound) {
  Link link = rod("a");
  link.mass = -2.5;
  EXPECT_EQ(toString(faultsOf(link).at(0)), "mass: expected a number > 0 kg, got -2.5");
  link.mass = infinity;
  EXPECT_EQ(toString(faultsOf(link).at(0)), "mass: expected a finite number > 0 kg, got inf");
}

TEST(Chain, RefusesMomentsOfInertiaBeyondADouble) {
  Link link = rod("a");
  link.com = {0, 1e200};
  link.pin = {1e200, 0};
  const std::vector<Fault> faults = faultsOf(link);
  EXPECT_EQ(pathsOf(faults), (Paths{"com", "pin"}));
}

TEST(Chain, RefusesNamesThatAreEmptyOrTaken) {
  std::vector<Link> links{rod("a"), rod("a"), rod("")};
  std::vector<Joint> joints{{"j", 0, 0, 0}, {"", 0, 0, 0}, {"j", 0, 0, 0}};
  EXPECT_EQ(pathsOf(faultsOfChain(links, joints)),
            (Paths{"links/a", "links/a/joint/name", "links/", "links//joint/name"}));
}

TEST(Chain, RefusesSizesThatCannotBe) {
  EXPECT_EQ(pathsOf(faultsOfChain({}, {})), Paths{"chain"});
  EXPECT_EQ(pathsOf(faultsOfChain({rod("a"), rod("b")}, jointsFor({rod("a")}))), Paths{"chain"});
}

TEST(Chain, RefusesGravityThatIsNotFinite) {
  EXPECT_THROW(Chain({rod("a")}, jointsFor({rod("a")}), {0, notANumber}), Refused);
}

// ---- The singular mass matrix ----------------------------------------------------------------

/// Links of every kind that the rule tells apart.
std::vector<Link> kinds() {
  return {
      {"", 1, 0.1, {0.5, 0}, {1, 0}},    // a rod
      {"", 1, 0.1, {0, 0}, {0, 0}},      // a disc on its pin, of no length
      {"", 1, 0, {0, 0}, {1, 0}},        // a point mass on its inner pin
      {"", 1, 0, {0, 0}, {0, 0}},        // the same, of no length
      {"", 1, 0, {1, 0}, {1, 0}},        // a point mass at its outer pin
      {"", 1, 0, {0.3, 0.4}, {1, 0.2}},  // a point mass elsewhere
      {"", 1, 0, {0.5, 0}, {0, 0}},      // a point mass, of no length
  };
}

double angleOf(Vec2d a) {
  return std::atan2(a.y, a.x);
}

/// The smallest eigenvalue of M = Σ m Jᵀ J + I 1ᵀ 1, in absolute angles.
double eigenvalueAt(const std::vector<Link>& links, const std::vector<double>& theta) {
  const auto n = static_cast<Eigen::Index>(links.size());
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n);
  Eigen::MatrixXd toPin = Eigen::MatrixXd::Zero(2, n);  // ∂(inner pin)/∂θ
  for (Eigen::Index i = 0; i < n; ++i) {
    const Link& link = links[static_cast<std::size_t>(i)];
    const auto e = Rotation<double>::of(theta[static_cast<std::size_t>(i)]);
    const Vec2d R = perp(e * link.com);
    const Vec2d P = perp(e * link.pin);
    Eigen::MatrixXd J = toPin;
    J.col(i) << R.x, R.y;
    M += link.mass * J.transpose() * J;
    M(i, i) += link.inertia;
    toPin.col(i) << P.x, P.y;
  }
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(M, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

/// The smallest over the configurations in which each centre of mass points anywhere, or in line with
/// the link before: with its outer pin as seen from its inner one, or from its centre of mass. Where a
/// motion moves no mass, it is in one of these.
double smallestEigenvalue(const std::vector<Link>& links, std::vector<double> theta = {0}) {
  if (theta.size() == links.size()) return eigenvalueAt(links, theta);
  const Link& before = links[theta.size() - 1];
  const double own = angleOf(links[theta.size()].com);
  double smallest = infinity;
  for (const double line : {angleOf(before.pin), angleOf(before.pin - before.com), 0.7}) {
    std::vector<double> longer = theta;
    longer.push_back(theta.back() + line - own);
    smallest = std::min(smallest, smallestEigenvalue(links, std::move(longer)));
  }
  return smallest;
}

/// All chains of up to three links of the kinds above. The smallest eigenvalue is either zero up to
/// rounding (1e-16 of masses and lengths of 1) or far from it.
TEST(Chain, RefusesExactlyTheSingularMassMatrices) {
  const std::vector<Link> all = kinds();
  int singular = 0;
  int regular = 0;
  for (std::size_t n = 1; n <= 3; ++n) {
    const auto count = static_cast<std::size_t>(std::pow(all.size(), n) + 0.5);
    for (std::size_t code = 0; code < count; ++code) {
      std::vector<Link> links;
      std::string kindsUsed;
      for (std::size_t i = 0, rest = code; i < n; ++i, rest /= all.size()) {
        links.push_back(all[rest % all.size()]);
        links.back().name = "link" + std::to_string(i);
        kindsUsed += std::to_string(rest % all.size());
      }
      const bool isRefused = !faultsOfChain(links, jointsFor(links)).empty();
      const double lowest = smallestEigenvalue(links);
      ASSERT_EQ(isRefused, lowest < 1e-12) << "kinds " << kindsUsed << ", eigenvalue " << lowest;
      ASSERT_TRUE(lowest < 1e-12 || lowest > 1e-4) << "kinds " << kindsUsed;
      ++(isRefused ? singular : regular);
    }
  }
  EXPECT_GT(singular, 50);
  EXPECT_GT(regular, 50);
}

TEST(Chain, NamesTheLinkThatTurnsWithoutMass) {
  std::vector<Link> links{kinds()[0], kinds()[2], kinds()[5], kinds()[4], kinds()[0]};
  for (std::size_t i = 0; i < links.size(); ++i) links[i].name = std::string(1, char('a' + i));
  const std::vector<Fault> faults = faultsOfChain(links, jointsFor(links));
  ASSERT_EQ(pathsOf(faults), Paths{"links/b"});
  EXPECT_NE(faults[0].found.find("out to d"), std::string::npos) << faults[0].found;
}

/// A mass on the pin that it is carried by moves with it, whatever is further out.
TEST(Chain, DoesNotBlameTheLinkThatCarriesAMass) {
  std::vector<Link> links{kinds()[2], kinds()[2]};
  links[0].name = "a";
  links[1].name = "b";
  EXPECT_EQ(pathsOf(faultsOfChain(links, jointsFor(links))), Paths{"links/b"});
}

TEST(Chain, RefusesOffsetsThatVanishWhenSquared) {
  Link link{"a", 1, 0, {1e-170, 0}, {1, 0}};
  EXPECT_EQ(pathsOf(faultsOfChain({link}, jointsFor({link}))), Paths{"links/a"});
}

}  // namespace
}  // namespace planar_chain
