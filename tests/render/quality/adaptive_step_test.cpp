// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the adaptive step: its stated error is a bound for all values, and it saves samples.
#include "render/quality/adaptive_step.hpp"

#include <algorithm>
#include <cstring>

#include "tests/render/verification_engines.hpp"

namespace nav::render {
namespace {

using AdaptiveStepTest = test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, AdaptiveStepTest, ::testing::ValuesIn(test::verified_engines()),
                         [](const auto& c) { return c.param.name; });

/// A transfer function that is smooth in parts and jumps in others, with a gap.
TransferFunction lively(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<TransferNode> nodes;
  double hu = -500;
  for (int i = 0; i < 8; ++i) {
    const double opacity = i == 4 ? 0 : std::pow(10, -4 + 3.5 * unit(random));
    nodes.push_back({hu, {unit(random), unit(random), unit(random)}, opacity, 1});
    hu += i % 3 == 2 ? 1 : 20 + 200 * unit(random);
  }
  return *TransferFunction::create("lively", nodes);
}

/// Premultiplied colour and opacity.
using Light = Eigen::Vector4d;

Light over(const Light& front, const Light& back) { return front + (1 - front[3]) * back; }

Light piece(const TransferSample& look, double length_mm) {
  const double alpha = -std::expm1(-look.tau_per_mm * length_mm);
  Light light;
  light << alpha * look.rgb, alpha;
  return light;
}

/// Values along a segment between two limits.
std::vector<double> profile(std::mt19937& random, double low, double high) {
  constexpr int kCount = 400;
  std::uniform_real_distribution<double> any(low, high);
  const int kind = std::uniform_int_distribution<int>(0, 3)(random);
  std::vector<double> values;
  double v = any(random);
  for (int i = 0; i < kCount; ++i) {
    if (kind == 0) v = any(random);                             // Noise.
    if (kind == 1) v = i % 2 == 0 ? low : high;                 // Alternates between the limits.
    if (kind == 2) v = i == 0 || i == kCount - 1 ? low : high;  // The ends mislead.
    if (kind == 3) v = std::clamp(v + 0.1 * (any(random) - v), low, high);  // A random walk.
    values.push_back(v);
  }
  return values;
}

TEST(AdaptiveBoundTest, HoldsForAllValuesInTheRange) {
  std::mt19937 random(7);
  double tightest = 0;
  for (int round = 0; round < 300; ++round) {
    const TransferTable table(lively(random));
    std::uniform_real_distribution<double> any(-600, 900);
    double low = any(random);
    double high = low + std::exp(std::uniform_real_distribution<double>(0, 6)(random));
    const auto values = profile(random, low, high);
    const double length_mm = std::uniform_real_distribution<double>(0.1, 8)(random);
    Light exact = Light::Zero();
    const double part_mm = length_mm / static_cast<double>(values.size());
    for (const double v : values) exact = over(exact, piece(table.at(v), part_mm));
    const Light found = piece(table.mean(values.front(), values.back()), length_mm);
    const double bound = length_mm * segment_error_per_mm(table, low, high, false);
    for (const double behind : {0.0, 1.0}) {
      const Light back(behind, behind, behind, 1);
      const double error = (over(found, back) - over(exact, back)).cwiseAbs().maxCoeff();
      ASSERT_LE(error, bound + 1e-9) << round;
      if (bound > 0) tightest = std::max(tightest, error / bound);
    }
  }
  EXPECT_GT(tightest, 0.5) << "a looser bound than it need be";
}

TEST(AdaptiveBoundTest, BricksAllowAsManyCellsAsTheBound) {
  std::mt19937 random(3);
  const auto ct =
      test::make_volume(test::centred_grid({40, 33, 20}, {1, 1, 1}), [&](int i, int, int) {
        return i < 16 ? 50 : std::normal_distribution<double>(100, i)(random);
      });
  const BrickGrid bricks = make_brick_grid(*ct, 1);
  const TransferTable table(lively(random));
  for (const bool shaded : {false, true}) {
    const AdaptiveStep adaptive{0.05, 0.4, shaded};
    const auto cells = brick_cells(bricks, table, adaptive, 1);
    for (std::size_t b = 0; b < cells.size(); ++b) {
      const double per_mm = segment_error_per_mm(table, bricks.low[b], bricks.high[b], shaded);
      const double error = per_mm * adaptive.step_mm;
      EXPECT_GE(cells[b], 1);
      EXPECT_TRUE(cells[b] == 1 || cells[b] * error <= adaptive.error * (1 + 1e-9));
      EXPECT_TRUE(cells[b] == kMostCells || (cells[b] + 1) * error > adaptive.error * (1 - 1e-9));
    }
  }
}

/// One brick with values that go up and down from voxel to voxel along the ray.
Scene zigzag(double low, double high) {
  const auto ct = test::make_volume(test::centred_grid({8, 8, 8}, {1, 1, 1}),
                                    [=](int, int j, int) { return j % 2 == 0 ? low : high; });
  const TransferFunction transfer = *TransferFunction::create(
      "slopes", {{0, {0.9, 0.2, 0.1}, 0.01, 1}, {1000, {0.1, 0.5, 1.0}, 0.3, 1}});
  Scene scene = test::plain_scene(ct, transfer, test::frontal(30, 4, true));
  scene.background_rgb = {1, 0, 0.5};
  scene.quality.step_voxels = 0.125;
  return scene;
}

TEST_P(AdaptiveStepTest, ErrorIsAtMostTheSumOfTheStatedErrors) {
  const auto reference = make_reference_engine();
  double most_saved = 0;
  for (const auto& [low, high] : {std::pair{100.0, 140.0}, {300.0, 600.0}, {0.0, 1000.0}}) {
    Scene scene = zigzag(low, high);
    scene.quality.step_voxels = 1.0 / 64;
    const RgbaF exact = test::middle(test::draw(*reference, scene));
    scene.quality.step_voxels = 0.125;
    const RenderedImage fixed = test::draw(*engine_, scene);
    const double per_mm = segment_error_per_mm(TransferTable(scene.transfer), low, high, false);
    for (const double error : {0.002, 0.02, 0.2}) {
      scene.quality.adaptive_error = error;
      const RenderedImage image = test::draw(*engine_, scene);
      constexpr double kLengthMm = 7;
      const double cells = std::floor(error / (per_mm * 0.125));
      const double segments = std::ceil(kLengthMm / (0.125 * std::clamp(cells, 1.0, 56.0))) + 2;
      constexpr double kRest = 1e-4;  // The error of the cells of the exact image and of rounding.
      EXPECT_LE(test::difference(test::middle(image), exact), segments * error + kRest);
      EXPECT_LE(test::difference(test::middle(image), exact), kLengthMm * per_mm + kRest);
      EXPECT_LE(image.statistics.volume_samples, fixed.statistics.volume_samples);
      most_saved = std::max(most_saved, double(fixed.statistics.volume_samples) /
                                            double(image.statistics.volume_samples));
    }
  }
  EXPECT_GT(most_saved, 5) << "nothing was saved";
}

/// Flat tissue with a noisy lump, in air. If \p cut, there is a plane with a cutaway.
Scene patchy(bool orthographic, bool cut) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 30);
  const auto grid = test::centred_grid({45, 37, 41}, {1, 1.2, 0.9});
  const Eigen::Vector3d lump(10, -4, 5);
  const auto ct = test::make_volume(grid, [&](int i, int j, int k) {
    const Eigen::Vector3d p = grid.at({double(i), double(j), double(k)}).mm;
    return p.norm() > 18 ? -1000.0 : (p - lump).norm() > 5 ? 200.0 : 350 + noise(random);
  });
  const TransferFunction transfer =
      *TransferFunction::create("tissue", {{-200, {0.9, 0.6, 0.5}, 0, 0.3},
                                           {100, {0.9, 0.6, 0.5}, 0.03, 0.3},
                                           {300, {0.9, 0.6, 0.5}, 0.03, 0.3},
                                           {500, {1, 1, 0.8}, 0.2, 0.8}});
  Scene scene = test::plain_scene(ct, transfer, test::frontal(90, 42, orthographic));
  scene.quality.adaptive_error = 0.004;
  if (!cut) return scene;
  scene.plane = test::upright_plane(test::grey_picture(20, 16, 120), 0.8, {0, 2, 6});
  scene.cutaway.emplace();
  scene.cutaway->overlay_mm = 4;
  return scene;
}

