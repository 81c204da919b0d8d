// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/confidence.hpp"

#include <filesystem>
#include <fstream>

#include "tests/render/features/derived_support.hpp"
#include "tests/support/test_data.hpp"
#include "tests/support/trials.hpp"

namespace nav::render::features {
namespace {

ScanLines down() { return *ScanLines::parallel({{0, 1, 0}}, {{0, -100, 0}}); }

ConfidenceOptions exact() {
  ConfidenceOptions options;
  options.solve.error = 1e-9;
  options.solve.max_iterations = 2000;
  return options;
}

TEST(ConfidenceTest, FallsLinearlyWithDepthInAHomogeneousBlock) {
  auto options = exact();
  options.alpha = 0;
  for (const std::array<int, 3> size : {std::array{9, 17, 7}, {1, 33, 1}, {5, 12, 1}, {1, 9, 6}}) {
    const auto grid = test::centred_grid(size, {0.2, 0.2, 1});
    const auto volume = test::make_scalar(grid, [](int, int, int) { return 90; });
    const auto found = confidence(volume, down(), options);
    ASSERT_TRUE(test::has_value(found));
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          EXPECT_NEAR(found->volume.at(i, j, k), 1 - j / (size[1] - 1.0), 2e-6);
        }
      }
    }
  }
}

TEST(ConfidenceTest, IsTheVoltageAlongResistorsInSeriesInAColumn) {
  const auto grid = test::centred_grid({1, 24, 1}, {1, 1, 1});
  std::mt19937 random(2);
  std::uniform_real_distribution<double> grey(100, 110);
  const auto volume = test::make_scalar(grid, [&](int, int j, int) {
    return j == 0 ? 0 : j == 23 ? 255 : grey(random);
  });
  const auto options = exact();
  const auto found = confidence(volume, down(), options);
  ASSERT_TRUE(test::has_value(found));
  std::vector<double> drop{0};
  const auto step = [&](int j) {
    const auto attenuated = [&](int at) {
      return volume.at(0, at, 0) / 255.0 * (1 - std::exp(-options.alpha * at / 23.0));
    };
    return std::abs(attenuated(j) - attenuated(j - 1));
  };
  double largest = 0;
  for (int j = 1; j < 24; ++j) largest = std::max(largest, step(j));
  for (int j = 1; j < 24; ++j) {
    const double weight = std::exp(-options.beta * step(j) / largest / (1 + options.gamma)) + 1e-5;
    drop.push_back(drop.back() + 1 / weight);
  }
  for (int j = 0; j < 24; ++j) {
    // Attenuated intensities are stored as floats. beta = 90 magnifies their rounding.
    EXPECT_NEAR(found->volume.at(0, j, 0), 1 - drop[static_cast<std::size_t>(j)] / drop.back(),
                2e-5);
  }
}

// Edges in all eight directions, at angles that are not in the paper. The expected values come
// directly from the formula.
TEST(ConfidenceTest, EqualsItsFormulaForNineVoxels) {
  const auto grid = test::centred_grid({3, 3, 1}, {0.4, 0.5, 1});
  std::mt19937 random(4);
  std::uniform_real_distribution<double> grey(80, 140);
  const auto volume = test::make_scalar(grid, [&](int i, int j, int) {
    return i == 0 && j == 0 ? 0 : i == 2 && j == 2 ? 255 : grey(random);
  });
  auto options = exact();
  options.beta = 10;
  const auto found = confidence(volume, down(), options);
  ASSERT_TRUE(test::has_value(found));
  const auto attenuated = [&](int i, int j) {
    return volume.at(i, j, 0) / 255.0 * (1 - std::exp(-options.alpha * j / 2.0));
  };
  double largest = 0;
  for (int n = 0; n < 9; ++n) {
    for (int m = 0; m < n; ++m) {
      if (std::abs(n % 3 - m % 3) > 1 || std::abs(n / 3 - m / 3) > 1) continue;
      largest = std::max(largest, std::abs(attenuated(n % 3, n / 3) - attenuated(m % 3, m / 3)));
    }
  }
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {  // The middle row. The first row is fixed at 1 and the last one at
                                 // 0.
    for (int x = std::max(i - 1, 0); x <= std::min(i + 1, 2); ++x) {
      for (int y = 0; y < 3; ++y) {
        if (x == i && y == 1) continue;
        const double aside = 0.4 * (x - i);
        const double penalty = options.gamma * std::abs(aside) / 0.4;
        const double jump = std::abs(attenuated(i, 1) - attenuated(x, y)) / largest;
        const double weight =
            std::exp(-options.beta * (jump + penalty) / (1 + options.gamma)) + 1e-5;
        matrix(i, i) += weight;
        if (y == 1) matrix(i, x) -= weight;
        if (y == 0) b[i] += weight;
      }
    }
  }
  const Eigen::Vector3d x = matrix.inverse() * b;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(found->volume.at(i, 1, 0), x[i], 5e-6);
}

