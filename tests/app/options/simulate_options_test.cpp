// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "app/verbs/simulate/simulate.hpp"

namespace nav::app {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string rejection(const SimulateOptions& options) {
  const auto ok = validate(options);
  if (ok) return "accepted";
  EXPECT_EQ(ok.error().code, ErrorCode::kUsage);
  return ok.error().message;
}

TEST(SimulateOptionsTest, ErrorsOfNumbersGiveNameRangeAndFoundValue) {
  struct Case {
    const char* name;
    double SimulateOptions::*number;
    double accepted, refused;
    const char* expected;
  };
  using O = SimulateOptions;
  const Case cases[] = {
      {"--ct-spacing-mm", &O::ct_spacing_mm, 0.2, 0.1, "0.2 to 100 mm, found 0.1"},
      {"--length-mm", &O::length_mm, 500, 10000, "0 to 500 mm, found 10000"},
      {"--length-mm", &O::length_mm, 0, -5, "0 to 500 mm, found -5"},
      {"--angle-deg", &O::angle_deg, 170, 1000, "0 to 170 degrees, found 1000"},
      {"--deform-mm", &O::deform_mm, 20, 21, "0 to 20 mm, found 21"},
      {"--needle-bevel-deg", &O::needle_bevel_deg, -360, 400, "-360 to 360 degrees, found 400"},
      {"--needle-speed-mm-s", &O::needle_speed_mm_s, 0, -4, "0 to 1000 mm/s, found -4"},
      {"--needle-length-mm", &O::needle_length_mm, 1, 0,
       "more than 0 and at most 1000 mm, found 0"},
      {"--tracker-rate-hz", &O::tracker_rate_hz, 1, 0, "more than 0 and at most 10000 Hz, found 0"},
      {"--latency-ms", &O::latency_ms, 0, -5, "0 to 10000 ms, found -5"},
      {"--jitter-ms", &O::jitter_ms, 1000, 1e6, "0 to 1000 ms, found 1000000"},
      {"--clock-offset-ms", &O::clock_offset_ms, -3.6e6, 1e30,
       "-3600000 to 3600000 ms, found 1e+30"},
      {"--clock-drift-ppm", &O::clock_drift_ppm, 10000, 1e9,
       "-10000 to 10000 ppm, found 1000000000"},
      {"--loss", &O::loss, 1, 1.5, "0 to 1, found 1.5"},
      {"--image-offset-ms", &O::image_offset_ms, -10000, 1e6, "-10000 to 10000 ms, found 1000000"},
      {"--unevenness", &O::unevenness, 0.9, 1, "0 to 0.9, found 1"},
      {"--pressure-mm", &O::pressure_mm, 12, 13, "0 to 12 mm, found 13"},
      {"--stand-off-mm", &O::stand_off_mm, 40, 41, "0 to 40 mm, found 41"},
      {"--frame-rate-hz", &O::frame_rate_hz, 1000, 0, "more than 0 and at most 1000 Hz, found 0"},
  };
  for (const Case& c : cases) {
    SimulateOptions options;
    options.*c.number = c.accepted;
    EXPECT_EQ(rejection(options), "accepted") << c.name;
    options.*c.number = c.refused;
    EXPECT_EQ(rejection(options), std::string(c.name) + ": expected " + c.expected);
    options.*c.number = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THAT(rejection(options), StartsWith(std::string(c.name) + ": expected "));
    EXPECT_THAT(rejection(options), HasSubstr(", found nan"));
    options.*c.number = std::numeric_limits<double>::infinity();
    EXPECT_THAT(rejection(options), StartsWith(std::string(c.name) + ": expected "));
  }
}

TEST(SimulateOptionsTest, AnImageHasTheSizeOfTheProbeOrAtMostAFewThousandPixels) {
  for (int SimulateOptions::*side : {&SimulateOptions::columns, &SimulateOptions::rows}) {
    SimulateOptions options;
    for (const int accepted : {0, 16, 4096}) {
      options.*side = accepted;
      EXPECT_EQ(rejection(options), "accepted") << accepted;
    }
    for (const int refused : {-4, 8, 4097}) {
      options.*side = refused;
      EXPECT_THAT(rejection(options), HasSubstr("0 (the probe's own) or 16 to 4096 pixels, found " +
                                                std::to_string(refused)));
    }
  }
}

TEST(SimulateOptionsTest, RejectsBreathingNumbersWithoutBreathing) {
  SimulateOptions options;
  options.breathing_mm = 5;
  EXPECT_THAT(rejection(options), StartsWith("--breathing-mm requires --breathing rigid"));
  options.breathing = "smooth";
  EXPECT_EQ(rejection(options), "accepted");
  options.breathing_mm = -5;
  EXPECT_EQ(rejection(options), "--breathing-mm: expected 0 to 60 mm, found -5");
  options = SimulateOptions();
  options.breathing_period_s = 5;
  EXPECT_THAT(rejection(options), StartsWith("--breathing-period-s requires --breathing rigid"));
  options.breathing = "rigid";
  EXPECT_EQ(rejection(options), "accepted");
  options.breathing_period_s = 0;
  EXPECT_EQ(rejection(options), "--breathing-period-s: expected 0.5 to 30 s, found 0");
}

TEST(SimulateOptionsTest, AStraightNeedleDoesNotBend) {
  SimulateOptions options;
  options.needle = "straight";
  options.needle_bending_mm = 4;
  EXPECT_EQ(rejection(options), "--needle-bending-mm: expected 0 mm of a straight needle, found 4");
  options.needle = "bevel";
  EXPECT_EQ(rejection(options), "accepted");
  options.needle_bending_mm = -3;
  EXPECT_EQ(rejection(options), "--needle-bending-mm: expected 0 to 200 mm, found -3");
}

TEST(SimulateOptionsTest, RejectsAPointThatIsNotFinite) {
  SimulateOptions options;
  options.look_at_mm = {1, 2, std::numeric_limits<double>::infinity()};
  EXPECT_EQ(rejection(options),
            "--look-at: expected 3 numbers of -10000000 to 10000000 mm, found 1 2 inf");
}

TEST(SimulateOptionsTest, ARecordingHasAtLeastTwoImages) {
  SimulateOptions options;
  options.frame_rate_hz = 5;
  options.duration_s = 0.2;
  EXPECT_EQ(rejection(options), "accepted");
  options.duration_s = 0.1;
  EXPECT_THAT(rejection(options), HasSubstr("--duration-s: expected time for two images"));
}

}  // namespace
}  // namespace nav::app
