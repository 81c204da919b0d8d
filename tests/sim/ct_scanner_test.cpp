// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/ct_scanner.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

const AbdomenPhantom& scanned() {
  static const AbdomenPhantom instance({3, Contrast::kPortal});
  return instance;
}

CtOptions small_scan() {
  CtOptions options;
  options.spacing_mm = {2, 2, 3};
  options.region = {{-100, -60, -30}, {-20, 20, 30}};  // The region is inside the patient, so no
                                                       // value is clipped.
  return options;
}

TEST(CtScannerTest, NoiseHasTheStatedStandardDeviation) {
  CtOptions options = small_scan();
  options.psf_mm = 0;
  options.noise_hu = 12;
  const auto ct = scan_ct(scanned(), options);
  ASSERT_TRUE(test::has_value(ct));
  double sum = 0;
  double squares = 0;
  const auto size = ct->grid().size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const double error =
            ct->at(i, j, k) - scanned().hu(ct->grid().at({i * 1., j * 1., k * 1.}));
        sum += error;
        squares += error * error;
      }
    }
  }
  const auto n = static_cast<double>(ct->grid().voxel_count());
  // Five standard errors of the mean and of the standard deviation of n samples.
  EXPECT_NEAR(sum / n, 0, 5 * 12 / std::sqrt(n));
  const double rounded = std::sqrt(144 + 1.0 / 12.0);
  EXPECT_NEAR(std::sqrt(squares / n), rounded, 5 * 12 / std::sqrt(2 * n));
}

TEST(CtScannerTest, WithoutNoiseAndBlurTheScanEqualsThePhantom) {
  CtOptions options = small_scan();
  options.psf_mm = 0;
  options.noise_hu = 0;
  const auto ct = scan_ct(scanned(), options);
  ASSERT_TRUE(test::has_value(ct));
  for (const auto& p : scanned().targets()) {
    const Eigen::Vector3d index = ct->grid().index_of(p).array().round();
    const auto at = index.cast<int>();
    const auto size = ct->grid().size;
    if ((index.array() < 0).any() || at.x() >= size[0] || at.y() >= size[1] || at.z() >= size[2]) {
      continue;
    }
    EXPECT_EQ(ct->at(at.x(), at.y(), at.z()), std::lround(scanned().hu(ct->grid().at(index))));
  }
}

TEST(CtScannerTest, BlurKeepsTheMeanAndSoftensEdges) {
  CtOptions sharp = small_scan();
  sharp.noise_hu = 0;
  sharp.psf_mm = 0;
  CtOptions soft = sharp;
  soft.psf_mm = 2;
  const auto a = scan_ct(scanned(), sharp);
  const auto b = scan_ct(scanned(), soft);
  ASSERT_TRUE(test::has_value(a) && test::has_value(b));
  const auto roughness = [](const Volume& v) {
    double sum = 0;
    for (std::size_t i = 1; i < v.hu().size(); ++i) sum += std::abs(v.hu()[i] - v.hu()[i - 1]);
    return sum;
  };
  EXPECT_LT(roughness(*b), 0.9 * roughness(*a));
  double mean_a = 0;
  double mean_b = 0;
  for (const auto v : a->hu()) mean_a += v;
  for (const auto v : b->hu()) mean_b += v;
  // Only the border, where the blur repeats the edge, can change the mean.
  EXPECT_NEAR(mean_a, mean_b, 3.0 * static_cast<double>(a->hu().size()));
}

TEST(CtScannerTest, OneAndTwoThreadsGiveEqualBytes) {
  const auto scan = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return scan_ct(scanned(), small_scan());
  };
  const auto one = scan(1);
  const auto two = scan(2);
  ASSERT_TRUE(test::has_value(one) && test::has_value(two));
  EXPECT_TRUE(std::ranges::equal(one->hu(), two->hu()));
}

TEST(CtScannerTest, RejectsInvalidOptions) {
  CtOptions options = small_scan();
  options.spacing_mm.y() = 0;
  EXPECT_TRUE(test::rejects(scan_ct(scanned(), options), ErrorCode::kUsage, {"spacing > 0", "0"}));
  options = small_scan();
  options.noise_hu = -1;
  EXPECT_TRUE(test::rejects(scan_ct(scanned(), options), ErrorCode::kUsage, {"noise", "-1"}));
  options = small_scan();
  options.region.max_mm.x() = options.region.min_mm.x() - 1;
  EXPECT_TRUE(test::rejects(scan_ct(scanned(), options), ErrorCode::kUsage, {"region"}));
}

}  // namespace
}  // namespace nav::sim
