// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <set>
#include <sstream>

#include "app/options/option_help.hpp"
#include "app/options/option_parser.hpp"
#include "app/options/verb_table.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

std::string name_of(const Option& option) { return option.name + " " + option.key; }

TEST(OptionTableTest, EveryKeyIsOneOfTheSessionFile) {
  const test::TemporaryFolder folder;
  const auto path = folder / "session.toml";
  for (const Option& option : option_table()) {
    std::vector<std::string> keys = option.more_keys;
    if (!option.key.empty()) keys.push_back(option.key);
    for (const std::string& key : keys) {
      std::ofstream(path) << key << " = 1979-05-27\n";  // No value is a date.
      const auto read = read_session_config(path);
      ASSERT_FALSE(read) << key;
      EXPECT_EQ(read.error().message.find("unknown key"), std::string::npos)
          << read.error().message;
      EXPECT_NE(read.error().message.find("1979-05-27"), std::string::npos) << read.error().message;
    }
  }
}

TEST(OptionTableTest, EveryRowHasAVerbOrAKeyAPlaceForItsValueATextAndAGroup) {
  for (const Option& option : option_table()) {
    EXPECT_TRUE(!option.verbs.empty() || !option.key.empty()) << name_of(option);
    EXPECT_EQ(option.name.empty(), option.verbs.empty()) << name_of(option);
    EXPECT_TRUE(option.slot != nullptr || option.take != nullptr || option.read != nullptr ||
                !option.retired.empty())
        << name_of(option);
    EXPECT_FALSE(option.group.empty()) << name_of(option);
    ASSERT_FALSE(option.text.empty()) << name_of(option);
    EXPECT_NE(option.text.back(), '.') << option.text;
    for (const char* start : {"of ", "what ", "whether ", "where ", "as ", "by ", "the same"}) {
      EXPECT_FALSE(option.text.starts_with(start)) << option.text;
    }
    for (const std::string_view verb : option.verbs) {
      EXPECT_NE(find_verb(verb), nullptr) << verb;
    }
  }
}

TEST(OptionTableTest, NoVerbHasTwoOptionsOfOneName) {
  for (const Verb& verb : verb_table()) {
    std::set<std::string> names;
    for (const Option* option : options_of(verb.name)) {
      EXPECT_TRUE(names.insert(option->name).second) << verb.name << " " << option->name;
    }
  }
}

TEST(OptionTableTest, EveryValueHasADefaultOrSaysWhatHappensWithoutIt) {
  for (const Verb& verb : verb_table()) {
    const Settings defaults = default_settings(verb.name);
    for (const Option* option : options_of(verb.name)) {
      const bool said = !option->absent.empty() || option->required || is_flag(*option);
      EXPECT_TRUE(said || !value_text(*option, defaults).empty()) << verb.name << name_of(*option);
    }
  }
}

TEST(OptionTableTest, EveryDefaultIsInItsRange) {
  for (const Verb& verb : verb_table()) {
    const Settings defaults = default_settings(verb.name);
    for (const Option* option : options_of(verb.name)) {
      EXPECT_TRUE(test::has_value(check_value(*option, defaults))) << verb.name << name_of(*option);
    }
  }
}

TEST(OptionTableTest, EveryNumberHasARangeOrSaysWhyNot) {
  const std::set<std::string> units{"X", "N",  "MM", "DEG", "HU",  "MS",
                                    "S", "HZ", "ML", "PPM", "MM/S"};
  int checked = 0;
  for (const Option& option : option_table()) {
    if (!units.contains(option.type) || !option.retired.empty()) continue;
    ++checked;
    EXPECT_FALSE(range_text(option).empty()) << name_of(option);
    EXPECT_TRUE(option.range.has_value() + !option.unbounded.empty() <= 1) << name_of(option);
    EXPECT_FALSE(option.unit == "mm" && option.type == "X") << name_of(option);
  }
  EXPECT_GT(checked, 90);
  EXPECT_EQ(range_text(*find_option_of("demo", "--seed")), "0 to 18446744073709551615");
  EXPECT_EQ(range_text(*find_option_of("slices", "--at")), "-10000000 to 10000000 mm");
}

