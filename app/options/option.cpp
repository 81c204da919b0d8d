// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <type_traits>

#include "app/options/option_checks.hpp"

namespace nav::app {
namespace {

template <class T>
struct Held {
  using Type = T;
  static constexpr bool kOptional = false;
};
template <class T>
struct Held<std::optional<T>> {
  using Type = T;
  static constexpr bool kOptional = true;
};

/// Numbers that one value holds; 0: it is no vector of a fixed size.
template <class T>
constexpr int kRowsOf = 0;
template <int Rows>
constexpr int kRowsOf<Eigen::Matrix<double, Rows, 1>> = Rows;
template <>
constexpr int kRowsOf<std::array<double, 3>> = 3;
template <>
constexpr int kRowsOf<std::vector<double>> = 3;

template <class T>
constexpr bool kIsWhole = std::is_integral_v<T> && !std::is_same_v<T, bool>;
template <class T>
constexpr bool kIsList = std::is_same_v<T, std::vector<std::string>> ||
                         std::is_same_v<T, std::vector<std::filesystem::path>>;

/// Calls use with the value that the option stores, or with std::monostate.
template <class Use>
decltype(auto) with_value(const Option& option, const Settings& settings, Use use) {
  // No use changes the settings: a slot only says where the value lies.
  const Slot slot = option.slot == nullptr ? Slot() : option.slot(const_cast<Settings&>(settings));
  return std::visit(
      [&](auto at) {
        if constexpr (std::is_same_v<decltype(at), std::monostate>) {
          return use(at);
        } else {
          return use(std::as_const(*at));
        }
      },
      slot);
}

/// Only the types of the slots matter to its users.
const Settings& any_settings() {
  static const Settings settings;
  return settings;
}

std::string number_text(double number) {
  std::ostringstream text;
  text.precision(12);
  text << number;
  return text.str();
}

template <class Vector>
std::string numbers_text(const Vector& numbers) {
  std::string text;
  for (const double number : numbers) text += (text.empty() ? "" : " ") + number_text(number);
  return text;
}

template <class T>
std::string as_text(const T& value) {
  using Type = typename Held<T>::Type;
  if constexpr (Held<T>::kOptional) {
    return value ? as_text(*value) : "";
  } else if constexpr (std::is_same_v<T, std::monostate>) {
    return "";
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? "on" : "off";
  } else if constexpr (kIsWhole<T>) {
    return std::to_string(value);
  } else if constexpr (std::is_same_v<T, double>) {
    return number_text(value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    return value;
  } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
    return value.string();
  } else if constexpr (kIsList<T>) {
    std::string text;
    for (const auto& one : value) text += (text.empty() ? "" : ",") + as_text(one);
    return text;
  } else {
    static_assert(kRowsOf<Type> > 0);
    return numbers_text(value);
  }
}

bool is_in(const Range& range, double number) {
  if (!range.zero.empty() && number == 0) return true;
  if (std::isnan(number)) return false;
  return number <= range.high && (range.above_low ? number > range.low : number >= range.low);
}

/// Limits of the type of a whole number; empty for other values.
std::string whole_range_text(const Option& option) {
  return with_value(option, any_settings(), [](const auto& value) -> std::string {
    using T = typename Held<std::remove_cvref_t<decltype(value)>>::Type;
    if constexpr (kIsWhole<T>) {
      using Limits = std::numeric_limits<T>;
      return std::to_string(Limits::min()) + " to " + std::to_string(Limits::max());
    } else {
      return "";
    }
  });
}

Error wrong(const Option& option, const std::string& found) {
  std::string further;
  if (!option.choices_from.empty()) {
    std::error_code none;
    const bool missing = !std::filesystem::is_directory(option.choices_from, none);
    further = " (further ones are files of " + option.choices_from.string() +
              (missing ? ", which is missing)" : ")");
  }
  return {ErrorCode::kUsage, "expected " + expected_text(option) + further + ", found " + found};
}

template <class T>
Result<T> parsed_whole(const Option& option, const std::string& text) {
  T number{};
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  if (text.empty() || read.ec != std::errc() || read.ptr != end) return wrong(option, text);
  if (option.range && !is_in(*option.range, static_cast<double>(number))) {
    return wrong(option, text);
  }
  return number;
}

Result<double> parsed_number(const Option& option, const std::string& text) {
  double number = 0;
  if (!CLI::detail::lexical_cast(text, number)) return wrong(option, text);
  if (option.range ? !is_in(*option.range, number) : !std::isfinite(number)) {
    return wrong(option, text);
  }
  return number;
}

template <class T>
Result<T> parsed(const Option& option, const std::vector<std::string>& values) {
  const std::string& text = values.front();
  if constexpr (std::is_same_v<T, bool>) {
    bool given = false;
    if (!CLI::detail::lexical_cast(text, given)) return wrong(option, text);
    return given != option.negates;
  } else if constexpr (kIsWhole<T>) {
    return parsed_whole<T>(option, text);
  } else if constexpr (std::is_same_v<T, double>) {
    return parsed_number(option, text);
  } else if constexpr (kRowsOf<T> > 0) {
    T numbers{};
    if constexpr (std::is_same_v<T, std::vector<double>>) numbers.resize(values.size());
    std::string all;
    for (const std::string& value : values) all += (all.empty() ? "" : " ") + value;
    for (std::size_t n = 0; n < values.size(); ++n) {
      const auto number = parsed_number(option, values[n]);
      if (!number) return wrong(option, all);
      using Index =
          std::conditional_t<std::is_base_of_v<Eigen::DenseBase<T>, T>, Eigen::Index, std::size_t>;
      numbers[static_cast<Index>(n)] = *number;
    }
    return numbers;
  } else if constexpr (kIsList<T>) {
    for (const std::string& value : values) {
      const bool known = option.choices.empty() || std::ranges::count(option.choices, value) > 0;
      if (!known) return wrong(option, value);
    }
    return T(values.begin(), values.end());
  } else {
    if (!option.choices.empty() && std::ranges::count(option.choices, text) == 0) {
      return wrong(option, text);
    }
    return T(text);
  }
}

Result<void> store(const Option& option, const std::vector<std::string>& values,
                   Settings& settings) {
  if (option.take != nullptr) return option.take(settings, values);
  return std::visit(
      [&](auto at) -> Result<void> {
        if constexpr (!std::is_same_v<decltype(at), std::monostate>) {
          auto value =
              parsed<typename Held<std::remove_pointer_t<decltype(at)>>::Type>(option, values);
          if (!value) return value.error();
          *at = *std::move(value);
        }
        return {};
      },
      option.slot(settings));
}

}  // namespace

Settings default_settings(std::string_view verb) {
  Settings settings;
  if (verb == "demo") {
    settings.config.appearance = settings.demo.appearance;
    settings.config.view = settings.demo.view;
  }
  return settings;
}

std::vector<const Option*> options_of(std::string_view verb) {
  std::vector<const Option*> options;
  for (const Option& option : option_table()) {
    if (!option.name.empty() && std::ranges::count(option.verbs, verb) > 0) {
      options.push_back(&option);
    }
  }
  return options;
}

const Option* find_option_of(std::string_view verb, std::string_view name) {
  for (const Option* option : options_of(verb)) {
    if (option->name == name) return option;
  }
  return nullptr;
}

bool is_flag(const Option& option) { return option.type.empty(); }

bool is_argument(const Option& option) {
  return !option.name.empty() && !option.name.starts_with('-');
}

Count count_of(const Option& option) {
  if (is_flag(option)) return {0, 0};
  if (option.repeats) return {1, -1};
  return with_value(option, any_settings(), [](const auto& value) -> Count {
    constexpr int rows = kRowsOf<typename Held<std::remove_cvref_t<decltype(value)>>::Type>;
    return rows > 0 ? Count{rows, rows} : Count{1, 1};
  });
}

Result<void> take(const Option& option, const std::vector<std::string>& values,
                  Settings& settings) {
  if (option.before != nullptr) option.before(settings);
  const auto ok = store(option, values, settings);
  if (ok) return ok;
  // Some parsers of values name the option that most verbs have for them.
  std::string said = ok.error().message;
  if (said.starts_with("--")) said = said.substr(said.find(": ") + 2);
  return Error{ok.error().code, option.name + ": " + said};
}

std::string value_text(const Option& option, const Settings& settings) {
  return with_value(option, settings, [](const auto& value) { return as_text(value); });
}

bool is_set(const Option& option, const Settings& settings) {
  return with_value(option, settings, [&](const auto& value) {
    using T = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<T, std::monostate>) {
      return false;
    } else if constexpr (std::is_same_v<T, bool>) {
      return value != option.negates;
    } else if constexpr (std::is_same_v<T, std::optional<bool>>) {
      return value && *value != option.negates;
    } else if constexpr (Held<T>::kOptional) {
      return value.has_value();
    } else if constexpr (std::is_arithmetic_v<T>) {
      return value != T{};
    } else if constexpr (std::is_same_v<T, Eigen::Vector3d>) {
      return true;
    } else {
      return !value.empty();
    }
  });
}

