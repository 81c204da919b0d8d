// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/registration_image.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace nav::app {
namespace {

constexpr int kPanel = 400;       // Width of each of the three panels, pixels.
constexpr int kCaption = 24;      // Height of the captions above them, pixels.
constexpr int kClearlyRed = 100;  // Excess of red over green; greys have none.

Volume soft_ct() {
  VoxelGrid grid;
  grid.size = {20, 20, 20};
  grid.spacing_mm = {2, 2, 2};
  return *Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 40), "soft");
}

Image2d<Rgba8> image(bool accepted) {
  const Transform<frames::Ct, frames::Reference> pose(Eigen::Quaterniond::Identity(), {20, 0, 20});
  const UltrasoundImage frame{
      .pixels = Image2d<std::uint8_t>(8, 8, std::vector<std::uint8_t>(64, 90)),
      .grid = PixelGrid::centred(8, 4, 4)};
  const TrackedImage tracked{
      frame, {Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()}, Duration(0)};
  return registration_image(soft_ct(), tracked, pose, pose, accepted, {});
}

/// Number of red pixels in a caption.
int red(const Image2d<Rgba8>& image, int panel) {
  int count = 0;
  for (int y = 0; y < kCaption; ++y) {
    for (int x = panel * kPanel; x < (panel + 1) * kPanel; ++x) {
      const Rgba8 pixel = image.at(x, y);
      if (pixel.r - pixel.g > kClearlyRed) ++count;
    }
  }
  return count;
}

TEST(RegistrationImageTest, ARefusedRegistrationHasARedCaption) {
  const auto refused = image(false);
  EXPECT_GT(red(refused, 2), 50);
  EXPECT_EQ(red(refused, 0) + red(refused, 1), 0);
  EXPECT_EQ(red(image(true), 2), 0);
}

}  // namespace
}  // namespace nav::app
