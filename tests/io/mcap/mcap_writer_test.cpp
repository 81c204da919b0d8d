// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/mcap/mcap_bytes.hpp"
#include "io/mcap/mcap_crc.hpp"
#include "nav/check.hpp"
#include "tests/io/mcap/mcap_damage.hpp"

namespace nav::io::mcap {
namespace {

using test::has_value;
using test::number_at;
using test::rejects;

std::span<const std::byte> raw(std::string_view text) { return std::as_bytes(std::span(text)); }

TEST(McapCrcTest, IsTheChecksumOfZlibAndJoins) {
  EXPECT_EQ(crc32_of(raw("123456789")), 0xCBF43926U);
  EXPECT_EQ(crc32_of(raw("6789"), crc32_of(raw("12345"))), 0xCBF43926U);
  EXPECT_EQ(crc32_joined(crc32_of(raw("12345")), crc32_of(raw("6789")), 4), 0xCBF43926U);
  EXPECT_EQ(crc32_of({}, 7U), 7U);
}

/// A record with all bytes as the specification of MCAP has them.
TEST(McapRecordsTest, AChannelHasTheBytesOfTheSpecification) {
  Buffer out;
  append(out, Channel{1, 2, "/a", "m", {{"k", "v"}}});
  const std::string expected(
      "\x04\x1D\0\0\0\0\0\0\0\x01\0\x02\0\x02\0\0\0/a\x01\0\0\0m\x0a\0\0\0\x01\0\0\0k\x01\0\0\0v",
      9 + 0x1D);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(out.data()), out.size()), expected);
  const auto content = std::span<const std::byte>(out).subspan(kPrefixBytes);
  const auto channel = parse_channel(content);
  ASSERT_TRUE(channel);
  EXPECT_EQ(channel->metadata, (TextMap{{"k", "v"}}));
  for (std::size_t size = 0; size < content.size(); ++size) {
    EXPECT_FALSE(parse_channel(content.first(size))) << size;
  }
}

/// Everything that other readers rely on: order, checksums, offsets, lengths, counts.
TEST(McapWriterTest, AFinishedFileIsAsTheSpecificationSays) {
  const std::string file = test::small_recording();
  std::string order;
  std::vector<ChunkIndex> indexes;
  std::optional<Statistics> statistics;
  std::size_t data_end = 0, summary = 0;
  test::for_each_record(file, 8, file.size() - 8,
                        [&](int opcode, std::size_t at, std::size_t content, std::size_t end) {
                          const char letter = "-HFSCMKIcAaTDdOE"[opcode];
                          if (order.empty() || order.back() != letter) order += letter;
                          const auto bytes = raw(file).subspan(content, end - content);
                          if (opcode == 0x0F) {
                            data_end = at;
                            summary = end;
                            EXPECT_EQ(number_at(file, content, 4), crc32_of(raw(file).first(at)));
                          }
                          if (opcode == 0x08) indexes.push_back(*parse_chunk_index(bytes));
                          if (opcode == 0x0B) statistics = parse_statistics(bytes);
                          if (opcode == 0x02) {
                            EXPECT_EQ(number_at(file, content, 8), summary);
                            EXPECT_EQ(number_at(file, content + 16, 4),
                                      crc32_of(raw(file).subspan(summary, content + 16 - summary)));
                          }
                        });
  EXPECT_GT(data_end, 0U);
  // Header, metadata, attachment, chunks with their indexes, metadata, end of data, then schemas,
  // channels, statistics, chunk, attachment and metadata indexes, offsets, footer.
  EXPECT_EQ(order.substr(0, 3), "HDA");
  EXPECT_EQ(order.substr(order.size() - 10), "DESCTcadOF");
  const auto chunks = test::chunks_in(file);
  ASSERT_EQ(indexes.size(), chunks.size());
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    EXPECT_EQ(indexes[i].offset, chunks[i].offset);
    EXPECT_EQ(indexes[i].length, chunks[i].end - chunks[i].offset);
    std::size_t listed = 0;
    for (const auto& [channel, offset] : indexes[i].message_indexes) {
      EXPECT_EQ(file[offset], 0x07);
      EXPECT_EQ(number_at(file, offset + 9, 2), channel);
      const std::size_t count = number_at(file, offset + 11, 4) / 16;
      for (std::size_t entry = 0; entry < count; ++entry) {
        const std::size_t at = offset + 15 + 16 * entry;
        const std::size_t record = chunks[i].offset + 49 + number_at(file, at + 8, 8);
        EXPECT_EQ(file[record], 0x05);
        EXPECT_EQ(number_at(file, record + 9, 2), channel);
        EXPECT_EQ(number_at(file, record + 15, 8), number_at(file, at, 8));
      }
      listed += count;
    }
    EXPECT_EQ(listed, chunks[i].messages.size());
  }
  ASSERT_TRUE(statistics);
  EXPECT_EQ(statistics->messages, 200U);
  EXPECT_EQ(statistics->chunks, chunks.size());
  EXPECT_EQ(statistics->attachments, 1U);
  EXPECT_EQ(statistics->metadata, 2U);
  EXPECT_EQ(statistics->start_time, 1'000'000'000U);
}

