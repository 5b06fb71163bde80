/// Every file of bad_scenes is refused with exactly the faults that its first lines name, in the order of the
/// lines that have them:
///
///     # expect: links/upper/mass: expected a number > 0 kg, got -1
///
/// where a trailing ... stands for any rest. Files called broken_… or duplicate_… are faulty as text, or
/// read otherwise by other readers of YAML; the rest must be refused just so by the parameter server's road.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "planar_chain/scene_reader.h"

namespace planar_chain {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> badScenes() {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(BAD_SCENES_DIR)) {
    if (entry.path().extension() == ".yaml") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<std::string> expectedIn(const std::string& text) {
  const std::string mark = "# expect: ";
  std::vector<std::string> expected;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && line.compare(0, mark.size(), mark) == 0;) {
    expected.push_back(line.substr(mark.size()));
  }
  std::sort(expected.begin(), expected.end());
  return expected;
}

std::vector<std::string> faultsIn(const std::string& text) {
  std::vector<std::string> found;
  try {
    readSceneText(text);
  } catch (const Refused& refused) {
    for (const Fault& fault : refused.faults()) found.push_back(toString(fault));
    const auto isBefore = [](const Fault& a, const Fault& b) {
      const auto isInUrdf = [](const Fault& fault) { return fault.path.rfind("robot_description", 0) == 0; };
      return isInUrdf(a) == isInUrdf(b) ? a.line < b.line : isInUrdf(a);
    };
    EXPECT_TRUE(std::is_sorted(refused.faults().begin(), refused.faults().end(), isBefore)) << refused.what();
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool matches(const std::string& expected, const std::string& found) {
  const std::size_t size = expected.size();
  const bool isOpen = size >= 3 && expected.compare(size - 3, 3, "...") == 0;
  return isOpen ? found.compare(0, size - 3, expected, 0, size - 3) == 0 : found == expected;
}

std::string linesOf(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += "\n  " + line;
  return text;
}

class BadScene : public testing::TestWithParam<fs::path> {};

TEST_P(BadScene, IsRefusedWithExactlyTheFaultsItNames) {
  std::ifstream file(GetParam());
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::vector<std::string> expected = expectedIn(text);
  const std::vector<std::string> found = faultsIn(text);
  ASSERT_FALSE(expected.empty());
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), found.begin(), found.end(), matches))
      << "expected" << linesOf(expected) << "\nfound" << linesOf(found);
}

std::string nameOf(const testing::TestParamInfo<fs::path>& file) {
  return file.param.stem().string();
}

INSTANTIATE_TEST_SUITE_P(Files, BadScene, testing::ValuesIn(badScenes()), nameOf);

}  // namespace
}  // namespace planar_chain
