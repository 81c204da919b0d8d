// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <thread>

#include "nav/check.hpp"
#include "tests/io/mcap/mcap_samples.hpp"

namespace nav::io::mcap {
namespace {

using test::at_ns;
using test::bits_of;
using test::has_value;
using test::rejects;
using test::small_session;

std::vector<Sample> of_device(const std::vector<DeviceSample>& samples, std::size_t device) {
  std::vector<Sample> own;
  for (const DeviceSample& next : samples) {
    if (next.device == device) own.push_back(next.sample);
  }
  return own;
}

void expect_equal(const std::vector<Sample>& actual, const std::vector<Sample>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) {
    EXPECT_EQ(actual[i].stream, expected[i].stream) << i;
    EXPECT_EQ(bits_of(actual[i]), bits_of(expected[i])) << i;
  }
}

/// Expects the same samples by index and by scan.
void expect_recorded(const std::filesystem::path& path, const std::vector<DeviceSample>& samples) {
  for (const bool use_index : {true, false}) {
    const auto recording = DeviceRecording::open(path, {false, use_index});
    ASSERT_TRUE(has_value(recording));
    for (std::size_t device = 0; device < recording->devices().size(); ++device) {
      auto source = recording->source(device);
      ASSERT_TRUE(has_value(source));
      expect_equal(test::drained(**source), of_device(samples, device));
      EXPECT_EQ((*source)->damage(), "");
    }
    EXPECT_EQ(recording->samples(), samples.size());
    EXPECT_EQ(recording->warnings(), std::vector<std::string>());
  }
}

/// Field by field, because bits_of() uses the code that is tested.
void expect_same_pose(const Sample& a, const Sample& b) {
  const auto& x = std::get<PoseSample>(a.what);
  const auto& y = std::get<PoseSample>(b.what);
  EXPECT_EQ(x.pose.acquired, y.pose.acquired);
  EXPECT_EQ(x.pose.received, y.pose.received);
  EXPECT_EQ(x.pose.status, y.pose.status);
  EXPECT_EQ(x.pose.clock_unsure, y.pose.clock_unsure);
  EXPECT_EQ(x.tracker_error_mm, y.tracker_error_mm);
  for (int i = 0; i < 16; ++i) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(x.pose.tracker_from_body(i / 4, i % 4)),
              std::bit_cast<std::uint64_t>(y.pose.tracker_from_body(i / 4, i % 4)));
  }
}

void expect_same_image(const Sample& a, const Sample& b) {
  const auto& x = std::get<UltrasoundImage>(a.what);
  const auto& y = std::get<UltrasoundImage>(b.what);
  EXPECT_EQ(x.acquired, y.acquired);
  EXPECT_EQ(x.received, y.received);
  EXPECT_EQ(x.sequence, y.sequence);
  EXPECT_EQ(x.clock_unsure, y.clock_unsure);
  EXPECT_EQ(x.grid.mm_per_pixel, y.grid.mm_per_pixel);
  EXPECT_EQ(x.grid.origin_mm, y.grid.origin_mm);
  ASSERT_EQ(x.outline.has_value(), y.outline.has_value());
  if (x.outline) {
    EXPECT_EQ(x.outline->apex_mm, y.outline->apex_mm);
    EXPECT_EQ(x.outline->radius_min_mm, y.outline->radius_min_mm);
    EXPECT_EQ(x.outline->radius_max_mm, y.outline->radius_max_mm);
    EXPECT_EQ(x.outline->half_angle_rad, y.outline->half_angle_rad);
  }
  EXPECT_EQ(x.pixels.width(), y.pixels.width());
  EXPECT_EQ(x.pixels.height(), y.pixels.height());
  EXPECT_TRUE(std::ranges::equal(x.pixels.pixels(), y.pixels.pixels()));
}

