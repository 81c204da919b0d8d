// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/image_bootstrap.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <random>

#include "nav/matrices.hpp"
#include "registration/uncertainty/sandwich.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

constexpr double kWayMm = 2;

/// Images with random gradients around a minimum. Each image has an equal share of the Hessian.
LocalShape shape_of(int images, unsigned seed = 3) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  LocalShape shape{{{10, -20, 30}}, Matrix6d::Zero(), {}, {}};
  Vector6d diagonal;
  diagonal << 2, 3, 1, 2, 1, 4;
  shape.hessian = diagonal.asDiagonal();
  shape.hessian(0, 4) = shape.hessian(4, 0) = 0.5;
  Vector6d mean = Vector6d::Zero();
  for (int i = 0; i < images; ++i) {
    ImageShape image{.frame = i,
                     .weight = 1.0 / images,
                     .way_mm = i == 0 ? 0 : kWayMm,
                     .gradient = Vector6d::Zero(),
                     .hessian = shape.hessian / images};
    for (int k = 0; k < 6; ++k) image.gradient[k] = normal(random) / images;
    mean += image.gradient / images;
    shape.images.push_back(image);
  }
  for (ImageShape& image : shape.images) image.gradient -= mean;
  return shape;
}

BootstrapOptions many(double block_mm) { return {20000, block_mm, 1}; }

TEST(ImageDrawsTest, DrawsBlocksOfNeighboursEvenly) {
  const std::vector<double> ways(29, kWayMm);
  const ImageDraws draws(ways, many(3 * kWayMm));
  EXPECT_EQ(draws.block(), 3);
  EXPECT_EQ(draws.blocks(), 10);
  EXPECT_EQ(draws.starts(7), ImageDraws(ways, many(3 * kWayMm)).starts(7));
  EXPECT_NE(draws.starts(7), draws.starts(8));
  std::vector<double> mean(30, 0);
  constexpr int kReplicates = 4000;
  for (int replicate = 0; replicate < kReplicates; ++replicate) {
    const auto counts = draws.counts(replicate);
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0), 30);
    for (std::size_t i = 0; i < counts.size(); ++i) mean[i] += counts[i] / double{kReplicates};
  }
  // Five standard deviations of a mean of about 1.
  for (const double one : mean) EXPECT_NEAR(one, 1, 5 * std::sqrt(1.0 / kReplicates));
}

TEST(ImageDrawsTest, ImagesOfOnePlaneAreOneBlock) {
  EXPECT_EQ(ImageDraws(std::vector<double>(11, 0.0), {}).block(), 12);
  EXPECT_EQ(ImageDraws({}, {}).block(), 1);
  EXPECT_EQ(ImageDraws(std::vector<double>(11, 50.0), {}).block(), 1);
}

TEST(ImageBootstrapTest, AgreesWithItsClosedForm) {
  // Monte Carlo with 20 000 replicates: 1 % of a variance.
  constexpr double kRelative = 0.05;
  for (const int block : {1, 4}) {
    const LocalShape shape = shape_of(32);
    const ImageBootstrap found = image_bootstrap(shape, many(block * kWayMm));
    ASSERT_TRUE(found.valid) << found.fault;
    EXPECT_EQ(found.block, block);
    // With one Hessian for all images, 32 / l blocks are drawn, and each of the 32 blocks is
    // equally likely.
    Matrix6d scatter = Matrix6d::Zero();
    for (std::size_t first = 0; first < 32; ++first) {
      Vector6d sum = Vector6d::Zero();
      for (std::size_t i = 0; i < static_cast<std::size_t>(block); ++i) {
        sum += shape.images[(first + i) % 32].gradient;
      }
      scatter += sum * sum.transpose() / block;
    }
    const Matrix6d expected = twist_from_scaled() * symmetric_inverse(shape.hessian) * scatter *
                              symmetric_inverse(shape.hessian) * twist_from_scaled();
    const PoseUncertainty exact{shape.centre_ct, expected};
    for (const Eigen::Vector3d& at : {Eigen::Vector3d(10, -20, 30), Eigen::Vector3d(60, 10, -40)}) {
      EXPECT_NEAR(found.tre_rms_mm({at}) / exact.tre_rms_mm({at}), 1, kRelative);
      EXPECT_LT(found.tre_quantile_mm({at}, 0.5), found.tre_rms_mm({at}));
      EXPECT_GT(found.tre_quantile_mm({at}, 0.95), found.tre_rms_mm({at}));
    }
  }
}

