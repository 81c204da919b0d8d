// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/panels.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace nav::app {
namespace {

constexpr int kWidth = 500;
constexpr int kHeight = 400;

Image2d<Rgba8> composed(const std::string& note, const std::string& warning = "") {
  VoxelGrid grid;
  grid.size = {1, 1, 1};
  const auto ct = Volume::create(grid, {0}, "one voxel");
  const Image2d<Rgba8> view(kWidth, kHeight,
                            std::vector<Rgba8>(std::size_t{kWidth} * kHeight, {40, 40, 40, 255}));
  const session::Epoch epoch;
  const std::string banner = "SIMULATED";
  return compose_panels(
      view,
      {.epoch = epoch, .ct = *ct, .plan = {}, .banner = banner, .note = note, .warning = warning});
}

TEST(PanelsTest, ShowTheEnginesNoteOverThe3dViewOnly) {
  const auto silent = composed("");
  const auto spoken = composed("CT down-sampled to 2 mm");
  ASSERT_EQ(silent.width(), spoken.width());
  int changed = 0;
  for (int y = 0; y < silent.height(); ++y) {
    for (int x = 0; x < silent.width(); ++x) {
      if (silent.at(x, y) == spoken.at(x, y)) continue;
      ++changed;
      EXPECT_TRUE(x < kWidth && y > 20 && y < 60) << x << ", " << y;
    }
  }
  EXPECT_GT(changed, 500);
}

TEST(PanelsTest, ShowTheRegistrationWarningBelowTheNote) {
  const auto silent = composed("");
  const auto warned = composed("", "registration warning: cost of the match: 0.3");
  int changed = 0;
  for (int y = 0; y < silent.height(); ++y) {
    for (int x = 0; x < silent.width(); ++x) {
      if (silent.at(x, y) == warned.at(x, y)) continue;
      ++changed;
      EXPECT_TRUE(x < kWidth && y >= 50 && y < 80) << x << ", " << y;
    }
  }
  EXPECT_GT(changed, 500);
}

/// Epoch with a live black image of 40 mm in the plane z = 0 of the CT, and a needle whose +z
/// points along a direction.
session::Epoch with_needle(const Eigen::Vector3d& tip, const Eigen::Vector3d& along) {
  UltrasoundImage frame;
  constexpr int kSide = 80;
  frame.pixels = Image2d<std::uint8_t>(kSide, kSide, std::vector<std::uint8_t>(kSide * kSide, 0));
  frame.grid = PixelGrid::centred(kSide, 0.5, 0.5);
  const SafetyState valid = SafetyState::kValid;
  session::Epoch epoch;
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  const auto still = Eigen::Quaterniond::Identity();
  epoch.frame = TrackedImage{frame, Transform<frames::Reference, frames::Image>(still, zero),
                             Duration::zero()};
  epoch.ultrasound = epoch.placement = epoch.plane = epoch.needle = {valid, ""};
  // The image's middle column lies at x = 20 of the CT.
  epoch.ct_from_image = Transform<frames::Ct, frames::Image>(still, {20, 0, 0});
  const auto turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), along);
  epoch.ct_from_needle = Transform<frames::Ct, frames::Needle>(turn, tip);
  return epoch;
}

Image2d<Rgba8> composed(const session::Epoch& epoch, int width = kWidth, int height = kHeight,
                        const std::string& banner = "", bool needle = false) {
  VoxelGrid grid;
  grid.size = {1, 1, 1};
  const auto ct = Volume::create(grid, {0}, "one voxel");
  const Image2d<Rgba8> view(
      width, height,
      std::vector<Rgba8>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                         {40, 40, 40, 255}));
  PanelContext context{.epoch = epoch, .ct = *ct, .plan = {}, .banner = banner};
  context.needle_expected = needle;
  return compose_panels(view, context);
}

