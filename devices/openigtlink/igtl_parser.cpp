// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_parser.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "devices/openigtlink/igtl_crc.hpp"
#include "devices/openigtlink/igtl_sizes.hpp"
#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kFirstBuffer = 65536;

bool is_type_letter(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
}

/// True for letters, then NULs only.
bool is_type_name(const IgtlHeader& header) {
  const std::size_t length = header.type_name().size();
  const auto* const end = header.type.begin() + length;
  return length > 0 && std::all_of(header.type.begin(), end, is_type_letter) &&
         std::all_of(end, header.type.end(), [](char c) { return c == '\0'; });
}

}  // namespace

const char* to_string(IgtlFault fault) {
  switch (fault) {
    case IgtlFault::kGarbage:
      return "garbage";
    case IgtlFault::kVersion:
      return "version";
    case IgtlFault::kTooLarge:
      return "too_large";
    case IgtlFault::kSize:
      return "size";
    case IgtlFault::kCrc:
      return "crc";
    case IgtlFault::kMetadata:
      return "metadata";
  }
  return "unknown";
}

std::uint64_t IgtlStreamCounts::faults_total() const {
  return std::accumulate(faults.begin(), faults.end(), std::uint64_t{0});
}

IgtlParser::IgtlParser(const IgtlParserOptions& options) : options_(options) {}

