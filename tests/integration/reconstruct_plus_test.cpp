// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Volumes of the recorded spine sweep beside those of PLUS.
#include <cmath>
#include <gtest/gtest.h>
#include <ostream>

#include "app/verbs/reconstruct.hpp"
#include "io/ct.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

struct PlusVolume {
  const char* config;
  const char* volume;
  const char* compound;
  double least_correlation;
  double least_within_one;  ///< Share of common voxels within 1 grey level.
};

void PrintTo(const PlusVolume& plus, std::ostream* out) { *out << plus.compound; }

class PlusVolumeTest : public ::testing::TestWithParam<PlusVolume> {};

TEST_P(PlusVolumeTest, NearestAgreesWithPlus) {
  const PlusVolume& plus = GetParam();
  SONDE_REQUIRE_DATA(data, std::filesystem::path("plus-sequences"));
  const test::TemporaryFolder folder;
  SessionConfig config;
  config.source.recording = data / "sequences/SpinePhantomFreehand.igs.mha";
  config.source.plus_config = data / "config" / plus.config;
  ReconstructOptions options;
  options.out = folder / "us.mha";
  options.compound = plus.compound;
  Console console(false);
  ASSERT_TRUE(test::has_value(run_reconstruct(config, options, std::nullopt, console)));
  const auto ours = io::read_stored_volume(options.out, console);
  const auto theirs = io::read_stored_volume(data / "baselines" / plus.volume, console);
  ASSERT_TRUE(test::has_value(ours));
  ASSERT_TRUE(test::has_value(theirs));
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_LE(std::abs(ours->grid().size[a] - theirs->grid().size[a]), 1);
  }
  constexpr double kRoundedMm = 1e-3;  // PLUS writes six digits.
  EXPECT_LT((ours->grid().origin_mm - theirs->grid().origin_mm).norm(), kRoundedMm);
  // Common voxels: seen by both. 0 is PLUS's mark of empty voxels.
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0, within = 0;
  for (int k = 0; k < std::min(ours->grid().size[2], theirs->grid().size[2]); ++k) {
    for (int j = 0; j < std::min(ours->grid().size[1], theirs->grid().size[1]); ++j) {
      for (int i = 0; i < std::min(ours->grid().size[0], theirs->grid().size[0]); ++i) {
        const double a = ours->at(i, j, k);
        const double b = theirs->at(i, j, k);
        if (a < 0 || b <= 0) continue;
        ++n;
        x += a;
        y += b;
        xx += a * a;
        yy += b * b;
        xy += a * b;
        if (std::abs(a - b) <= 1) ++within;
      }
    }
  }
  EXPECT_GT(n, 50000);
  const double correlation = (n * xy - x * y) / std::sqrt((n * xx - x * x) * (n * yy - y * y));
  EXPECT_GE(correlation, plus.least_correlation);
  EXPECT_GE(within / n, plus.least_within_one);
  ::testing::Test::RecordProperty("correlation", std::to_string(correlation));
}

// PLUS's mean truncates at every pixel, 4.9 grey levels too low, so that its levels do not count.
INSTANTIATE_TEST_SUITE_P(
    Spine, PlusVolumeTest,
    ::testing::Values(
        PlusVolume{"PlusDeviceSet_VolumeReconstructionOnly_SonixRP_TRUS_D70mm_NN_LATE.xml",
                   "vtkVolumeReconstructorTestNNLATEvolumeRef.mha", "latest", 0.9985, 0.9},
        PlusVolume{"PlusDeviceSet_VolumeReconstructionOnly_SpinePhantom_NN_MEAN.xml",
                   "vtkVolumeReconstructorTestNNMEANvolumeRef.mha", "mean", 0.9988, 0}));

}  // namespace
}  // namespace nav::app
