// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "io/mcap/mcap_reader.hpp"
#include "tests/io/mcap/mcap_samples.hpp"

namespace nav::test {

/// A chunk as a parser of its own finds it in an undamaged file.
struct ChunkInFile {
  std::size_t offset = 0;
  std::size_t end = 0;
  std::vector<std::string_view> messages;  ///< Content of its Message records.
};

inline std::uint64_t number_at(std::string_view bytes, std::size_t at, std::size_t width) {
  std::uint64_t value = 0;
  for (std::size_t i = width; i-- > 0;) {
    value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  }
  return value;
}

/// Calls \p visit(opcode, offset, content offset, end) for every record between two offsets.
template <class Visit>
void for_each_record(std::string_view bytes, std::size_t at, std::size_t end, Visit visit) {
  while (at < end) {
    const std::size_t content = at + 9;
    const std::size_t stop = content + number_at(bytes, at + 1, 8);
    ASSERT_LE(stop, end);
    visit(static_cast<int>(bytes[at]), at, content, stop);
    at = stop;
  }
}

inline std::vector<ChunkInFile> chunks_in(std::string_view file) {
  constexpr int kChunk = 6, kMessage = 5;
  std::vector<ChunkInFile> chunks;
  const auto visit_inside = [&](int opcode, std::size_t, std::size_t content, std::size_t end) {
    if (opcode == kMessage) chunks.back().messages.push_back(file.substr(content, end - content));
  };
  for_each_record(file, 8, file.size() - 8,
                  [&](int opcode, std::size_t at, std::size_t content, std::size_t end) {
                    if (opcode != kChunk) return;
                    chunks.push_back({at, end, {}});
                    for_each_record(file, content + 40, end, visit_inside);
                  });
  return chunks;
}

/// A recording and variants of it that are damaged.
class DamagedRecording {
 public:
  explicit DamagedRecording(std::string file)
      : file_(std::move(file)), chunks_(chunks_in(file_)), intact_(chunks_.size(), true) {}

  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] const std::vector<ChunkInFile>& chunks() const { return chunks_; }

  /// Reads a variant. Empty: exactly the messages of the intact chunks were given, and a sentence
  /// if anything is lost; otherwise what is wrong.
  [[nodiscard]] std::string fault_of(std::string_view variant, const std::vector<bool>& intact) {
    auto reader = io::mcap::Reader::open(
        io::mcap::memory_input("variant", std::as_bytes(std::span(variant))));
    if (!reader) return reader.error().message;
    std::size_t read = 0;
    for (std::size_t i = 0; i < chunks_.size(); ++i) {
      if (!intact[i]) continue;
      for (const std::string_view expected : chunks_[i].messages) {
        if (!gives(*reader, expected))
          return "message " + std::to_string(read) + " differs: " + reader->damage();
        ++read;
      }
    }
    if (!gives(*reader, {})) return "a message that is not in an intact chunk";
    const bool lost = std::count(intact.begin(), intact.end(), false) > 0;
    const std::string damage = reader->damage();
    if (damage.find('\n') != std::string::npos) return "not one line: " + damage;
    return lost && damage.empty() ? "the loss is not reported" : "";
  }

  /// Flips one bit and reads.
  [[nodiscard]] std::string fault_of_bit(std::size_t byte, int bit) {
    const auto hit = std::find_if(chunks_.begin(), chunks_.end(), [&](const ChunkInFile& chunk) {
      return byte >= chunk.offset && byte < chunk.end;
    });
    // The times of a chunk are not covered by its checksum, and not used.
    const bool harmless =
        hit == chunks_.end() || (byte >= hit->offset + 9 && byte < hit->offset + 25);
    const auto index = static_cast<std::size_t>(hit - chunks_.begin());
    file_[byte] = static_cast<char>(file_[byte] ^ (1 << bit));
    if (!harmless) intact_[index] = false;
    // The messages of other chunks are compared in the flipped file itself.
    std::string fault = fault_of(file_, intact_);
    if (!harmless) intact_[index] = true;
    file_[byte] = static_cast<char>(file_[byte] ^ (1 << bit));
    return fault;
  }
  [[nodiscard]] bool is_in_records(std::size_t byte) const {
    return std::any_of(chunks_.begin(), chunks_.end(), [&](const ChunkInFile& chunk) {
      return byte >= chunk.offset + 49 && byte < chunk.end;
    });
  }

 private:
  /// True if the next message is \p expected; empty: if there is none.
  static bool gives(io::mcap::Reader& reader, std::string_view expected) {
    while (true) {
      const auto event = reader.next();
      if (!event) return false;
      if (event->is_end()) return expected.empty();
      if (!event->message) continue;
      const auto& message = *event->message;
      constexpr std::size_t kHead = io::mcap::kMessageHeadBytes;
      return expected.size() == message.data.size() + kHead &&
             std::memcmp(expected.data() + kHead, message.data.data(), message.data.size()) == 0 &&
             number_at(expected, 0, 2) == message.channel->id &&
             number_at(expected, 2, 4) == message.head.sequence &&
             number_at(expected, 6, 8) == message.head.log_time;
    }
  }

  std::string file_;
  std::vector<ChunkInFile> chunks_;
  std::vector<bool> intact_;
};

/// Two texts with zeros between them, of which no byte exists.
class SparseInput final : public io::mcap::Input {
 public:
  SparseInput(std::string before, std::uint64_t hole, std::string after)
      : before_(std::move(before)), hole_(hole), after_(std::move(after)) {}
  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] std::uint64_t size() const override {
    return before_.size() + hole_ + after_.size();
  }
  [[nodiscard]] Result<std::size_t> read_at(std::uint64_t offset,
                                            std::span<std::byte> out) const override {
    std::size_t done = 0;
    for (; done < out.size() && offset + done < size(); ++done) {
      const std::uint64_t at = offset + done;
      const bool is_before = at < before_.size();
      const bool is_hole = !is_before && at < before_.size() + hole_;
      out[done] = is_hole     ? std::byte{0}
                  : is_before ? static_cast<std::byte>(before_[at])
                              : static_cast<std::byte>(after_[at - before_.size() - hole_]);
    }
    return done;
  }

 private:
  std::string name_ = "sparse";
  std::string before_;
  std::uint64_t hole_;
  std::string after_;
};

/// A recording of 200 samples within 64 kB, with an attachment and metadata at both ends.
inline std::string small_recording(bool finish = true) {
  const TemporaryFolder folder;
  {
    auto recorder = DeviceRecorder::create(folder / "a", small_chunks(12000));
    EXPECT_TRUE(has_value(recorder));
    add_devices(**recorder);
    const std::string text = "calibration";
    const auto bytes = std::as_bytes(std::span(text));
    EXPECT_TRUE(has_value((*recorder)->attach("c", "text/xml", at_ns(1), bytes)));
    for (const DeviceSample& next : small_session(200)) {
      EXPECT_TRUE(has_value((*recorder)->record(next.device, next.sample)));
    }
    EXPECT_TRUE(has_value((*recorder)->flush()));
    if (!finish) return get(folder / "a");
    EXPECT_TRUE(has_value((*recorder)->add_metadata("end", {{"why", "done"}})));
    EXPECT_TRUE(has_value((*recorder)->finish()));
  }
  return get(folder / "a");
}

}  // namespace nav::test
