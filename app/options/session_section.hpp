// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <toml++/toml.h>
#include <utility>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

/// A path as a session file says it: readable from any folder; empty stays empty.
inline std::string absolute_text(const std::filesystem::path& path) {
  return path.empty() ? "" : std::filesystem::absolute(path).lexically_normal().string();
}

/// The table of a session file that is being written.
struct KeyWriter {
  toml::table& table;
  std::filesystem::path
      folder{};  ///< Folder of the file, which paths are relative to; empty: absolute.

  /// A path as the file says it; empty stays empty.
  [[nodiscard]] std::string path(const std::filesystem::path& path) const {
    const std::string absolute = absolute_text(path);
    if (folder.empty() || absolute.empty()) return absolute;
    return std::filesystem::path(absolute)
        .lexically_proximate(std::filesystem::absolute(folder).lexically_normal())
        .string();
  }
};

/// One table of the file: hands out its values by type and, at the end, rejects keys that nobody
/// asked for. The first problem is kept; later calls do nothing.
class Section {
 public:
  Section(const std::string& file, const std::string& name, const toml::table* table,
          std::optional<Error>& error)
      : file_(file), name_(name), table_(table), error_(error) {}

  /// False where the file has no such table.
  [[nodiscard]] bool is_there() const { return table_ != nullptr; }
  /// A table inside of this one. name: in full.
  [[nodiscard]] Section inside(const std::string& name, const toml::table* table) const {
    return {file_, name, table, error_};
  }
  /// A path of the file is relative to its folder.
  [[nodiscard]] std::filesystem::path beside_file(const std::string& path) const {
    return std::filesystem::path(file_).parent_path() / path;
  }
  /// Keeps a problem of its own kind.
  void stop(ErrorCode code, const std::string& message) {
    if (!error_) error_ = Error{code, file_ + ": " + message};
  }
  /// Keeps a problem with the line of a value.
  void stop_at(const toml::node& node, const std::string& message) {
    if (!error_) fail(node, message);
  }

