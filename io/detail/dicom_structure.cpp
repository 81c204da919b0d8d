// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/dicom_structure.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>

#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

constexpr std::uint32_t kUndefined = 0xffffffffU;
constexpr std::uint32_t kItem = 0xfffee000U;
constexpr std::uint32_t kItemEnd = 0xfffee00dU;
constexpr std::uint32_t kSequenceEnd = 0xfffee0ddU;
constexpr std::uint32_t kPixelData = 0x7fe00010U;
constexpr std::uint32_t kTransferSyntax = 0x00020010U;
constexpr int kMaxDepth = 32;

struct Element {
  std::uint32_t tag = 0;
  std::string vr;  ///< Empty in implicit coding and for items.
  std::uint32_t size = 0;
  std::int64_t value = 0;  ///< Offset of the value.
};

struct Coding {
  bool implicit = false;
  bool big_endian = false;
};

class Walker {
 public:
  explicit Walker(const InputFile& file) : file_(file) {}

  std::string walk() {
    std::int64_t at = 0;
    std::array<std::byte, 4> magic{};
    constexpr std::int64_t kPreamble = 128;
    if (read(kPreamble, magic) && text(magic) == "DICM") {
      at = read_meta(kPreamble + 4);
      if (at < 0) return defect_;
    } else {
      std::array<std::byte, 2> vr{};
      coding_.implicit = !read(4, vr) || !is_vr(text(vr));
    }
    walk_elements(at, file_.size(), 0);
    return defect_;
  }