TEST(SampleLayoutTest, KeepsEveryBitOfEveryKind) {
  std::vector<std::byte> buffer;
  for (std::uint64_t i = 0; i < 60; ++i) {
    Sample sample = i % 3 == 0 ? test::pose_sample(0, i, 5'000 - static_cast<std::int64_t>(i) * 700)
                    : i % 3 == 1 ? test::image_sample(0, i << 40, 1, static_cast<int>(i), 7)
                                 : test::missing_sample(0, ~i, -5);
    const auto encoded = encode(sample, buffer);
    std::vector<std::byte> bytes(encoded.fields.begin(), encoded.fields.end());
    bytes.insert(bytes.end(), encoded.pixels.begin(), encoded.pixels.end());
    const auto decoded = decode(kind_of(sample), bytes);
    ASSERT_TRUE(decoded) << i;
    EXPECT_EQ(decoded->sequence, sample.sequence);
    EXPECT_EQ(decoded->received, sample.received);
    EXPECT_EQ(decoded->device_time, sample.device_time);
    if (i % 3 == 0) expect_same_pose(*decoded, sample);
    if (i % 3 == 1) expect_same_image(*decoded, sample);
    if (i % 3 == 2) {
      EXPECT_EQ(std::get<MissingImage>(decoded->what).cause, "no_timestamp");
      EXPECT_EQ(std::get<MissingImage>(decoded->what).message, "image without a time");
    }
  }
}

TEST(SampleLayoutTest, RejectsEveryOtherLength) {
  std::vector<std::byte> buffer;
  for (const Sample& sample : {test::pose_sample(0, 2, 3), test::image_sample(0, 1, 2, 5, 3),
                               test::colour_sample(0, 1, 2, 5, 3), test::missing_sample(0, 1, 2),
                               Sample{0, 1, test::at_ns(2), {}, ButtonSample{{}, true}}}) {
    const auto encoded = encode(sample, buffer);
    std::vector<std::byte> bytes(encoded.fields.begin(), encoded.fields.end());
    bytes.insert(bytes.end(), encoded.pixels.begin(), encoded.pixels.end());
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      EXPECT_FALSE(decode(kind_of(sample), std::span(bytes).first(size))) << size;
    }
    bytes.push_back(std::byte{0});
    EXPECT_FALSE(decode(kind_of(sample), bytes));
  }
}

TEST(SampleLayoutTest, KeepsColoursAndTheirLuma) {
  std::vector<std::byte> buffer;
  const Sample sample = test::colour_sample(0, 1, 2, 5, 3);
  const auto encoded = encode(sample, buffer);
  EXPECT_EQ(encoded.pixels.size(), 5u * 3u * 3u);
  std::vector<std::byte> bytes(encoded.fields.begin(), encoded.fields.end());
  bytes.insert(bytes.end(), encoded.pixels.begin(), encoded.pixels.end());
  const auto decoded = decode(kind_of(sample), bytes);
  ASSERT_TRUE(decoded);
  expect_same_image(*decoded, sample);
  const auto& image = std::get<UltrasoundImage>(decoded->what);
  const auto& colours = std::get<UltrasoundImage>(sample.what).colours;
  ASSERT_EQ(image.colours.width(), 5);
  ASSERT_EQ(image.colours.height(), 3);
  EXPECT_TRUE(std::ranges::equal(image.colours.pixels(), colours.pixels()));
}

TEST(DeviceRecordingTest, ImagesWithAndWithoutColoursKeepTheirOrder) {
  const test::TemporaryFolder folder;
  const auto path = folder / "colours.mcap";
  std::vector<DeviceSample> samples = small_session(12);
  std::int64_t ns = 2'000'000'000;
  for (std::uint64_t i = 0; i < 9; ++i, ns += 10'000'000) {
    samples.push_back({1, i % 3 == 0 ? test::image_sample(0, i, ns, 12, 8)
                                     : test::colour_sample(0, i, ns, 12, 8)});
  }
  ASSERT_NO_FATAL_FAILURE(test::record_all(path, samples, test::small_chunks(500)));
  expect_recorded(path, samples);
}

/// Sizes whose product overflows must not allocate.
TEST(SampleLayoutTest, RejectsHostileImageSizes) {
  std::vector<std::byte> buffer;
  const Sample sample = test::image_sample(0, 1, 2, 5, 3);
  const auto encoded = encode(sample, buffer);
  const std::size_t width_at = encoded.fields.size() - 8;
  std::vector<std::byte> bytes(encoded.fields.begin(), encoded.fields.end());
  bytes.insert(bytes.end(), encoded.pixels.begin(), encoded.pixels.end());
  for (std::size_t i = 0; i < 8; ++i) bytes[width_at + i] = std::byte{0xFF};
  EXPECT_FALSE(decode(SampleKind::kImage, bytes));
  for (std::size_t i = 0; i < 8; ++i)
    bytes[width_at + i] = i % 4 == 3 ? std::byte{0x7F} : std::byte{0xFF};
  EXPECT_FALSE(decode(SampleKind::kImage, bytes));
}