TEST_P(AdaptiveStepTest, SkippingStaysBitIdentical) {
  for (const bool orthographic : {false, true}) {
    for (const bool cut : {false, true}) {
      Scene scene = patchy(orthographic, cut);
      scene.quality.jitter = orthographic;
      const RenderedImage skipped = test::draw(*engine_, scene);
      scene.quality.skip_empty_bricks = false;
      const RenderedImage all = test::draw(*engine_, scene);
      const auto a = skipped.pixels.pixels();
      const auto b = all.pixels.pixels();
      EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0)
          << orthographic << cut << ' ' << test::max_difference(skipped, all);
    }
  }
}

TEST_P(AdaptiveStepTest, EnginesAgreeAndSaveSamplesInFlatTissue) {
  const auto reference = make_reference_engine();
  for (const bool shaded : {false, true}) {
    for (const bool cut : {false, true}) {
      Scene scene = patchy(false, cut);
      scene.shading.enabled = shaded;
      const RenderedImage image = test::draw(*engine_, scene);
      // An engine can leave a brick one cell earlier than another. Then one segment becomes two.
      EXPECT_LE(test::max_difference(image, test::draw(*reference, scene)),
                2 * scene.quality.adaptive_error);
      scene.quality.adaptive_error = 0;
      const RenderedImage fixed = test::draw(*engine_, scene);
      EXPECT_LE(image.statistics.volume_samples, fixed.statistics.volume_samples);
      if (shaded || cut) continue;  // Then few bricks allow more than one cell.
      EXPECT_LT(image.statistics.volume_samples, fixed.statistics.volume_samples);
    }
  }
}

}  // namespace
}  // namespace nav::render
