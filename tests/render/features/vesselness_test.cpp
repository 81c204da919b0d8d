// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/vesselness.hpp"

#include <numbers>

#include "render/features/definition.hpp"
#include "tests/render/features/derived_support.hpp"

namespace nav::render::features {
namespace {

/// 1 inside, 0 outside, with an edge as wide as one voxel: the share of the voxel that is inside.
double soft(double inside_mm, double voxel_mm) {
  return std::clamp(0.5 + inside_mm / voxel_mm, 0.0, 1.0);
}

VesselnessOptions bright(double smallest, double largest, int scales, double contrast) {
  VesselnessOptions options;
  options.polarity = Polarity::kBright;
  options.smallest_radius_mm = smallest;
  options.largest_radius_mm = largest;
  options.scales = scales;
  options.contrast = contrast;
  return options;
}

/// A straight tube through the origin.
ScalarVolume tube(const VoxelGrid& grid, double radius_mm, const Eigen::Vector3d& along,
                  double contrast) {
  const Eigen::Vector3d d = along.normalized();
  return test::make_scalar_at(grid, [&](const Eigen::Vector3d& p) {
    return 20 + contrast * soft(radius_mm - p.cross(d).norm(), 0.5);
  });
}

float middle_of(const FeatureVolume& v) {
  return v.at(v.grid.size[0] / 2, v.grid.size[1] / 2, v.grid.size[2] / 2);
}

TEST(VesselnessTest, EigenvaluesInATubeEqualTheClosedForm) {
  // A disc of radius r smoothed with sigma has the transverse eigenvalues -C (r^2 / 2 s^2) exp(-r^2
  // / 2 s^2).
  const auto grid = test::centred_grid({41, 41, 33}, {0.5, 0.5, 0.5});
  const double radius = 3;
  const auto volume = tube(grid, radius, {0, 0, 1}, 100);
  const std::size_t centre = offset_of(grid, 20, 20, 16);
  for (const double sigma : {1.6, radius / std::numbers::sqrt2, 3.0}) {
    const auto values = definition::eigenvalues(volume, sigma, 6)[centre];
    const double ratio = radius * radius / (2 * sigma * sigma);
    EXPECT_NEAR(values[0], -100 * ratio * std::exp(-ratio), 0.6) << sigma;
    EXPECT_NEAR(values[1], -100 * ratio * std::exp(-ratio), 0.6) << sigma;
    EXPECT_NEAR(values[2], 0, 1e-9) << sigma;
  }
}

TEST(VesselnessTest, ATubeHasTheLargestResponseAtItsOwnRadius) {
  const auto grid = test::centred_grid({45, 45, 45}, {0.5, 0.5, 0.5});
  for (const Eigen::Vector3d& along : {Eigen::Vector3d(0, 0, 1), {1, 0, 0}, {1, 2, -1}}) {
    const auto volume = tube(grid, 2.5, along, 100);
    const auto at_radius = [&](double r) {
      return middle_of(*vesselness(volume, bright(r, r, 1, 100)));
    };
    const float best = at_radius(2.5);
    // For the ideal tube: (1 - e^-2) (1 - e^-2).
    EXPECT_NEAR(best, std::pow(1 - std::exp(-2.0), 2), 0.03);
    EXPECT_GT(best, 1.1 * at_radius(1.4));
    EXPECT_GT(best, 1.1 * at_radius(4.4));
  }
}

TEST(VesselnessTest, PlatesBlobsAndTheOppositePolarityHaveNoResponse) {
  const auto grid = test::centred_grid({41, 41, 41}, {0.5, 0.5, 0.5});
  const auto options = bright(2, 3, 3, 100);
  const auto plate = test::make_scalar_at(
      grid, [](const Eigen::Vector3d& p) { return 100 * soft(2.5 - std::abs(p.x()), 0.5); });
  const auto blob = test::make_scalar_at(
      grid, [](const Eigen::Vector3d& p) { return 100 * soft(2.5 - p.norm(), 0.5); });
  EXPECT_LT(middle_of(*vesselness(plate, options)), 1e-3);
  EXPECT_LT(middle_of(*vesselness(blob, options)), 0.13);  // exp(-2), the limit of the measure
                                                           // itself.
  auto dark = options;
  dark.polarity = Polarity::kDark;
  const auto vessel = tube(grid, 2.5, {0, 0, 1}, 100);
  EXPECT_LT(middle_of(*vesselness(vessel, dark)), 1e-6);
  EXPECT_GT(middle_of(*vesselness(tube(grid, 2.5, {0, 0, 1}, -15), dark)), 0.01);
}

TEST(VesselnessTest, DependsOnMillimetresNotOnVoxels) {
  // A smooth tube on a grid of 0.4 x 0.4 x 1 mm, along and across the thick slices.
  for (const Eigen::Vector3d& along : {Eigen::Vector3d(0, 0, 1), {0, 1, 0}}) {
    const auto profile = [&](const Eigen::Vector3d& p) {
      return 100 * std::exp(-p.cross(along).squaredNorm() / (2 * 2.2 * 2.2));
    };
    const auto fine =
        test::make_scalar_at(test::centred_grid({41, 41, 41}, {0.5, 0.5, 0.5}), profile);
    const auto thick =
        test::make_scalar_at(test::centred_grid({51, 51, 21}, {0.4, 0.4, 1}), profile);
    const auto options = bright(3, 3, 1, 100);
    EXPECT_NEAR(middle_of(*vesselness(thick, options)), middle_of(*vesselness(fine, options)),
                3e-3);
  }
}

TEST(VesselnessTest, EqualsItsDefinition) {
  unsigned seed = 1;
  for (const auto& [size, spacing] :
       {std::pair{std::array{27, 20, 18}, Eigen::Vector3d(0.4, 0.4, 0.4)},
        {{24, 24, 9}, {0.2, 0.2, 1}},
        {{1, 30, 21}, {0.5, 0.5, 0.5}},
        {{33, 17, 1}, {0.3, 0.5, 0.4}}}) {
    const auto volume = test::speckled(test::centred_grid(size, spacing), seed++);
    auto options = bright(0.6, 1.8, 3, 60);
    options.truncate = 6;
    const auto found = vesselness(volume, options);
    ASSERT_TRUE(test::has_value(found));
    // Float eigenvalues near a change of sign change the response steeply, but only there.
    EXPECT_LT(test::largest_difference(*found, definition::vesselness(volume, options)), 2e-4);
  }
}

TEST(VesselnessTest, UnknownVoxelsStayUnknownAndCauseNoResponse) {
  const auto grid = test::centred_grid({31, 31, 31}, {0.5, 0.5, 0.5});
  const auto volume = test::make_scalar(
      grid, [](int i, int j, int) { return i < 8 || j > 25 ? std::nan("") : 1e6 + 100; });
  const auto found = vesselness(volume, bright(1, 3, 2, 100));
  ASSERT_TRUE(test::has_value(found));
  EXPECT_TRUE(std::isnan(found->at(3, 3, 3)));
  for (int i = 8; i < 31; ++i) EXPECT_EQ(found->at(i, 20, 15), 0) << i;
}

TEST(VesselnessTest, ExtendsValuesIntoUnknownVoxelsAsDefined) {
  const auto grid = test::centred_grid({21, 19, 15}, {0.5, 0.5, 0.5});
  std::mt19937 random(2);
  std::normal_distribution<double> noise;
  const auto volume = test::make_scalar(grid, [&](int i, int j, int k) {
    const double value = 60 + 20 * noise(random);
    return i + j + k < 16 || (i == 15 && j == 9) ? std::nan("") : value;
  });
  auto options = bright(0.7, 1.4, 2, 60);
  options.truncate = 6;
  EXPECT_LT(test::largest_difference(*vesselness(volume, options),
                                     definition::vesselness(volume, options)),
            2e-4);
}

TEST(VesselnessTest, ConstantAndSaturatedVolumesHaveNoResponse) {
  const auto grid = test::centred_grid({17, 9, 5}, {0.2, 0.2, 1});
  for (const double value : {0.0, 255.0, 1e6, std::nan("")}) {
    const auto volume = test::make_scalar(grid, [&](int, int, int) { return value; });
    const auto found = vesselness(volume, {});
    ASSERT_TRUE(test::has_value(found));
    for (const float v : *found->values) EXPECT_TRUE(std::isnan(value) ? std::isnan(v) : v == 0);
  }
}

TEST(VesselnessTest, ContrastDependsOnTheValuesNotOnTheUnit) {
  const auto grid = test::centred_grid({41, 41, 41}, {0.5, 0.5, 0.5});
  auto options = bright(1, 1, 1, 0);
  std::vector<float> middles;
  for (const double unit : {1e-3, 1.0, 1e3}) {
    // Seven of 1681 voxels in each slice differ.
    const auto volume = test::make_scalar(grid, [&](int i, int j, int) {
      const bool inside = std::abs(i - 20) <= 1 && std::abs(j - 20) <= 1 &&
                          (i == 20 || j == 20 || (i == 19 && j == 19) || (i == 21 && j == 21));
      return unit * (inside ? 100 : 0);
    });
    EXPECT_NEAR(contrast_of(options, volume, 1), 50 * unit, 0.05 * unit);
    middles.push_back(middle_of(*vesselness(volume, options)));
  }
  EXPECT_GT(middles[1], 0.1F);
  EXPECT_NEAR(middles[0], middles[1], 1e-3);
  EXPECT_NEAR(middles[2], middles[1], 1e-3);
}

TEST(VesselnessTest, OneOutlierDoesNotDetermineTheContrast) {
  const auto grid = test::centred_grid({21, 21, 21}, {0.5, 0.5, 0.5});
  const auto value = [](int i, int j, int k) { return 10.0 * ((3 * i + 5 * j + 7 * k) % 11); };
  const auto quiet = test::make_scalar(grid, value);
  const auto loud = test::make_scalar(
      grid, [&](int i, int j, int k) { return i == 4 && j == 5 && k == 6 ? 1e9 : value(i, j, k); });
  const VesselnessOptions options;
  EXPECT_NEAR(contrast_of(options, quiet, 1), 50, 0.1);
  EXPECT_NEAR(contrast_of(options, loud, 1), 50, 0.1);
}

TEST(VesselnessTest, SkippingChangesNoMoreThanStated) {
  const auto grid = test::centred_grid({48, 40, 40}, {0.5, 0.5, 0.5});
  // A tube beside a slope that is so gentle that its bricks are skipped.
  const auto volume = test::make_scalar_at(grid, [](const Eigen::Vector3d& p) {
    return 1e-3 * p.x() + 100 * soft(1.5 - std::hypot(p.y() - 6, p.z() - 6), 0.5);
  });
  auto options = bright(1, 2, 2, 100);
  const auto skipped = vesselness(volume, options);
  options.negligible_response = 0;
  const auto all = vesselness(volume, options);
  float worst = 0;
  for (std::size_t n = 0; n < all->values->size(); ++n) {
    worst = std::max(worst, std::abs((*all->values)[n] - (*skipped->values)[n]));
  }
  EXPECT_LE(worst, 1e-4F);
}

TEST(VesselnessTest, AFaintTubeWithAResponseIsNotSkipped) {
  const auto grid = test::centred_grid({32, 32, 32}, {0.5, 0.5, 0.5});
  auto options = bright(2, 2, 1, 100);
  options.negligible_response = 0.1;
  float most = 0;
  for (const double contrast : {5.0, 10.0, 20.0, 30.0, 40.0}) {
    const float found = middle_of(*vesselness(tube(grid, 2, {0, 0, 1}, contrast), options));
    options.negligible_response = 0;
    const float full = middle_of(*vesselness(tube(grid, 2, {0, 0, 1}, contrast), options));
    options.negligible_response = 0.1;
    EXPECT_LE(std::abs(full - found), 0.1F) << contrast;
    most = std::max(most, full);
  }
  EXPECT_GT(most, 0.1F);
}

TEST(VesselnessTest, ScalesAreRadiiOverTheRootOfTwoInEqualRatios) {
  auto options = bright(1, 4, 3, 100);
  const auto sigmas = sigmas_mm(options);
  ASSERT_EQ(sigmas.size(), 3U);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_NEAR(sigmas[s], std::pow(2.0, static_cast<double>(s)) / std::sqrt(2.0), 1e-12);
  }
  options.scales = 1;
  ASSERT_EQ(sigmas_mm(options).size(), 1U);
  EXPECT_NEAR(sigmas_mm(options)[0], std::sqrt(2.0), 1e-12);
}

TEST(VesselnessTest, DoesNotDependOnThreadsAndStopsOnRequest) {
  const auto volume = test::speckled(test::centred_grid({30, 22, 26}, {0.4, 0.4, 0.4}), 9);
  RunOptions one;
  one.threads = 1;
  RunOptions three;
  three.threads = 3;
  EXPECT_TRUE(test::same_bytes(*vesselness(volume, {}, one)->values,
                               *vesselness(volume, {}, three)->values));
  std::stop_source stop;
  RunOptions stopped;
  stopped.stop = stop.get_token();
  stopped.progress = [&](double share) {
    if (share > 0.3) stop.request_stop();
  };
  EXPECT_EQ(vesselness(volume, {}, stopped).error().code, ErrorCode::kCancelled);
}

TEST(VesselnessTest, RejectsInvalidOptionsByName) {
  const auto volume = test::speckled(test::centred_grid({4, 4, 4}, {0.01, 1, 1}), 1);
  auto options = bright(3, 2, 1, 1);
  EXPECT_NE(vesselness(volume, options).error().message.find("largest_radius_mm"),
            std::string::npos);
  options = bright(1, 2, 99, 1);
  EXPECT_NE(vesselness(volume, options).error().message.find("scales"), std::string::npos);
  options = bright(1, 9, 2, 1);  // A sigma of 6.4 mm is 636 voxels.
  EXPECT_NE(vesselness(volume, options).error().message.find("at most 256 voxels"),
            std::string::npos);
}

}  // namespace
}  // namespace nav::render::features
