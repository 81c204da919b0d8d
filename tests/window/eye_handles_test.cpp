// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/eye_handles.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/window/moments.hpp"

namespace nav::app {
namespace {

constexpr int kColumns = 640;
constexpr int kRows = 400;
constexpr double kPixel = 1e-6;

/// A plane of 40 x 30 mm, seen obliquely.
class EyeHandles3dTest : public ::testing::Test {
 protected:
  EyeHandles3dTest() {
    UltrasoundImage image;
    image.pixels = Image2d<std::uint8_t>(41, 31, std::vector<std::uint8_t>(std::size_t{41} * 31));
    image.grid = PixelGrid::centred(41, 1, 1);
    const auto placed = Transform<frames::Ct, frames::Image>(
        Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized())),
        {12, -30, 55});
    moment_->epoch.frame =
        TrackedImage{std::move(image),
                     Transform<frames::Reference, frames::Image>(Eigen::Quaterniond::Identity(),
                                                                 Eigen::Vector3d::Zero()),
                     Duration(0)};
    moment_->epoch.ct_from_image = placed;
    seen_.camera = {.eye_ct = {{200, -250, 90}},
                    .look_at_ct = {{5, -20, 50}},
                    .up_ct = {{0.1, 0.2, 1}},
                    .vertical_fov_rad = 0.6};
    seen_.image = QImage(kColumns, kRows, QImage::Format_RGB32);
    seen_.moment = moment_;
  }
  /// Centre of the plane in the CT.
  [[nodiscard]] Eigen::Vector3d centre() const {
    return (*moment_->epoch.ct_from_image * Point<frames::Image>{{0, 15, 0}}).mm;
  }
  /// Pixel of a point, by a pinhole camera that is written for this test.
  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector3d& point) const {
    const render::Camera& camera = seen_.camera;
    const Eigen::Vector3d z = (camera.eye_ct.mm - camera.look_at_ct.mm).normalized();
    const Eigen::Vector3d x = camera.up_ct.v.cross(z).normalized();
    const Eigen::Vector3d y = z.cross(x);
    const Eigen::Vector3d p = point - camera.eye_ct.mm;
    const double scale = camera.orthographic
                             ? kRows / camera.orthographic_height_mm
                             : kRows / (2 * std::tan(camera.vertical_fov_rad / 2)) / -p.dot(z);
    return {kColumns / 2.0 + scale * p.dot(x), kRows / 2.0 - scale * p.dot(y)};
  }
  /// Position of a point of the plane after the CT has moved: the plane moves the other way.
  static Eigen::Vector3d after(const EyeMovement& movement, const Eigen::Vector3d& point) {
    const double angle = movement.turn_rad.norm();
    Eigen::Vector3d turned = point;
    if (angle > 0) {
      const Eigen::AngleAxisd turn(-angle, movement.turn_rad / angle);
      turned = turn * (point - movement.about.mm) + movement.about.mm;
    }
    return turned - movement.shift_mm;
  }

  std::shared_ptr<Moment> moment_ = test::valid_moment(1, test::kStart);
  ViewImage seen_;
};

TEST_F(EyeHandles3dTest, ThePlaneFollowsTheMouse) {
  for (const bool orthographic : {false, true}) {
    seen_.camera.orthographic = orthographic;
    const auto shift = eye_movement_3d(seen_, {300, 200}, {331, 188}, false);
    ASSERT_TRUE(shift);
    const Eigen::Vector2d way = pixel_of(after(*shift, centre())) - pixel_of(centre());
    EXPECT_NEAR(way.x(), 31, kPixel);
    EXPECT_NEAR(way.y(), -12, kPixel);
    EXPECT_EQ(shift->turn_rad.norm(), 0);
  }
}

TEST_F(EyeHandles3dTest, ThePlaneTurnsWithTheMouseAboutTheMiddle) {
  const Eigen::Vector2d middle(kColumns / 2.0, kRows / 2.0);
  const double angle = 0.3;
  const Eigen::Vector2d from = middle + Eigen::Vector2d(150, 0);
  const Eigen::Vector2d to = middle + 150 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  const auto turn = eye_movement_3d(seen_, from, to, true);
  ASSERT_TRUE(turn);
  const Eigen::Vector2d before = pixel_of(centre()) - middle;
  const Eigen::Vector2d now = pixel_of(after(*turn, centre())) - middle;
  const Eigen::Vector2d expected = Eigen::Rotation2Dd(angle) * before;
  EXPECT_NEAR(now.x(), expected.x(), kPixel);
  EXPECT_NEAR(now.y(), expected.y(), kPixel);
}

TEST_F(EyeHandles3dTest, WithoutAPlaneOnTheScreenNothingMoves) {
  moment_->epoch.plane.state = SafetyState::kStale;
  EXPECT_FALSE(eye_movement_3d(seen_, {0, 0}, {10, 10}, false)) << "the plane is withdrawn";
  moment_->epoch.plane.state = SafetyState::kDegraded;
  EXPECT_TRUE(eye_movement_3d(seen_, {0, 0}, {10, 10}, false));
  seen_.camera.eye_ct.mm = seen_.camera.look_at_ct.mm + 0.01 * Eigen::Vector3d::UnitX();
  seen_.camera.look_at_ct.mm = seen_.camera.eye_ct.mm + (seen_.camera.eye_ct.mm - centre());
  EXPECT_FALSE(eye_movement_3d(seen_, {0, 0}, {10, 10}, false)) << "the plane is behind the eye";
  moment_->epoch.ct_from_image.reset();
  EXPECT_FALSE(eye_movement_3d(seen_, {0, 0}, {10, 10}, true)) << "no plane is placed";
}

TEST(EyeHandlesTest, ADragBeginsAndEndsOnce) {
  EyeHandles handles;
  int open = 0;
  handles.dragged = [&](bool begins) { open += begins ? 1 : -1; };
  EXPECT_TRUE(handles.set_on(true));
  EXPECT_FALSE(handles.set_on(true)) << "it is on";
  handles.begin({210, 200}, {400, 400});
  EXPECT_EQ(handles.drag(), EyeHandles::Drag::kShift) << "inside of the ring";
  EXPECT_EQ(open, 1);
  EXPECT_TRUE(handles.end());
  EXPECT_FALSE(handles.end());
  handles.begin({10, 10}, {400, 400});
  EXPECT_EQ(handles.drag(), EyeHandles::Drag::kTurn) << "outside";
  EXPECT_TRUE(handles.set_on(false));
  EXPECT_EQ(handles.drag(), EyeHandles::Drag::kNone);
  EXPECT_EQ(open, 0) << "the drag has ended with the handles";
}

}  // namespace
}  // namespace nav::app
