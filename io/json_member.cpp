// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/json_member.hpp"

#include <algorithm>
#include <memory>
#include <string_view>

#include "io/atomic_file.hpp"
#include "io/detail/text.hpp"

template class nlohmann::basic_json<nlohmann::ordered_map>;

namespace nav::io {
namespace {

/// Deepest nesting of lists and objects, outside of texts.
int depth_of(const std::string& text) {
  int depth = 0;
  int deepest = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if (c == ']' || c == '}') --depth;
  }
  return deepest;
}

/// Keeps the name of a member that an object has twice: the parser takes the last one without a
/// word.
Json::parser_callback_t reject_twice(std::string& twice) {
  using Event = Json::parse_event_t;
  auto open = std::make_shared<std::vector<std::set<std::string>>>();
  return [open, &twice](int, Event event, Json& found) {
    if (event == Event::object_start) open->emplace_back();
    if (event == Event::object_end) open->pop_back();
    if (event == Event::key && !open->back().insert(found.get<std::string>()).second) {
      twice = found.get<std::string>();
    }
    return true;
  };
}

/// The place at which a text stops being JSON, for a message. \p byte: its number, counted from 1;
/// 0: unknown.
std::string place_of(const std::string& text, std::size_t byte) {
  if (byte == 0) return "a number or text that is none";
  if (byte > text.size()) return "the end of the text";
  const auto before = std::string_view(text).substr(0, byte - 1);
  const auto line = 1 + std::ranges::count(before, '\n');
  const std::size_t begin = before.rfind('\n') + 1;  // npos + 1 is 0.
  return "'" + detail::excerpt(std::string_view(text).substr(byte - 1, 20)) + "' at line " +
         std::to_string(line) + ", column " + std::to_string(byte - begin);
}

}  // namespace

Result<Json> parse_json(const std::string& name, const std::string& text) {
  if (const int depth = depth_of(text); depth > kDeepestJson) {
    return Error{ErrorCode::kMalformedData, name + ": expected JSON at most " +
                                                std::to_string(kDeepestJson) +
                                                " levels deep, found " + std::to_string(depth)};
  }
  std::string twice;
  try {
    Json found = Json::parse(text, reject_twice(twice));
    if (twice.empty()) return found;
    return Error{ErrorCode::kMalformedData,
                 name + ": expected each member of an object once, found \"" + twice + "\" twice"};
  } catch (const nlohmann::json::exception& problem) {
    const auto* at = dynamic_cast<const nlohmann::json::parse_error*>(&problem);
    return Error{ErrorCode::kMalformedData,
                 name + ": expected JSON, found " + place_of(text, at != nullptr ? at->byte : 0)};
  }
}

Result<Json> read_json(const std::filesystem::path& path, std::uint64_t most_bytes) {
  const auto text = io::read_file(path, most_bytes);
  if (!text) return text.error();
  return parse_json(path.string(), *text);
}

}  // namespace nav::io
