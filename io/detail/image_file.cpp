// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/image_file.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "io/detail/input_file.hpp"
#include "io/detail/text.hpp"

namespace nav::io {

std::size_t size_of(PixelType type) {
  switch (type) {
    case PixelType::kUint8:
    case PixelType::kInt8:
      return 1;
    case PixelType::kUint16:
    case PixelType::kInt16:
      return 2;
    case PixelType::kUint32:
    case PixelType::kInt32:
    case PixelType::kFloat32:
      return 4;
    case PixelType::kFloat64:
      return 8;
  }
  return 0;
}

const char* to_string(PixelType type) {
  constexpr std::array kNames = {"uint8",  "int8",  "uint16",  "int16",
                                 "uint32", "int32", "float32", "float64"};
  return kNames[static_cast<std::size_t>(type)];
}

namespace detail {

namespace {

constexpr std::int64_t kMaxHeaderBytes = 512LL << 20;
constexpr std::size_t kMaxLineBytes = 1 << 20;

struct Span {
  std::size_t begin, size;
};

/// Reads header lines in chunks, up to the format's last line.
class HeaderReader {
 public:
  HeaderReader(const InputFile& file, ImageFile& out) : file_(file), out_(out) {}

  /// Returns the offset of the first byte after the header.
  Result<std::int64_t> read() {
    out_.text = std::make_unique<std::string>();
    while (true) {
      const auto end = out_.text->find('\n', line_begin_);
      if (end == std::string::npos) {
        if (const auto ok = check_line(); !ok) return ok.error();
        const auto more = read_chunk();
        if (!more) return more.error();
        if (*more) continue;
        if (out_.format == "NRRD" && first_done_) {  // A detached header may just end.
          const auto last = take_line(out_.text->size());
          if (!last) return last.error();
          return finish(out_.text->size());
        }
        return cut_short();
      }
      const auto done = take_line(end);
      if (!done) return done.error();
      line_begin_ = end + 1;
      if (*done) return finish(line_begin_);
    }
  }

 private:
  /// Rejects a line without an end that cannot be one of a header.
  [[nodiscard]] Result<void> check_line() const {
    const std::string_view line = std::string_view(*out_.text).substr(line_begin_);
    if (line.size() <= kMaxLineBytes && line.find('\0') == std::string_view::npos) return {};
    return Error{ErrorCode::kMalformedData,
                 file_.path().string() + ": line " + std::to_string(line_number_ + 1) +
                     ": expected a line of text of at most 1 MiB, found '" + excerpt(line) + "'"};
  }

  Result<bool> read_chunk() {
    constexpr std::size_t kChunk = 256 << 10;
    const std::size_t have = out_.text->size();
    if (static_cast<std::int64_t>(have) >= kMaxHeaderBytes) {
      return Error{ErrorCode::kMalformedData,
                   file_.path().string() + ": expected a header of at most 512 MiB, found no end"};
    }
    out_.text->resize(have + kChunk);
    const auto got = file_.read_some(static_cast<std::int64_t>(have),
                                     std::as_writable_bytes(std::span(*out_.text)).subspan(have));
    if (!got) return got.error();
    out_.text->resize(have + *got);
    return *got > 0;
  }

  Error cut_short() const {
    return {ErrorCode::kMalformedData,
            file_.path().string() + ": header cut short: expected " +
                (out_.format == "NRRD" ? "an empty line" : "ElementDataFile") +
                ", found the end of the file"};
  }

  /// Returns true when the line was the last of the header.
  Result<bool> take_line(std::size_t end) {
    const std::string_view all(*out_.text);
    const std::string_view line = all.substr(line_begin_, end - line_begin_);
    ++line_number_;
    if (line.find('\0') != std::string_view::npos) return cut_short();
    const std::string_view content = trim(line);
    if (!first_done_) {
      first_done_ = true;
      if (content.starts_with("NRRD000")) {
        out_.format = "NRRD";
        return false;
      }
      out_.format = "MetaImage";
    }
    return out_.format == "NRRD" ? take_nrrd(line, content) : take_meta(line, content);
  }