/// Mean of the row of pixels at half depth, with the weights as the paper prints them.
double printed_half_way(const ScalarVolume& volume, const ConfidenceOptions& options) {
  const auto [width, height, slices] = volume.grid().size;
  const auto attenuated = [&](int i, int j) {
    return volume.at(i, j, 0) / 255.0 * std::exp(-options.alpha * j / (height - 1));
  };
  const int open = width * (height - 2);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(open, open);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(open);
  for (int n = 0; n < open; ++n) {
    const int i = n % width, j = n / width + 1;
    for (int y = j - 1; y <= j + 1; ++y) {
      for (int x = std::max(i - 1, 0); x <= std::min(i + 1, width - 1); ++x) {
        if (x == i && y == j) continue;
        const double aside = x == i ? 0 : std::hypot(x - i, y - j);
        const double weight =
            std::exp(-options.beta *
                     (std::abs(attenuated(i, j) - attenuated(x, y)) + options.gamma * aside)) +
            1e-5;
        matrix(n, n) += weight;
        if (y == 0) b[n] += weight;
        if (y > 0 && y < height - 1) matrix(n, (y - 1) * width + x) -= weight;
      }
    }
  }
  const Eigen::VectorXd x = matrix.ldlt().solve(b);
  return x.segment((height / 2 - 1) * width, width).mean();
}

// With the printed weights the differences are smallest at depth. Random walks run freely there, so
// all confidence is lost in front of them.
TEST(ConfidenceTest, ThePrintedWeightsLoseAllConfidenceInFrontOfSpeckle) {
  const auto grid = test::centred_grid({16, 40, 1}, {1, 1, 1});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> grey(0, 1);
  const auto volume = test::make_scalar(grid, [&](int, int j, int) {
    return std::floor(256 * grey(random) * std::exp(-2 * j / 39.0));
  });
  EXPECT_LT(printed_half_way(volume, {}), 0.05);
  const auto found = confidence(volume, down(), exact());
  ASSERT_TRUE(test::has_value(found));
  double mean = 0;
  for (int i = 0; i < 16; ++i) mean += static_cast<double>(found->volume.at(i, 20, 0)) / 16;
  EXPECT_NEAR(mean, 0.5, 0.2);
}

/// RMS difference over the voxels that are solved for, like the estimate.
double rms_apart(const FeatureVolume& a, const FeatureVolume& b) {
  double squares = 0;
  std::size_t open = 0;
  for (std::size_t n = 0; n < a.values->size(); ++n) {
    const float x = (*a.values)[n];
    const float y = (*b.values)[n];
    if (!(x > 0 && x < 1 && y > 0 && y < 1)) continue;
    squares += std::pow(static_cast<double>(x) - static_cast<double>(y), 2);
    ++open;
  }
  return std::sqrt(squares / static_cast<double>(open));
}

