// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "nav/index.hpp"
#include "registration/acceptance.hpp"
#include "registration/prepared.hpp"
#include "registration/similarity/coarse_images.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

UltrasoundImage counting_frame(int width, int height) {
  std::vector<std::uint8_t> pixels;
  for (int i = 0; i < width * height; ++i) pixels.push_back(static_cast<std::uint8_t>(i % 251));
  UltrasoundImage frame{};
  frame.pixels = Image2d<std::uint8_t>(width, height, std::move(pixels));
  frame.grid = PixelGrid::centred(width, 0.3, 0.4);
  frame.grid.mm_per_pixel(0, 1) = 0.02;  // Sheared, like real calibrations.
  return frame;
}

TEST(CoarseImagesTest, AveragesBlocksAndKeepsTheirPosition) {
  const UltrasoundImage fine = counting_frame(23, 14);
  const UltrasoundImage coarse = averaged(fine, 3);
  ASSERT_EQ(coarse.pixels.width(), 7);
  ASSERT_EQ(coarse.pixels.height(), 4);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 7; ++column) {
      double sum = 0;
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 3; ++x) {
          sum += fine.pixels.at(3 * column + x, 3 * row + y);
          middle += fine.grid.at(3 * column + x, 3 * row + y).mm / 9;
        }
      }
      EXPECT_NEAR(coarse.pixels.at(column, row), sum / 9, 0.5 + 1e-9);
      EXPECT_LT((coarse.grid.at(column, row).mm - middle).norm(), 1e-12);
    }
  }
}

TEST(CoarseImagesTest, ManyBrightPixelsDoNotOverflow) {
  UltrasoundImage frame = counting_frame(130, 130);
  frame.pixels = Image2d<std::uint8_t>(130, 130, std::vector<std::uint8_t>(130 * 130, 255));
  const UltrasoundImage coarse = averaged(frame, kMostPixelsPerBlock);
  for (const std::uint8_t pixel : coarse.pixels.pixels()) EXPECT_EQ(pixel, 255);
}

TEST(CoarseImagesTest, BlocksAreNoWiderThanTheSmoothingAllows) {
  const PixelGrid grid = PixelGrid::centred(400, 0.5, 0.25);
  EXPECT_EQ(pixels_per_block(grid, 400, 300, 0.0), 1);
  EXPECT_EQ(pixels_per_block(grid, 400, 300, 1.8), 3);  // 0.85 · 1.8 / 0.5
  EXPECT_EQ(pixels_per_block(grid, 2, 300, 1.8), 2);
  PixelGrid broken = grid;
  broken.mm_per_pixel.setConstant(std::nan(""));
  EXPECT_EQ(pixels_per_block(broken, 400, 300, 1.8), 1);
}

/// Sweep with very unequal distances between images.
Sweep uneven_sweep() {
  std::vector<TrackedImage> frames;
  double along = 0;
  for (int i = 0; i < 50; ++i) {
    TrackedImage tracked{counting_frame(20, 20),
                         {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, along)},
                         Duration{0}};
    tracked.frame.acquired = Timestamp(from_seconds(0.1 * i));
    frames.push_back(tracked);
    along += i < 40 ? 0.1 : 4.0;  // The hand waits, then moves.
  }
  return *Sweep::create(std::move(frames), "uneven");
}

TEST(CoarseImagesTest, ImagesAreChosenEvenlyAlongThePathNotInTime) {
  const Sweep all = uneven_sweep();
  const Sweep some = coarse_images(all, 8, 0);
  ASSERT_LE(some.frames().size(), 8u);
  ASSERT_GE(some.frames().size(), 7u);
  EXPECT_EQ(some.frames().front().frame.acquired, all.frames().front().frame.acquired);
  double longest = 0;
  for (std::size_t i = 1; i < some.frames().size(); ++i) {
    longest = std::max(longest, (some.frames()[i].reference_from_image.translation_mm() -
                                 some.frames()[i - 1].reference_from_image.translation_mm())
                                    .norm());
  }
  // An eighth of 40 mm, plus the distance to the nearest image.
  EXPECT_LE(longest, 5.0 + 4.0);
  EXPECT_EQ(coarse_images(all, 1000, 0).frames().size(), all.frames().size());
}