  Result<bool> take_meta(std::string_view line, std::string_view content) {
    if (content.empty()) return false;
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) return bad_line(content, "'Key = Value'");
    add(line.substr(0, equals), line.substr(equals + 1));
    return trim(line.substr(0, equals)) == "ElementDataFile";
  }

  Result<bool> take_nrrd(std::string_view line, std::string_view content) {
    if (content.empty()) return true;
    if (content.front() == '#') return false;
    // "key:=value" is free text; "field: value" belongs to the format.
    const auto colon = line.find(':');
    if (colon == std::string_view::npos) return bad_line(content, "'field: value'");
    const bool free_text = colon + 1 < line.size() && line[colon + 1] == '=';
    add(line.substr(0, colon), line.substr(colon + (free_text ? 2 : 1)));
    return false;
  }

  Error bad_line(std::string_view content, const char* expected) const {
    const std::string where = file_.path().string() + ": line " + std::to_string(line_number_);
    if (line_number_ == 1) {
      return {ErrorCode::kUnsupportedData, file_.path().string() +
                                               ": expected a MetaImage or NRRD header, found '" +
                                               excerpt(content) + "'"};
    }
    return {ErrorCode::kMalformedData,
            where + ": expected " + expected + ", found '" + excerpt(content) + "'"};
  }

  // The text may be moved in memory while it grows, so offsets are stored until it is complete.
  void add(std::string_view key, std::string_view value) {
    const auto place = [&](std::string_view piece) {
      const std::string_view t = trim(piece);
      return Span{t.empty() ? 0 : static_cast<std::size_t>(t.data() - out_.text->data()), t.size()};
    };
    places_.emplace_back(place(key), place(value));
  }

  Result<std::int64_t> finish(std::size_t header_size) {
    out_.text->resize(header_size);
    out_.text->shrink_to_fit();
    const std::string_view all(*out_.text);
    out_.fields.reserve(places_.size());
    for (const auto& [key, value] : places_) {
      const Field field(all.substr(key.begin, key.size), all.substr(value.begin, value.size));
      out_.fields.push_back(field);
      if (is_frame_key(field.first)) continue;
      const auto [old, fresh] = out_.keys.insert(field);
      if (!fresh && old->second != field.second) {
        return Error{ErrorCode::kMalformedData, file_.path().string() + ": expected one value of " +
                                                    excerpt(field.first) + ", found '" +
                                                    excerpt(old->second) + "' and '" +
                                                    excerpt(field.second) + "'"};
      }
    }
    return static_cast<std::int64_t>(header_size);
  }