std::string range_text(const Option& option) {
  if (!option.choices.empty()) return listed(option.choices);
  if (!option.range) return option.unbounded.empty() ? whole_range_text(option) : option.unbounded;
  const Range& range = *option.range;
  const std::string low = number_text(range.low);
  const std::string high = number_text(range.high);
  const std::string unit = option.unit.empty() ? "" : " " + option.unit;
  const std::string zero = range.zero.empty() ? "" : "0 (" + range.zero + ") or ";
  if (std::isinf(range.high)) return zero + low + unit + " or more, or inf";
  if (range.above_low) return zero + "more than " + low + " and at most " + high + unit;
  return zero + low + " to " + high + unit;
}

std::string expected_text(const Option& option) {
  const std::string range = range_text(option);
  return with_value(option, any_settings(), [&](const auto& value) -> std::string {
    using T = typename Held<std::remove_cvref_t<decltype(value)>>::Type;
    if constexpr (std::is_same_v<T, bool>) {
      return "true or false";
    } else if constexpr (kIsWhole<T>) {
      if (option.range && !option.range->zero.empty()) return range;
      return "a whole number of " + range;
    } else if constexpr (std::is_same_v<T, double>) {
      return range.empty() ? "a number" : range;
    } else if constexpr (kRowsOf<T> > 0) {
      const std::string count = std::to_string(kRowsOf<T>);
      return option.range ? count + " numbers of " + range : count + " finite numbers";
    } else {
      return range.empty() ? "a value" : range;
    }
  });
}

