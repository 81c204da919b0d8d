// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/own_mark.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "io/detail/input_file.hpp"
#include "io/digest.hpp"
#include "io/json.hpp"

namespace nav::io {
namespace {

constexpr std::string_view kTomlMark =
    "# Written by Sonde, which replaces this file only as long as nobody changes it. sha256: ";
/// First columns of a pose log and of following.csv.
constexpr std::array<std::string_view, 2> kLogColumns{"sequence,acquired_ns,received_ns,outcome,",
                                                      "sequence,acquired_ns,state,cost,"};
constexpr std::string_view kFooter = "Research software, not a medical device.</footer>";

Result<std::string> piece_of(const detail::InputFile& file, std::int64_t offset,
                             std::int64_t size) {
  std::string bytes(static_cast<std::size_t>(size), '\0');
  const auto got = file.read_at(offset, std::as_writable_bytes(std::span(bytes)));
  if (!got) return got.error();
  bytes.resize(*got);
  return bytes;
}

bool is_own_png(std::string_view head) {
  // Behind the signature and the header: length, type, key, zero, text.
  constexpr std::size_t kType = 37;
  const std::string mark = "tEXtSoftware" + std::string(1, '\0') + std::string(kSoftwareMark);
  return head.starts_with("\x89PNG\r\n\x1a\n") && head.size() > kType &&
         head.substr(kType).starts_with(mark);
}

bool is_own_json(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return false;
  const auto is_text = [&](const char* key) {
    const auto found = json.find(key);
    return found != json.end() && found->is_string();
  };
  return is_text("verb") && is_text("version");
}

bool is_own_meta_image(std::string_view head) {
  head = head.substr(0, head.find("\nElementDataFile"));
  return head.starts_with("ObjectType = Image\n") &&
         (head.find("\nSoftware = " + std::string(kSoftwareMark) + "\n") != head.npos ||
          head.find("\nSondeVolumeSha256 = ") != head.npos);
}

bool is_own_toml(std::string_view text) {
  if (!text.starts_with(kTomlMark)) return false;
  const std::size_t end = text.find('\n');
  if (end == text.npos) return false;
  return text.substr(kTomlMark.size(), end - kTomlMark.size()) == sha256_hex(text.substr(end + 1));
}

}  // namespace

std::string with_mark(std::string_view text) {
  return std::string(kTomlMark) + sha256_hex(text) + "\n" + std::string(text);
}

Result<bool> is_own_file(const std::filesystem::path& path) {
  const auto file = detail::InputFile::open(path);
  if (!file) return file.error();
  const std::string kind = path.extension().string();
  constexpr std::int64_t kEnd = 4096;
  constexpr std::int64_t kMostText = 256LL << 20;  // A report of 10^6 images.
  const std::int64_t size = file->size();
  const bool whole = kind == ".json" || kind == ".toml";
  if (whole && size > kMostText) return false;
  const auto head = piece_of(*file, 0, whole ? size : std::min(size, kEnd));
  if (!head) return head.error();
  if (kind == ".json") return is_own_json(*head);
  if (kind == ".toml") return is_own_toml(*head);
  if (kind == ".png") return is_own_png(*head);
  if (kind == ".mha") return is_own_meta_image(*head);
  if (kind == ".csv") {
    return std::ranges::any_of(kLogColumns, [&](auto line) { return head->starts_with(line); });
  }
  const auto tail = piece_of(*file, std::max<std::int64_t>(0, size - kEnd), std::min(size, kEnd));
  if (!tail) return tail.error();
  if (kind == ".html") return tail->find(kFooter) != tail->npos;
  if (kind == ".webp") {
    return head->starts_with("RIFF") && tail->find("XMP ") != tail->npos &&
           tail->find("CreatorTool>" + std::string(kSoftwareMark) + "<") != tail->npos;
  }
  return false;
}

}  // namespace nav::io