ImageRegistrationOptions quick() {
  ImageRegistrationOptions options = with_effort(Effort::kQuick);
  options.ridge = 0.005;  // This CT has only rounding noise (0.3 HU).
  options.threads = 1;
  return options;
}

TEST(EffortTest, EffortsHaveNamesAndValidOptions) {
  EXPECT_STREQ(to_string(Effort::kQuick), "quick");
  EXPECT_STREQ(to_string(Effort::kUsual), "usual");
  EXPECT_TRUE(test::has_value(validate(with_effort(Effort::kQuick))));
  EXPECT_EQ(with_effort(Effort::kUsual).levels.size(), ImageRegistrationOptions{}.levels.size());
  auto options = quick();
  options.most_images = -1;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"most_images"}));
  options = quick();
  options.least_judging = 19;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"least_judging"}));
  options = quick();
  options.levels[0].texel_sigmas = 0;
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"levels[0].texel_sigmas"}));
}

TEST(EffortTest, AQuickRegistrationFindsThePoseFromEightImages) {
  CollectingDiagnostics diagnostics;
  // The probe moves at an even speed, which eight images do not tell from a delay: it is known.
  ImageRegistrationOptions options = quick();
  options.delay_sigma_s = 0.01;
  options.speed_from_ct = false;  // Images of blobs have one speed of sound.
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const auto start = test::off_by(test::true_pose(), 6, 0.08, seed);
    const auto result = register_sweep(test::blob_scene().ct, test::blob_scene().sweep, start,
                                       options, diagnostics);
    ASSERT_TRUE(test::has_value(result));
    // Samples of 2 mm, a patient that follows the model, and noise of 4 grey levels.
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), 0.8);
    EXPECT_LE(result->levels.back().frames, 8);
    EXPECT_LT(result->final_cost, result->initial_cost);
    const Decision decision = decide(*result, limits_for(Effort::kQuick), {{0, 0, 0}});
    EXPECT_TRUE(decision.accepted) << (decision.reasons.empty() ? "" : decision.reasons[0]);
  }
}

TEST(EffortTest, TheCtNearThePatchesGivesTheResultOfTheWholeCt) {
  // With voxels of 1 mm, the boxes of 200 patches contain a small part of the texels.
  const Volume fine = test::blob_ct(test::blob_scene().patient, test::cubic_grid(80, 1.0));
  CollectingDiagnostics diagnostics;
  const auto options = quick();
  const auto sweep = PreparedSweep::create(test::blob_scene().sweep, options, diagnostics);
  const auto ct = PreparedCt::create(fine, options);
  ASSERT_TRUE(test::has_value(sweep));
  ASSERT_TRUE(test::has_value(ct));
  const auto start = test::off_by(test::true_pose(), 6, 0.08, 2);
  const auto whole = register_prepared(*ct, *sweep, start, options);
  const auto once = register_prepared(fine, *sweep, start, options);
  ASSERT_TRUE(test::has_value(whole));
  ASSERT_TRUE(test::has_value(once));
  EXPECT_LT(test::cube_error_mm(once->ct_from_reference, whole->ct_from_reference), 0.05);
  EXPECT_NEAR(once->final_cost, whole->final_cost, 0.01);
}

