// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>

#include "app/verbs/export.hpp"
#include "io/mcap/device_recorder.hpp"
#include "io/sequence_writer.hpp"
#include "session/recorded_setup.hpp"
#include "session/session.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

constexpr int kImages = 5;

Timestamp at_export_ms(int ms) { return Timestamp(std::chrono::milliseconds(ms)); }

/// Image of 3 x 2 pixels. \p colours: red, green, blue / their halves; otherwise grey.
UltrasoundImage image_of(int number, bool colours) {
  UltrasoundImage image;
  image.acquired = image.received = at_export_ms(100 + 40 * number);
  image.sequence = static_cast<std::uint64_t>(number);
  image.grid = PixelGrid::centred(3, 0.5, 0.5);
  const auto n = static_cast<std::uint8_t>(number);
  std::vector<Rgb8> pixels{{255, 0, n}, {0, 255, n}, {n, 0, 255},
                           {127, 0, 0}, {0, 127, 0}, {0, 0, 127}};
  if (!colours) {
    for (Rgb8& pixel : pixels) pixel = {luma(pixel), luma(pixel), luma(pixel)};
  }
  set_colours(image, {3, 2, std::move(pixels)});
  return image;
}

/// Records images of a scanner, those from \p first_colour on in colours, and poses of its probe.
void record_images(const std::filesystem::path& path, int first_colour) {
  auto recorder = io::mcap::DeviceRecorder::create(path);
  ASSERT_TRUE(test::has_value(recorder));
  session::SessionSetup setup;
  setup.calibration = ProbeCalibration{Transform<frames::Probe, frames::Image>(
      Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero())};
  setup.fixed_reference.emplace(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero());
  ASSERT_TRUE(test::has_value(
      (*recorder)->add_metadata(session::kSetupMetadata, session::facts_of(setup))));
  const auto device =
      (*recorder)->add_device("scanner", {{"Probe", StreamKind::kPoses, ToolRole::kProbe},
                                          {"Image", StreamKind::kImages, ToolRole::kOther}});
  ASSERT_TRUE(test::has_value(device));
  const auto record = [&](std::size_t stream, std::uint64_t sequence, int ms, auto what) {
    const Sample sample{stream, sequence, at_export_ms(ms), {}, std::move(what)};
    ASSERT_TRUE(test::has_value((*recorder)->record(*device, sample)));
  };
  std::uint64_t poses = 0;
  for (int ms = 0; ms <= 400; ms += 10) {
    PoseSample pose{
        {at_export_ms(ms), at_export_ms(ms), TrackingStatus::kOk, Eigen::Matrix4d::Identity()}};
    pose.pose.tracker_from_body(0, 3) = 0.05 * ms;
    record(0, poses++, ms, pose);
    const int number = (ms - 100) / 40;
    if (ms < 100 || (ms - 100) % 40 != 0 || number >= kImages) continue;
    record(1, static_cast<std::uint64_t>(number), ms, image_of(number, number >= first_colour));
  }
  ASSERT_TRUE(test::has_value((*recorder)->finish()));
}

class ExportColoursTest : public ::testing::Test {
 protected:
  /// The exported sequence of such a recording.
  io::SequenceReader exported(int first_colour) {
    const auto recording = folder_ / (std::to_string(first_colour) + ".mcap");
    record_images(recording, first_colour);
    SessionConfig config;
    config.source.recording = recording;
    const ExportOptions options{.out = folder_ / (std::to_string(first_colour) + ".igs.mha")};
    Console console(false);
    EXPECT_TRUE(test::has_value(run_export(config, options, console)));
    auto reader = io::SequenceReader::open(options.out);
    EXPECT_TRUE(test::has_value(reader));
    return std::move(*reader);
  }
  test::TemporaryFolder folder_;
};

TEST_F(ExportColoursTest, EveryImageKeepsItsColoursToTheBit) {
  // The scanner shows colours from the first image on, or from a later one, or only in the last.
  for (const int first_colour : {0, 2, kImages - 1}) {
    auto reader = exported(first_colour);
    EXPECT_EQ(reader.header().components, 3);
    EXPECT_EQ(reader.header().image_type, "RGB_COLOR");
    ASSERT_EQ(reader.header().frame_count, kImages);
    for (int i = 0; i < kImages; ++i) {
      const auto frame = reader.read(i);
      ASSERT_TRUE(test::has_value(frame));
      GreyScale scale;
      const auto image = io::sequence_image(reader.header(), *frame, scale);
      ASSERT_TRUE(test::has_value(image));
      const UltrasoundImage expected = image_of(i, i >= first_colour);
      EXPECT_TRUE(std::ranges::equal(image->pixels.pixels(), expected.pixels.pixels())) << i;
      EXPECT_TRUE(std::ranges::equal(image->colours.pixels(), expected.colours.pixels())) << i;
      EXPECT_EQ(image->colours.empty(), i < first_colour);
    }
  }
}

TEST_F(ExportColoursTest, ARecordingWithoutColoursIsWrittenInGrey) {
  auto reader = exported(kImages);
  EXPECT_EQ(reader.header().components, 1);
  EXPECT_EQ(reader.header().image_type, "BRIGHTNESS");
  const auto frame = reader.read(3);
  ASSERT_TRUE(test::has_value(frame));
  const UltrasoundImage expected = image_of(3, false);
  ASSERT_EQ(frame->pixels.size(), expected.pixels.pixels().size());
  EXPECT_EQ(std::memcmp(frame->pixels.data(), expected.pixels.pixels().data(), 6), 0);
}

}  // namespace
}  // namespace nav::app