std::span<std::byte> IgtlParser::prepare(std::size_t least) {
  NAV_CHECK(least >= 1);
  if (begin_ == end_) {
    begin_ = end_ = scanned_ = 0;
    candidate_count_ = 0;
  }
  if (buffer_.size() - end_ < least && begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    for (std::size_t i = 0; i < candidate_count_; ++i) candidates_[i] -= begin_;
    scanned_ -= std::min(scanned_, begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (buffer_.size() - end_ < least) {
    buffer_.resize(std::max({kFirstBuffer, 2 * buffer_.size(), end_ + least}));
  }
  return std::span(buffer_).subspan(end_);
}

void IgtlParser::commit(std::size_t count) {
  NAV_CHECK(count <= buffer_.size() - end_, count, buffer_.size() - end_);
  end_ += count;
  counts_.bytes += count;
}

void IgtlParser::feed(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  std::memcpy(prepare(bytes.size()).data(), bytes.data(), bytes.size());
  commit(bytes.size());
}

void IgtlParser::reset() {
  drop_to(end_);
  in_step_ = true;
  begin_ = end_ = scanned_ = 0;
  candidate_count_ = 0;
}

IgtlParser::Look IgtlParser::look_at(std::size_t at) const {
  const std::size_t available = end_ - at;
  if (available < kIgtlHeaderBytes) return {};
  const std::byte* from = buffer_.data() + at;
  const IgtlHeader header =
      read_igtl_header(std::span<const std::byte, kIgtlHeaderBytes>(from, kIgtlHeaderBytes));
  const auto no = [](IgtlFault fault) { return Look{.verdict = Verdict::kNot, .fault = fault}; };
  if (!is_type_name(header)) return no(IgtlFault::kGarbage);
  if (header.version < 1 || header.version > kIgtlNewestVersion) return no(IgtlFault::kVersion);
  if (header.body_size > options_.largest_body) return no(IgtlFault::kTooLarge);
  const auto body_size = static_cast<std::size_t>(header.body_size);
  Look look{.size = kIgtlHeaderBytes + body_size};
  const std::span<const std::byte> body(from + kIgtlHeaderBytes,
                                        std::min(available - kIgtlHeaderBytes, body_size));
  if (header.version > 1) {
    if (body_size < kIgtlExtendedHeaderBytes) return no(IgtlFault::kSize);
    if (body.size() < kIgtlExtendedHeaderBytes) return look;
  }
  const auto parts = igtl_parts(header, body);
  if (!parts) return no(IgtlFault::kSize);
  const std::size_t content_there =
      std::min(body.size() - std::min(body.size(), parts->extended_header), parts->content);
  const auto content = body.subspan(std::min(body.size(), parts->extended_header), content_there);
  switch (igtl_fit(header.type_name(), parts->content, content)) {
    case IgtlFit::kWrong:
      return no(IgtlFault::kSize);
    case IgtlFit::kFits:
      look.trusted = true;
      break;
    case IgtlFit::kUnknownType:
    case IgtlFit::kMore:
      break;
  }
  if (available >= look.size) look.verdict = Verdict::kMessage;
  return look;
}

bool IgtlParser::crc_holds(std::size_t at, std::size_t size) const {
  const auto message = std::span(buffer_).subspan(at, size);
  const IgtlHeader header = read_igtl_header(message.first<kIgtlHeaderBytes>());
  return igtl_crc64(message.subspan(kIgtlHeaderBytes)) == header.crc;
}

void IgtlParser::drop_to(std::size_t at) {
  counts_.skipped += at - begin_;
  begin_ = at;
}

/// Begins the search for the next message behind a fault.
void IgtlParser::lose_step(IgtlFault fault) {
  count(fault);
  in_step_ = false;
  scanned_ = std::max(scanned_, begin_ + 1);
}

/// Lists the offsets at which a message may begin. When there are too many the oldest is given up.
void IgtlParser::note_candidates() {
  for (; scanned_ + kIgtlHeaderBytes <= end_; ++scanned_) {
    const std::byte* at = buffer_.data() + scanned_;
    if (at[0] != std::byte{0} || at[1] == std::byte{0} || at[1] > std::byte{kIgtlNewestVersion} ||
        !is_type_letter(static_cast<char>(at[2]))) {
      continue;
    }
    if (look_at(scanned_).verdict == Verdict::kNot) continue;
    if (candidate_count_ == kCandidates) {
      std::copy(candidates_.begin() + 1, candidates_.end(), candidates_.begin());
      --candidate_count_;
    }
    candidates_[candidate_count_++] = scanned_;
  }
}

/// Moves to the first listed message whose CRC holds. Returns false if there is none yet.
bool IgtlParser::find_step() {
  note_candidates();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < candidate_count_; ++i) {
    const std::size_t at = candidates_[i];
    const Look look = look_at(at);
    if (look.verdict == Verdict::kMore) candidates_[kept++] = at;
    if (look.verdict != Verdict::kMessage) continue;
    // The CRC of an empty body is 0 and proves nothing: zeros behind a name look like that.
    if (look.size == kIgtlHeaderBytes && (in_step_ || !look.trusted)) continue;
    if (crc_holds(at, look.size)) {
      drop_to(at);
      candidate_count_ = 0;
      scanned_ = begin_;
      return true;
    }
    if (look.trusted) count(IgtlFault::kCrc);
  }
  candidate_count_ = kept;
  return false;
}

std::optional<IgtlMessage> IgtlParser::take(std::size_t size) {
  const auto bytes = std::span<const std::byte>(buffer_).subspan(begin_, size);
  const IgtlHeader header = read_igtl_header(bytes.first<kIgtlHeaderBytes>());
  const auto message = split_igtl_body(header, bytes.subspan(kIgtlHeaderBytes));
  candidate_count_ = 0;
  scanned_ = begin_ + size;
  if (!message) {
    count(IgtlFault::kMetadata);
    drop_to(begin_ + size);
    return std::nullopt;
  }
  begin_ += size;
  ++counts_.messages;
  return *message;
}

std::optional<IgtlMessage> IgtlParser::next() {
  while (begin_ < end_) {
    if (!in_step_) {
      if (!find_step()) {
        // The bytes before the first candidate, and before what may begin a header, are used up.
        drop_to(candidate_count_ > 0 ? candidates_[0] : std::max(begin_, std::min(scanned_, end_)));
        return std::nullopt;
      }
      in_step_ = true;
    }
    const Look look = look_at(begin_);
    if (look.verdict == Verdict::kNot) {
      lose_step(look.fault);
      continue;
    }
    if (look.verdict == Verdict::kMessage) {
      if (!crc_holds(begin_, look.size)) {
        lose_step(IgtlFault::kCrc);
      } else if (auto message = take(look.size)) {
        return message;
      }
      continue;
    }
    if (look.size == 0 || look.trusted) return std::nullopt;
    scanned_ = std::max(scanned_, begin_ + 1);
    if (!find_step()) return std::nullopt;
    count(IgtlFault::kSize);  // A message lay inside what this one claimed.
  }
  return std::nullopt;
}

std::size_t IgtlParser::wanted() const {
  if (begin_ == end_ || !in_step_) return 0;
  const Look look = look_at(begin_);
  return look.size > end_ - begin_ ? look.size - (end_ - begin_) : 0;
}

}  // namespace nav::devices