TEST(SampleLayoutTest, RejectsUnknownVersionsStatusesAndFlags) {
  EXPECT_EQ(sample_kind("sonde.Pose.1"), SampleKind::kPose);
  EXPECT_FALSE(sample_kind("sonde.Pose.2"));
  std::vector<std::byte> buffer;
  const Sample sample = test::pose_sample(0, 2, 3);
  static_cast<void>(encode(sample, buffer));
  constexpr std::size_t kHead = 25, kStatusAt = kHead + 16, kFlagsAt = kStatusAt + 1;
  for (const auto& [at, value] : {std::pair{kStatusAt, 6}, {kFlagsAt, 4}, {std::size_t{16}, 2}}) {
    auto bytes = buffer;
    bytes[at] = static_cast<std::byte>(value);
    EXPECT_FALSE(decode(SampleKind::kPose, bytes)) << at;
  }
}

TEST(DeviceRecordingTest, ButtonsComeBackWithTheirActions) {
  const test::TemporaryFolder folder;
  const auto path = folder / "buttons.mcap";
  const auto change = [](std::size_t stream, std::uint64_t sequence, std::int64_t ns, bool down) {
    return Sample{stream, sequence, test::at_ns(ns), {}, ButtonSample{test::at_ns(ns - 5), down}};
  };
  const std::vector<Sample> samples{change(0, 0, 1000, true), change(1, 0, 1500, true),
                                    change(0, 1, 2000, false)};
  {
    auto recorder = DeviceRecorder::create(path);
    ASSERT_TRUE(test::has_value(recorder));
    const auto device = (*recorder)->add_device(
        "pedal", {{"left", StreamKind::kButtons, ToolRole::kOther, ButtonAction::kMark},
                  {"right", StreamKind::kButtons, ToolRole::kOther, ButtonAction::kCapture}});
    ASSERT_TRUE(test::has_value(device));
    for (const Sample& sample : samples) {
      ASSERT_TRUE(test::has_value((*recorder)->record(*device, sample)));
    }
  }
  const auto recording = DeviceRecording::open(path);
  ASSERT_TRUE(test::has_value(recording));
  const auto& streams = recording->devices().at(0).streams;
  EXPECT_EQ(streams[0].kind, StreamKind::kButtons);
  EXPECT_EQ(streams[0].action, ButtonAction::kMark);
  EXPECT_EQ(streams[1].action, ButtonAction::kCapture);
  auto source = recording->source(0);
  ASSERT_TRUE(test::has_value(source));
  for (const Sample& sample : samples) {
    const auto read = (*source)->next(Timestamp::max());
    ASSERT_TRUE(test::has_value(read));
    EXPECT_EQ(read->stream, sample.stream);
    EXPECT_EQ(test::bits_of(*read), test::bits_of(sample));
  }
}

TEST(DeviceRecordingTest, GivesEverySampleBackBitForBit) {
  const test::TemporaryFolder folder;
  const auto samples = small_session(300);
  test::record_all(folder / "a.mcap", samples, test::small_chunks(4096));
  expect_recorded(folder / "a.mcap", samples);
}

TEST(DeviceRecordingTest, DescribesDevicesStreamsCountsAndTimes) {
  const test::TemporaryFolder folder;
  const auto samples = small_session(100);
  test::record_all(folder / "a.mcap", samples, test::small_chunks(4096));
  for (const bool read_all : {false, true}) {
    const auto recording = DeviceRecording::open(folder / "a.mcap", {read_all, true});
    ASSERT_TRUE(has_value(recording));
    ASSERT_EQ(recording->devices().size(), 2U);
    const auto& tracker = recording->devices()[0];
    EXPECT_EQ(tracker.id, "tracker");
    ASSERT_EQ(tracker.streams.size(), 2U);
    EXPECT_EQ(tracker.streams[1].name, "Needle/1");
    EXPECT_EQ(tracker.streams[1].kind, StreamKind::kPoses);
    EXPECT_EQ(tracker.streams[1].role, ToolRole::kNeedle);
    EXPECT_EQ(tracker.samples, (std::vector<std::uint64_t>{40, 40}));
    EXPECT_EQ(recording->devices()[1].streams[0].kind, StreamKind::kImages);
    EXPECT_EQ(recording->devices()[1].samples, (std::vector<std::uint64_t>{20}));
    EXPECT_EQ(recording->find("scanner"), 1U);
    EXPECT_FALSE(recording->find("other"));
    EXPECT_EQ(recording->first_time(), samples.front().sample.received);
    EXPECT_EQ(recording->last_time(), samples.back().sample.received);
    EXPECT_EQ(recording->duration(), Duration(790'000'001));
    EXPECT_TRUE(recording->is_finished());
    EXPECT_EQ(recording->session().at("version"), "test");
    EXPECT_EQ(recording->session().at("recording"), recording->id());
  }
}