TEST(EffortTest, AQuickRegistrationRejectsAnotherPatient) {
  const Volume other = test::blob_ct(test::BlobPatient(99), test::cubic_grid());
  CollectingDiagnostics diagnostics;
  const auto result =
      register_sweep(other, test::blob_scene().sweep, test::true_pose(), quick(), diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_FALSE(decide(*result, limits_for(Effort::kQuick), {{0, 0, 0}}).accepted);
}

TEST(EffortTest, AQuickRegistrationHasALowerCostLimit) {
  EXPECT_EQ(limits_for(Effort::kUsual).max_cost, AcceptanceLimits{}.max_cost);
  EXPECT_LT(limits_for(Effort::kQuick).max_cost, AcceptanceLimits{}.max_cost);
  EXPECT_TRUE(test::has_value(validate(limits_for(Effort::kQuick))));
}

TEST(EffortTest, OneAndTwoThreadsGiveEqualBits) {
  CollectingDiagnostics diagnostics;
  const auto start = test::off_by(test::true_pose(), 6, 0.08, 1);
  auto options = quick();
  const auto one =
      register_sweep(test::blob_scene().ct, test::blob_scene().sweep, start, options, diagnostics);
  options.threads = 2;
  const auto two =
      register_sweep(test::blob_scene().ct, test::blob_scene().sweep, start, options, diagnostics);
  ASSERT_TRUE(test::has_value(one));
  ASSERT_TRUE(test::has_value(two));
  EXPECT_EQ(one->ct_from_reference.matrix(), two->ct_from_reference.matrix());
  EXPECT_EQ(one->final_cost, two->final_cost);
  EXPECT_EQ(one->uncertainty.covariance, two->uncertainty.covariance);
}

TEST(PatchesTest, UprightPixelsAreSampledExactlyLikeShearedOnes) {
  const Sweep upright = test::blob_sweep(test::BlobPatient(11), {});
  const auto masks = shadow_masks(upright, {});
  ASSERT_TRUE(test::has_value(masks));
  // The shear is too small to move anything, but the pixels are no longer upright.
  std::vector<TrackedImage> frames = upright.frames();
  for (TrackedImage& tracked : frames) {
    tracked.frame.grid.mm_per_pixel(1, 0) = 1e-300;
    tracked.frame.grid.mm_per_pixel(0, 1) = 1e-300;
  }
  const auto leaning = Sweep::create(std::move(frames), upright.calibration_id());
  ASSERT_TRUE(test::has_value(leaning));
  for (const PatchChoice choice : {PatchChoice::kContrast, PatchChoice::kEven}) {
    for (const int side : {5, 7, 21}) {
      const LevelOptions level{.sample_step_mm = 2.0,
                               .patch_side = side,
                               .patches = 120,
                               .frame_step_mm = 6.0,
                               .choice = choice};
      const PatchSet expected = make_patches(*leaning, *masks, level, 1.5);
      const PatchSet found = make_patches(upright, *masks, level, 1.5);
      ASSERT_EQ(found.patches.size(), expected.patches.size());
      EXPECT_EQ(found.samples, expected.samples);
      EXPECT_EQ(found.samples.empty(), false) << side;
    }
  }
}

/// Images of noise, in which every square has contrast.
Sweep noisy_sweep(int images, int width, int height) {
  std::vector<TrackedImage> frames;
  std::mt19937 random(7);
  for (int i = 0; i < images; ++i) {
    TrackedImage tracked{counting_frame(width, height),
                         {Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 10.0 * i)},
                         Duration{0}};
    std::vector<std::uint8_t> pixels(as_size(width * height));
    for (std::uint8_t& pixel : pixels) pixel = static_cast<std::uint8_t>(random() % 256);
    tracked.frame.pixels = Image2d<std::uint8_t>(width, height, std::move(pixels));
    tracked.frame.grid = PixelGrid::centred(width, 1.0, 1.0);
    tracked.frame.acquired = Timestamp(from_seconds(0.1 * i));
    frames.push_back(tracked);
  }
  return *Sweep::create(std::move(frames), "noisy");
}

std::vector<Image2d<std::uint8_t>> open_masks(const Sweep& sweep) {
  const auto& first = sweep.frames().front().frame.pixels;
  const std::vector<std::uint8_t> open(first.pixels().size(), 1);
  return {sweep.frames().size(), Image2d<std::uint8_t>(first.width(), first.height(), open)};
}

