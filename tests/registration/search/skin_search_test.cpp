// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/search/skin_search.hpp"

#include <chrono>
#include <cmath>
#include <ctime>
#include <gtest/gtest.h>

#include "nav/stopwatch.hpp"
#include "registration/acceptance.hpp"
#include "registration/search/body_surface.hpp"
#include "registration/similarity/patches.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

constexpr double kRadiusX = 95, kRadiusY = 70;

/// Signed distance to an elliptic trunk along z, mm, to first order. Negative inside.
double trunk(const Eigen::Vector3d& p) {
  const double r = std::hypot(p.x() / kRadiusX, p.y() / kRadiusY);
  const double slope = std::hypot(p.x() / (kRadiusX * kRadiusX), p.y() / (kRadiusY * kRadiusY));
  return slope > 0 ? (r - 1) * r / slope : -kRadiusY;
}

/// Blobs in a trunk in air, with a lung that the upper end of the CT cuts off.
struct Trunk {
  test::BlobPatient blobs{11, 110, 75};
  [[nodiscard]] static bool lung(const Eigen::Vector3d& p) {
    return p.z() > 60 && std::hypot(p.x() - 30, p.y()) < 30;
  }
  [[nodiscard]] double hu(const Eigen::Vector3d& p) const {
    if (trunk(p) > 0) return -1000;
    return lung(p) ? -850 : blobs.hu(p);
  }
};

const Volume& trunk_ct() {
  static const Volume ct = [] {
    VoxelGrid grid = test::cubic_grid(125, 2.5);
    grid.size[2] = 65;
    grid.origin_mm.z() = -80;
    return test::blob_ct(Trunk(), grid);
  }();
  return ct;
}

TEST(BodySurfaceTest, ComputesTheDepthBelowTheSkin) {
  const BodySurface body(trunk_ct());
  for (const double angle : {0.0, 0.7, 1.6, 3.0, 4.4, 5.5}) {
    const Eigen::Vector3d skin(kRadiusX * std::cos(angle), kRadiusY * std::sin(angle), -10);
    const Eigen::Vector3d inward =
        -Eigen::Vector3d(std::cos(angle) / kRadiusX, std::sin(angle) / kRadiusY, 0).normalized();
    for (const double depth : {-8.0, 0.0, 10.0}) {
      // Half a cell, plus the effect of the curvature of the skin within the smoothing.
      EXPECT_NEAR(body.depth_mm({skin + depth * inward}), depth, 4) << angle << ' ' << depth;
    }
  }
  EXPECT_GE(body.depth_mm({{0, 0, 0}}), 19);
  EXPECT_GE(body.depth_mm({{30, 0, 70}}), 10) << "a lung is inside, cut or not";
}

TEST(BodySurfaceTest, PointsLieOnTheSkinWithInwardNormals) {
  const auto points = BodySurface(trunk_ct()).points(20);
  // The points cover the sides of the trunk over the height of the CT. The cut ends have no skin.
  EXPECT_GE(points.size(), 100u);
  EXPECT_LE(points.size(), 500u);
  for (const auto& [place, inward] : points) {
    EXPECT_LE(std::abs(trunk(place.mm)), 5) << place.mm.transpose();
    const Eigen::Vector3d expected = -Eigen::Vector3d(place.mm.x() / (kRadiusX * kRadiusX),
                                                      place.mm.y() / (kRadiusY * kRadiusY), 0)
                                          .normalized();
    EXPECT_GE(inward.dot(expected), std::cos(0.3)) << place.mm.transpose();
  }
}

TEST(BodySurfaceTest, ACtWithoutAirHasNoSkin) {
  const Volume ct = test::blob_ct(test::BlobPatient(3), test::cubic_grid(40, 4));
  EXPECT_TRUE(BodySurface(ct).points(20).empty());
}

/// Sweep over the side of the trunk, with images of a linear probe that begin 3 mm below the skin.
Sweep side_sweep(const Trunk& patient) {
  std::vector<TrackedImage> frames;
  std::mt19937 random(9);
  for (int f = 0; f < 20; ++f) {
    const double angle = 3.9 + 0.012 * (f - 10);
    const Eigen::Vector3d skin(kRadiusX * std::cos(angle), kRadiusY * std::sin(angle),
                               -20 + 2.5 * (f - 10));
    Eigen::Matrix3d axes;
    axes.col(1) =
        -Eigen::Vector3d(std::cos(angle) / kRadiusX, std::sin(angle) / kRadiusY, 0).normalized();
    axes.col(2) = Eigen::Vector3d::UnitZ();
    axes.col(0) = axes.col(1).cross(axes.col(2));
    const Transform<frames::Ct, frames::Image> pose(
        Eigen::Quaterniond(axes) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()),
        skin + 3 * axes.col(1));
    UltrasoundImage frame;
    frame.acquired = frame.received = Timestamp(std::chrono::milliseconds(100 * f));
    frame.grid = PixelGrid::centred(90, 1, 1);
    const Eigen::Vector3d beam = pose.rotation() * Eigen::Vector3d::UnitY();
    std::vector<std::uint8_t> grey;
    for (int row = 0; row < 90; ++row) {
      for (int column = 0; column < 90; ++column) {
        const Eigen::Vector3d p = (pose * frame.grid.at(column, row)).mm;
        const double noise = 4.0 * (static_cast<double>(random()) / 2147483648.0 - 1.0);
        const double value =
            60 + 0.7 * patient.blobs.hu(p) + 4 * std::abs(patient.blobs.slope(p, beam)) + noise;
        grey.push_back(static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0))));
      }
    }
    frame.pixels = Image2d<std::uint8_t>(90, 90, std::move(grey));
    frames.push_back({std::move(frame), test::true_pose().inverse() * pose, Duration{0}});
  }
  return *Sweep::create(std::move(frames), "synthetic");
}