/// Compares the estimated error of a solve with that of a solve that continues.
void expect_honest_estimates(const std::string& name, const ScalarVolume& volume,
                             const ScanLines& lines) {
  constexpr double kFactor = 3;  // Ratios of 0.33 to 1.6 were found.
  const auto truth = confidence(volume, lines, exact());
  ASSERT_TRUE(test::has_value(truth)) << name;
  for (const double error : {1e-2, SolveOptions{}.error, 3e-4}) {
    ConfidenceOptions options;
    options.solve.error = error;
    const auto found = confidence(volume, lines, options);
    ASSERT_TRUE(test::has_value(found)) << name;
    const double rms = rms_apart(found->volume, truth->volume);
    EXPECT_LE(found->report.estimated_error, error) << name;
    EXPECT_LT(rms, kFactor * found->report.estimated_error) << name << ", error " << error;
    EXPECT_GT(rms, found->report.estimated_error / kFactor) << name << ", error " << error;
  }
}

/// Returns the 8-bit pixels from the top down. The file stores them from the bottom up.
std::vector<std::uint8_t> turned(const std::filesystem::path& path, int width, int height) {
  std::vector<std::uint8_t> stored(static_cast<std::size_t>(width * height));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(stored.data()), static_cast<std::streamsize>(stored.size()));
  EXPECT_EQ(file.gcount(), static_cast<std::streamsize>(stored.size())) << path;
  std::vector<std::uint8_t> rows;
  for (int j = height - 1; j >= 0; --j) {
    rows.insert(rows.end(), stored.begin() + j * width, stored.begin() + (j + 1) * width);
  }
  return rows;
}

// An image of vessels and its confidence map as published by the laboratory of the authors.
TEST(ConfidenceTest, AgreesWithTheMapOfItsAuthors) {
  SONDE_REQUIRE_DATA(map, "us-predicate/cm.raw");
  constexpr int kWidth = 720, kHeight = 500;
  const auto image = turned(map.parent_path() / "us.raw", kWidth, kHeight);
  const auto theirs = turned(map, kWidth, kHeight);
  const auto volume = test::make_scalar(
      test::centred_grid({kWidth, kHeight, 1}, {1, 1, 1}), [&](int i, int j, int) {
        return static_cast<double>(image[static_cast<std::size_t>(j * kWidth + i)]);
      });
  const auto ours = confidence(volume, down(), {});
  ASSERT_TRUE(test::has_value(ours));
  double squares = 0;
  for (std::size_t n = 0; n < theirs.size(); ++n) {
    const double apart = static_cast<double>((*ours->volume.values)[n]) - theirs[n] / 255.0;
    squares += apart * apart;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(theirs.size())), 0.005);
  expect_honest_estimates("their image", volume, down());
}

TEST(ConfidenceTest, UnknownVoxelsInFrontDoNotCount) {
  const auto inside = [](int i, int j, int k) { return 80.0 + (7 * i + 5 * j + 3 * k) % 11; };
  const auto found = confidence(test::make_scalar(test::centred_grid({5, 10, 4}, {1, 1, 1}),
                                                  [&](int i, int j, int k) {
                                                    return j < 3 ? std::nan("") : inside(i, j, k);
                                                  }),
                                down(), exact());
  const auto cropped =
      confidence(test::make_scalar(test::centred_grid({5, 7, 4}, {1, 1, 1}),
                                   [&](int i, int j, int k) { return inside(i, j + 3, k); }),
                 down(), exact());
  ASSERT_TRUE(test::has_value(found));
  ASSERT_TRUE(test::has_value(cropped));
  for (int j = 0; j < 7; ++j) {
    EXPECT_NEAR(found->volume.at(2, j + 3, 1), cropped->volume.at(2, j, 1), 1e-6) << j;
  }
}

TEST(ConfidenceTest, EqualsTheDirectSolutionForEveryGeometry) {
  const auto grid = test::centred_grid({14, 19, 12}, {0.4, 0.4, 0.4});
  const auto volume = test::speckled(grid, 3);
  const std::vector<ScanLines> geometries{down(), *ScanLines::parallel({{1, 0, 0}}, {{0, 0, 0}}),
                                          *ScanLines::parallel({{0.2, -0.3, -1}}, {{0, 0, 0}}),
                                          *ScanLines::fan({{0, -12, 0}}, 5)};
  for (const ScanLines& lines : geometries) {
    const auto truth = definition::confidence(volume, lines, {});
    ASSERT_TRUE(test::has_value(truth));
    const auto found = confidence(volume, lines, exact());
    ASSERT_TRUE(test::has_value(found));
    EXPECT_TRUE(found->report.converged);
    EXPECT_LT(test::largest_difference(found->volume, *truth), 1e-4);
    EXPECT_LT(found->report.iterations, 400);
    EXPECT_LT(found->report.relative_residual, 1e-3);
  }
}

