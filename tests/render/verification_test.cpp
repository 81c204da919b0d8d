// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the integration along rays with manufactured solutions. These are scenes whose image has a
// closed form. The tests refine step, grid and pixels, and compare the observed order of
// convergence with the theory. After Etiene et al. 2014, "Verifying volume rendering using
// discretization error analysis".
#include <array>
#include <functional>
#include <vector>

#include "render/transfer/transfer_table.hpp"
#include "tests/render/verification_engines.hpp"

namespace nav::render {
namespace {

using test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, VerificationTest, ::testing::ValuesIn(test::verified_engines()),
                         [](const auto& c) { return c.param.name; });

constexpr double kOrderTolerance = 0.15;
/// Single precision over the cells of a ray. Errors below this show no order.
constexpr double kNoise = 2e-6;

constexpr double kLengthMm = 64;
constexpr double kHuPerMm = 40;
constexpr double kLastHu = kLengthMm * kHuPerMm;

/// The value grows along the ray by exactly 40 HU/mm from 0.
std::shared_ptr<const StoredVolume> ramp_volume() {
  return test::make_volume(test::centred_grid({9, 65, 9}, {4, 1, 4}),
                           [](int, int j, int) { return kHuPerMm * j; });
}

/// A function sampled at each HU: colour and extinction of a depth s = hu / kHuPerMm, in mm.
TransferFunction function_of_depth(const std::function<double(double)>& grey,
                                   const std::function<double(double)>& tau) {
  std::vector<TransferNode> nodes;
  for (int hu = 0; hu <= static_cast<int>(kLastHu); ++hu) {
    const double s = hu / kHuPerMm;
    nodes.push_back({1.0 * hu, Eigen::Vector3d::Constant(grey(s)), -std::expm1(-tau(s)), 1});
  }
  return *TransferFunction::create("manufactured", nodes);
}

/// One ray through the ramp. The distance from the eye to the face is a whole number of the
/// coarsest cells.
Scene ramp_scene(const TransferFunction& transfer, double step_voxels,
                 Classification classification = Classification::kPreIntegrated) {
  Scene scene = test::plain_scene(ramp_volume(), transfer, test::frontal(96, 10, true));
  scene.width = scene.height = 1;
  scene.quality.step_voxels = step_voxels;
  scene.quality.classification = classification;
  return scene;
}

/// The slope of log error over log size, by least squares.
double observed_order(const std::vector<double>& sizes, const std::vector<double>& errors) {
  double x = 0;
  double y = 0;
  double xx = 0;
  double xy = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double a = std::log(sizes[i]);
    const double b = std::log(std::abs(errors[i]));
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  const auto n = static_cast<double>(sizes.size());
  return (n * xy - x * y) / (n * xx - x * x);
}

/// An image with a closed form: the visible grey for a grey and an extinction that depend on depth.
struct Manufactured {
  const char* name;
  std::function<double(double)> grey;
  std::function<double(double)> tau;
  double exact;
};

std::vector<Manufactured> manufactured() {
  constexpr double kTau = 0.04;
  const double x = kTau * kLengthMm;
  const double decay = 1.0 / 40;  // Decay of the exponential colour, per mm.
  const double wave = 2 * M_PI / 32;
  const double far = std::exp(-x);
  // Colour (1 + sin(w s)) / 2: the integral of tau e^(-tau s) sin(w s) over [0, L].
  const double sine =
      kTau *
      (wave - far * (kTau * std::sin(wave * kLengthMm) + wave * std::cos(wave * kLengthMm))) /
      (kTau * kTau + wave * wave);
  // Extinction grows as 2 a s, colour e^(-a s^2): half of 1 - e^(-2 a L^2).
  const double a = 3e-4;
  return {{"linear colour", [](double s) { return s / kLengthMm; }, [](double) { return kTau; },
           (1 - far * (1 + x)) / x},
          {"exponential colour", [=](double s) { return std::exp(-decay * s); },
           [](double) { return kTau; },
           kTau / (kTau + decay) * -std::expm1(-(kTau + decay) * kLengthMm)},
          {"sinusoidal colour", [=](double s) { return 0.5 * (1 + std::sin(wave * s)); },
           [](double) { return kTau; }, 0.5 * (1 - far) + 0.5 * sine},
          {"linear extinction", [=](double s) { return std::exp(-a * s * s); },
           [=](double s) { return 2 * a * s; }, -0.5 * std::expm1(-2 * a * kLengthMm * kLengthMm)}};
}

TEST_P(VerificationTest, ConvergesWithSecondOrderInTheStep) {
  const std::vector<double> steps{8, 4, 2};
  for (const Manufactured& m : manufactured()) {
    const TransferFunction transfer = function_of_depth(m.grey, m.tau);
    for (const auto classification :
         {Classification::kPreIntegrated, Classification::kPostClassified}) {
      std::vector<double> errors;
      for (const double step : steps) {
        const Scene scene = ramp_scene(transfer, step, classification);
        errors.push_back(test::middle(test::draw(*engine_, scene)).g - m.exact);
      }
      EXPECT_GT(std::abs(errors.back()), 5 * kNoise) << m.name << ": order would be noise";
      EXPECT_NEAR(observed_order(steps, errors), 2, kOrderTolerance)
          << m.name << ", classification " << static_cast<int>(classification) << ", errors "
          << errors[0] << ' ' << errors[1] << ' ' << errors[2];
    }
  }
}

TEST_P(VerificationTest, CurvedValuesAreIntegratedToThirdOrder) {
  // Values follow a parabola, and the extinction is proportional to them. Straight lines between
  // samples miss h²/12 of its second derivative along the whole ray, with one sign. With the bow of
  // the cells, only the cells at the entry miss it.
  constexpr double kPeakHu = 16000;
  constexpr double kPeakTau = 0.03;
  const auto value = [&](double s) { return kPeakHu * 4 * s / kLengthMm * (1 - s / kLengthMm); };
  constexpr int kVoxels = 128;
  const auto ct =
      test::make_volume(test::centred_grid({5, kVoxels + 1, 5}, {4, kLengthMm / kVoxels, 4}),
                        [&](int, int j, int) { return value(kLengthMm * j / kVoxels); });
  const auto transfer = TransferFunction::create(
      "proportional", {{0, {1, 1, 1}, 0, 1}, {kPeakHu, {1, 1, 1}, -std::expm1(-kPeakTau), 1}});
  const double exact = kPeakTau * kLengthMm * 2 / 3 * (1 - 1.0 / (kVoxels * kVoxels));
  Scene scene = test::plain_scene(ct, *transfer, test::frontal(96, 10, true));
  scene.width = scene.height = 1;
  for (const double step_mm : {8.0, 4.0, 2.0}) {
    scene.quality.step_voxels = step_mm * kVoxels / kLengthMm;
    const double found = -std::log1p(-test::middle(test::draw(*engine_, scene)).g);
    const double second_derivative = 8 * kPeakTau / (kLengthMm * kLengthMm);
    const double of_lines = step_mm * step_mm / 12 * second_derivative * kLengthMm;
    EXPECT_LT(std::abs(found - exact), 2.5 * step_mm / kLengthMm * of_lines + 2e-5) << step_mm;
  }
}

TEST_P(VerificationTest, ErrorFallsMonotonicallyToTheFloorOfItsArithmetic) {
  // A polynomial for 1 - exp(-x) let the error grow again below half a voxel.
  constexpr double kFloor = 1e-5;
  const Manufactured m = manufactured()[2];
  const TransferFunction transfer = function_of_depth(m.grey, m.tau);
  double last = 1;
  for (const double step : {8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125, 1.0 / 32}) {
    const double found = test::middle(test::draw(*engine_, ramp_scene(transfer, step))).g;
    const double error = std::abs(found - m.exact);
    EXPECT_LT(error, std::max(0.3 * last, kFloor)) << "step " << step;
    last = error;
  }
  EXPECT_LT(last, kFloor);
}

TEST_P(VerificationTest, ConvergesWithSecondOrderInTheGrid) {
  // Values sin(pi y / L) sampled on finer and finer grids. The extinction is proportional to them,
  // and the step is constant in mm. The rest is the error of trilinear interpolation.
  constexpr double kPeakHu = 16000;
  constexpr double kPeakTau = 0.03;
  const double exact = -std::expm1(-kPeakTau * kLengthMm * 2 / M_PI);
  const auto transfer = TransferFunction::create(
      "proportional", {{0, {1, 1, 1}, 0, 1}, {kPeakHu, {1, 1, 1}, -std::expm1(-kPeakTau), 1}});
  std::vector<double> sizes;
  std::vector<double> errors;
  for (const int cells : {4, 8, 16, 32}) {
    const double spacing = kLengthMm / cells;
    const auto ct =
        test::make_volume(test::centred_grid({9, cells + 1, 9}, {spacing, spacing, spacing}),
                          [&](int, int j, int) { return kPeakHu * std::sin(M_PI * j / cells); });
    Scene scene = test::plain_scene(ct, *transfer, test::frontal(96, 10, true));
    scene.width = scene.height = 1;
    scene.quality.step_voxels = 0.5 / spacing;
    sizes.push_back(spacing);
    errors.push_back(test::middle(test::draw(*engine_, scene)).g - exact);
  }
  EXPECT_NEAR(observed_order(sizes, errors), 2, kOrderTolerance)
      << errors[0] << ' ' << errors[1] << ' ' << errors[2] << ' ' << errors[3];
}

/// The root mean square difference between a ball of constant fog and its closed form 1 - exp(-tau
/// chord). Uses rays through its inner 0.8 radius.
double ball_error(Engine& engine, int cells) {
  constexpr double kRadiusMm = 24;
  constexpr double kTau = 0.02;
  constexpr double kScaleHu = 8000;
  const double spacing = kLengthMm / cells;
  const VoxelGrid grid =
      test::centred_grid({cells + 1, cells + 1, cells + 1}, {spacing, spacing, spacing});
  const auto ct = test::make_volume(grid, [&](int i, int j, int k) {
    const Eigen::Vector3d p = grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm;
    return kScaleHu * (1 - p.squaredNorm() / (kRadiusMm * kRadiusMm));
  });
  const double opacity = -std::expm1(-kTau);
  const auto transfer =
      TransferFunction::create("inside", {{-1, {1, 1, 1}, 0, 1}, {1, {1, 1, 1}, opacity, 1}});
  Scene scene = test::plain_scene(ct, *transfer, test::frontal(150, 1.6 * kRadiusMm, true));
  scene.width = scene.height = 31;
  scene.quality.step_voxels = 0.25 / spacing;
  const RenderedImage image = test::draw(engine, scene);
  const double pixel = 1.6 * kRadiusMm / scene.height;
  double sum = 0;
  int count = 0;
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      const double across = std::hypot(x - 15, y - 15) * pixel;
      if (across > 0.8 * kRadiusMm) continue;
      const double chord = 2 * std::sqrt(kRadiusMm * kRadiusMm - across * across);
      sum += std::pow(image.pixels.at(x, y).g + std::expm1(-kTau * chord), 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST_P(VerificationTest, BallOfFogConvergesWithSecondOrderInTheGrid) {
  const std::vector<double> sizes{8, 4, 2};
  std::vector<double> errors;
  for (const double spacing : sizes) {
    errors.push_back(ball_error(*engine_, static_cast<int>(kLengthMm / spacing)));
  }
  EXPECT_LT(errors.back(), 2e-3);
  EXPECT_NEAR(observed_order(sizes, errors), 2, kOrderTolerance)
      << errors[0] << ' ' << errors[1] << ' ' << errors[2];
}

TEST_P(VerificationTest, ConvergesWithSecondOrderInThePixels) {
  // Opacity 1 - exp(-L tau(x, z)) with bilinear tau. Images with finer pixels, interpolated at
  // points between pixels, approach it with the square of the pixel size.
  const auto ct = test::make_volume(test::centred_grid({33, 3, 33}, {1, 16, 1}),
                                    [](int i, int, int k) { return 20 * i + 10 * k; });
  const double peak = 0.1;
  const auto transfer = TransferFunction::create(
      "ramp", {{0, {1, 1, 1}, 0, 1}, {1000, {1, 1, 1}, -std::expm1(-peak), 1}});
  const auto exact = [&](double x_mm, double z_mm) {
    const double hu = 20 * (x_mm + 16) + 10 * (z_mm + 16);
    return -std::expm1(-32 * peak * hu / 1000);
  };
  constexpr double kHeightMm = 30;
  std::vector<double> sizes;
  std::vector<double> errors;
  for (const int n : {5, 10, 20, 40}) {
    Scene scene = test::plain_scene(ct, *transfer, test::frontal(100, kHeightMm, true));
    scene.width = scene.height = n;
    const RenderedImage image = test::draw(*engine_, scene);
    const double pixel = kHeightMm / n;
    double sum = 0;
    for (int y = 0; y + 1 < n; ++y) {
      for (int x = 0; x + 1 < n; ++x) {
        const double mean = 0.25 * (image.pixels.at(x, y).g + image.pixels.at(x + 1, y).g +
                                    image.pixels.at(x, y + 1).g + image.pixels.at(x + 1, y + 1).g);
        sum += std::pow(mean - exact((x + 1 - 0.5 * n) * pixel, (0.5 * n - y - 1) * pixel), 2);
      }
    }
    sizes.push_back(pixel);
    errors.push_back(std::sqrt(sum / ((n - 1) * (n - 1))));
  }
  EXPECT_NEAR(observed_order(sizes, errors), 2, kOrderTolerance)
      << errors[0] << ' ' << errors[1] << ' ' << errors[2] << ' ' << errors[3];
}

/// Clear except for one HU.
TransferFunction spike(double hu, double last_hu, double tau) {
  const Eigen::Vector3d white(1, 1, 1);
  return *TransferFunction::create("spike", {{0, white, 0, 1},
                                             {hu - 1, white, 0, 1},
                                             {hu, white, -std::expm1(-tau), 1},
                                             {hu + 1, white, 0, 1},
                                             {last_hu, white, 0, 1}});
}

TEST_P(VerificationTest, SpikeOfOneHuIsNeverMissed) {
  // The spike fills a triangle of 1 HU. At 40 HU/mm this is 1/40 mm for all steps. Tables have 256
  // to 16384 entries.
  constexpr double kTolerance = 2e-5;
  constexpr double kTau = 20;
  const double exact = -std::expm1(-kTau / kHuPerMm);
  int missed_by_points = 0;
  for (const double last_hu : {2560.0, 256.0, 1024.0, 4096.0, 16384.0}) {
    const TransferFunction transfer = spike(203, last_hu, kTau);
    for (const double step : {0.25, 0.5, 1.0, 3.7, 8.0}) {
      const float found = test::middle(test::draw(*engine_, ramp_scene(transfer, step))).g;
      EXPECT_NEAR(found, exact, kTolerance) << "table to " << last_hu << " HU, step " << step;
      const Scene points = ramp_scene(transfer, step, Classification::kPostClassified);
      const double naive = test::middle(test::draw(*engine_, points)).g;
      missed_by_points += std::abs(naive - exact) > 0.3 ? 1 : 0;
    }
  }
  EXPECT_GE(missed_by_points, 20) << "classification of points should fail here";
}

TEST_P(VerificationTest, AStepOfOneHuIsAtItsExactPosition) {
  constexpr double kTolerance = 2e-5;
  constexpr double kTau = 0.03;
  const Eigen::Vector3d white(1, 1, 1);
  const double opacity = -std::expm1(-kTau);
  const auto transfer = TransferFunction::create(
      "step", {{0, white, 0, 1}, {700, white, 0, 1}, {701, white, opacity, 1}});
  const double exact = -std::expm1(-kTau * (kLastHu - 700.5) / kHuPerMm);
  for (const double step : {0.25, 1.0, 3.7, 8.0, 16.0}) {
    const float found = test::middle(test::draw(*engine_, ramp_scene(*transfer, step))).g;
    EXPECT_NEAR(found, exact, kTolerance) << "step " << step;
  }
}

TEST(PreIntegrationTest, DoesNotDependOnTheOrderOfTheEndsAndAcceptsEqualEnds) {
  const TransferTable table(function_of_depth([](double s) { return s / kLengthMm; },
                                              [](double s) { return 0.1 + 0.05 * std::sin(s); }));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> hu(-50, kLastHu + 50);
  for (int i = 0; i < 2000; ++i) {
    const double a = hu(random);
    const double b = hu(random);
    const TransferSample there = table.mean(a, b);
    const TransferSample back = table.mean(b, a);
    EXPECT_NEAR(there.tau_per_mm, back.tau_per_mm, 1e-12);
    EXPECT_NEAR((there.rgb - back.rgb).norm(), 0, 1e-9);
    // If the ends approach each other, the mean approaches the value between them.
    for (const double apart : {1.0, 1e-2, 1e-4, 1e-6, 1e-9, 0.0}) {
      const TransferSample mean = table.mean(a, a + apart);
      const TransferSample point = table.at(a + 0.5 * apart);
      EXPECT_NEAR(mean.tau_per_mm, point.tau_per_mm, 1e-6 + 1e-3 * apart) << apart;
      EXPECT_NEAR(mean.rgb.x(), point.rgb.x(), 1e-5 + 1e-3 * apart) << apart;
    }
  }
}

TEST_P(VerificationTest, OpacityIsTheSameFromBothSides) {
  constexpr double kTolerance = 1e-5;
  const TransferFunction transfer = function_of_depth(
      [](double) { return 1.0; }, [](double s) { return 0.02 + 0.015 * std::sin(0.4 * s); });
  for (const double step : {0.5, 1.0, 4.0}) {
    Scene scene = ramp_scene(transfer, step);
    const float front = test::middle(test::draw(*engine_, scene)).g;
    scene.camera.eye_ct.mm.y() *= -1;
    const float back = test::middle(test::draw(*engine_, scene)).g;
    EXPECT_NEAR(front, back, kTolerance) << "step " << step;
  }
}

}  // namespace
}  // namespace nav::render
