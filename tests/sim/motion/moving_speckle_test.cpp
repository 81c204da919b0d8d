// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>

#include "sim/motion/rest_path.hpp"
#include "sim/session/moving_patient.hpp"
#include "sim/ultrasound.hpp"
#include "tests/sim/block.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;
using Pose = Transform<Ct, Image>;

SmoothWarp breath() {
  auto warp = SmoothWarp::create({{{10, 70, 5}, {60, 55, 60}, {2, 11.9, 3}}});
  EXPECT_TRUE(warp.has_value());
  return std::move(*warp);
}

TEST(RestPathTest, WithoutMotionItIsExactlyTheStraightLine) {
  const Vec start(1.1, 2.7, -3.9);
  const Vec along = Vec(0.3, 0.9, 0.1).normalized();
  const Vec across = along.unitOrthogonal();
  const RestPath path(nullptr, start, along, across, 100);
  for (const double depth : {0.0, 0.1, 33.3, 99.9}) {
    EXPECT_EQ(path.at(depth, 0.7), (start + depth * along + 0.7 * across).eval());
    EXPECT_EQ(path.direction(depth), along);
  }
}

TEST(RestPathTest, FollowsTheInverseMotionToAHundredthOfAMillimetre) {
  const SmoothWarp warp = breath();
  const Vec start(-20, 5, 3);
  const Vec along = Vec(0.3, 0.9, 0.1).normalized();
  const Vec across = along.unitOrthogonal();
  const RestPath path(&warp, start, along, across, 150);
  const Eigen::Matrix3d map = Eigen::AngleAxisd(0.5, Vec::UnitY()).matrix() * 3;
  const RestPath mapped = path.mapped(map);
  for (double depth = 0; depth <= 150; depth += 0.37) {
    EXPECT_LT((path.at(depth) - warp.invert(start + depth * along)).norm(), 0.01) << depth;
    EXPECT_LT((path.at(depth, 2) - warp.invert(start + depth * along + 2 * across)).norm(), 0.05)
        << depth;
    EXPECT_LT((mapped.at(depth, 2) - map * path.at(depth, 2)).norm(), 1e-11) << depth;
    const Vec ahead = warp.invert(start + (depth + 0.01) * along);
    const Vec behind = warp.invert(start + (depth - 0.01) * along);
    EXPECT_LT((path.direction(depth) - (ahead - behind).normalized()).norm(), 0.005) << depth;
  }
}

double nowhere(const Vec&) { return 1e3; }

class MovingSpeckleTest : public testing::TestWithParam<AcousticModel> {
 protected:
  MovingSpeckleTest() {
    probe_.model = GetParam();
    probe_.lines = 256;  // The lines are finer than the beam.
    probe_.half_angle_rad = 0.3;
    probe_.depth_mm = 100;
    probe_.tgc_db_per_cm_mhz = 0.5;
    probe_.tgc_error_db = 0;
  }
  [[nodiscard]] UltrasoundSimulator simulator() const {
    return {std::make_shared<const Block>(Tissue::kLiver, nowhere), probe_, 3};
  }

  ProbeModel probe_ = convex_abdominal();
  Pose pose_{Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vec(0.2, 1, 0.3).normalized())),
             Vec(4, 2, -1)};
};

TEST_P(MovingSpeckleTest, ARigidMotionEqualsTheInverseMotionOfTheProbe) {
  const auto warp = AffineWarp::rigid({0.05, -0.02, 0.1}, {-60, 0, 0}, {1, -4, -12});
  const Eigen::Vector3d turn(0.05, -0.02, 0.1);
  const Eigen::Quaterniond q(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
  const Transform<Ct, Ct> back = Transform<Ct, Ct>(q, warp.apply(Vec::Zero())).inverse();
  const auto moved = simulator().envelope(pose_, 0, {}, &warp);
  const auto probe = simulator().envelope(back * pose_, 0);
  double difference = 0, square = 0;
  for (std::size_t i = 0; i < moved.amplitude.size(); ++i) {
    const double d = static_cast<double>(moved.amplitude[i] - probe.amplitude[i]);
    difference += d * d;
    square += static_cast<double>(probe.amplitude[i] * probe.amplitude[i]);
  }
  // A scatterer on the border of a cell may fall on either side of it.
  EXPECT_LT(std::sqrt(difference / square), 0.01);
  EXPECT_GT(square, 0);
}

/// Correlation of the grey values of the moved image with those of the image at rest. \p from maps
/// a position in the moved image (mm, image plane) to its position in the image at rest.
template <class Map>
double correlation(const UltrasoundImage& moved, const UltrasoundImage& rest, const Map& from) {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
  for (int row = 0; row < moved.pixels.height(); ++row) {
    for (int column = 0; column < moved.pixels.width(); ++column) {
      const Point<Image> p = moved.grid.at(column, row);
      if (p.mm.y() < 35 || p.mm.y() > 85 || std::abs(p.mm.x()) > 20) continue;
      const Eigen::Vector2d pixel = moved.grid.pixel_of(from(p));
      const int c = static_cast<int>(std::lround(pixel.x()));
      const int r = static_cast<int>(std::lround(pixel.y()));
      if (c < 0 || r < 0 || c >= rest.pixels.width() || r >= rest.pixels.height()) continue;
      const double x = moved.pixels.at(column, row);
      const double y = rest.pixels.at(c, r);
      n += 1, a += x, b += y, aa += x * x, bb += y * y, ab += x * y;
    }
  }
  return (n * ab - a * b) / std::sqrt((n * aa - a * a) * (n * bb - b * b));
}

TEST_P(MovingSpeckleTest, SpeckleMovesWithItsTissue) {
  const auto warp = SmoothWarp::create({{{0, 60, 0}, {50, 50, 50}, {2, 6, 0}}});
  ASSERT_TRUE(warp.has_value());
  const AffineWarp shift = AffineWarp::rigid(Vec::Zero(), Vec::Zero(), {2, 6, 0});
  const Pose pose(Eigen::Quaterniond::Identity(), Vec::Zero());  // The motion stays within the
                                                                 // image plane.
  const auto rest = simulator().simulate(pose, {}, 0);
  const auto moved = simulator().simulate(pose, {}, 0, {}, &*warp);
  const auto shifted = simulator().simulate(pose, {}, 0, {}, &shift);
  const auto by = [](const Warp& w) {
    return [&w](const Point<Image>& p) { return Point<Image>{w.invert(p.mm)}; };
  };
  const RestView view =
      rest_view(*warp, pose, moved.grid, moved.pixels.width(), moved.pixels.height());
  const auto nearest_rigid = [&](const Point<Image>& p) {
    return Point<Image>{(view.ct_from_image * p).mm};
  };
  // Correlation that remains after a pure shift, where beams of another direction meet the tissue.
  const double best = correlation(shifted, rest, by(shift));
  EXPECT_GT(correlation(moved, rest, by(*warp)), 0.7 * best);
  EXPECT_LT(correlation(moved, rest, nearest_rigid), 0.5 * best);
}

INSTANTIATE_TEST_SUITE_P(Models, MovingSpeckleTest,
                         testing::Values(AcousticModel::kRays, AcousticModel::kScatterers));

}  // namespace
}  // namespace nav::sim