TEST(ConfidenceTest, MeetsTheDefaultError) {
  const auto volume = test::speckled(test::centred_grid({24, 30, 16}, {0.4, 0.4, 0.4}), 6);
  const auto truth = definition::confidence(volume, down(), {});
  const auto found = confidence(volume, down(), {});
  ASSERT_TRUE(test::has_value(found));
  double squares = 0;
  for (std::size_t n = 0; n < truth->size(); ++n) {
    const double d = (*truth)[n] - static_cast<double>((*found->volume.values)[n]);
    squares += d * d;
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(truth->size())), SolveOptions{}.error);
}

/// Layers with a vessel, and a bone with its shadow, in speckle that is correlated along the row.
ScalarVolume tissue(const VoxelGrid& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::exponential_distribution<double> power;
  double kept = 1;
  return test::make_scalar(grid, [&](int i, int j, int k) {
    kept = 0.6 * kept + 0.4 * power(random);
    const double x = (i + 0.5) / grid.size[0], y = (j + 0.5) / grid.size[1];
    const double z = (k + 0.5) / grid.size[2];
    const bool vessel = std::hypot(x - 0.3 - 0.08 * std::sin(6 * z), y - 0.45) < 0.06;
    const bool beside = std::abs(x - 0.8) < 0.08;
    const double mean = vessel               ? 14
                        : beside && y > 0.35 ? 6
                        : beside && y > 0.27 ? 230
                                             : 90 + 30 * std::sin(14 * y + 2 * std::sin(5 * x));
    return std::floor(std::min(255.0, mean * std::sqrt(kept)));
  });
}

TEST(ConfidenceTest, EstimatesItsErrorWithinAFactor) {
  expect_honest_estimates(
      "speckle", test::speckled(test::centred_grid({24, 30, 16}, {0.4, 0.4, 0.4}), 6), down());
  if (test::kSanitized) return;
  expect_honest_estimates("tissue", tissue(test::centred_grid({40, 40, 40}, {0.4, 0.4, 0.4}), 2),
                          down());
  expect_honest_estimates("few slices",
                          tissue(test::centred_grid({48, 48, 16}, {0.4, 0.4, 1.5}), 3), down());
  expect_honest_estimates("oblique", tissue(test::centred_grid({48, 48, 16}, {0.4, 0.4, 1.5}), 3),
                          *ScanLines::parallel({{0.2, -0.3, -1}}, {{0, 0, 0}}));
  expect_honest_estimates("fine depth",
                          tissue(test::centred_grid({32, 72, 32}, {0.6, 0.15, 0.6}), 4), down());
  expect_honest_estimates("fan", tissue(test::centred_grid({36, 36, 36}, {0.4, 0.4, 0.4}), 5),
                          *ScanLines::fan({{0, -12, 0}}, 5));
  expect_honest_estimates("one slice", tissue(test::centred_grid({96, 96, 1}, {0.4, 0.4, 0.4}), 7),
                          down());
  expect_honest_estimates("thin", tissue(test::centred_grid({64, 64, 4}, {0.4, 0.4, 0.4}), 8),
                          down());
}

TEST(ConfidenceTest, IsLowerBehindAShadow) {
  const auto grid = test::centred_grid({20, 40, 20}, {0.5, 0.5, 0.5});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> grain(-4, 4);
  const auto volume = test::make_scalar(grid, [&](int i, int j, int) {
    if (j == 12 && i < 10) return 250.0;  // Bone.
    return j > 12 && i < 10 ? 2.0 : 110 + grain(random);
  });
  const auto found = confidence(volume, down(), {});
  ASSERT_TRUE(test::has_value(found));
  EXPECT_LT(found->volume.at(4, 24, 10) + 0.1, found->volume.at(15, 24, 10));
}