TEST(McapWriterTest, EndsAChunkAtItsSizeAndAtItsTime) {
  const test::TemporaryFolder folder;
  WriterOptions options;
  options.chunk_bytes = 1000;
  auto writer = Writer::create(folder / "a", options);
  ASSERT_TRUE(has_value(writer));
  const auto channel = writer->add_channel({0, 0, "/t", "x", {}});
  ASSERT_TRUE(has_value(channel));
  const auto chunks = [&] { return test::chunks_in(test::get(folder / "a") + "12345678").size(); };
  const auto put = [&](std::uint64_t ns, std::size_t bytes) {
    const std::string data(bytes, 'x');
    EXPECT_TRUE(has_value(writer->write({*channel, 0, ns, ns}, raw(data))));
  };
  put(0, 10);
  put(99'999'999, 10);
  EXPECT_EQ(chunks(), 0U);
  put(100'000'000, 10);
  EXPECT_EQ(chunks(), 1U);
  put(100'000'001, 900);
  put(100'000'001, 10);
  EXPECT_EQ(chunks(), 2U);
  ASSERT_TRUE(has_value(writer->advance_to(200'000'000)));
  EXPECT_EQ(chunks(), 2U);
  ASSERT_TRUE(has_value(writer->advance_to(200'000'001)));
  EXPECT_EQ(chunks(), 3U);
  ASSERT_TRUE(has_value(writer->flush()));
  EXPECT_EQ(chunks(), 3U);
  EXPECT_TRUE(rejects(writer->write({7, 0, 0, 0}, {}), ErrorCode::kUsage, {"channel 7"}));
  EXPECT_TRUE(rejects(writer->add_channel({0, 9, "/t", "x", {}}), ErrorCode::kUsage, {"number 9"}));
  ASSERT_TRUE(has_value(writer->finish()));
  EXPECT_THROW(static_cast<void>(writer->flush()), Bug);
}

TEST(McapWriterTest, AFullDeviceIsAnError) {
  const int descriptor = ::open("/dev/full", O_WRONLY);
  ASSERT_GE(descriptor, 0);
  EXPECT_TRUE(rejects(Writer::adopt(descriptor, "full.mcap", {}), ErrorCode::kIo,
                      {"full.mcap", "expected to write at byte 0", "No space left"}));
  EXPECT_TRUE(rejects(Writer::create("/dev/full", {}), ErrorCode::kIo, {"No space left"}));
  EXPECT_TRUE(std::filesystem::exists("/dev/full"));
}