  const InputFile& file_;
  ImageFile& out_;
  std::vector<std::pair<Span, Span>> places_;
  std::size_t line_begin_ = 0;
  std::size_t line_number_ = 0;
  bool first_done_ = false;
};

/// Assigns each of several raw files its share of the samples; bytes after the share are ignored.
Result<void> take_shares(ImageFile& file) {
  const auto files = static_cast<std::int64_t>(file.data.size());
  if (file.encoding != Encoding::kRaw || files < 2) return {};
  const std::int64_t share = file.sample_bytes / files;
  if (share * files != file.sample_bytes) {
    return Error{ErrorCode::kMalformedData,
                 file.path.string() + ": expected samples for " + std::to_string(files) +
                     " files of one size, found " + std::to_string(file.sample_bytes) + " bytes"};
  }
  for (DataPart& part : file.data) {
    // Only the last file may be cut short; otherwise the samples of the next file would be shifted.
    if (part.size < share && &part != &file.data.back()) {
      return Error{ErrorCode::kMalformedData,
                   part.path.string() + ": expected " + std::to_string(share) +
                       " bytes of pixels, found " + std::to_string(part.size)};
    }
    part.size = std::min(part.size, share);
  }
  return {};
}

Result<void> check_claims(ImageFile& file) {
  std::int64_t bytes = static_cast<std::int64_t>(size_of(file.type)) * file.components;
  for (const std::int64_t size : file.sizes) {
    if (__builtin_mul_overflow(bytes, size, &bytes)) {
      return Error{ErrorCode::kMalformedData,
                   file.path.string() + ": expected sizes below 2^63 bytes in all, found more"};
    }
  }
  file.sample_bytes = bytes;
  if (file.encoding == Encoding::kRaw && !file.pipe) {
    std::int64_t found = 0;
    for (const DataPart& part : file.data) found += part.size;
    if (found > bytes) file.findings.push_back(longer_than_stated(file.path, bytes, found));
  }
  if (const auto ok = take_shares(file); !ok) return ok;
  for (const DataPart& part : file.data) file.available_bytes += part.size;
  // The limit allows for the few bytes of an empty stream.
  const bool possible = bytes / kMostExpansion <= file.available_bytes;
  if (file.encoding == Encoding::kDeflate && !possible) {
    return Error{ErrorCode::kMalformedData,
                 file.path.string() + ": sizes claim " + std::to_string(bytes) +
                     " bytes, expected at most " + std::to_string(kMostExpansion) +
                     " times the compressed data, found " + std::to_string(file.available_bytes) +
                     " compressed bytes"};
  }
  return {};
}

}  // namespace

bool is_frame_key(std::string_view key) { return key.starts_with("Seq_Frame"); }

std::string_view ImageFile::value(std::string_view key) const {
  const auto found = keys.find(key);
  return found == keys.end() ? std::string_view() : found->second;
}

void compare_spellings(ImageFile& file, std::initializer_list<std::string_view> keys) {
  std::vector<std::string> values;
  std::string_view first;
  for (const std::string_view key : keys) {
    if (!file.has(key)) continue;
    if (first.empty()) first = key;
    const bool differs = file.value(key) != file.value(first);
    if (values.empty() || differs) {
      values.push_back(std::string(key) + " " + excerpt(file.value(key)));
    }
  }
  if (values.size() < 2) return;
  file.findings.push_back({.subject = file.path.string(),
                           .key = std::string(first),
                           .values = std::move(values),
                           .used = std::string(first)});
}

std::string_view other_case(const ImageFile& file, std::string_view key) {
  if (file.has(key)) return {};
  for (const auto& [found, value] : file.keys) {
    if (equals_ignoring_case(found, key)) return found;
  }
  return {};
}

namespace {

/// True if one letter that is changed, missing or too many makes a text of the other.
bool is_one_letter_off(std::string_view a, std::string_view b) {
  if (a.size() > b.size()) std::swap(a, b);
  if (b.size() - a.size() > 1 || a == b) return false;
  std::size_t same = 0;
  while (same < a.size() && a[same] == b[same]) ++same;
  const std::size_t behind = a.size() == b.size() ? 1 : 0;
  return a.substr(std::min(same + behind, a.size())) == b.substr(same + 1);
}

}  // namespace

void note_near_key(ImageFile& file, std::string_view key, std::span<const char* const> known) {
  constexpr std::size_t kLeast = 6;
  if (file.has(key) || key.size() < kLeast) return;
  for (const auto& [found, value] : file.keys) {
    if (!is_one_letter_off(found, key) || std::ranges::find(known, found) != known.end()) continue;
    file.findings.push_back({.subject = file.path.string(),
                             .key = excerpt(found),
                             .values = {"unknown (is it " + std::string(key) + "?)"},
                             .used = "nothing of it"});
    return;
  }
}

Error bad_field(const ImageFile& file, std::string_view key, const std::string& expected,
                std::string_view found) {
  return {ErrorCode::kMalformedData, file.path.string() + ": " + std::string(key) + ": expected " +
                                         expected + ", found '" + excerpt(found) + "'"};
}

Result<ImageFile> read_image_file(const std::filesystem::path& path, bool pipes) {
  auto opened = pipes ? InputFile::open_or_pipe(path) : InputFile::open(path);
  if (!opened) return opened.error();
  const auto input = std::make_shared<const InputFile>(*std::move(opened));
  ImageFile file;
  file.path = path;
  if (input->is_pipe()) file.pipe = input;
  HeaderReader reader(*input, file);
  const auto offset = reader.read();
  if (!offset) return offset.error();
  const auto interpreted = file.format == "NRRD"
                               ? interpret_nrrd(file, *offset, input->size())
                               : interpret_meta_image(file, *offset, input->size());
  if (!interpreted) return interpreted.error();
  const auto possible = check_claims(file);
  if (!possible) return possible.error();
  return file;
}

namespace {

Result<DataPart> detached_part(const std::filesystem::path& path, std::int64_t skip_bytes) {
  const auto input = InputFile::open(path);
  if (!input) return input.error();
  if (skip_bytes > input->size()) {
    return Error{ErrorCode::kMalformedData, path.string() + ": expected more than " +
                                                std::to_string(skip_bytes) + " bytes, found " +
                                                std::to_string(input->size())};
  }
  return DataPart{path, skip_bytes, input->size() - skip_bytes};
}

/// Replaces %d or %03d in a name by a number; nothing when the name has no such pattern.
std::optional<std::string> number_name(std::string_view pattern, std::int64_t number) {
  const auto percent = pattern.find('%');
  if (percent == std::string_view::npos) return {};
  const auto end = pattern.find('d', percent);
  if (end == std::string_view::npos || end - percent > 3) return {};
  const std::string_view width_text = pattern.substr(percent + 1, end - percent - 1);
  const auto width = width_text.empty() ? 0 : parse_int(width_text);
  if (!width || *width < 0) return {};
  std::string digits = std::to_string(number);
  if (digits.size() < static_cast<std::size_t>(*width)) {
    digits.insert(0, static_cast<std::size_t>(*width) - digits.size(),
                  width_text.starts_with('0') ? '0' : ' ');
  }
  return std::string(pattern.substr(0, percent)) + digits + std::string(pattern.substr(end + 1));
}

}  // namespace

Result<std::vector<DataPart>> detached_parts(const ImageFile& file, std::string_view key,
                                             std::string_view value, std::int64_t skip_bytes) {
  const std::filesystem::path folder = file.path.parent_path();
  std::vector<DataPart> parts;
  const auto words = split_words(value);
  if (words.empty()) return bad_field(file, key, "a file name", value);
  // A path has at most 4096 bytes.
  constexpr std::size_t kLongest = 4096;
  if (value.size() > kLongest) return bad_field(file, key, "the name of a file", value);
  const auto blame = [&](const Error& error) {
    return Error{error.code, file.path.string() + ": " + std::string(key) + ": " + error.message};
  };
  if (words[0] == "LIST") {
    return Error{ErrorCode::kUnsupportedData, file.path.string() + ": " + std::string(key) +
                                                  ": lists of files are not supported"};
  }
  if (words.size() < 3 || words[0].find('%') == std::string_view::npos) {
    auto part = detached_part(folder / std::string(value), skip_bytes);
    if (!part) return blame(part.error());
    parts.push_back(std::move(*part));
    return parts;
  }
  const auto first = parse_int(words[1]);
  const auto last = parse_int(words[2]);
  const auto step = words.size() > 3 ? parse_int(words[3]) : 1;
  constexpr std::int64_t kMaxFiles = 100000;
  if (!first || !last || !step || *first < 0 || *last < *first || *step < 1 ||
      (*last - *first) / *step >= kMaxFiles || words.size() > 5) {
    return bad_field(file, key, "'name%d first last step' of at most 100000 files", value);
  }
  for (std::int64_t number = *first; number <= *last; number += *step) {
    const auto name = number_name(words[0], number);
    if (!name) return bad_field(file, key, "a pattern like name%03d.raw", value);
    auto part = detached_part(folder / *name, skip_bytes);
    if (!part) return blame(part.error());
    parts.push_back(std::move(*part));
  }
  return parts;
}

}  // namespace detail
}  // namespace nav::io
