// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "app/options/settings.hpp"
#include "nav/result.hpp"

namespace nav::app {

class Section;
struct KeyWriter;

/// Variable in which an option stores its value. A slot of vectors holds as many numbers as it has
/// rows.
using Slot =
    std::variant<std::monostate, bool*, int*, std::uint64_t*, double*, std::string*,
                 std::filesystem::path*, std::optional<bool>*, std::optional<int>*,
                 std::optional<std::int64_t>*, std::optional<double>*, std::optional<std::string>*,
                 Eigen::Vector3d*, std::optional<Eigen::Vector2d>*, std::optional<Eigen::Vector3d>*,
                 std::optional<Eigen::Vector4d>*, std::optional<Eigen::Matrix<double, 6, 1>>*,
                 std::optional<std::array<double, 3>>*, std::vector<double>*,
                 std::vector<std::string>*, std::vector<std::filesystem::path>*>;

/// Numbers that an option takes, in its unit. Ends are included.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();  ///< Infinity: "inf" is taken too.
  bool above_low = false;                                 ///< Without the low end itself.
  std::string zero{};  ///< Meaning of 0, which is then taken too; empty: 0 is as any number.
};

/// A condition on another option of the same verb, whether the command line or the session file
/// gave its value.
struct Condition {
  std::string option;                 ///< Name, such as "--fusion".
  std::vector<std::string> values{};  ///< It has one of these values; empty: it is set.
};

/// An option without effect unless one of the conditions holds, or a rule that no condition states.
struct Requirement {
  std::vector<Condition> any_of{};
  bool (*met)(const Settings&) = nullptr;           ///< A rule; replaces the conditions.
  std::string text{};                               ///< The rule in words: "a DICOM folder".
  std::string (*found)(const Settings&) = nullptr;  ///< Text of what was found; null: not said.
  std::string_view verb{};                          ///< Only for this verb; empty: for all.
};

/// Property of the predicates of a set that an option acts on.
enum class SetProperty { kNone, kScanLines, kLabels, kVesselness, kGradients, kDerived };

/// One option of the command line, one key of the session file, or both.
struct Option {
  /// "--width", "sweep" for an argument without a name, empty for a key that has no option.
  std::string name{};
  /// Placeholder of the value: FILE, DIR, NAME, TEXT, LIST, N (whole number), X (number), or a unit
  /// (MM, DEG, HU, MS, S, HZ). Empty: a flag. Repeated for a slot of several numbers.
  std::string type{};
  std::string unit{};   ///< "mm"; empty: none.
  std::string text{};   ///< One sentence: a verb or noun phrase, without unit, range and default.
  std::string group{};  ///< Heading of the help and table of the documents (option_groups.hpp).
  std::vector<std::string_view> verbs{};
  Slot (*slot)(Settings&) = nullptr;  ///< Null: take, read and write do all.
  std::optional<Range> range{};       ///< For each number; where it is absent, unbounded says why.
  std::string unbounded{};            ///< Numbers that it takes, in words, where no range says it.
  std::vector<std::string> choices{};
  std::filesystem::path choices_from{};  ///< Folder whose files are choices; empty: none.
  std::string absent{};  ///< Effect of not giving it, where the slot has no default: "automatic".
  bool usual = false;    ///< Shown by --help; the others only by --help-all.
  bool required = false;
  bool repeats = false;   ///< May be given several times.
  bool negates = false;   ///< A flag that stores false.
  bool in_order = false;  ///< Stored as soon as it is read: the order among such options counts.
  bool may_be_empty = false;             ///< An empty value has a meaning.
  char delimiter = '\0';                 ///< Between the values of a list.
  std::string key{};                     ///< Session file key: "output.width_px"; empty: none.
  std::vector<std::string> more_keys{};  ///< Further keys that it sets.
  bool written_when_set = false;         ///< An empty value is left out of a session file.
  std::vector<Requirement> needs{};
  std::vector<Condition> idle_with{};   ///< It has no effect while one of these holds.
  std::vector<std::string> excludes{};  ///< Options that cannot be given beside it.
  /// Rules (met, text and found) for the value, wherever it comes from: the command line, the
  /// session file or a default.
  std::vector<Requirement> always{};
  SetProperty acts_on = SetProperty::kNone;  ///< No effect on a predicate set without it.
  std::string formerly{};                    ///< Older name, which works with a warning.
  std::string
      retired{};  ///< Reason why an option of the last version is ignored; empty: it is not.
  /// Replaces the slot: stores values that need more than a conversion. Errors: `expected …, found
  /// …`, without the name.
  Result<void> (*take)(Settings&, const std::vector<std::string>&) = nullptr;
  /// Called before the value is stored: clears what the option replaces of a session file.
  void (*before)(Settings&) = nullptr;
  /// Replace the slot in the session file. Called with the key's table.
  void (*read)(Section&, const char* key, Settings&) = nullptr;
  void (*write)(KeyWriter&, const char* key, const Settings&) = nullptr;
};

/// low to high, ends included.
inline Range within(double low, double high) { return {low, high}; }
/// More than low, to high.
inline Range above(double low, double high) { return {low, high, true}; }
/// 0 has its own meaning; otherwise low to high.
inline Range zero_or(std::string zero, double low, double high) {
  return {low, high, false, std::move(zero)};
}

/// Every option of the session verbs, in the order of the help and of the session file.
const std::vector<Option>& option_table();

/// Options of one verb, in order, without keys that have no option.
std::vector<const Option*> options_of(std::string_view verb);

/// Null: no option of that verb is called so.
const Option* find_option_of(std::string_view verb, std::string_view name);

/// True for an option without a value.
bool is_flag(const Option& option);
/// True for an argument without a name.
bool is_argument(const Option& option);

/// Fewest and most values that one use takes; most may be "any number" (negative).
struct Count {
  int fewest;
  int most;
};
Count count_of(const Option& option);

/// Stores values of the command line. Errors name the option, what was expected and what was found;
/// kUsage.
Result<void> take(const Option& option, const std::vector<std::string>& values, Settings& settings);

/// The value as a user would type it; empty: none.
std::string value_text(const Option& option, const Settings& settings);

/// True where the value is neither absent nor empty, 0 or false; of a flag that negates, false.
bool is_set(const Option& option, const Settings& settings);

/// "16 to 8192 pixels", "cpu, gl or reference", unbounded; empty: any value.
std::string range_text(const Option& option);

/// Values that the option takes, for messages: "a whole number of 16 to 8192 pixels", "3 finite
/// numbers".
std::string expected_text(const Option& option);

/// Rejects a number out of the option's range or a text that is none of its choices, as `expected
/// …, found …`.
Result<void> check_value(const Option& option, const Settings& settings);

}  // namespace nav::app