/// Number of pixels of the flat panels in which two images differ.
int changed_in_panels(const Image2d<Rgba8>& a, const Image2d<Rgba8>& b) {
  int changed = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth; x < a.width(); ++x) changed += a.at(x, y) == b.at(x, y) ? 0 : 1;
  }
  return changed;
}

TEST(PanelsTest, TheNeedleIsDrawnOnlyWhereItMeetsThePlane) {
  const auto none = [] {
    session::Epoch epoch = with_needle({0, 0, 0}, {0, 1, 0});
    epoch.needle = {SafetyState::kLost, ""};
    return composed(epoch);
  }();
  const auto changed = [&](const Eigen::Vector3d& tip, const Eigen::Vector3d& along) {
    return changed_in_panels(composed(with_needle(tip, along)), none);
  };
  const Eigen::Vector3d down(0, 1, 0);
  const int in_plane = changed({20, 20, 0}, down);
  EXPECT_GT(in_plane, 300);
  EXPECT_EQ(changed({20, 20, 1}, down), in_plane) << "within the thickness of a slice";
  EXPECT_EQ(changed({20, 20, 27}, down), 0) << "far from the plane and along it";
  EXPECT_EQ(changed({20, 20, -27}, down), 0);
  EXPECT_EQ(changed({20, 20, 27}, {0, 0, 1}), changed({20, 20, 90}, {0, 0, 1}))
      << "a dot where the shaft goes through";
  const int dot = changed({20, 20, 27}, {0, 0, 1});
  EXPECT_GT(dot, 10);
  EXPECT_LT(dot, 300);
  const int ring = changed({20, 20, -27}, {0, 0, 1});
  EXPECT_GT(ring, 10) << "a ring where it would";
  EXPECT_LT(ring, 600);
  EXPECT_NE(ring, dot);
}

TEST(PanelsTest, TheMarginIsARingAroundTheTargetInThePlane) {
  session::Epoch epoch = with_needle({0, 0, 0}, {0, 1, 0});
  epoch.needle = {SafetyState::kLost, ""};
  VoxelGrid grid;
  grid.size = {1, 1, 1};
  const auto ct = Volume::create(grid, {0}, "one voxel");
  const Image2d<Rgba8> view(kWidth, kHeight,
                            std::vector<Rgba8>(std::size_t{kWidth} * kHeight, {40, 40, 40, 255}));
  const auto drawn = [&](double margin_mm, double off_plane_mm) {
    NeedlePlan plan;
    plan.target_ct = {{20, 20, off_plane_mm}};
    plan.entry_ct = {{20, 0, off_plane_mm}};
    plan.target_radius_mm = 4;
    plan.margin_mm = margin_mm;
    const std::optional<NeedlePlan> planned = plan;
    return compose_panels(view, {.epoch = epoch, .ct = *ct, .plan = planned, .banner = ""});
  };
  EXPECT_GT(changed_in_panels(drawn(0, 0), drawn(5, 0)), 100);
  EXPECT_GT(changed_in_panels(drawn(0, 6), drawn(5, 6)), 100) << "the margin alone meets it";
  EXPECT_EQ(changed_in_panels(drawn(0, 10), drawn(5, 10)), 0);
}

TEST(PanelsTest, AnExpectedNeedleHasALampEvenWhileLost) {
  session::Epoch epoch = with_needle({20, 20, 0}, {0, 1, 0});
  epoch.needle = {SafetyState::kLost, "no needle pose"};
  const auto without = composed(epoch);
  const auto with = composed(epoch, kWidth, kHeight, "", true);
  int changed = 0;
  for (int y = kHeight; y < with.height(); ++y) {
    for (int x = 0; x < with.width(); ++x) changed += with.at(x, y) == without.at(x, y) ? 0 : 1;
  }
  EXPECT_GT(changed, 200);
}

