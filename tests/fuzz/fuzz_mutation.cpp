// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_mutation.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/json.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace nav::fuzz {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  /// A number below \p count, which is positive.
  std::size_t below(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(engine_);
  }

 private:
  std::minstd_rand engine_;
};

std::size_t by_bytes(std::uint8_t* data, std::size_t size, std::size_t most) {
  return LLVMFuzzerMutate(data, size, most);
}

std::size_t put(const std::string& text, std::uint8_t* data, std::size_t most) {
  const std::size_t size = std::min(text.size(), most);
  std::memcpy(data, text.data(), size);
  return size;
}

constexpr const char* kWords[] = {"0",
                                  "-1",
                                  "1",
                                  "0.5",
                                  "1e308",
                                  "-1e308",
                                  "1e-320",
                                  "nan",
                                  "inf",
                                  "2147483648",
                                  "-0",
                                  "1e400",
                                  "65536",
                                  "true",
                                  "false",
                                  "none",
                                  "\"\"",
                                  "\"",
                                  "'",
                                  "[",
                                  "]",
                                  "[]",
                                  "{",
                                  "}",
                                  "{}",
                                  "=",
                                  ",",
                                  ";",
                                  ":",
                                  "#",
                                  "\t",
                                  "--",
                                  "()",
                                  "\xc3",
                                  "\xef\xbb\xbf",
                                  "9223372036854775808",
                                  "0x10",
                                  "1_000",
                                  "\r",
                                  "<a>",
                                  "</a>",
                                  "/",
                                  "&#0;",
                                  "..",
                                  "/dev/null"};

/// Ends of the pieces of a text that begin at \p begin.
struct Piece {
  std::size_t begin, size;
};

std::vector<Piece> pieces_of(std::string_view text, std::string_view between) {
  std::vector<Piece> pieces;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= text.size(); ++i) {
    if (i < text.size() && between.find(text[i]) == between.npos) continue;
    if (i > begin) pieces.push_back({begin, i - begin});
    begin = i + 1;
  }
  return pieces;
}

std::string changed_text(std::string text, Dice& dice) {
  const bool lines = dice.below(3) == 0;
  const auto pieces = pieces_of(text, lines ? "\n" : " \n\t=,;:<>\"'[](){}/");
  if (pieces.empty()) return text;
  const Piece one = pieces[dice.below(pieces.size())];
  const Piece other = pieces[dice.below(pieces.size())];
  const std::string copy = text.substr(other.begin, other.size);
  switch (dice.below(4)) {
    case 0:
      return text.erase(one.begin, one.size + (lines ? 1 : 0));
    case 1:
      return text.insert(one.begin, copy + (lines ? "\n" : " "));
    case 2:
      return text.replace(one.begin, one.size, copy);
    default:
      return text.replace(one.begin, one.size, kWords[dice.below(std::size(kWords))]);
  }
}

using Json = io::Json;

void collect(Json& json, std::vector<Json*>& all) {
  all.push_back(&json);
  if (!json.is_structured()) return;
  for (Json& part : json) collect(part, all);
}

Json other_value(Dice& dice) {
  const Json values[] = {nullptr,
                         true,
                         0,
                         -1,
                         1e308,
                         1e-320,
                         std::int64_t{1} << 53,
                         "",
                         "text",
                         std::string(3000, 'x'),
                         Json::array(),
                         Json::object(),
                         Json::array({1, 2, 3}),
                         Json::array({nullptr}),
                         Json{{"name", "x"}}};
  return values[dice.below(std::size(values))];
}

void change(Json& root, Dice& dice) {
  std::vector<Json*> all;
  collect(root, all);
  Json& at = *all[dice.below(all.size())];
  const Json copy = *all[dice.below(all.size())];
  if (at.is_object() && !at.empty() && dice.below(2) == 0) {
    const auto member = std::next(at.begin(), static_cast<std::ptrdiff_t>(dice.below(at.size())));
    const std::string name = member.key();
    if (dice.below(2) == 0) at[name + "x"] = *member;
    at.erase(name);
  } else if (at.is_array() && !at.empty() && dice.below(2) == 0) {
    const std::size_t i = dice.below(at.size());
    if (dice.below(2) == 0) {
      at.erase(i);
    } else {
      at.push_back(Json(at[i]));
    }
  } else {
    at = dice.below(2) == 0 ? copy : other_value(dice);
  }
}

}  // namespace

std::size_t mutate_text(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  Dice dice(seed);
  if (dice.below(2) == 0) return by_bytes(data, size, most);
  std::string text(reinterpret_cast<const char*>(data), size);
  for (std::size_t left = 1 + dice.below(4); left > 0; --left) {
    text = changed_text(std::move(text), dice);
  }
  return put(text, data, most);
}

std::size_t mutate_json(std::uint8_t* data, std::size_t size, std::size_t most, unsigned seed) {
  Dice dice(seed);
  if (dice.below(4) == 0) return by_bytes(data, size, most);
  Json root = Json::parse(data, data + size, nullptr, false);
  if (root.is_discarded()) return mutate_text(data, size, most, seed);
  for (std::size_t left = 1 + dice.below(3); left > 0; --left) change(root, dice);
  return put(root.dump(1, ' ', false, Json::error_handler_t::replace), data, most);
}

}  // namespace nav::fuzz
