// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/json.hpp"
#include "nav/result.hpp"

namespace nav::io {

inline constexpr double kRadPerDeg = M_PI / 180;

/// Levels of lists and objects in each other, at most.
inline constexpr int kDeepestJson = 64;

/// A text as JSON, at most kDeepestJson levels deep; the message begins with the name of the file.
Result<Json> parse_json(const std::string& name, const std::string& text);
/// Reads a file of at most \p most_bytes as JSON. Errors: those of parse_json() and
/// io::read_file().
Result<Json> read_json(const std::filesystem::path& path, std::uint64_t most_bytes);

/// One object of the file: hands out its members and, at the end, rejects members that nobody asked
/// for. The first problem is kept.
class JsonMember {
 public:
  JsonMember(const Json& json, std::string where, std::optional<Error>& error)
      : json_(json), where_(std::move(where)), error_(error) {
    if (!json_.is_object()) fail("", "an object", json_);
  }
  void number(const char* key, double& value, bool infinite = false) {
    take(key, infinite ? "a number or null" : "a number", [&](const Json& found) {
      if (infinite && found.is_null()) value = std::numeric_limits<double>::infinity();
      if (found.is_number()) value = found.get<double>();
      return (infinite && found.is_null()) || (found.is_number() && std::isfinite(value));
    });
  }
  /// A number that has no usual value: finish() rejects an object without it.
  void required_number(const char* key, double& value) {
    number(key, value);
    required_.push_back(key);
  }
  void angle(const char* key, double& value_rad) {
    double degrees = value_rad / kRadPerDeg;
    number(key, degrees);
    value_rad = degrees * kRadPerDeg;
  }
  void flag(const char* key, bool& value) {
    take(key, "true or false", [&](const Json& found) {
      if (found.is_boolean()) value = found.get<bool>();
      return found.is_boolean();
    });
  }
  void text(const char* key, std::string& value) {
    take(key, "text", [&](const Json& found) {
      if (found.is_string()) value = found.get<std::string>();
      return found.is_string();
    });
  }
  void numbers(const char* key, std::size_t count, std::vector<double>& value) {
    take(key, std::to_string(count) + " numbers", [&](const Json& found) {
      const bool good =
          found.is_array() && found.size() == count &&
          std::all_of(found.begin(), found.end(), [](const Json& x) { return x.is_number(); });
      if (good) value = found.get<std::vector<double>>();
      return good;
    });
  }
  /// Checks the version of a format. The error says if a newer Sonde has written the file.
  void version(const char* key, int known) {
    const Json* found = any(key);
    if (error_) return;
    const bool number = found != nullptr && found->is_number();
    if (number && found->get<double>() == known) return;
    if (!number || found->get<double>() < known) {
      return fail(key, std::to_string(known), found == nullptr ? Json() : *found);
    }
    error_ = Error{ErrorCode::kUnsupportedData,
                   where_ + "." + key + ": expected version " + std::to_string(known) + ", found " +
                       found->dump() + ", which a newer Sonde has written"};
  }
  /// The member itself, or nothing when it is absent.
  const Json* any(const char* key) {
    known_.insert(key);
    return json_.is_object() && json_.contains(key) ? &json_.at(key) : nullptr;
  }
  /// Reads a member that is an object; nothing if it is absent.
  void object(const char* key, const std::function<void(JsonMember&)>& read) {
    const Json* found = any(key);
    if (found == nullptr || error_) return;
    JsonMember member(*found, where_ + "." + key, error_);
    read(member);
  }
  void list(const char* key, const std::function<void(const Json&, const std::string&)>& visit) {
    take(key, "a list", [&](const Json& found) {
      if (!found.is_array()) return false;
      for (std::size_t i = 0; i < found.size() && !error_; ++i) {
        visit(found[i], where_ + "." + key + "[" + std::to_string(i) + "]");
      }
      return true;
    });
  }
  /// Rejects members that nobody asked for, and an object without a required member.
  void finish() {
    if (!json_.is_object() || error_) return;
    for (const auto& [key, value] : json_.items()) {
      if (!known_.contains(key)) fail(key, "no such member", value);
    }
    for (const char* key : required_) {
      if (error_ || json_.contains(key)) continue;
      error_ = Error{ErrorCode::kMalformedData,
                     where_ + "." + key + ": expected a number, found nothing"};
    }
  }
  void fail(const std::string& key, const std::string& expected, const Json& found) {
    if (error_) return;
    std::string text = found.dump(-1, ' ', true, Json::error_handler_t::replace);
    if (text.size() > 60) text = text.substr(0, 60) + "…";
    error_ = Error{ErrorCode::kMalformedData, where_ + (key.empty() ? "" : "." + key) +
                                                  ": expected " + expected + ", found " + text};
  }

 private:
  void take(const char* key, const std::string& expected,
            const std::function<bool(const Json&)>& use) {
    const Json* found = any(key);
    if (found == nullptr || error_) return;
    if (!use(*found)) fail(key, expected, *found);
  }
  const Json& json_;
  std::string where_;
  std::optional<Error>& error_;
  std::set<std::string> known_;
  std::vector<const char*> required_;
};

}  // namespace nav::io
