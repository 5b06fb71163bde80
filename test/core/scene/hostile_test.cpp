/// Texts that are made to take time and memory: each is refused with its reason, by a process that may have
/// one GiB. What takes too long meets ctest's limit of time.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <functional>
#include <string>
#include <vector>

#include "planar_chain/fault.h"
#include "planar_chain/scene_reader.h"
#include "planar_chain/urdf_reader.h"
#include "planar_chain/value.h"

namespace planar_chain {
namespace {

constexpr std::size_t million = 1000000;
constexpr std::size_t some = longestYaml / 8;  // where time and memory are proportional to the length

std::string repeated(const std::string& what, std::size_t times) {
  std::string text;
  for (std::size_t i = 0; i < times; ++i) text += what;
  return text;
}

/// Each anchor holds ten times the one before, written as `entry` of it.
std::string laughs(const std::string& open, const std::string& entry, const std::string& close) {
  std::string text = "a0: &a0 {x: 1}\n";
  for (int i = 1; i < 15; ++i) {
    text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " " + open;
    for (int k = 0; k < 10; ++k) {
      std::string one = entry;
      if (const auto mark = one.find('#'); mark != std::string::npos) one.replace(mark, 1, std::to_string(k));
      text += (k > 0 ? ", " : "") + one + "*a" + std::to_string(i - 1);
    }
    text += close + "\n";
  }
  return text;
}

struct Bomb {
  const char* name;
  std::string text;
  const char* refusal;
};

std::vector<Bomb> bombs() {
  const char* const values = "at most 1000000 values in all";
  const char* const levels = "at most 16 levels";
  const char* const bytes = "at most 16777216 bytes";
  return {
      {"Brackets", repeated("[", longestYaml), values},
      {"BracketsWithinBounds", repeated("[", million), levels},
      {"BracesWithinBounds", repeated("{a: ", million / 2), levels},
      {"Commas", "[" + repeated(",", longestYaml - 1), values},
      {"CommasWithinBounds", "[" + repeated(",", million - 1), values},
      {"KeysWithoutValues", "{" + repeated("a,", million / 2 - 1) + "}", "each key once"},
      {"QuestionMarks", "[" + repeated("? ", million - 1) + "]", "YAML"},
      {"Dashes", repeated("- ", some / 2), levels},
      {"Colons", repeated(": ", longestYaml / 2), values},
      {"ColonsWithinBounds", repeated(": ", million), levels},
      {"WordsWithColons", "[" + repeated("a: ", million - 1), "YAML"},
      {"Quotes", "[" + repeated("\"\"", some / 2 - 1), "YAML"},
      {"Anchors", "[" + repeated("&a ", some / 3), "YAML"},
      {"ManyKeys", repeated("k: 1\n", longestYaml / 5), values},
      {"ManyKeysWithinBounds", repeated("k: 1\n", million / 2 - 1), "each key once"},
      {"ManyNulls", repeated("-\n", some / 2), values},
      {"Laughs", laughs("[", "", "]"), values},
      {"LaughsAsMaps", laughs("{", "k#: ", "}"), values},
      {"LaughsMerged", laughs("{<<: [", "", "]}"), values},
      {"LongTextManyTimes", "a: &a " + repeated("x", million) + "\nb: [" + repeated("*a,", 60000) + "]",
       bytes},
      {"LongTextInAListManyTimes",
       "a: &a [" + repeated("x", million) + "]\nb: [" + repeated("*a,", 60000) + "]", bytes},
      {"LongListManyTimes", "a: &a [" + repeated("1,", 400000) + "]\nb: [" + repeated("*a,", 60000) + "]",
       values},
      {"AnchorInItself", "chain: &a [*a]", "an alias of a complete value"},
      {"TooLong", repeated("#", longestYaml + 1), bytes},
      {"LongName", "chain: [" + repeated("x", some) + "]", "chain/0"},
      {"LongKey", "? " + repeated("x", some) + "\n: 1", "one of the keys"},
      {"LongNumber", "gravity: [" + repeated("9", some / 2) + ", 0]", "gravity: expected two finite numbers"},
      {"LongExponent", "gravity: [1e" + repeated("9", some / 2) + ", 0]", "gravity"},
      {"Zeros", std::string(some, '\0'), "YAML"},
      {"NoUnicode", std::string(some, '\xff'), "chain"},
      {"Documents", repeated("--- a\n", some / 6), "one YAML document"},
      {"Tags", "[" + repeated("!!str 1,", 400000) + "]", "a value without a tag"},
  };
}

/// A text that is made when it is wanted, or all of them would fill the memory that is allowed.
struct RobotBomb {
  const char* name;
  std::function<std::string()> text;
  const char* refusal;
};

std::string robot(const std::string& inside) {
  return "<robot>" + inside + "</robot>";
}

/// Each entity is ten times the one before.
std::string entities() {
  std::string text = "<!DOCTYPE robot [<!ENTITY e0 'ha'>";
  for (int i = 1; i < 30; ++i) {
    text += "<!ENTITY e" + std::to_string(i) + " '" + repeated("&e" + std::to_string(i - 1) + ";", 10) + "'>";
  }
  return text + "]><robot name='&e29;'/>";
}

std::vector<RobotBomb> robotBombs() {
  const char* const marks = "at most 1000000 of < and =";
  const char* const link = "<link name='a'><inertial><mass value='1'/></inertial></link>";
  return {
      {"Elements", [] { return repeated("<a/>", longestYaml / 4); }, marks},
      {"ElementsWithinBounds", [] { return robot(repeated("<a/>", million - 2)); },
       "one link that is the child of no joint"},
      {"Nested", [] { return repeated("<a>", million); }, "XML_ELEMENT_DEPTH_EXCEEDED"},
      {"Attributes", [] { return "<robot" + repeated(" a=''", longestYaml / 6) + "/>"; }, marks},
      {"AttributesAllAlike", [] { return "<robot" + repeated(" a=''", million - 1) + "/>"; }, "XML"},
      {"Links", [] { return robot(repeated("<link/>", million - 2)); }, "at most 50000 of link"},
      {"LinksWithinBounds", [] { return robot(repeated("<link><inertial/></link>", 50000)); },
       "a name, got nothing"},
      {"LinksOfOneName", [=] { return robot(repeated(link, 50000)); }, "a unique name"},
      {"Joints", [] { return robot(repeated("<joint/>", million - 2)); }, "at most 50000 of joint"},
      {"JointsWithinBounds",
       [] { return robot(repeated("<joint type='revolute'><axis xyz='0'/></joint>", 50000)); },
       "at most 1000 faults"},
      {"Origins", [] { return robot("<joint name='j'>" + repeated("<origin/>", million - 10) + "</joint>"); },
       "this element once"},
      {"Brackets", [] { return repeated("<", million); }, "XML"},
      {"Comments", [] { return repeated("<!--", million); }, "XML"},
      {"Entities", entities, "one link that is the child of no joint"},
      {"Declarations", [] { return repeated("<?xml?>", million); }, "one element robot"},
      {"LongName", [] { return robot("<link name='" + repeated("x", some) + "'/>"); },
       "a joint that is revolute"},
      {"LongNumber",
       [] {
         return robot("<link name='a'><inertial><mass value='" + repeated("9", some) +
                      "'/></inertial></link>");
       },
       "mass/value"},
      {"ManyNumbers",
       [] { return robot("<joint name='a'><origin xyz='" + repeated("9 ", some / 2) + "'/></joint>"); },
       "origin/xyz"},
      {"LongText", [] { return robot(repeated("x", longestYaml - 100)); },
       "one link that is the child of no joint"},
      {"TooLong", [] { return robot(repeated("x", longestYaml)); }, "at most 16777216 bytes"},
      {"Zeros", [] { return std::string(some, '\0'); }, "a byte 0"},
      {"NoUnicode", [] { return std::string(some, '\xff'); }, "XML"},
  };
}

class Hostile : public testing::TestWithParam<Bomb> {};
class HostileRobot : public testing::TestWithParam<RobotBomb> {};

template <class Read>
void refuse(const std::string& text, const char* refusal, Read&& read) {
#ifndef __SANITIZE_ADDRESS__  // which has its own idea of address space
  const rlimit half{1 << 29, RLIM_INFINITY};
  ASSERT_EQ(setrlimit(RLIMIT_AS, &half), 0);
#endif
  try {
    read(text);
    ADD_FAILURE() << "accepted";
  } catch (const Refused& refused) {
    const std::string words = refused.what();
    EXPECT_NE(words.find(refusal), std::string::npos) << words.substr(0, 300);
    EXPECT_LT(words.size(), 300000U);
  }
}

TEST_P(Hostile, TextIsRefusedInBoundedTimeAndMemory) {
  refuse(GetParam().text, GetParam().refusal, readSceneText);
}

TEST_P(HostileRobot, TextIsRefusedInBoundedTimeAndMemory) {
  refuse(GetParam().text(), GetParam().refusal, readUrdf);
}

template <class Param>
std::string nameOf(const testing::TestParamInfo<Param>& bomb) {
  return bomb.param.name;
}

INSTANTIATE_TEST_SUITE_P(Texts, Hostile, testing::ValuesIn(bombs()), nameOf<Bomb>);
INSTANTIATE_TEST_SUITE_P(Texts, HostileRobot, testing::ValuesIn(robotBombs()), nameOf<RobotBomb>);

TEST(Refusal, OfVeryManyFaultsSaysHowManyThereWere) {
  std::string text = "chain: [";
  for (int i = 0; i < 5000; ++i) text += "a" + std::to_string(i) + ", ";
  try {
    readSceneText(text + "]\nlinks: {b: {mass: 1, inertia: 1, com: [0, 0], pin: [1, 0]}}");
    ADD_FAILURE() << "accepted";
  } catch (const Refused& refused) {
    ASSERT_EQ(refused.faults().size(), 1001U);
    EXPECT_EQ(toString(refused.faults().front()),
              "chain/0: expected the name of an entry in links, got \"a0\"");
    EXPECT_EQ(toString(refused.faults().back()), "input: expected at most 1000 faults, got 5001");
  }
}

}  // namespace
}  // namespace planar_chain
