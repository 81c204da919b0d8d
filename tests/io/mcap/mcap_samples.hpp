// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <bit>
#include <cstdint>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/mcap/device_recorder.hpp"
#include "io/mcap/device_recording.hpp"
#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::test {

using io::mcap::DeviceRecorder;
using io::mcap::DeviceRecording;
using io::mcap::DeviceSample;
using io::mcap::RecorderOptions;

inline Timestamp at_ns(std::int64_t ns) { return Timestamp(Duration(ns)); }

/// Bytes of all that a sample holds but its stream, for comparisons bit for bit.
inline std::string bits_of(const Sample& sample) {
  std::vector<std::byte> buffer;
  const auto encoded = io::mcap::encode(sample, buffer);
  std::string bits(1, static_cast<char>('0' + static_cast<int>(io::mcap::kind_of(sample))));
  for (const auto part : {encoded.fields, encoded.pixels}) {
    bits.append(reinterpret_cast<const char*>(part.data()), part.size());
  }
  return bits;
}

/// Sample with numbers of its own in every field.
inline Sample pose_sample(std::size_t stream, std::uint64_t sequence, std::int64_t ns) {
  PoseSample what;
  what.pose.acquired = at_ns(ns - 9'000'000);
  what.pose.received = at_ns(ns - 1);
  what.pose.status = static_cast<TrackingStatus>(sequence % 6);
  for (int i = 0; i < 16; ++i) {
    what.pose.tracker_from_body(i / 4, i % 4) = 0.1 * i + 1e-9 * static_cast<double>(sequence);
  }
  if (sequence % 5 == 0) {
    what.pose.tracker_from_body.setConstant(std::bit_cast<double>(0x7ff8'0000'dead'beefULL));
  }
  what.pose.clock_unsure = sequence % 3 == 0;
  if (sequence % 2 == 0) what.tracker_error_mm = 0.25 + static_cast<double>(sequence);
  Sample sample{stream, sequence, at_ns(ns), {}, what};
  if (sequence % 4 == 1) sample.device_time = DeviceTime(DeviceClock::duration(ns * 3 - 77));
  return sample;
}

inline Sample image_sample(std::size_t stream, std::uint64_t sequence, std::int64_t ns, int width,
                           int height) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) *
                                   static_cast<std::size_t>(height));
  auto state = static_cast<std::uint32_t>(sequence * 2654435761u + 12345u);
  for (auto& pixel : pixels) {
    state = state * 1664525u + 1013904223u;
    pixel = static_cast<std::uint8_t>(state >> 24);
  }
  UltrasoundImage image;
  image.acquired = at_ns(ns - 40'000'000);
  image.received = at_ns(ns - 2);
  image.sequence = sequence + 1000;
  image.pixels = Image2d<std::uint8_t>(width, height, std::move(pixels));
  image.grid.mm_per_pixel << 0.1, 0.003, -0.001, 0.12;
  image.grid.origin_mm << -3.5, 0.25;
  if (sequence % 2 == 1) image.outline = SectorOutline{{0.5, -40.0}, 41.0, 160.0, 0.6};
  image.clock_unsure = sequence % 3 == 1;
  Sample sample{stream, sequence, at_ns(ns), {}, std::move(image)};
  if (sequence % 4 == 2) sample.device_time = DeviceTime(DeviceClock::duration(-ns));
  return sample;
}

/// image_sample() with colours.
inline Sample colour_sample(std::size_t stream, std::uint64_t sequence, std::int64_t ns, int width,
                            int height) {
  Sample sample = image_sample(stream, sequence, ns, width, height);
  auto& image = std::get<UltrasoundImage>(sample.what);
  std::vector<Rgb8> colours;
  for (const std::uint8_t value : image.pixels.pixels()) {
    colours.push_back(
        {value, static_cast<std::uint8_t>(value * 3 + 1), static_cast<std::uint8_t>(200 - value)});
  }
  set_colours(image, {width, height, std::move(colours)});
  return sample;
}

inline Sample missing_sample(std::size_t stream, std::uint64_t sequence, std::int64_t ns) {
  return {stream, sequence, at_ns(ns), {}, MissingImage{"no_timestamp", "image without a time"}};
}

inline const std::vector<StreamInfo> kTrackerStreams = {
    {"Probe", StreamKind::kPoses, ToolRole::kProbe},
    {"Needle/1", StreamKind::kPoses, ToolRole::kNeedle}};
inline const std::vector<StreamInfo> kScannerStreams = {
    {"Image", StreamKind::kImages, ToolRole::kOther}};

/// A session of two devices, tracker (0) and scanner (1): poses at 100 Hz, an image after every
/// fourth, a missing one sometimes. Image pixels: 12 x 8.
inline std::vector<DeviceSample> small_session(std::size_t count) {
  std::vector<DeviceSample> samples;
  std::int64_t ns = 1'000'000'000;
  for (std::uint64_t i = 0; samples.size() < count; ++i, ns += 10'000'000) {
    samples.push_back({0, pose_sample(i % 2, i, ns)});
    if (i % 4 == 3) {
      samples.push_back(
          {1, i % 16 == 15 ? missing_sample(0, i, ns + 1) : image_sample(0, i, ns + 1, 12, 8)});
    }
  }
  samples.resize(count);
  return samples;
}

/// Adds the two devices of small_session().
inline void add_devices(DeviceRecorder& recorder) {
  ASSERT_TRUE(has_value(recorder.add_device("tracker", kTrackerStreams)));
  ASSERT_TRUE(has_value(recorder.add_device("scanner", kScannerStreams)));
}

/// Records samples into a new file. \p finish: with an index.
inline void record_all(const std::filesystem::path& path, const std::vector<DeviceSample>& samples,
                       RecorderOptions options, bool finish = true) {
  auto recorder = DeviceRecorder::create(path, std::move(options));
  ASSERT_TRUE(has_value(recorder));
  add_devices(**recorder);
  for (const DeviceSample& next : samples) {
    ASSERT_TRUE(has_value((*recorder)->record(next.device, next.sample)));
  }
  ASSERT_TRUE(has_value(finish ? (*recorder)->finish() : (*recorder)->flush()));
}

/// All samples of a source.
inline std::vector<Sample> drained(Source& source) {
  std::vector<Sample> samples;
  while (true) {
    auto next = source.next(Deadline::max());
    if (!next) {
      EXPECT_EQ(next.error().code, ErrorCode::kEndOfStream) << next.error().message;
      return samples;
    }
    samples.push_back(*std::move(next));
  }
}

/// Options with chunks of a size, however long they take, and a known id.
inline RecorderOptions small_chunks(std::size_t bytes) {
  RecorderOptions options;
  options.writer.chunk_bytes = bytes;
  options.writer.chunk_time = std::chrono::hours(1);
  options.session = {{"version", "test"}};
  options.id = "0123456789abcdef";
  return options;
}

}  // namespace nav::test