TEST(ImageBootstrapTest, TheSeedDeterminesTheBits) {
  const LocalShape shape = shape_of(20);
  const ImageBootstrap a = image_bootstrap(shape, {});
  const ImageBootstrap b = image_bootstrap(shape, {});
  EXPECT_EQ(a.twists, b.twists);
  BootstrapOptions other;
  other.seed = 2;
  EXPECT_NE(a.twists, image_bootstrap(shape, other).twists);
}

TEST(ImageBootstrapTest, TooFewImagesAreReportedAndNeverGiveNan) {
  for (const int images : {0, 1, 2, 3, kLeastImages - 1}) {
    const ImageBootstrap found = image_bootstrap(shape_of(images), {});
    EXPECT_FALSE(found.valid);
    EXPECT_NE(found.fault.find("found " + std::to_string(images)), std::string::npos)
        << found.fault;
    EXPECT_TRUE(std::isinf(found.tre_rms_mm({{0, 0, 0}})));
    EXPECT_TRUE(std::isinf(found.tre_quantile_mm({{0, 0, 0}}, 0.95)));
  }
  EXPECT_TRUE(image_bootstrap(shape_of(kLeastImages), {}).valid);
  EXPECT_FALSE(image_bootstrap(shape_of(20), {.replicates = 0}).valid);
}

TEST(ImageBootstrapTest, ImagesAtTooFewPositionsAreReported) {
  // Draws of one or two blocks hardly differ.
  for (const int places : {1, 2, 3}) {
    const ImageBootstrap found = image_bootstrap(shape_of(12), many(12 / places * kWayMm));
    EXPECT_EQ(found.places, places);
    EXPECT_EQ(found.valid, places >= kLeastPlaces);
    if (found.valid) continue;
    EXPECT_EQ(found.fault, "expected at least 3 positions at which images were acquired, found " +
                               std::to_string(places));
    EXPECT_TRUE(std::isinf(found.tre_rms_mm({{0, 0, 0}})));
  }
}

TEST(ImageBootstrapTest, ImagesWithoutWeightAreNotDrawn) {
  const LocalShape shape = shape_of(20);
  LocalShape more = shape;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  more.images.insert(more.images.begin() + 5, {.frame = 99,
                                               .weight = 0,
                                               .way_mm = 0.5 * kWayMm,
                                               .gradient = Vector6d::Constant(kNan),
                                               .hessian = Matrix6d::Zero()});
  more.images[6].way_mm = 0.5 * kWayMm;
  const ImageBootstrap found = image_bootstrap(more, {});
  EXPECT_EQ(found.images, 20);
  EXPECT_EQ(found.twists, image_bootstrap(shape, {}).twists);
}

TEST(ImageBootstrapTest, AnUndeterminedDirectionIsReported) {
  LocalShape shape = shape_of(20);
  shape.hessian.row(5).setZero();
  shape.hessian.col(5).setZero();
  for (ImageShape& image : shape.images) image.hessian = shape.hessian / 20;
  const ImageBootstrap found = image_bootstrap(shape, {});
  EXPECT_FALSE(found.valid);
  EXPECT_NE(found.fault.find("translation along Ct (0.00, 0.00, 1.00)"), std::string::npos)
      << found.fault;
  shape.hessian.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(image_bootstrap(shape, {}).fault.find("NaN"), std::string::npos);
}

/// A shape whose sixth direction is determined only by the first \p images of 30 images.
LocalShape known_from(int images) {
  LocalShape shape = shape_of(30);
  for (ImageShape& image : shape.images) {
    const double share = image.frame < images ? 1.0 / images : 0;
    image.hessian.row(5).setZero();
    image.hessian.col(5).setZero();
    image.hessian(5, 5) = share * shape.hessian(5, 5);
  }
  return shape;
}

TEST(ImageBootstrapTest, DrawsThatDetermineNoPoseAreCountedOrReported) {
  BootstrapOptions single;
  single.block_mm = 0;
  const ImageBootstrap seldom = image_bootstrap(known_from(4), single);
  EXPECT_TRUE(seldom.valid) << seldom.fault;
  // (26/30)^30 = 1.4 % of the draws.
  EXPECT_GT(seldom.unsolved, 0);
  EXPECT_EQ(seldom.unsolved + static_cast<int>(seldom.twists.size()), single.replicates);
  for (const Vector6d& twist : seldom.twists) EXPECT_TRUE(twist.allFinite());
  const ImageBootstrap often = image_bootstrap(known_from(1), single);
  EXPECT_FALSE(often.valid);
  EXPECT_NE(often.fault.find("of 400 samples"), std::string::npos) << often.fault;
}