 private:
  static bool is_vr(std::string_view vr) {
    return std::all_of(vr.begin(), vr.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  }
  template <std::size_t N>
  static std::string text(const std::array<std::byte, N>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), N};
  }
  bool read(std::int64_t at, std::span<std::byte> out) const {
    const auto got = file_.read_at(at, out);
    return got && *got == out.size();
  }
  std::uint32_t number(std::span<const std::byte> bytes, bool big) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const std::size_t place = big ? bytes.size() - 1 - i : i;
      value |= static_cast<std::uint32_t>(bytes[i]) << (8 * place);
    }
    return value;
  }
  std::int64_t fail(const std::string& what, std::int64_t at) {
    if (defect_.empty()) defect_ = what + " at byte " + std::to_string(at);
    return -1;
  }

  /// Reads group 2, which is always explicit and little-endian. Returns the offset of the data set,
  /// or -1.
  std::int64_t read_meta(std::int64_t at) {
    std::string syntax;
    while (at < file_.size()) {
      // The following element may have another coding, so only its group may be read here.
      std::array<std::byte, 2> group{};
      if (!read(at, group) || number(group, false) != 2) break;
      const auto element = header(at, file_.size(), {});
      if (!element) return -1;
      if (element->size == kUndefined) {
        return fail("expected a length of an element of group 2, found none", at);
      }
      if (element->tag == kTransferSyntax && element->size <= 64) {
        std::array<std::byte, 64> value{};
        if (!read(element->value, std::span(value).first(element->size))) {
          return fail("transfer syntax cut short", at);
        }
        syntax = text(value).substr(0, element->size);
        while (!syntax.empty() && (syntax.back() == '\0' || syntax.back() == ' '))
          syntax.pop_back();
      }
      at = element->value + element->size;
    }
    if (syntax == "1.2.840.10008.1.2.1.99") {
      return fail("expected a transfer syntax that is not deflated, found a deflated one", at);
    }
    coding_.implicit = syntax == "1.2.840.10008.1.2";
    coding_.big_endian = syntax == "1.2.840.10008.1.2.2";
    return at;
  }

  /// Reads the header of an element whose value ends before \p end.
  std::optional<Element> header(std::int64_t at, std::int64_t end, const Coding& coding) {
    std::array<std::byte, 12> bytes{};
    const auto available = static_cast<std::size_t>(std::clamp<std::int64_t>(end - at, 0, 12));
    if (available < 8 || !read(at, std::span(bytes).first(available))) {
      fail("expected an element of at least 8 bytes, found the end", at);
      return {};
    }
    const auto part = [&](std::size_t from, std::size_t size) {
      return number(std::span(bytes).subspan(from, size), coding.big_endian);
    };
    Element element;
    element.tag = part(0, 2) << 16 | part(2, 2);
    const bool item = element.tag >> 16 == 0xfffe;
    std::int64_t header_size = 8;
    if (item || coding.implicit) {
      element.size = part(4, 4);
    } else {
      element.vr = text(bytes).substr(4, 2);
      if (!is_vr(element.vr)) {
        fail("expected a value representation of two letters, found '" + excerpt(element.vr) + "'",
             at);
        return {};
      }
      constexpr std::array<std::string_view, 13> kLong = {"OB", "OD", "OF", "OL", "OV", "OW", "SQ",
                                                          "SV", "UC", "UN", "UR", "UT", "UV"};
      if (std::find(kLong.begin(), kLong.end(), element.vr) != kLong.end()) {
        header_size = 12;
        if (available < 12) {
          fail("expected an element of at least 12 bytes, found the end", at);
          return {};
        }
        element.size = part(8, 4);
      } else {
        element.size = part(6, 2);
      }
    }
    element.value = at + header_size;
    if (element.size != kUndefined && element.value + element.size > end) {
      fail("pixel data or another element cut short: expected a value of " +
               std::to_string(element.size) + " bytes, found " +
               std::to_string(end - element.value),
           at);
      return {};
    }
    return element;
  }

  /// Walks the elements from \p at to \p end, or to the end mark of an item. Returns the offset of
  /// their end, or -1.
  std::int64_t walk_elements(std::int64_t at, std::int64_t end, int depth) {
    if (depth > kMaxDepth) return fail("expected sequences of at most 32 levels, found more", at);
    while (at < end) {
      const auto element = header(at, end, coding_);
      if (!element) return -1;
      if (element->tag == kItemEnd && depth > 0) return element->value;
      if (element->tag >> 16 == 0xfffe) return fail("expected an element, found an item", at);
      if (element->size == kUndefined && element->tag == kPixelData) {
        at = walk_fragments(element->value, end);
      } else if (element->vr == "SQ" || element->size == kUndefined) {
        const bool open = element->size == kUndefined;
        at = walk_items(element->value, open ? end : element->value + element->size, open, depth,
                        element->vr == "UN");
      } else {
        at = element->value + element->size;
      }
      if (at < 0) return -1;
      // The library goes on behind the pixel data.
      if (element->tag == kPixelData && depth == 0 && is_padding(at, end)) return at;
    }
    return at;
  }

  /// True if only zeros are left, or nothing.
  bool is_padding(std::int64_t at, std::int64_t end) {
    std::array<std::byte, 4096> bytes{};
    for (; at < end; at += static_cast<std::int64_t>(bytes.size())) {
      const auto some = std::span(bytes).first(static_cast<std::size_t>(
          std::min<std::int64_t>(end - at, static_cast<std::int64_t>(bytes.size()))));
      if (!read(at, some)) return true;
      if (!std::ranges::all_of(some, [](std::byte b) { return b == std::byte{0}; })) return false;
    }
    return true;
  }

  std::int64_t walk_items(std::int64_t at, std::int64_t end, bool open, int depth, bool unknown) {
    const Coding outside = coding_;
    if (unknown) coding_.implicit = true;  // PS3.5, 6.2.2: unknown sequences are implicit inside.
    while (at < end) {
      const auto item = header(at, end, coding_);
      if (!item) return -1;
      if (item->tag == kSequenceEnd && open) {
        coding_ = outside;
        return item->value;
      }
      if (item->tag != kItem) return fail("expected an item of a sequence, found another tag", at);
      const bool open_item = item->size == kUndefined;
      at = walk_elements(item->value, open_item ? end : item->value + item->size, depth + 1);
      if (at < 0) return -1;
    }
    if (open) return fail("expected the end of a sequence, found the end of the file", at);
    coding_ = outside;
    return at;
  }

  std::int64_t walk_fragments(std::int64_t at, std::int64_t end) {
    while (at < end) {
      const auto item = header(at, end, coding_);
      if (!item) return -1;
      if (item->tag == kSequenceEnd) return item->value;
      if (item->tag != kItem || item->size == kUndefined) {
        return fail("expected a fragment of pixel data, found another tag", at);
      }
      at = item->value + item->size;
    }
    return fail("pixel data cut short: expected their end mark, found the end of the file", at);
  }

  const InputFile& file_;
  Coding coding_;
  std::string defect_;
};

/// True for "DICM" after 128 bytes, which only DICOM files have.
bool has_preamble(const InputFile& file) {
  constexpr std::int64_t kPreamble = 128;
  std::array<std::byte, 4> magic{};
  const auto got = file.read_at(kPreamble, magic);
  return got && *got == magic.size() && std::memcmp(magic.data(), "DICM", magic.size()) == 0;
}

}  // namespace

std::string dicom_structure_defect(const InputFile& file) { return Walker(file).walk(); }

bool is_dicom(const InputFile& file) {
  if (has_preamble(file)) return true;
  // Files from before part 10 begin with group 2 or 8, little-endian, low element. Other files may
  // begin in the same way, so the structure is checked too.
  std::array<std::byte, 8> head{};
  const auto got = file.read_at(0, head);
  const auto is = [&](std::size_t i, char c) { return head[i] == static_cast<std::byte>(c); };
  return got && *got == head.size() && (is(0, 2) || is(0, 8)) && is(1, 0) && is(3, 0) &&
         dicom_structure_defect(file).empty();
}

}  // namespace nav::io::detail