TEST(PatchSetTest, CoarsenedPatchesAreEqualWithFewerSamples) {
  PatchSet all;
  all.side = 7;
  all.frames = 1;
  for (int i = 0; i < 3; ++i) {
    Patch patch{};
    patch.step_a = {1.5, 0, 0};
    patch.step_b = {0, 1.5, 0};
    patch.weight = i == 2 ? 0.5 : 0.25;
    all.patches.push_back(patch);
    for (int k = 0; k < 49; ++k) {
      // The last patch varies only between the samples that remain.
      const float ramp = static_cast<float>(k % 7 - 3 + 2 * (k / 7 - 3));
      all.samples.push_back(i == 2 ? static_cast<float>(k % 7 % 3 != 0) : ramp);
    }
  }
  const PatchSet few = coarsened(all, 3);
  ASSERT_EQ(few.patches.size(), 2u) << "flat ones are left out";
  EXPECT_EQ(few.side, 3);
  EXPECT_EQ(few.patches[0].step_a, Eigen::Vector3d(4.5, 0, 0));
  EXPECT_DOUBLE_EQ(few.patches[0].weight + few.patches[1].weight, 1);
  // 3 (a + 2 b) for a and b in −1, 0, 1, divided by its norm.
  const double norm = std::sqrt(6 * (1.0 + 4.0));
  for (int k = 0; k < 9; ++k) {
    const double expected = (k % 3 - 1 + 2 * (k / 3 - 1)) / norm;
    EXPECT_NEAR(few.u(1)[static_cast<std::size_t>(k)], expected, 1e-6);
  }
}

TEST(PatchSetTest, CoarsenedPatchesKeepTheirGreyValues) {
  PatchSet all;
  all.side = 7;
  all.patches.push_back({});
  all.patches[0].mean_grey = 100;
  all.patches[0].norm_grey = 40;
  all.patches[0].weight = 1;
  for (int k = 0; k < 49; ++k) all.samples.push_back(0.02F * static_cast<float>(k * k % 17 - 6));
  const PatchSet few = coarsened(all, 3);
  ASSERT_EQ(few.patches.size(), 1U);
  const auto grey = [](const PatchSet& set, std::size_t k) {
    return set.patches[0].mean_grey + set.patches[0].norm_grey * static_cast<double>(set.u(0)[k]);
  };
  constexpr double kRounding = 1e-4;  // Rounding of 256 grey values in float.
  for (std::size_t b = 0; b < 3; ++b) {
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(grey(few, 3 * b + a), grey(all, 21 * b + 3 * a), kRounding);
    }
  }
}

/// One slice of fat with air on its left and right.
Volume slab_ct(double slice_mm) {
  VoxelGrid grid;
  grid.size = {60, 20, 1};
  grid.spacing_mm = {2, 2, slice_mm};
  std::vector<std::int16_t> hu;
  for (int k = 0; k < 20 * 60; ++k) {
    hu.push_back(static_cast<std::int16_t>(k % 60 < 15 || k % 60 >= 45 ? -1000 : -100));
  }
  return *Volume::create(grid, std::move(hu), "slab");
}

TEST(BodySurfaceTest, SurfaceOfOneSliceDoesNotDependOnItsThickness) {
  const BodySurface thick(slab_ct(5));
  const BodySurface thin(slab_ct(1e-4));
  constexpr double kRoundingMm = 1e-4;
  for (double x = 0; x < 120; x += 3) {
    EXPECT_NEAR(thin.depth_mm({{x, 20, 0}}), thick.depth_mm({{x, 20, 0}}), kRoundingMm) << x;
  }
}

TEST(SkinSearchTest, RejectsOptionsOutOfRangeByName) {
  EXPECT_TRUE(validate(SkinSearchOptions()));
  SkinSearchOptions options;
  options.tried = 0;
  const auto refused = validate(options);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("tried"), std::string::npos);
  options = {};
  options.lean_rad = std::nan("");
  EXPECT_FALSE(validate(options));
}

/// Direction in Ct in which the left edge of the middle image of the sweep points.
Eigen::Vector3d left_of(const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& pose) {
  const TrackedImage& middle = sweep.frames()[sweep.frames().size() / 2];
  return pose.rotation() * (middle.reference_from_image.rotation() * -Eigen::Vector3d::UnitX());
}