TEST(ImageBootstrapTest, ANonFiniteGradientGivesNoTwist) {
  LocalShape shape = shape_of(12);
  for (ImageShape& image : shape.images) {
    image.gradient[2] = std::numeric_limits<double>::infinity();
  }
  const ImageBootstrap found = image_bootstrap(shape, {});
  EXPECT_FALSE(found.valid);
  EXPECT_EQ(found.unsolved, 400);
}

/// Smallest eigenvalue of a - b, relative to the norm of a.
double least_of(const Matrix6d& a, const Matrix6d& b) {
  const Matrix6d scaled = symmetric_inverse(twist_from_scaled());
  return eigenpairs<6>(scaled * (a - b) * scaled).values[0] / (scaled * a * scaled).norm();
}

TEST(WithBootstrapTest, IsAtLeastAsLargeAsBothInEveryDirection) {
  constexpr double kRounding = 1e-9;
  const LocalShape shape = shape_of(24);
  const ImageBootstrap drawn = image_bootstrap(shape, {});
  Vector6d along;
  along << 9, 0.1, 1, 0.1, 5, 0.5;
  const Matrix6d other = 1e-2 * Matrix6d(along.asDiagonal());
  SandwichCovariance clusters{
      {shape.centre_ct, twist_from_scaled() * other * twist_from_scaled()}, true, ""};
  const Matrix6d found = with_bootstrap(clusters, drawn, 0).covariance;
  EXPECT_GT(least_of(found, clusters.uncertainty.covariance), -kRounding);
  EXPECT_GT(least_of(found, drawn.uncertainty().covariance), -kRounding);
  // Neither covariance alone passes, so the test can fail.
  EXPECT_LT(least_of(clusters.uncertainty.covariance, drawn.uncertainty().covariance), -0.01);
  EXPECT_LT(least_of(drawn.uncertainty().covariance, clusters.uncertainty.covariance), -0.01);
  clusters.uncertainty.covariance *= 1e6;
  EXPECT_TRUE(with_bootstrap(clusters, drawn, 0.07)
                  .covariance.isApprox(clusters.uncertainty.covariance, 1e-6));
  clusters.uncertainty.covariance.setZero();
  EXPECT_GT(least_of(with_bootstrap(clusters, drawn, 0).covariance, drawn.uncertainty().covariance),
            -kRounding);
  clusters.valid = false;
  EXPECT_EQ(with_bootstrap(clusters, drawn, 0).covariance, clusters.uncertainty.covariance);
}

TEST(ImageBootstrapTest, IsEqualForAnyNumberOfThreads) {
  const auto start = test::off_by(test::true_pose(), 4, 0.04, 1);
  CollectingDiagnostics diagnostics;
  auto options = test::small_options();
  const auto& scene = test::blob_scene();
  const auto one = register_sweep(scene.ct, scene.sweep, start, options, diagnostics);
  options.threads = 4;
  const auto four = register_sweep(scene.ct, scene.sweep, start, options, diagnostics);
  ASSERT_TRUE(test::has_value(one));
  ASSERT_TRUE(test::has_value(four));
  ASSERT_TRUE(one->bootstrap.valid) << one->bootstrap.fault;
  EXPECT_EQ(one->bootstrap.twists, four->bootstrap.twists);
  EXPECT_EQ(one->uncertainty.covariance, four->uncertainty.covariance);
  EXPECT_GE(one->tre_rms_mm({{0, 0, 0}}), one->bootstrap.tre_rms_mm({{0, 0, 0}}));
  EXPECT_GE(one->tre_rms_mm({{0, 0, 0}}) * (1 + 1e-9), one->clusters.tre_rms_mm({{0, 0, 0}}));
  options.bootstrap.replicates = 0;
  const auto none = register_sweep(scene.ct, scene.sweep, start, options, diagnostics);
  ASSERT_TRUE(test::has_value(none));
  EXPECT_EQ(none->uncertainty.covariance, none->clusters.covariance);
  EXPECT_EQ(none->clusters.covariance, one->clusters.covariance);
}

TEST(ImageBootstrapTest, RejectsOptionsOutOfRangeByName) {
  EXPECT_TRUE(test::rejects(validate(BootstrapOptions{.replicates = 19}), ErrorCode::kUsage,
                            {"replicates"}));
  EXPECT_TRUE(test::rejects(validate(BootstrapOptions{.block_mm = std::nan("")}), ErrorCode::kUsage,
                            {"block_mm"}));
  EXPECT_TRUE(validate(BootstrapOptions{}));
}

}  // namespace
}  // namespace nav::registration