/// Limit of the size of files of this process, and no signal when it is reached.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(McapWriterTest, AFullDiskStopsTheRecordingAndKeepsWhatIsThere) {
  const test::TemporaryFolder folder;
  constexpr std::size_t kLimit = 100'000;
  auto recorder = DeviceRecorder::create(folder / "a.mcap", test::small_chunks(8192));
  ASSERT_TRUE(has_value(recorder));
  test::add_devices(**recorder);
  std::size_t accepted = 0;
  {
    const FileSizeLimit limit(kLimit);
    Result<void> last;
    for (const DeviceSample& next : test::small_session(1000)) {
      last = (*recorder)->record(next.device, next.sample);
      if (!last) break;
      ++accepted;
    }
    ASSERT_TRUE(rejects(last, ErrorCode::kIo, {"a.mcap", "expected to write", "File too large"}));
    const Error stopped = last.error();
    for (int i = 0; i < 3; ++i) {
      EXPECT_TRUE(rejects((*recorder)->record(0, test::pose_sample(0, 1, 1)), ErrorCode::kIo,
                          {stopped.message}));
    }
    EXPECT_TRUE(rejects((*recorder)->flush(), ErrorCode::kIo, {stopped.message}));
    EXPECT_TRUE(rejects((*recorder)->finish(), ErrorCode::kIo, {stopped.message}));
    EXPECT_EQ((*recorder)->stopped()->message, stopped.message);
  }
  // Cut behind the last whole record: nothing is damaged, and only the end is missing.
  EXPECT_EQ((*recorder)->counts().bytes_written, std::filesystem::file_size(folder / "a.mcap"));
  const auto recording = DeviceRecording::open(folder / "a.mcap");
  ASSERT_TRUE(has_value(recording));
  EXPECT_GT(recording->samples(), accepted - 60);
  EXPECT_LE(recording->samples(), accepted);
  EXPECT_FALSE(recording->is_finished());
  ASSERT_EQ(recording->warnings().size(), 1U);
  EXPECT_EQ(recording->warnings()[0].find("damaged"), std::string::npos)
      << recording->warnings()[0];
}

TEST(McapWriterTest, LeavesNoFileThatItCannotBegin) {
  const test::TemporaryFolder folder;
  const FileSizeLimit limit(10);
  EXPECT_TRUE(rejects(DeviceRecorder::create(folder / "a.mcap"), ErrorCode::kIo, {"a.mcap"}));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mcap"));
}

/// Records poses and images as fast as it can, on real time, until it is killed. \p recorded: time
/// of the last sample that record() accepted, ns.
[[noreturn]] void record_until_killed(const std::filesystem::path& path,
                                      std::atomic<std::int64_t>& recorded) {
  auto recorder = DeviceRecorder::create(path);
  if (!recorder || !(*recorder)->add_device("tracker", test::kTrackerStreams) ||
      !(*recorder)->add_device("scanner", test::kScannerStreams)) {
    ::_exit(1);
  }
  const MonotonicClock clock;
  Sample pose = test::pose_sample(0, 1, 0);
  Sample image = test::image_sample(0, 1, 0, 820, 616);
  for (std::uint64_t i = 0;; ++i) {
    const bool is_image = i % 40 == 39;
    Sample& next = is_image ? image : pose;
    next.sequence = i;
    next.received = clock.now();
    if (!(*recorder)->record(is_image ? 1 : 0, next)) ::_exit(2);
    recorded = next.received.time_since_epoch().count();
  }
}

TEST(McapWriterTest, AKillLosesAtMost200Milliseconds) {
  constexpr Duration kMostLost = std::chrono::milliseconds(200);
  void* shared = ::mmap(nullptr, sizeof(std::atomic<std::int64_t>), PROT_READ | PROT_WRITE,
                        MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  auto& recorded = *new (shared) std::atomic<std::int64_t>(0);
  const test::TemporaryFolder folder;
  for (int run = 0; run < 5; ++run) {
    const auto path = folder / ("a" + std::to_string(run));
    recorded = 0;
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) record_until_killed(path, recorded);
    // Not a multiple of the time of a chunk.
    const std::int64_t until = 250'000'000 + 37'000'000 * run;
    int status = 0;
    while (recorded < until && ::waitpid(child, &status, WNOHANG) == 0) ::usleep(1000);
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    const auto recording = DeviceRecording::open(path);
    ASSERT_TRUE(has_value(recording));
    ASSERT_TRUE(recording->last_time());
    EXPECT_LE(Timestamp(Duration(recorded)) - *recording->last_time(), kMostLost);
    EXPECT_GE(*recording->last_time(), Timestamp(Duration(until) - kMostLost));
    std::filesystem::remove(path);
  }
  ::munmap(shared, sizeof(std::atomic<std::int64_t>));
}