TEST(ConfidenceTest, UnknownVoxelsAreHolesNotTransducers) {
  const auto grid = test::centred_grid({12, 20, 9}, {1, 1, 1});
  const auto volume = test::make_scalar(grid, [](int i, int j, int k) {
    const bool hole = i > 3 && i < 8 && j > 8 && j < 12 && k > 2 && k < 6;
    const bool island = i == 6 && j == 10 && k == 4;
    return (hole && !island) || i == 0 || j < 2 ? std::nan("") : 80;
  });
  auto options = exact();
  options.alpha = 0;
  const auto found = confidence(volume, down(), options);
  ASSERT_TRUE(test::has_value(found));
  EXPECT_TRUE(std::isnan(found->volume.at(0, 9, 4)));
  EXPECT_TRUE(std::isnan(found->volume.at(5, 10, 4)));
  EXPECT_TRUE(std::isnan(found->volume.at(6, 10, 4)));  // Connected to nothing.
  EXPECT_EQ(found->volume.at(5, 2, 4), 1);              // The first known voxel of its line.
  EXPECT_EQ(found->volume.at(5, 19, 4), 0);
  EXPECT_LT(found->volume.at(5, 12, 4), 0.6F);  // Just behind the hole.
  EXPECT_GT(found->volume.at(5, 8, 4), 0.4F);   // Just in front of the hole.
  EXPECT_LT(
      test::largest_difference(found->volume, *definition::confidence(volume, down(), options)),
      1e-5);
}

TEST(ConfidenceTest, SolvesSaturatedConstantAndSingleVoxelVolumes) {
  for (const std::array<int, 3> size : {std::array{8, 8, 8}, {1, 1, 1}, {7, 1, 3}}) {
    for (const double value : {0.0, 255.0}) {
      const auto volume = test::make_scalar(test::centred_grid(size, {0.2, 0.2, 1}),
                                            [&](int, int, int) { return value; });
      const auto found = confidence(volume, down(), {});
      ASSERT_TRUE(test::has_value(found));
      for (const float v : *found->volume.values) EXPECT_TRUE(v >= 0 && v <= 1) << v;
      EXPECT_EQ(found->volume.at(0, 0, 0), 1);
      EXPECT_LE(found->report.estimated_error, SolveOptions{}.error) << value;
    }
  }
}

TEST(ConfidenceTest, ReportsNoErrorThatItCannotEstimate) {
  // One bright layer whose voxels are connected 10^5 times as strongly to each other as to any
  // other.
  const auto layer = test::make_scalar(test::centred_grid({12, 24, 8}, {0.5, 0.5, 0.5}),
                                       [](int, int j, int) { return j == 12 ? 255.0 : 20.0; });
  ConfidenceOptions options;
  const auto usual = confidence(layer, down(), options);
  options.gamma = 0;
  const auto tied = confidence(layer, down(), options);
  ASSERT_TRUE(test::has_value(usual) && test::has_value(tied));
  EXPECT_LE(usual->report.estimated_error, options.solve.error);
  EXPECT_TRUE(std::isnan(tied->report.estimated_error));
}

TEST(ConfidenceTest, RejectsInvalidInputByNameAndStopsOnRequest) {
  const auto grid = test::centred_grid({6, 6, 6}, {1, 1, 1});
  const auto nothing = test::make_scalar(grid, [](int, int, int) { return std::nan(""); });
  EXPECT_EQ(confidence(nothing, down(), {}).error().code, ErrorCode::kMalformedData);
  const auto volume = test::speckled(test::centred_grid({16, 16, 16}, {1, 1, 1}), 2);
  ConfidenceOptions options;
  options.solve.error = 1e-9;
  options.solve.max_iterations = 1;
  EXPECT_TRUE(test::rejects(confidence(volume, down(), options), ErrorCode::kNumerical,
                            {"estimated error", "found an unknown one after 1"}));
  options.solve.error = 0.02;
  EXPECT_TRUE(test::rejects(confidence(volume, down(), options), ErrorCode::kUsage,
                            {"error", "0.01", "0.02"}));
  options.solve.error = 1e-9;
  options.beta = -1;
  EXPECT_NE(confidence(volume, down(), options).error().message.find("beta"), std::string::npos);
  RunOptions run;
  run.memory_limit = 1000;
  EXPECT_EQ(confidence(volume, down(), {}, run).error().code, ErrorCode::kUnsupportedData);
  std::stop_source stop;
  stop.request_stop();
  RunOptions stopped;
  stopped.stop = stop.get_token();
  EXPECT_EQ(confidence(volume, down(), {}, stopped).error().code, ErrorCode::kCancelled);
  // The stop comes before there is anything to solve.
  const auto system = confidence_system(volume, down(), {}, stopped);
  ASSERT_FALSE(system.has_value());
  EXPECT_EQ(system.error().code, ErrorCode::kCancelled);
}

