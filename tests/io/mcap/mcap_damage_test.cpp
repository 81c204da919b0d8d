// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Recordings that are cut, flipped, zeroed or shifted: exactly the samples of the intact chunks are
// read, and nothing else.
#include "tests/io/mcap/mcap_damage.hpp"

#include "io/mcap/mcap_crc.hpp"

namespace nav::test {
namespace {

#ifdef __SANITIZE_ADDRESS__
constexpr std::size_t kSlower = 20;  // How much fewer variants a sanitizer tries.
#else
constexpr std::size_t kSlower = 1;
#endif

std::shared_ptr<const io::mcap::Input> input_of(std::string_view bytes) {
  return io::mcap::memory_input("variant", std::as_bytes(std::span(bytes)));
}

TEST(McapDamageTest, TheRecordingIsAsTheIssueAsks) {
  DamagedRecording recording(small_recording());
  EXPECT_LE(recording.file().size(), 64U << 10);
  EXPECT_GE(recording.chunks().size(), 5U);
  std::size_t messages = 0;
  for (const auto& chunk : recording.chunks()) messages += chunk.messages.size();
  EXPECT_EQ(messages, 200U);
  EXPECT_EQ(recording.fault_of(recording.file(), std::vector(recording.chunks().size(), true)), "");
}

TEST(McapDamageTest, ACutLosesOnlyTheChunkThatItHits) {
  DamagedRecording recording(small_recording());
  const std::string& file = recording.file();
  for (std::size_t size = 0; size <= file.size(); size += kSlower) {
    std::vector<bool> intact;
    for (const auto& chunk : recording.chunks()) intact.push_back(chunk.end <= size);
    ASSERT_EQ(recording.fault_of(std::string_view(file).substr(0, size), intact), "") << size;
  }
}

/// Every bit outside the records of the chunks, and every bit of every 13th byte inside: the
/// checksum makes no difference between those. io_mcap_slow_test tries all.
TEST(McapDamageTest, AFlippedBitLosesOnlyTheChunkThatItHits) {
  DamagedRecording recording(small_recording());
  std::size_t tried = 0;
  for (std::size_t byte = 0; byte < recording.file().size(); byte += kSlower) {
    if (recording.is_in_records(byte) && (byte / kSlower) % 13 != 0) continue;
    for (int bit = 0; bit < 8; ++bit, ++tried) {
      ASSERT_EQ(recording.fault_of_bit(byte, bit), "") << "bit " << bit << " of byte " << byte;
    }
  }
  RecordProperty("variants", std::to_string(tried));
}

/// Flips some of the bits and reads through everything up to the samples.
TEST(McapDamageTest, NoSampleIsEverWrong) {
  const std::string file = small_recording();
  const auto samples = small_session(200);
  std::vector<std::string> bits;
  for (const auto& next : samples) bits.push_back(bits_of(next.sample));
  for (std::size_t byte = 0; byte < file.size(); byte += 101 * kSlower) {
    std::string variant = file;
    variant[byte] = static_cast<char>(variant[byte] ^ (1 << (byte % 8)));
    const auto recording = DeviceRecording::open(input_of(variant), {true, byte % 2 == 0});
    ASSERT_TRUE(has_value(recording)) << byte;
    auto merged = recording->merged();
    ASSERT_TRUE(has_value(merged));
    std::size_t read = 0;
    for (std::size_t at = 0;; ++read) {
      const auto next = merged->next();
      if (!next) break;
      while (at < bits.size() && (samples[at].device != next->device ||
                                  samples[at].sample.stream != next->sample.stream ||
                                  bits[at] != bits_of(next->sample))) {
        ++at;
      }
      ASSERT_LT(at, bits.size()) << byte << ": a sample that was not recorded";
    }
    EXPECT_EQ(read, recording->samples()) << byte;
    EXPECT_GE(read, 130U) << byte;
    EXPECT_EQ(read == samples.size() || !recording->warnings().empty(), true) << byte;
  }
}

TEST(McapDamageTest, ADamagedStretchLosesOnlyTheChunksThatItHits) {
  DamagedRecording recording(small_recording());
  const std::string& file = recording.file();
  for (const char fill : {'\0', '\x06', '\xFF'}) {
    for (std::size_t start = 0; start < file.size(); start += 173 * kSlower) {
      const std::size_t length = std::min<std::size_t>(6'000, file.size() - start);
      std::string variant = file;
      std::fill_n(variant.begin() + static_cast<std::ptrdiff_t>(start), length, fill);
      std::vector<bool> intact;
      for (const auto& chunk : recording.chunks()) {
        intact.push_back(chunk.end <= start || chunk.offset >= start + length);
      }
      ASSERT_EQ(recording.fault_of(variant, intact), "") << start;
    }
  }
}

TEST(McapDamageTest, MissingAndAddedBytesLoseOnlyTheChunkThatTheyHit) {
  DamagedRecording recording(small_recording());
  const std::string& file = recording.file();
  for (std::size_t at = 0; at < file.size(); at += 31 * kSlower) {
    std::vector<bool> cut, inserted;
    for (const auto& chunk : recording.chunks()) {
      cut.push_back(chunk.end <= at || chunk.offset >= at + 7);
      inserted.push_back(chunk.end <= at || chunk.offset >= at);
    }
    std::string variant = file;
    variant.erase(at, 7);
    ASSERT_EQ(recording.fault_of(variant, cut), "") << at;
    variant = file;
    variant.insert(at, "\x06garbage");
    ASSERT_EQ(recording.fault_of(variant, inserted), "") << at;
  }
}

void put_crc(std::string& file, std::size_t at, std::size_t from, std::size_t to) {
  const std::uint32_t crc =
      io::mcap::crc32_of(std::as_bytes(std::span(file)).subspan(from, to - from));
  for (std::size_t i = 0; i < 4; ++i) file[at + i] = static_cast<char>(crc >> (8 * i) & 255U);
}

/// Reads everything that a file claims to have; returns the number of samples.
std::size_t read_everything(std::string_view file, bool use_index) {
  const auto recording = DeviceRecording::open(input_of(file), {true, use_index});
  if (!recording) return 0;
  for (const auto& attachment : recording->attachments()) {
    static_cast<void>(recording->read(attachment, 1 << 20));
  }
  auto merged = recording->merged();
  std::size_t read = 0;
  while (merged && merged->next()) ++read;
  return read;
}

/// Contents that are wrong although their checksum holds: no crash, and the other chunks are read.
TEST(McapDamageTest, AForgedChunkOrIndexNeverCrashes) {
  const DamagedRecording recording(small_recording());
  const auto& chunk = recording.chunks()[1];
  const std::size_t others = 200 - chunk.messages.size();
  constexpr std::size_t kCrcAt = 9 + 24, kRecordsAt = 49;
  for (std::size_t byte = chunk.offset + kRecordsAt; byte < chunk.end; byte += 3 * kSlower) {
    std::string variant = recording.file();
    variant[byte] = static_cast<char>(variant[byte] ^ (byte % 2 == 0 ? 0xFF : 0x80));
    put_crc(variant, chunk.offset + kCrcAt, chunk.offset + kRecordsAt, chunk.end);
    ASSERT_GE(read_everything(variant, byte % 4 != 0), others) << byte;
  }
  const std::string& file = recording.file();
  const std::size_t footer = file.size() - 8 - 20;
  const std::size_t summary = number_at(file, footer, 8);
  for (std::size_t byte = summary; byte < footer; byte += kSlower) {
    std::string variant = file;
    variant[byte] = static_cast<char>(variant[byte] ^ (byte % 2 == 0 ? 0xFF : 0x01));
    put_crc(variant, footer + 16, summary, footer + 16);
    ASSERT_LE(read_everything(variant, true), 200U) << byte;
  }
}

TEST(McapDamageTest, OneSentenceSaysWhatIsLost) {
  DamagedRecording recording(small_recording());
  const auto& chunk = recording.chunks()[2];
  std::string variant = recording.file();
  variant[chunk.offset + 100] ^= 1;
  const auto damage_of = [](std::string_view bytes, bool use_index) {
    const auto open = DeviceRecording::open(input_of(bytes), {true, use_index});
    return open && open->warnings().size() == 1 ? open->warnings()[0] : "none or several";
  };
  const std::string place = "from byte " + std::to_string(chunk.offset) + " on; all else was read";
  EXPECT_EQ(damage_of(variant, true), "variant: expected a finished and intact recording, found " +
                                          std::to_string(chunk.end - chunk.offset) +
                                          " damaged or incomplete bytes in 1 place " + place);
  EXPECT_NE(damage_of(variant, false).find(place), std::string::npos);
  const std::string unfinished = small_recording(false);
  EXPECT_EQ(damage_of(unfinished, true),
            "variant: expected a finished and intact recording, found no intact index at its end; "
            "all else was read");
  const auto open = DeviceRecording::open(input_of(unfinished));
  ASSERT_TRUE(has_value(open));
  EXPECT_FALSE(open->is_finished());
  EXPECT_EQ(open->samples(), 200U);
}

}  // namespace
}  // namespace nav::test
