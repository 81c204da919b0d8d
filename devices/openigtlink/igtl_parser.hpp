// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "devices/openigtlink/igtl_header.hpp"

namespace nav::devices {

/// Why a message of the stream was not delivered.
enum class IgtlFault {
  kGarbage,   ///< Bytes that are no header stand where a header was expected.
  kVersion,   ///< A header version other than 1, 2 and 3.
  kTooLarge,  ///< A body beyond the limit.
  kSize,      ///< A size that the type of the message cannot have, or that does not fit its parts.
  kCrc,       ///< The CRC of the body differs from that in the header.
  kMetadata,  ///< Metadata that do not fit their own sizes, although the CRC holds.
};
constexpr std::size_t kIgtlFaults = 6;
/// Stable lower-case name, for reports.
const char* to_string(IgtlFault fault);

/// Counts of one stream.
struct IgtlStreamCounts {
  std::uint64_t bytes = 0;     ///< All that came.
  std::uint64_t skipped = 0;   ///< Bytes outside intact messages.
  std::uint64_t messages = 0;  ///< Intact ones.
  std::array<std::uint64_t, kIgtlFaults> faults{};

  [[nodiscard]] std::uint64_t of(IgtlFault fault) const {
    return faults[static_cast<std::size_t>(fault)];
  }
  [[nodiscard]] std::uint64_t faults_total() const;
};

struct IgtlParserOptions {
  std::uint64_t largest_body = std::uint64_t{64} << 20;  ///< Bytes.
};

/// Finds messages in a stream of bytes, in whatever pieces it comes. Broken bytes cost only the
/// messages that they hit: after a fault the parser looks for the next header that is plausible and
/// whose CRC holds. Memory grows with the bytes that have come, never with a size that was only
/// announced, and no memory is allocated for a message once the buffer has grown. Not thread-safe.
class IgtlParser {
 public:
  explicit IgtlParser(const IgtlParserOptions& options = {});

  /// Space for at least \p least bytes to be received into, >= 1; then commit() says how many came.
  /// Ends the life of messages that next() gave.
  std::span<std::byte> prepare(std::size_t least);
  /// Precondition: count <= the size of what prepare() gave, otherwise a Bug.
  void commit(std::size_t count);
  /// Appends a copy of the bytes.
  void feed(std::span<const std::byte> bytes);

  /// The next intact message; absent until more bytes come. Its views are valid until prepare(),
  /// feed() or reset().
  std::optional<IgtlMessage> next();
  /// Bytes that the message which has begun still lacks; 0 when that is not known.
  [[nodiscard]] std::size_t wanted() const;
  /// Forgets the bytes of a connection that has ended; the counts stay. A message that had begun
  /// counts as skipped bytes.
  void reset();

  [[nodiscard]] const IgtlStreamCounts& counts() const { return counts_; }

 private:
  enum class Verdict { kMessage, kMore, kNot };
  /// Judgement of the bytes at an offset, as the beginning of a message.
  struct Look {
    Verdict verdict = Verdict::kMore;
    std::size_t size = 0;                   ///< Bytes of the message; 0 while that is unknown.
    bool trusted = false;                   ///< Its type is known to have this size.
    IgtlFault fault = IgtlFault::kGarbage;  ///< With kNot.
  };
  static constexpr std::size_t kCandidates = 16;

  [[nodiscard]] Look look_at(std::size_t at) const;
  [[nodiscard]] bool crc_holds(std::size_t at, std::size_t size) const;
  void count(IgtlFault fault) { ++counts_.faults[static_cast<std::size_t>(fault)]; }
  void drop_to(std::size_t at);
  void lose_step(IgtlFault fault);
  void note_candidates();
  bool find_step();
  std::optional<IgtlMessage> take(std::size_t size);

  IgtlParserOptions options_;
  std::vector<std::byte> buffer_;
  std::size_t begin_ = 0;  ///< First byte that is not used up.
  std::size_t end_ = 0;
  bool in_step_ = true;  ///< A header is expected at begin_.
  // Search for the next message, while out of step or while a message is not trusted.
  std::size_t scanned_ = 0;  ///< No candidate begins before this and is not listed.
  std::array<std::size_t, kCandidates> candidates_{};
  std::size_t candidate_count_ = 0;
  IgtlStreamCounts counts_;
};

}  // namespace nav::devices