TEST(DeviceRecordingTest, MergesDevicesInOrderOfArrival) {
  const test::TemporaryFolder folder;
  const auto samples = small_session(100);
  // Recorded device after device, as no live session does.
  auto by_device = samples;
  std::ranges::stable_sort(by_device, {}, &DeviceSample::device);
  test::record_all(folder / "a.mcap", by_device, test::small_chunks(2048));
  const auto recording = DeviceRecording::open(folder / "a.mcap");
  ASSERT_TRUE(has_value(recording));
  auto merged = recording->merged();
  ASSERT_TRUE(has_value(merged));
  for (const DeviceSample& expected : samples) {
    const auto next = merged->next();
    ASSERT_TRUE(has_value(next));
    EXPECT_EQ(next->device, expected.device);
    EXPECT_EQ(bits_of(next->sample), bits_of(expected.sample));
  }
  EXPECT_EQ(merged->next().error().code, ErrorCode::kEndOfStream);
  EXPECT_EQ(merged->next().error().code, ErrorCode::kEndOfStream);
}

TEST(DeviceRecordingTest, SourcesKeepTheContractOfTheVirtualClock) {
  const test::TemporaryFolder folder;
  const auto samples = small_session(20);
  test::record_all(folder / "a.mcap", samples, test::small_chunks(2048));
  const auto recording = DeviceRecording::open(folder / "a.mcap");
  ASSERT_TRUE(has_value(recording));
  auto source = recording->source(0);
  ASSERT_TRUE(has_value(source));
  EXPECT_EQ((*source)->streams().size(), 2U);
  const Timestamp first = samples.front().sample.received;
  EXPECT_EQ((*source)->next(first - Duration(1)).error().code, ErrorCode::kTimeout);
  EXPECT_EQ((*source)->next(first)->received, first);
  EXPECT_EQ((*source)->next(first).error().code, ErrorCode::kTimeout);
  (*source)->stop();
  EXPECT_EQ((*source)->next(Deadline::max()).error().code, ErrorCode::kCancelled);
}