TEST(OptionTableTest, ARangeHoldsForEachOfSeveralNumbers) {
  Settings settings;
  const Option& at = *find_option_of("slices", "--at");
  const auto far = take(at, {"0", "1e8", "0"}, settings);
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().message,
            "--at: expected 3 numbers of -10000000 to 10000000 mm, found 0 1e8 0");
  settings.config.predicates.apex_ct = Eigen::Vector3d(0, -2e7, 0);
  const auto from_a_file = check_value(*find_option_of("replay", "--apex"), settings);
  ASSERT_FALSE(from_a_file);
  EXPECT_EQ(from_a_file.error().message,
            "expected 3 numbers of -10000000 to 10000000 mm, found 0 -20000000 0");
}

TEST(OptionTableTest, ConditionsAndExclusionsNameOptionsOfSomeCommonVerb) {
  for (const Option& option : option_table()) {
    std::vector<std::string> named = option.excludes;
    std::vector<Condition> conditions = option.idle_with;
    for (const Requirement& need : option.needs) {
      EXPECT_TRUE(need.met == nullptr || !need.text.empty()) << name_of(option);
      conditions.insert(conditions.end(), need.any_of.begin(), need.any_of.end());
    }
    for (const Condition& condition : conditions) named.push_back(condition.option);
    for (const std::string& other : named) {
      EXPECT_TRUE(std::ranges::any_of(
          option.verbs,
          [&](std::string_view verb) { return find_option_of(verb, other) != nullptr; }))
          << name_of(option) << " " << other;
    }
    for (const Condition& condition : conditions) {
      for (const std::string& value : condition.values) {
        const auto* other = find_option_of(option.verbs.front(), condition.option);
        ASSERT_NE(other, nullptr);
        EXPECT_EQ(std::ranges::count(other->choices, value), 1) << condition.option << " " << value;
      }
    }
  }
}

TEST(OptionTableTest, EveryVerbHasTwoExamplesThatItTakes) {
  for (const Verb& verb : verb_table()) {
    EXPECT_EQ(verb.examples.size(), 2U) << verb.name;
    for (const std::string& example : verb.examples) {
      std::istringstream stream(example);
      std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
      ASSERT_GE(words.size(), 2U);
      EXPECT_EQ(words[0], "sonde");
      EXPECT_EQ(words[1], verb.name);
      std::vector<std::string> reversed(words.rbegin(), words.rend() - 2);
      CLI::App parser;
      Settings settings = default_settings(verb.name);
      add_options(parser, verb.name, settings);
      EXPECT_NO_THROW(parser.parse(reversed)) << example;
      EXPECT_TRUE(test::has_value(reject_idle(parser, verb.name, settings))) << example;
      EXPECT_TRUE(test::has_value(validate(settings.config))) << example;
    }
  }
}

TEST(OptionTableTest, OtherVerbsHaveTwoExamplesToo) {
  for (const Verb& verb : other_verbs()) {
    EXPECT_EQ(verb.examples.size(), 2U) << verb.name;
    EXPECT_TRUE(options_of(verb.name).empty()) << verb.name;
    EXPECT_EQ(find_verb(verb.name), &verb);
    const std::string help = verb_help(verb, false);
    for (const std::string& example : verb.examples) {
      EXPECT_TRUE(example.starts_with("sonde " + verb.name + " ")) << example;
      EXPECT_NE(help.find("  " + example + "\n"), std::string::npos) << help;
    }
  }
}