TEST(ConfidenceTest, StartsAtTheApexOfAFanForEveryPosition) {
  // The apex is on a voxel, between voxels, and outside. For the first two, the lines end in all
  // directions.
  const auto grid = test::centred_grid({15, 13, 11}, {1, 1, 1});
  const auto volume = test::make_scalar(grid, [](int, int, int) { return 90; });
  auto options = exact();
  options.alpha = 0;
  struct Case {
    Eigen::Vector3d apex;
    int first;  ///< First known voxel of the line down the middle.
  };
  for (const auto& [apex, first] :
       {Case{{0, 0, 0}, 7}, Case{{0.3, -0.2, 0.4}, 6}, Case{{0, -9, 0}, 0}}) {
    const auto fan = ScanLines::fan({apex}, 0);
    ASSERT_TRUE(test::has_value(fan));
    const auto found = confidence(volume, *fan, options);
    ASSERT_TRUE(test::has_value(found));
    EXPECT_EQ(found->volume.at(7, first, 5), 1) << apex.transpose();
    for (int y = first; y + 1 < 13; ++y) {
      EXPECT_GT(found->volume.at(7, y, 5), found->volume.at(7, y + 1, 5)) << apex.transpose();
    }
    EXPECT_EQ(found->volume.at(7, 12, 5), 0) << apex.transpose();
    EXPECT_LT(
        test::largest_difference(found->volume, *definition::confidence(volume, *fan, options)),
        1e-5);
  }
}

// Penalties of a fan and of parallel lines are computed in different ways.
TEST(ConfidenceTest, ADistantApexEqualsParallelLines) {
  const auto volume = test::speckled(test::centred_grid({12, 16, 10}, {0.4, 0.4, 0.4}), 9);
  const auto far = ScanLines::fan({{0, -1e6, 0}}, 0);
  const auto fan = definition::confidence(volume, *far, {});
  const auto parallel = definition::confidence(volume, down(), {});
  ASSERT_TRUE(test::has_value(fan));
  ASSERT_TRUE(test::has_value(parallel));
  for (std::size_t n = 0; n < fan->size(); ++n) EXPECT_NEAR((*fan)[n], (*parallel)[n], 1e-4) << n;
}

TEST(ConfidenceTest, ThinVolumesNeedMoreMemoryThanTheirVoxels) {
  // Including its border, a row of one voxel has 16 by 3 nodes.
  const auto grid = test::centred_grid({1, 1, 20000}, {1, 1, 1});
  const auto volume = test::make_scalar(grid, [](int, int, int) { return 90; });
  const auto along = ScanLines::parallel({{0, 0, 1}}, {{0, 0, -1e6}});
  RunOptions run;
  run.memory_limit = 21120000;  // Memory of the values of the nodes and of the rounded weights
                                // alone.
  const auto refused = confidence(volume, *along, {}, run);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupportedData);
}

TEST(ConfidenceTest, DoesNotDependOnTheNumberOfThreads) {
  const auto volume = test::speckled(test::centred_grid({18, 25, 14}, {0.4, 0.4, 0.4}), 8);
  RunOptions one;
  one.threads = 1;
  RunOptions three;
  three.threads = 3;
  EXPECT_TRUE(test::same_bytes(*confidence(volume, down(), {}, one)->volume.values,
                               *confidence(volume, down(), {}, three)->volume.values));
}

}  // namespace
}  // namespace nav::render::features