TEST(SkinSearchTest, TriesOnlyPosesThatAgreeWithTheMarker) {
  const Sweep sweep = side_sweep(Trunk());
  ImageRegistrationOptions options;
  options.threads = 1;
  CollectingDiagnostics diagnostics;
  const Eigen::Vector3d left = left_of(sweep, test::true_pose());
  SkinSearchOptions search;
  search.tried = 60;
  search.marker_towards = left;
  const auto found = register_on_skin(trunk_ct(), sweep, options, search, diagnostics);
  ASSERT_TRUE(test::has_value(found));
  const Point<frames::Reference> face =
      sweep.frames()[10].reference_from_image * sweep.frames()[10].frame.grid.at(45, 45);
  EXPECT_LE(((found->ct_from_reference * face) - (test::true_pose() * face)).v.norm(), 1);
  search.marker_towards = -left;
  const auto turned = register_on_skin(trunk_ct(), sweep, options, search, diagnostics);
  ASSERT_TRUE(test::has_value(turned));
  // A tried pose may rotate on its way to a minimum, but not by a half turn.
  EXPECT_GE(left_of(sweep, turned->ct_from_reference).dot(-left), std::cos(1.2));
  EXPECT_GE(turned->final_cost, 1.5 * found->final_cost);
  search.marker_towards = Eigen::Vector3d(1, 1, 0);
  const auto refused = register_on_skin(trunk_ct(), sweep, options, search, diagnostics);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().message.find("marker_towards"), std::string::npos);
}

TEST(SkinSearchTest, FindsThePoseWithoutAStart) {
  const Sweep sweep = side_sweep(Trunk());
  ImageRegistrationOptions options;
  options.threads = 1;
  CollectingDiagnostics diagnostics;
  const auto begin = std::chrono::steady_clock::now();
  const auto found = register_on_skin(trunk_ct(), sweep, options, {}, diagnostics);
  const double wall_s = seconds_since(begin);
  ASSERT_TRUE(test::has_value(found));
  // The reported time covers the whole search except for freeing memory at its end, not only the
  // last start.
  EXPECT_LE(found->total_s, wall_s);
  EXPECT_GE(found->total_s, 0.6 * wall_s);
  for (const TrackedImage& tracked : sweep.frames()) {
    const auto p = tracked.reference_from_image * tracked.frame.grid.at(45, 45);
    EXPECT_LE(((found->ct_from_reference * p) - (test::true_pose() * p)).v.norm(), 1);
  }
}

double process_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TEST(SkinSearchTest, TheTimeLimitBoundsTheSearch) {
  const Sweep sweep = side_sweep(Trunk());
  ImageRegistrationOptions options;
  options.threads = 1;
  CollectingDiagnostics diagnostics;
  const auto run = [&](double limit_s) {
    options.time_limit_s = limit_s;
    return register_on_skin(trunk_ct(), sweep, options, {}, diagnostics);
  };
  const auto start = std::chrono::steady_clock::now();
  const double before_s = process_s();
  ASSERT_TRUE(test::has_value(run(1e9)));
  const double whole_s = process_s() - before_s;
  const double wall_s = seconds_since(start);
  // Parts that cannot be interrupted: the skin of the CT and one level of patches.
  constexpr double kUninterrupted = 0.5;
  EXPECT_TRUE(test::rejects(run(1e-9), ErrorCode::kTimeout, {"time limit", "found none"}));
  EXPECT_LT(process_s() - before_s - whole_s, kUninterrupted * whole_s);
  for (const double share : {0.05, 0.2, 0.4, 0.6, 0.8, 0.9}) {
    const auto found = run(share * wall_s);
    if (!found) {
      EXPECT_EQ(found.error().code, ErrorCode::kTimeout) << share;
    } else if (found->termination != Termination::kConverged) {
      EXPECT_EQ(found->termination, Termination::kTimeLimit) << share;
      EXPECT_FALSE(decide(*found, {}, {{0, 0, 0}}).accepted) << share;
    }
  }
}

TEST(SkinSearchTest, ACancelledSearchReportsIt) {
  int asked = 0;
  ImageRegistrationOptions options;
  options.threads = 1;
  CollectingDiagnostics diagnostics;
  for (const int after : {1, 5, 100}) {
    asked = 0;
    const auto found = register_on_skin(trunk_ct(), side_sweep(Trunk()), options, {}, diagnostics,
                                        [&](double) { return ++asked < after; });
    EXPECT_TRUE(test::rejects(found, ErrorCode::kCancelled, {"cancelled"})) << after;
  }
}

TEST(SkinSearchTest, RejectsACtWithoutSkin) {
  const Volume ct = test::blob_ct(test::BlobPatient(3), test::cubic_grid(60, 3));
  CollectingDiagnostics diagnostics;
  const auto found = register_on_skin(ct, side_sweep(Trunk()), {}, {}, diagnostics);
  ASSERT_FALSE(found.has_value());
  EXPECT_EQ(found.error().code, ErrorCode::kRefused);
  EXPECT_NE(found.error().message.find("skin"), std::string::npos);
}

}  // namespace
}  // namespace nav::registration