/// Share of the patches that overlap more than half of another patch of the same image.
double overlapping(const PatchSet& set, double half_mm) {
  const auto& all = set.patches;
  const auto close = [&](const Patch& a, const Patch& b) {
    return &a != &b && a.frame == b.frame && (a.centre_mm - b.centre_mm).norm() < 1.01 * half_mm;
  };
  const auto count = std::count_if(all.begin(), all.end(), [&](const Patch& a) {
    return std::any_of(all.begin(), all.end(), [&](const Patch& b) { return close(a, b); });
  });
  return static_cast<double>(count) / static_cast<double>(all.size());
}

/// Star discrepancy: the largest difference between the share of some patches and the share of all
/// squares in boxes that start at one corner. The box sizes are multiples of an eighth of each
/// axis.
double unevenness(const PatchSet& some, const PatchSet& all) {
  Eigen::Array3d low = Eigen::Array3d::Constant(1e300);
  Eigen::Array3d high = -low;
  for (const Patch& patch : all.patches) {
    low = low.min(patch.centre_mm.array());
    high = high.max(patch.centre_mm.array());
  }
  const auto share = [](const PatchSet& set, const Eigen::Array3d& end) {
    const auto in = std::count_if(set.patches.begin(), set.patches.end(), [&](const Patch& patch) {
      return (patch.centre_mm.array() < end).all();
    });
    return static_cast<double>(in) / static_cast<double>(set.patches.size());
  };
  double most = 0;
  for (int box = 0; box < 512; ++box) {
    const Eigen::Array3d eighths = Eigen::Array3d(box % 8, box / 8 % 8, box / 64) + 1;
    const Eigen::Array3d end = low + (high - low) * (eighths / 8) + 1e-6;
    most = std::max(most, std::abs(share(some, end) - share(all, end)));
  }
  return most;
}

TEST(PatchesTest, AreSpreadEvenlyForAllImageSizes) {
  for (const int width : {70, 97, 128, 174, 200}) {
    for (const double step_mm : {1.7, 1.8, 1.9, 2.0, 2.1, 2.2}) {
      const Sweep sweep = noisy_sweep(8, width, 122);
      const LevelOptions level{.sample_step_mm = step_mm,
                               .patch_side = 7,
                               .patches = 160,
                               .frame_step_mm = 1.0,
                               .choice = PatchChoice::kEven};
      LevelOptions every = level;
      every.patches = 100'000;
      const PatchSet found = make_patches(sweep, open_masks(sweep), level, 0.6);
      ASSERT_EQ(found.patches.size(), 160u);
      const PatchSet all = make_patches(sweep, open_masks(sweep), every, 0.6);
      EXPECT_LT(unevenness(found, all), 0.07) << width << " at " << step_mm;
      EXPECT_EQ(overlapping(found, 3.5 * step_mm), 0) << width << " at " << step_mm;
    }
  }
}

TEST(PatchesTest, TakesEverySquareOnceIfAllAreRequested) {
  const Sweep sweep = noisy_sweep(3, 40, 33);
  const LevelOptions level{.sample_step_mm = 2.0,
                           .patch_side = 7,
                           .patches = 100'000,
                           .frame_step_mm = 1.0,
                           .choice = PatchChoice::kEven};
  std::set<std::array<double, 3>> found;
  const PatchSet set = make_patches(sweep, open_masks(sweep), level, 0.6);
  for (const Patch& patch : set.patches) {
    found.insert({patch.centre_mm.x(), patch.centre_mm.y(), patch.centre_mm.z()});
  }
  EXPECT_EQ(found.size(), set.patches.size());
  // The squares are half a side apart and start half a side from the border. Those at the rim reach
  // beyond it.
  EXPECT_EQ(set.patches.size(), 3u * 4 * 3);
}

}  // namespace
}  // namespace nav::registration