  void text(const char* key, std::string& value) {
    take<std::string>(key, "text", [&](const toml::node& node) {
      const auto found = node.value_exact<std::string>();
      if (found) value = *found;
      return found.has_value();
    });
  }
  void path(const char* key, std::filesystem::path& value) {
    std::string text_value;
    text(key, text_value);
    if (!text_value.empty()) value = beside_file(text_value);
  }
  void number(const char* key, std::optional<double>& value) {
    double found = std::numeric_limits<double>::quiet_NaN();
    number(key, found);
    if (std::isfinite(found)) value = found;
  }
  void flag(const char* key, std::optional<bool>& value) {
    take<bool>(key, "true or false", [&](const toml::node& node) {
      const auto found = node.value_exact<bool>();
      if (found) value = *found;
      return found.has_value();
    });
  }
  /// Any whole number that a 32-bit one holds.
  void whole_number(const char* key, std::optional<int>& value) {
    take<int>(key, "a whole number", [&](const toml::node& node) {
      const auto found = node.value_exact<std::int64_t>();
      const bool good = found && std::in_range<int>(*found);
      if (good) value = static_cast<int>(*found);
      return good;
    });
  }
  void number(const char* key, double& value) {
    take<double>(key, "a finite number", [&](const toml::node& node) {
      const auto found = node.is_number() ? node.value<double>() : std::nullopt;
      if (found && std::isfinite(*found)) value = *found;
      return found && std::isfinite(*found);
    });
  }
  /// A number that has no usual value: finish() rejects a table without it.
  void required_number(const char* key, double& value) {
    number(key, value);
    required_.emplace_back(key, "a finite number");
  }
  /// A text that has no usual value: finish() rejects a table without it.
  void required_text(const char* key, std::string& value) {
    text(key, value);
    required_.emplace_back(key, "text");
  }
  template <class Integer>
  void integer(const char* key, Integer& value) {
    take<Integer>(key, "a whole number >= 0", [&](const toml::node& node) {
      const auto found = node.value_exact<std::int64_t>();
      const bool good = found && *found >= 0 && std::in_range<Integer>(*found);
      if (good) value = static_cast<Integer>(*found);
      return good;
    });
  }
  void flag(const char* key, bool& value) {
    take<bool>(key, "true or false", [&](const toml::node& node) {
      const auto found = node.value_exact<bool>();
      if (found) value = *found;
      return found.has_value();
    });
  }
  void numbers(const char* key, std::size_t count, std::vector<double>& value) {
    take<double>(key, std::to_string(count) + " finite numbers", [&](const toml::node& node) {
      const toml::array* array = node.as_array();
      return array != nullptr && array->size() == count && take_finite(*array, value);
    });
  }
  /// Any number of numbers.
  void some_numbers(const char* key, std::vector<double>& value) {
    take<double>(key, "a list of finite numbers", [&](const toml::node& node) {
      const toml::array* array = node.as_array();
      return array != nullptr && take_finite(*array, value);
    });
  }
  /// Numbers that have no usual value: finish() rejects a table without them.
  void required_numbers(const char* key, std::size_t count, std::vector<double>& value) {
    numbers(key, count, value);
    required_.emplace_back(key, std::to_string(count) + " finite numbers");
  }
  void points(const char* key, std::vector<Eigen::Vector3d>& value) {
    take<double>(key, "a list of points, 3 finite numbers each", [&](const toml::node& node) {
      const toml::array* array = node.as_array();
      if (array == nullptr) return false;
      std::vector<Eigen::Vector3d> found;
      for (const toml::node& element : *array) {
        const toml::array* numbers = element.as_array();
        if (numbers == nullptr || numbers->size() != 3) return false;
        Eigen::Vector3d point;
        for (int axis = 0; axis < 3; ++axis) {
          const toml::node& one = (*numbers)[static_cast<std::size_t>(axis)];
          point[axis] =
              one.is_number() ? *one.value<double>() : std::numeric_limits<double>::quiet_NaN();
        }
        if (!point.allFinite()) return false;
        found.push_back(point);
      }
      value = std::move(found);
      return true;
    });
  }
  void texts(const char* key, std::vector<std::string>& value) {
    take<std::string>(key, "a list of texts", [&](const toml::node& node) {
      const toml::array* array = node.as_array();
      if (array == nullptr) return false;
      std::vector<std::string> found;
      for (const toml::node& element : *array) {
        const auto one = element.value_exact<std::string>();
        if (!one) return false;
        found.push_back(*one);
      }
      value = std::move(found);
      return true;
    });
  }
  void number_or_infinity(const char* key, std::optional<double>& value) {
    take<double>(key, "a number or inf", [&](const toml::node& node) {
      const auto found = node.is_number() ? node.value<double>() : std::nullopt;
      if (found && !std::isnan(*found)) value = *found;
      return found && !std::isnan(*found);
    });
  }
  const toml::table* table(const char* key) {
    const toml::table* found = nullptr;
    take<double>(key, "a table", [&](const toml::node& node) {
      found = node.as_table();
      return found != nullptr;
    });
    return found;
  }
  const toml::array* tables(const char* key) {
    const toml::array* found = nullptr;
    take<double>(key, "a list of tables", [&](const toml::node& node) {
      found = node.as_array();
      if (found == nullptr) return false;
      for (const toml::node& element : *found) {
        if (!element.is_table()) return false;
      }
      return true;
    });
    return found;
  }
  /// Rejects keys that nobody asked for, and a table without a key that it must have.
  void finish() {
    if (table_ == nullptr || error_) return;
    for (const auto& [key, node] : *table_) {
      if (known_.contains(std::string(key.str()))) continue;
      std::string keys;
      for (const std::string& known : known_) keys.append(keys.empty() ? "" : ", ").append(known);
      fail(node, "unknown key '" + full(std::string(key.str())) + "', expected one of " + keys);
      return;
    }
    for (const auto& [key, expected] : required_) {
      if (table_->contains(key)) continue;
      fail(*table_, full(key) + ": expected " + expected + ", found nothing");
      return;
    }
  }
  void reject(const char* key, const std::string& expected, const std::string& found) {
    if (error_ || table_ == nullptr) return;
    const toml::node* node = table_->get(key);
    if (node != nullptr) {
      fail(*node, full(key) + ": expected " + expected + ", found " + shortened(found));
    }
  }

 private:
  /// Takes the numbers of an array; false, and nothing is taken, if one is not finite or no number.
  static bool take_finite(const toml::array& array, std::vector<double>& value) {
    std::vector<double> found;
    for (const toml::node& element : array) {
      const auto one = element.is_number() ? element.value<double>() : std::nullopt;
      if (!one || !std::isfinite(*one)) return false;
      found.push_back(*one);
    }
    value = std::move(found);
    return true;
  }
  /// A value in a message.
  static std::string shortened(const std::string& value) {
    constexpr std::size_t kMost = 100;
    return value.size() > kMost ? value.substr(0, kMost) + "…" : value;
  }
  std::string full(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }
  void fail(const toml::node& node, const std::string& message) {
    error_ = Error{ErrorCode::kMalformedData,
                   file_ + ":" + std::to_string(node.source().begin.line) + ": " + message};
  }
  template <class T, class Use>
  void take(const char* key, const std::string& expected, Use use) {
    known_.insert(key);
    if (table_ == nullptr || error_) return;
    const toml::node* node = table_->get(key);
    if (node == nullptr) return;
    if (use(*node)) return;
    std::ostringstream found;
    node->visit([&](const auto& value) { found << value; });
    std::string text = found.str();
    for (char& c : text) c = c == '\n' ? ' ' : c;
    fail(*node, full(key) + ": expected " + expected + ", found " + shortened(text));
  }

  const std::string& file_;
  std::string name_;
  const toml::table* table_;
  std::optional<Error>& error_;
  std::set<std::string> known_;
  std::vector<std::pair<std::string, std::string>> required_;  ///< Keys, and what is expected.
};

}  // namespace nav::app