TEST(OptionTableTest, HelpIsShortEnoughForATerminalAndShowsTheRequiredOptions) {
  for (const Verb& verb : verb_table()) {
    const std::string usual = verb_help(verb, false);
    EXPECT_LT(std::ranges::count(usual, '\n'), 75) << usual;
    const std::string all = verb_help(verb, true);
    for (const Option* option : options_of(verb.name)) {
      if (!option->retired.empty()) continue;
      const std::string line = "\n  " + usage_text(*option);
      EXPECT_NE(all.find(line), std::string::npos) << verb.name << line;
      if (option->required) {
        EXPECT_NE(usual.find(line), std::string::npos) << line;
      }
    }
  }
}

/// Repeat: sonde help --tables docs/PAGE, written over the page.
TEST(OptionTableTest, TablesOfTheDocumentsAreThoseOfTheTable) {
  for (const char* page : {"command-line.md", "session-file.md"}) {
    const std::string path = std::string(SONDE_SOURCE_DIR) + "/docs/" + page;
    std::ifstream file(path);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    ASSERT_NE(text.find("<!-- end -->"), std::string::npos) << path;
    const auto generated = with_tables(text);
    ASSERT_TRUE(test::has_value(generated));
    EXPECT_TRUE(*generated == text) << "run 'sonde help --tables docs/" << page << "'";
  }
  EXPECT_FALSE(with_tables("<!-- options of nothing -->\n<!-- end -->\n"));
  EXPECT_FALSE(with_tables("<!-- options of demo -->\n"));
}

TEST(OptionTableTest, AnErrorOfAKeyNamesTheOptionThatWasGiven) {
  CLI::App verb;
  Settings settings;
  add_options(verb, "replay", settings);
  const Error about{ErrorCode::kUsage, "look.cutaway.theta1_deg: expected at most theta2_deg"};
  const auto without = as_given(verb, "replay", about);
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().message, about.message);
  verb.parse("--cutaway-inner 60");
  const auto with = as_given(verb, "replay", about);
  ASSERT_FALSE(with);
  EXPECT_EQ(with.error().message,
            "--cutaway-inner (look.cutaway.theta1_deg): expected at most theta2_deg");
}

TEST(OptionTableTest, ValuesOfTheCommandLineAreStoredOrRejectedByRange) {
  Settings settings;
  const Option& width = *find_option_of("replay", "--width");
  EXPECT_TRUE(test::has_value(take(width, {"640"}, settings)));
  EXPECT_EQ(settings.config.output.width, 640);
  for (const char* wrong : {"15", "8193", "many", "1.5", "", "99999999999"}) {
    const auto refused = take(width, {wrong}, settings);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().message,
              "--width: expected a whole number of 16 to 8192 pixels, found " + std::string(wrong));
  }
  const Option& overlay = *find_option_of("demo", "--cutaway-overlay");
  EXPECT_TRUE(test::has_value(take(overlay, {"inf"}, settings)));
  EXPECT_TRUE(settings.config.appearance.cutaway.enabled.value_or(false)) << "turned on";
  EXPECT_FALSE(take(overlay, {"nan"}, settings));
  const Option& at = *find_option_of("slices", "--at");
  EXPECT_TRUE(test::has_value(take(at, {"1", "2", "-3"}, settings)));
  EXPECT_EQ(*settings.slices.at_ct, Eigen::Vector3d(1, 2, -3));
  EXPECT_FALSE(take(at, {"1", "inf", "3"}, settings));
}

TEST(OptionTableTest, AnOlderNameWorksAndIsReported) {
  Option seed = *find_option_of("demo", "--seed");
  seed.formerly = "--patient";
  CLI::App verb;
  Settings settings;
  add_option(verb, seed, settings);
  verb.parse("--patient 7");
  EXPECT_EQ(settings.demo.seed, 7U);
  EXPECT_EQ(renamed_options({&seed}, {"demo", "--patient=7"}),
            std::vector<std::string>{"--patient is now called --seed"});
  EXPECT_TRUE(renamed_options({&seed}, {"demo", "--seed", "7"}).empty());
}

}  // namespace
}  // namespace nav::app