/// Chunks that claim to lie in each other, each with a wrong checksum.
TEST(McapReaderTest, GivesUpOnTooManyFalseBeginnings) {
  std::string file(reinterpret_cast<const char*>(kMagic.data()), kMagic.size());
  constexpr std::size_t kSize = std::size_t{2} << 20;
  while (file.size() + kPrefixBytes + kChunkHeadBytes < kSize) {
    const std::uint64_t rest = kSize - file.size() - kPrefixBytes - kChunkHeadBytes;
    Buffer head;
    append(head, ChunkHead{0, 0, rest, 1, "", rest});
    file.append(reinterpret_cast<const char*>(head.data()), head.size());
  }
  file.resize(kSize);
  auto reader = Reader::open(memory_input("false", raw(file)));
  ASSERT_TRUE(has_value(reader));
  ASSERT_TRUE(reader->next()->is_end());
  EXPECT_NE(reader->damage().find("too many false beginnings"), std::string::npos)
      << reader->damage();
}

std::string text_of(const Buffer& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(McapReaderTest, ReadsByIndexBeyond4GiB) {
  constexpr std::uint64_t kHole = 5ULL << 30;
  Buffer records;
  append(records, Channel{0, 0, "/far", "x", {}});
  append(records, MessageHead{0, 7, 8, 9}, 3);
  for (const char c : {'a', 'b', 'c'}) records.push_back(static_cast<std::byte>(c));
  Buffer chunk;
  append(chunk, ChunkHead{8, 8, records.size(), crc32_of(records), "", records.size()});
  chunk.insert(chunk.end(), records.begin(), records.end());
  std::string before(reinterpret_cast<const char*>(kMagic.data()), kMagic.size());
  Buffer header;
  append(header, Header{"", ""});
  append(header, AttachmentHead{0, 0, "hole", "", kHole});
  before += text_of(header);
  const std::uint64_t chunk_at = before.size() + kHole + 4;
  Buffer after(4);  // The checksum of the attachment, which is not read.
  after.insert(after.end(), chunk.begin(), chunk.end());
  append_data_end(after, 0);
  const std::uint64_t summary = before.size() + kHole + after.size();
  Buffer end;
  append(end, Statistics{1, 0, 1, 0, 0, 1, 8, 8, {{0, 1}}});
  append(end, ChunkIndex{8, 8, chunk_at, chunk.size(), {}, 0, "", records.size(), records.size()});
  append(end, Footer{summary, 0, 0});
  const std::uint32_t crc = crc32_of(std::span<const std::byte>(end).first(end.size() - 4));
  ByteWriter(end).patch(end.size() - 4, crc);
  const std::string magic(reinterpret_cast<const char*>(kMagic.data()), kMagic.size());
  const auto input =
      std::make_shared<test::SparseInput>(before, kHole, text_of(after) + text_of(end) + magic);
  auto reader = Reader::open(input);
  ASSERT_TRUE(has_value(reader));
  ASSERT_TRUE(reader->summary());
  const auto event = reader->next();
  ASSERT_TRUE(has_value(event));
  ASSERT_TRUE(event->message);
  EXPECT_EQ(event->message->channel->topic, "/far");
  EXPECT_EQ(event->message->head.publish_time, 9U);
  EXPECT_EQ(event->message->data.size(), 3U);
  EXPECT_TRUE(reader->next()->is_end());
  EXPECT_EQ(reader->damage(), "");
}

}  // namespace
}  // namespace nav::io::mcap