Result<void> check_value(const Option& option, const Settings& settings) {
  return with_value(option, settings, [&](const auto& value) -> Result<void> {
    using T = std::remove_cvref_t<decltype(value)>;
    using Type = typename Held<T>::Type;
    if constexpr (Held<T>::kOptional) {
      if (!value) return {};
    }
    if constexpr (std::is_arithmetic_v<Type> && !std::is_same_v<Type, bool>) {
      Type number{};
      if constexpr (Held<T>::kOptional) {
        number = *value;
      } else {
        number = value;
      }
      if (option.range && !is_in(*option.range, static_cast<double>(number))) {
        return wrong(option, as_text(number));
      }
    }
    if constexpr (kRowsOf < Type >> 0) {
      const Type* numbers = nullptr;
      if constexpr (Held<T>::kOptional) {
        numbers = &*value;
      } else {
        numbers = &value;
      }
      const auto in_range = [&](double number) { return is_in(*option.range, number); };
      if (option.range && !std::all_of(numbers->begin(), numbers->end(), in_range)) {
        return wrong(option, as_text(*numbers));
      }
    }
    if constexpr (std::is_same_v<Type, std::string>) {
      const std::string text = as_text(value);
      if (!option.choices.empty() && std::ranges::count(option.choices, text) == 0) {
        return wrong(option, text);
      }
    }
    return {};
  });
}

}  // namespace nav::app