TEST(DeviceRecordingTest, StoresMetadataAndAttachments) {
  const test::TemporaryFolder folder;
  auto recorder = DeviceRecorder::create(folder / "a.mcap", test::small_chunks(4096));
  ASSERT_TRUE(has_value(recorder));
  const std::string big(200'000, 'x');
  const auto bytes = [](const std::string& text) { return std::as_bytes(std::span(text)); };
  ASSERT_TRUE(has_value((*recorder)->attach("c.xml", "text/xml", at_ns(5), bytes("<a/>"))));
  ASSERT_TRUE(has_value((*recorder)->attach("empty", "", at_ns(6), {})));
  ASSERT_TRUE(has_value((*recorder)->attach("big", "text/plain", at_ns(6), bytes(big))));
  ASSERT_TRUE(has_value((*recorder)->add_metadata("note", {{"a", "b"}, {"", "\n"}})));
  ASSERT_TRUE(has_value((*recorder)->finish()));
  ASSERT_TRUE(has_value((*recorder)->finish()));
  for (const bool use_index : {true, false}) {
    const auto recording = DeviceRecording::open(folder / "a.mcap", {false, use_index});
    ASSERT_TRUE(has_value(recording));
    ASSERT_EQ(recording->metadata().size(), 1U);
    EXPECT_EQ(recording->metadata()[0].values, (TextMap{{"a", "b"}, {"", "\n"}}));
    ASSERT_EQ(recording->attachments().size(), 3U);
    EXPECT_EQ(recording->attachments()[0].head.media_type, "text/xml");
    EXPECT_EQ(recording->attachments()[0].head.log_time, 5U);
    const auto content = recording->read(recording->attachments()[2], big.size());
    ASSERT_TRUE(has_value(content));
    EXPECT_TRUE(std::ranges::equal(*content, bytes(big)));
    EXPECT_TRUE(rejects(recording->read(recording->attachments()[2], big.size() - 1),
                        ErrorCode::kUnsupportedData, {"big", "200000"}));
    EXPECT_EQ(recording->samples(), 0U);
    EXPECT_FALSE(recording->first_time());
    EXPECT_EQ(recording->duration(), Duration{});
    EXPECT_EQ(recording->warnings(), std::vector<std::string>());
  }
}

/// The attachment of a damaged recording is searched for chunks, and contains some.
TEST(DeviceRecordingTest, DoesNotMistakeARecordingInsideItForItsOwn) {
  const test::TemporaryFolder folder;
  auto inner_options = test::small_chunks(4096);
  inner_options.id = "another";
  test::record_all(folder / "inner.mcap", small_session(50), inner_options);
  const std::string inner = test::get(folder / "inner.mcap");
  const auto samples = small_session(30);
  {
    auto recorder = DeviceRecorder::create(folder / "a.mcap", test::small_chunks(4096));
    ASSERT_TRUE(has_value(recorder));
    test::add_devices(**recorder);
    ASSERT_TRUE(
        has_value((*recorder)->attach("inner", "", at_ns(0), std::as_bytes(std::span(inner)))));
    for (const auto& next : samples) {
      ASSERT_TRUE(has_value((*recorder)->record(next.device, next.sample)));
    }
    ASSERT_TRUE(has_value((*recorder)->finish()));
  }
  std::string damaged = test::get(folder / "a.mcap");
  damaged[damaged.find(inner) + 20] ^= 1;
  test::put(folder / "a.mcap", damaged);
  const auto recording = DeviceRecording::open(folder / "a.mcap", {false, false});
  ASSERT_TRUE(has_value(recording));
  EXPECT_EQ(recording->samples(), samples.size());
  EXPECT_EQ(recording->session().at("recording"), "0123456789abcdef");
  EXPECT_EQ(recording->attachments().size(), 0U);
  ASSERT_EQ(recording->warnings().size(), 2U);
  EXPECT_NE(recording->warnings()[1].find("51 parts of another recording"), std::string::npos)
      << recording->warnings()[1];
}

TEST(DeviceRecordingTest, RejectsFilesThatAreNoRecording) {
  const test::TemporaryFolder folder;
  test::put(folder / "empty", "");
  test::put(folder / "text", std::string(100'000, '\x06') + "no recording");
  EXPECT_TRUE(rejects(DeviceRecording::open(folder / "empty"), ErrorCode::kMalformedData,
                      {"empty", "expected a recording", "the file is empty"}));
  EXPECT_TRUE(rejects(DeviceRecording::open(folder / "text"), ErrorCode::kMalformedData,
                      {"text", "no intact part"}));
  EXPECT_TRUE(rejects(DeviceRecording::open(folder / "none"), ErrorCode::kNotFound, {"none"}));
  EXPECT_TRUE(rejects(DeviceRecording::open(folder.path()), ErrorCode::kIo, {"folder"}));
}

TEST(DeviceRecorderTest, RejectsWhatItCannotRecordAndGoesOn) {
  const test::TemporaryFolder folder;
  auto recorder = DeviceRecorder::create(folder / "a.mcap", test::small_chunks(4096));
  ASSERT_TRUE(has_value(recorder));
  test::add_devices(**recorder);
  EXPECT_TRUE(rejects((*recorder)->add_device("tracker", {}), ErrorCode::kUsage, {"tracker"}));
  EXPECT_TRUE(rejects((*recorder)->add_device("", {}), ErrorCode::kUsage, {"empty"}));
  EXPECT_TRUE(rejects((*recorder)->record(1, test::image_sample(0, 1, 5, 8192, 8193)),
                      ErrorCode::kUsage, {"67108864"}));
  Sample missing = test::missing_sample(0, 1, 5);
  std::get<MissingImage>(missing.what).message.assign(70'000, 'x');
  EXPECT_TRUE(rejects((*recorder)->record(1, missing), ErrorCode::kUsage, {"scanner", "65536"}));
  EXPECT_THROW(static_cast<void>((*recorder)->record(7, missing)), Bug);
  EXPECT_THROW(static_cast<void>((*recorder)->record(1, test::missing_sample(1, 1, 1))), Bug);
  ASSERT_TRUE(has_value((*recorder)->record(0, test::pose_sample(0, 1, 5))));
  EXPECT_EQ((*recorder)->counts().samples, 1U);
  EXPECT_FALSE((*recorder)->stopped());
  ASSERT_TRUE(has_value((*recorder)->finish()));
  const auto recording = DeviceRecording::open(folder / "a.mcap");
  ASSERT_TRUE(has_value(recording));
  EXPECT_EQ(recording->samples(), 1U);
}

TEST(DeviceRecorderTest, NeverOverwritesARecording) {
  const test::TemporaryFolder folder;
  test::put(folder / "a.mcap", "old");
  EXPECT_TRUE(rejects(DeviceRecorder::create(folder / "a.mcap"), ErrorCode::kIo,
                      {"a.mcap", "found an existing one"}));
  EXPECT_EQ(test::get(folder / "a.mcap"), "old");
  EXPECT_TRUE(
      rejects(DeviceRecorder::create(folder / "no/a.mcap"), ErrorCode::kIo, {"No such file"}));
  auto options = test::small_chunks(0);
  EXPECT_TRUE(
      rejects(DeviceRecorder::create(folder / "b.mcap", options), ErrorCode::kUsage, {"chunk"}));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.mcap"));
}

/// Time of the last sample that can be read while the recorder is still open.
TEST(DeviceRecorderTest, WritesAtLeastEvery100Milliseconds) {
  const test::TemporaryFolder folder;
  RecorderOptions options;
  options.id = "x";
  auto recorder = DeviceRecorder::create(folder / "a.mcap", options);
  ASSERT_TRUE(has_value(recorder));
  test::add_devices(**recorder);
  for (std::int64_t ms = 0; ms < 1000; ms += 10) {
    const auto number = static_cast<std::uint64_t>(ms);
    ASSERT_TRUE(has_value((*recorder)->record(0, test::pose_sample(0, number, ms * 1'000'000))));
    const auto recording = DeviceRecording::open(folder / "a.mcap");
    ASSERT_TRUE(has_value(recording));
    const auto last = recording->last_time();
    EXPECT_GE(last.value_or(at_ns(-10'000'000)), at_ns((ms - 100) * 1'000'000)) << ms;
  }
  // The stream falls silent: time alone brings the rest into the file.
  ASSERT_TRUE(has_value((*recorder)->advance_to(at_ns(1'090'000'000))));
  EXPECT_EQ(DeviceRecording::open(folder / "a.mcap")->samples(), 100U);
}

TEST(DeviceRecorderTest, TakesSamplesFromSeveralThreads) {
  const test::TemporaryFolder folder;
  auto recorder = DeviceRecorder::create(folder / "a.mcap", test::small_chunks(4096));
  ASSERT_TRUE(has_value(recorder));
  test::add_devices(**recorder);
  constexpr std::uint64_t kEach = 500;
  const auto run = [&](std::size_t device) {
    for (std::uint64_t i = 0; i < kEach; ++i) {
      const auto ns = static_cast<std::int64_t>(i) * 1'000'000;
      static_cast<void>((*recorder)->record(
          device, device == 0 ? test::pose_sample(0, i, ns) : test::image_sample(0, i, ns, 9, 9)));
    }
  };
  std::thread other(run, 1);
  run(0);
  other.join();
  ASSERT_TRUE(has_value((*recorder)->finish()));
  const auto recording = DeviceRecording::open(folder / "a.mcap", {true, true});
  ASSERT_TRUE(has_value(recording));
  EXPECT_EQ(recording->devices()[0].samples[0], kEach);
  EXPECT_EQ(recording->devices()[1].samples[0], kEach);
  auto source = recording->source(1);
  ASSERT_TRUE(has_value(source));
  const auto samples = test::drained(**source);
  for (std::uint64_t i = 0; i < kEach; ++i) ASSERT_EQ(samples[i].sequence, i);
}

/// Times before the origin have no place in the fields of MCAP, but in the sample.
TEST(DeviceRecorderTest, KeepsTimesBeforeTheOrigin) {
  const test::TemporaryFolder folder;
  std::vector<DeviceSample> samples = {{0, test::pose_sample(0, 1, -5'000'000'000)},
                                       {0, test::pose_sample(1, 1, -1)},
                                       {0, test::pose_sample(0, 2, 0)},
                                       {1, test::image_sample(0, 2, 7, 0, 0)}};
  test::record_all(folder / "a.mcap", samples, {});
  expect_recorded(folder / "a.mcap", samples);
}

}  // namespace
}  // namespace nav::io::mcap
