/// The tree of plain values: YAML as ROS reads it, numbers in text, and how a value is shown.

#include "planar_chain/value.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "planar_chain/fault.h"

namespace planar_chain {
namespace {

Value parsed(const std::string& scalar) {
  const Value root = parseYaml("key: " + scalar + "\n");
  return root.map()->at("key");
}

std::string refusal(const std::string& yaml) {
  try {
    parseYaml(yaml);
  } catch (const Refused& refused) {
    return refused.what();
  }
  return "";
}

// ---- Scalars as PyYAML resolves them ---------------------------------------------------------

TEST(Value, BoolsAreThoseOfYaml11) {
  for (const char* word : {"true", "True", "TRUE", "yes", "Yes", "on", "ON"}) {
    ASSERT_TRUE(parsed(word).flag()) << word;
    EXPECT_TRUE(*parsed(word).flag()) << word;
  }
  for (const char* word : {"false", "False", "no", "No", "off", "OFF"}) {
    ASSERT_TRUE(parsed(word).flag()) << word;
    EXPECT_FALSE(*parsed(word).flag()) << word;
  }
  for (const char* word : {"'yes'", "\"on\"", "y", "n", "tRUE"}) {
    EXPECT_TRUE(parsed(word).text()) << word;
  }
}

TEST(Value, NumbersAreThoseOfYaml11) {
  for (const char* word : {"1", "-1", "+1", "0", "1.0", "1.", ".5", "1.0e-3", "1.0E+3", "-0.0"}) {
    EXPECT_TRUE(parsed(word).number()) << word;
  }
  for (const char* word : {"1e-3", "1.0e3", "1e3", "'1.0'", "1.2.3", "1a", "nan", "+"}) {
    EXPECT_TRUE(parsed(word).text()) << word;
  }
  EXPECT_TRUE(std::isnan(*parsed(".nan").number()));
  EXPECT_EQ(*parsed("-.inf").number(), -std::numeric_limits<double>::infinity());
}

TEST(Value, NumbersThatReadersDisagreeOnAreOdd) {
  for (const char* word : {"010", "-07", "08", "0x1F", "0b101", "1_000", "1:30", "1:30.5"}) {
    EXPECT_TRUE(parsed(word).oddNumber()) << word;
    EXPECT_FALSE(numberIn(parsed(word))) << word;
  }
  EXPECT_FALSE(numberIn(Value("010")));
}

TEST(Value, NullHasManySpellings) {
  for (const char* word : {"", "~", "null", "NULL"}) EXPECT_TRUE(parsed(word).isNull()) << word;
  EXPECT_TRUE(parsed("''").text());
}

// ---- Numbers in text -------------------------------------------------------------------------

TEST(Value, TextThatIsWhollyANumberCounts) {
  EXPECT_EQ(numberIn(std::string("1e-3")), 1e-3);
  EXPECT_EQ(numberIn(std::string("-.5E+2")), -50);
  EXPECT_EQ(numberIn(std::string("+7")), 7);
  EXPECT_EQ(numberIn(std::string("5.")), 5);
  EXPECT_EQ(numberIn(std::string("0.1")), 0.1);
  EXPECT_EQ(numberIn(std::string("1e999")), std::numeric_limits<double>::infinity());
  EXPECT_EQ(numberIn(std::string("-1e999")), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(numberIn(std::string("1e-999")), 0);
  EXPECT_TRUE(std::isnan(*numberIn(std::string("nan"))));
}

TEST(Value, OtherTextDoesNot) {
  for (const char* text : {"", ".", "-", "e5", "1e", "1e+", "1,5", " 1", "1 ", "1kg", "0x10", "--1", "1.2.3",
                           "010", "infinity", "1e5.0"}) {
    EXPECT_FALSE(numberIn(std::string(text))) << text;
  }
}

TEST(Value, NumbersAreShownAsShortAsTheyReadBack) {
  EXPECT_EQ(toText(0.1), "0.1");
  EXPECT_EQ(toText(100000), "100000");
  EXPECT_EQ(toText(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(toText(-2.5e-9), "-2.5e-09");
  EXPECT_EQ(toText(std::nan("")), "nan");
  for (const double x : {0.1 + 0.2, 1.0 / 3, M_PI, 5e-324, 1.7976931348623157e308}) {
    EXPECT_EQ(numberIn(toText(x)), x);
  }
}

// ---- Shown to their writer -------------------------------------------------------------------

TEST(Value, IsShownAsItsWriterKnowsIt) {
  EXPECT_EQ(describe(Value("heavy")), "\"heavy\"");
  EXPECT_EQ(describe(Value(-1)), "-1");
  EXPECT_EQ(describe(Value(true)), "true");
  EXPECT_EQ(describe(Value()), "nothing");
  EXPECT_EQ(describe(nullptr), "nothing");
  EXPECT_EQ(describe(parsed("[1, 2.5, x]")), "[1, 2.5, \"x\"]");
  EXPECT_EQ(describe(parsed("{b: [], a: {}}")), "{a: {}, b: []}");
  EXPECT_EQ(describe(Value("two\nlines")), "\"two lines\"");
}

TEST(Value, IsCutWhereItGetsLong) {
  EXPECT_LT(describe(Value(std::string(100000, 'x'))).size(), 100U);
  EXPECT_LT(describe(Value(Value::List(100000, Value(1)))).size(), 100U);
  // Never within a character: € has three bytes.
  std::string euros;
  for (int i = 0; i < 50; ++i) euros += "€";
  const std::string shown = describe(Value(euros));
  EXPECT_EQ(shown.size() % 3, 2U) << shown;
}

// ---- Documents -------------------------------------------------------------------------------

TEST(Value, BrokenYamlNamesLineAndColumn) {
  EXPECT_EQ(refusal("a: 1\nb: [1, 2\n"),
            "scene: expected YAML, got line 3, column 1: end of sequence flow not found");
}

TEST(Value, ColonsEndBeforeABracketAndTheEnd) {
  EXPECT_EQ(describe(parsed("[b:]")), "[{b: nothing}]");
  for (const char* yaml : {"{b:", "[b:", "a: {b:", "[a, {b:]", "[b:\4 c"}) {
    EXPECT_NE(refusal(yaml).find("scene: expected YAML"), std::string::npos) << yaml;
  }
}

TEST(Value, TabsAreNamedWhereTheyIndent) {
  for (const char* yaml : {"a:\n\tb: 1\n", "a:\n  \tb: 1\n", "a:\n  b: 1\n\tc: 2\n"}) {
    EXPECT_NE(refusal(yaml).find(": a tab, where YAML is indented with spaces"), std::string::npos) << yaml;
  }
  EXPECT_EQ(refusal("a:\tb\n"), "");
  EXPECT_EQ(refusal("a:\tb\nc: [1\n").find("tab"), std::string::npos);
}

TEST(Value, KnowsItsLine) {
  const Value root = parseYaml(
      "# a comment\n"
      "first: {x: 1,\n"
      "        y: [2,\n"
      "            3]}\n"
      "second:\n"
      "  same: &same\n"
      "    z: 4\n"
      "  again: *same\n"
      "  merged: {<<: *same}\n");
  EXPECT_EQ(lineAt(root, "first"), 2);
  EXPECT_EQ(lineAt(root, "first/x"), 2);
  EXPECT_EQ(lineAt(root, "first/y"), 3);
  EXPECT_EQ(lineAt(root, "first/y/1"), 4);
  EXPECT_EQ(lineAt(root, "second/same"), 6);
  EXPECT_EQ(lineAt(root, "second/same/z"), 7);
  EXPECT_EQ(lineAt(root, "second/again"), 8);
  EXPECT_EQ(lineAt(root, "second/merged/z"), 7);
  EXPECT_EQ(lineAt(root, "second/again/missing/deeper"), 8);
  EXPECT_EQ(lineAt(root, "first/y/2"), 3);
  EXPECT_EQ(lineAt(root, "missing"), 2);
  EXPECT_EQ(lineAt(Value(Value::Map{{"a", 1}}), "a"), 0);
}

TEST(Value, KeysStandOnceAndAreText) {
  EXPECT_NE(refusal("a: {b: 1, b: 2}").find("a/b: expected each key once"), std::string::npos);
  EXPECT_NE(refusal("a: 1\na: 2\nb: {c: 1, c: 2}").find("b/c: expected each key once"), std::string::npos);
  EXPECT_NE(refusal("a: {1: 2}").find("a: expected text as a key, got 1"), std::string::npos);
  EXPECT_NE(refusal("a: {[x]: 2}").find("text as a key"), std::string::npos);
  EXPECT_NE(refusal("? ~\n: 2\n").find("text as a key"), std::string::npos);
}

TEST(Value, AnEmptyTextIsNull) {
  EXPECT_TRUE(parseYaml("").isNull());
  EXPECT_TRUE(parseYaml("# nothing but a comment\n").isNull());
}

TEST(Value, AliasesAndMergesAreFollowed) {
  const Value root = parseYaml(
      "rod: &rod {mass: 1, com: [1, 2]}\n"
      "same: *rod\n"
      "other: {<<: *rod, mass: 2}\n"
      "several: {<<: [{mass: 3}, *rod]}\n"
      "quoted: {'<<': 1}\n");
  EXPECT_EQ(describe(root.map()->at("same")), "{com: [1, 2], mass: 1}");
  EXPECT_EQ(describe(root.map()->at("other")), "{com: [1, 2], mass: 2}");
  EXPECT_EQ(describe(root.map()->at("several")), "{com: [1, 2], mass: 3}");
  EXPECT_EQ(describe(root.map()->at("quoted")), "{<<: 1}");
  EXPECT_NE(refusal("a: {<<: 1}").find("a map or a list of maps"), std::string::npos);
}

TEST(Value, AliasesCannotExplode) {
  std::string yaml = "l0: &l0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string before = "*l" + std::to_string(i - 1);
    yaml += "l" + std::to_string(i) + ": &l" + std::to_string(i) + " [" + before;
    for (int k = 1; k < 10; ++k) yaml += ", " + before;
    yaml += "]\n";
  }
  EXPECT_NE(refusal(yaml).find("at most 1000000 values"), std::string::npos);
}

TEST(Value, AliasesOfWhatIsNotCompleteAreRefused) {
  EXPECT_NE(refusal("a: &a [1, *a]\n").find("an alias of a complete value"), std::string::npos);
  EXPECT_NE(refusal("a: *nobody\n"), "");
}

TEST(Value, DepthIsBounded) {
  const auto nested = [](int levels) {
    const auto count = static_cast<std::size_t>(levels);
    return std::string(count, '[') + std::string(count, ']');
  };
  EXPECT_EQ(refusal(nested(16)), "");
  EXPECT_NE(refusal(nested(17)).find("at most 16 levels"), std::string::npos);
  EXPECT_NE(refusal(nested(100000)), "");

  std::string chained = "l0: &l0 []\n";
  for (int i = 1; i < 20; ++i) {
    chained += "l" + std::to_string(i) + ": &l" + std::to_string(i) + " [*l" + std::to_string(i - 1) + "]\n";
  }
  EXPECT_NE(refusal(chained).find("at most 16 levels"), std::string::npos);
}

}  // namespace
}  // namespace planar_chain
