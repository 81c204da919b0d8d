// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/structure_distances.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <vector>

namespace nav::session {
namespace {

using State = NearestStructure::State;

constexpr int kEdge = 48;
const Eigen::Vector3d kSpacing(1, 1.5, 2);

/// A CT of 47 x 70 x 94 mm with voxels of 500 HU at some places.
class StructureDistancesTest : public ::testing::Test {
 protected:
  StructureDistancesTest() {
    grid_.size = {kEdge, kEdge, kEdge};
    grid_.spacing_mm = kSpacing;
    hu_.assign(grid_.voxel_count(), 0);
  }
  void mark(int i, int j, int k) {
    hu_[static_cast<std::size_t>(i + kEdge * (j + kEdge * k))] = 500;
    marked_.emplace_back(i, j, k);
  }
  [[nodiscard]] Volume ct() const { return *Volume::create(grid_, hu_, "marked"); }
  [[nodiscard]] static CriticalStructure vessel(double clearance_mm) {
    CriticalStructure one;
    one.name = "vessel";
    one.values = CriticalStructure::Values{400, 600};
    one.clearance_mm = clearance_mm;
    return one;
  }
  [[nodiscard]] static CriticalStructure ball(const Eigen::Vector3d& centre, double clearance_mm) {
    CriticalStructure one;
    one.name = "ball";
    one.sphere = CriticalStructure::Sphere{{centre}, 3};
    one.clearance_mm = clearance_mm;
    return one;
  }
  [[nodiscard]] StructureDistances distances(const std::vector<CriticalStructure>& all) const {
    return StructureDistances::create({{{5, 35, 40}}, {{40, 35, 40}}, 5, 0}, all, ct());
  }

  VoxelGrid grid_;
  std::vector<std::int16_t> hu_;
  std::vector<Eigen::Vector3d> marked_;
};

TEST_F(StructureDistancesTest, ASphereHasTheDistanceOfItsSurface) {
  const auto all = distances({ball({20, 35, 40}, 5)});
  const auto near = all.nearest({{20, 35, 50}});
  EXPECT_EQ(near.state, State::kKnown);
  EXPECT_NEAR(near.distance_mm, 7, 1e-12);
  EXPECT_EQ(near.name, "ball");
  EXPECT_EQ(near.too_near, "");
  EXPECT_EQ(all.nearest({{20, 35, 47}}).too_near, "ball") << "4 mm of the 5 mm to keep";
  EXPECT_NEAR(all.nearest({{20, 35, 41}}).distance_mm, -2, 1e-12) << "inside";
}

TEST_F(StructureDistancesTest, TheFieldHasTheDistanceFromTheNearestVoxel) {
  std::mt19937 random(3);
  for (int n = 0; n < 20; ++n) {
    mark(static_cast<int>(random() % kEdge), static_cast<int>(random() % kEdge),
         static_cast<int>(random() % kEdge));
  }
  const auto all = distances({vessel(1)});
  const double half = 0.5 * kSpacing.maxCoeff();
  int compared = 0;
  for (int k = 15; k < 25; ++k) {
    for (int j = 18; j < 28; ++j) {
      for (int i = 0; i < kEdge; ++i) {
        const Point<frames::Ct> at = grid_.at(Eigen::Vector3d(i, j, k));
        double least = std::numeric_limits<double>::infinity();
        for (const auto& voxel : marked_) {
          least = std::min(least, (grid_.at(voxel).mm - at.mm).norm());
        }
        if (least == 0 || least - half > kFarthestClearanceMm) continue;
        const auto found = all.nearest(at);
        ASSERT_EQ(found.state, State::kKnown);
        // Rounding of the squares in single precision.
        ASSERT_NEAR(found.distance_mm, least - half, 1e-3) << i << ", " << j << ", " << k;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 3000);
}

TEST_F(StructureDistancesTest, InsideTheDistanceIsNegative) {
  for (int k = 16; k < 25; ++k) {
    for (int j = 18; j < 29; ++j) {
      for (int i = 18; i < 29; ++i) mark(i, j, k);
    }
  }
  const auto all = distances({vessel(1)});
  const auto inside = all.nearest(grid_.at(Eigen::Vector3d(23, 23, 20)));
  EXPECT_EQ(inside.state, State::kKnown);
  EXPECT_NEAR(inside.distance_mm, 1 - 6, 1e-3) << "6 voxels of 1 mm to the first one outside";
  EXPECT_EQ(inside.too_near, "vessel");
}

TEST_F(StructureDistancesTest, WhereNothingWasComputedNothingIsKnown) {
  mark(2, 2, 2);
  const auto all = distances({vessel(5), ball({20, 35, 40}, 5)});
  EXPECT_EQ(all.nearest({{-10, 35, 40}}).state, State::kUnknown) << "outside of the CT";
  // The sphere is known, but the voxels might be nearer.
  EXPECT_EQ(all.nearest({{20, 35, 200}}).state, State::kUnknown);
}

TEST_F(StructureDistancesTest, FarVoxelsAreFarUnlessTheyHaveToBeFarther) {
  mark(2, 2, 2);
  EXPECT_EQ(distances({vessel(5)}).nearest({{40, 60, 60}}).state, State::kFar);
  EXPECT_EQ(distances({vessel(60)}).nearest({{40, 60, 60}}).state, State::kUnknown);
  EXPECT_EQ(distances({}).nearest({{40, 60, 60}}).state, State::kNone);
}

}  // namespace
}  // namespace nav::session