TEST(PanelsTest, NumbersHaveTheirIntervalOf95PerCent) {
  NeedleGuidance guidance{};
  guidance.tip_to_target_mm = 12.34;
  guidance.lateral_mm = 1.25;
  guidance.angle_to_plan_rad = 0;
  EXPECT_EQ(guidance_words(guidance),
            "tip to target 12.3 mm    lateral 1.2 mm    angle to plan 0.0 deg");
  session::GuidanceError error;
  error.tip_to_target_mm = 0.8;
  error.angle_to_plan_rad = M_PI / 180;
  EXPECT_EQ(guidance_words(guidance, error),
            "tip to target 12.3 +/- 0.8 mm    lateral 1.2 mm    angle to plan 0.0 +/- 1.0 deg    "
            "(+/-: 95 %)");
}

TEST(PanelsTest, ALongNoteIsShownToItsEnd) {
  const std::string start =
      "the volume of 4096 x 4 x 4 voxels exceeds the device: it is drawn from means of 2 x 1 x 1 "
      "voxels; values differ by ";
  const auto one = composed(start + "12.5 HU rms");
  const auto other = composed(start + "98.7 HU rms");
  bool differ = false;
  for (int y = 0; y < one.height() && !differ; ++y) {
    for (int x = 0; x < one.width(); ++x) differ = differ || !(one.at(x, y) == other.at(x, y));
  }
  EXPECT_TRUE(differ);
}

TEST(PanelsTest, SmallImagesShowTheBanner) {
  const session::Epoch epoch;
  const auto without = composed(epoch, 300, 200);
  const auto with = composed(epoch, 300, 200, "CT NOT REGISTERED");
  int changed = 0;
  for (int y = 200; y < with.height(); ++y) {
    for (int x = 0; x < with.width(); ++x) changed += with.at(x, y) == without.at(x, y) ? 0 : 1;
  }
  EXPECT_GT(changed, 100);
}

TEST(PanelsTest, SmallImagesShowTheCauseAndWhatIsNotRegistered) {
  constexpr int kSmallHeight = 240;
  session::Epoch registered;
  registered.placement = {SafetyState::kValid, ""};
  session::Epoch centred = registered;
  centred.placement = {SafetyState::kDegraded, "the CT is only centred on the sweep"};
  session::Epoch lost = registered;
  lost.plane = {SafetyState::kLost, "no pose for 3 s: the tracker does not see the probe"};
  const auto changed = [](const Image2d<Rgba8>& a, const Image2d<Rgba8>& b, int from, int to) {
    int count = 0;
    for (int y = from; y < to; ++y) {
      for (int x = 0; x < a.width(); ++x) count += a.at(x, y) == b.at(x, y) ? 0 : 1;
    }
    return count;
  };
  const auto plain = composed(registered, 320, kSmallHeight);
  EXPECT_GT(changed(plain, composed(centred, 320, kSmallHeight), 0, 40), 200) << "NOT REGISTERED";
  const auto with_cause = composed(lost, 320, kSmallHeight);
  EXPECT_GT(changed(plain, with_cause, kSmallHeight + 20, with_cause.height()), 200) << "the cause";
}

TEST(PanelsTest, SmallImagesShowTheNotes) {
  VoxelGrid grid;
  grid.size = {1, 1, 1};
  const auto ct = Volume::create(grid, {0}, "one voxel");
  const Image2d<Rgba8> view(300, 200, std::vector<Rgba8>(60000, {40, 40, 40, 255}));
  const session::Epoch epoch;
  const std::string banner;
  const auto said = [&](const std::string& note, const std::string& warning) {
    return compose_panels(view, {.epoch = epoch,
                                 .ct = *ct,
                                 .plan = {},
                                 .banner = banner,
                                 .note = note,
                                 .warning = warning});
  };
  const auto silent = said("", "");
  for (const auto& image : {said("distance from the needle withdrawn: lost", ""),
                            said("", "registration warning: few images")}) {
    int changed = 0;
    for (int y = 0; y < 60; ++y) {
      for (int x = 0; x < 300; ++x) changed += image.at(x, y) == silent.at(x, y) ? 0 : 1;
    }
    EXPECT_GT(changed, 100);
  }
}

}  // namespace
}  // namespace nav::app
