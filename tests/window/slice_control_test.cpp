// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/slice_control.hpp"

#include <gtest/gtest.h>

#include "app/window/flat_widget.hpp"
#include "app/window/theme.hpp"
#include "tests/window/moments.hpp"

namespace nav::app {
namespace {

using Kind = SliceInput::Kind;

constexpr double kMm = 1e-9;

class SliceControlTest : public ::testing::Test {
 protected:
  SliceControlTest() {
    VoxelGrid grid;
    grid.size = {101, 101, 51};
    grid.spacing_mm = {1, 1, 2};
    moment_->ct = std::make_shared<const Volume>(
        *Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 0), "empty"));
  }
  /// The image that the user sees after the inputs so far.
  [[nodiscard]] ViewImage seen(ViewId id) const {
    ViewImage view_image = test::view_image_of(moment_);
    const PanelContext context = context_of(*moment_);
    view_image.cursor = cursor_of(control_.settings(), *moment_);
    view_image.slice = slice_geometry(context, {.kind = *slice_of(id),
                                                .size = {300, 200},
                                                .cursor = view_image.cursor,
                                                .zoom = control_.settings().zoom[id]});
    return view_image;
  }
  bool apply(ViewId id, const SliceInput& input) { return control_.apply(id, input, seen(id)); }

  std::shared_ptr<Moment> moment_ = test::valid_moment(1, test::kStart);
  SliceControl control_;
};

TEST_F(SliceControlTest, OneCursorMovesAllSlices) {
  const Point<frames::Ct> there{{20, 30, 40}};
  const Eigen::Vector2d at = seen(ViewId::kAxial).slice->pixel_of(there).head<2>();
  ASSERT_TRUE(apply(ViewId::kAxial, {.kind = Kind::kCursor, .at = at}));
  const Eigen::Vector3d cursor = control_.settings().cursor->mm;
  EXPECT_NEAR(cursor.x(), 20, kMm);
  EXPECT_NEAR(cursor.y(), 30, kMm);
  EXPECT_NEAR(cursor.z(), 50, kMm) << "the axial slice keeps its height";
  EXPECT_NEAR(seen(ViewId::kSagittal).slice->plane.centre_ct.mm.x(), 20, kMm);
  EXPECT_NEAR(seen(ViewId::kCoronal).slice->plane.centre_ct.mm.y(), 30, kMm);
}

TEST_F(SliceControlTest, TheCursorStaysInTheCt) {
  ASSERT_TRUE(apply(ViewId::kAxial, {.kind = Kind::kCursor, .at = {-1e6, 1e6}}));
  EXPECT_EQ(control_.settings().cursor->mm, Eigen::Vector3d(0, 100, 50));
}

TEST_F(SliceControlTest, TheBeginningIsTheTarget) {
  moment_->plan = NeedlePlan{{{0, 0, 0}}, {{10, 20, 30}}, 5, 0};
  EXPECT_EQ(cursor_of({}, *moment_).mm, Eigen::Vector3d(10, 20, 30));
}

TEST_F(SliceControlTest, ZoomKeepsThePointUnderTheMouse) {
  const Eigen::Vector2d at(220, 50);
  const Eigen::Vector3d before = seen(ViewId::kCoronal).slice->point_at(at).mm;
  ASSERT_TRUE(apply(ViewId::kCoronal, {.kind = Kind::kZoom, .at = at, .amount = 3}));
  const ViewImage after = seen(ViewId::kCoronal);
  EXPECT_NEAR((after.slice->point_at(at).mm - before).norm(), 0, 1e-6);
  EXPECT_EQ(control_.settings().zoom[ViewId::kCoronal].factor, 3);
  EXPECT_EQ(control_.settings().zoom[ViewId::kAxial].factor, 1) << "each view has its own";
}

TEST_F(SliceControlTest, ADragMovesTheImageWithTheMouse) {
  const Eigen::Vector3d before = seen(ViewId::kSagittal).slice->point_at({100, 100}).mm;
  ASSERT_TRUE(apply(ViewId::kSagittal, {.kind = Kind::kPan, .drag = {40, -25}}));
  EXPECT_NEAR((seen(ViewId::kSagittal).slice->point_at({140, 75}).mm - before).norm(), 0, 1e-6);
}

TEST_F(SliceControlTest, WindowAndResetAreTheSameForAllSlices) {
  moment_->window = {40, 400};
  ASSERT_TRUE(apply(ViewId::kAxial, {.kind = Kind::kWindow, .drag = {0, 0.25}}));
  EXPECT_EQ(control_.settings().window->level, -60);
  const std::uint64_t changes = control_.number();
  control_.reset();
  EXPECT_GT(control_.number(), changes);
  EXPECT_FALSE(control_.settings().window || control_.settings().cursor);
}

TEST_F(SliceControlTest, AViewWithoutAPositionInTheCtSetsNoCursor) {
  ViewImage view_image = test::view_image_of(moment_);
  EXPECT_FALSE(control_.apply(ViewId::kUltrasound, {.kind = Kind::kCursor}, view_image));
  EXPECT_FALSE(control_.apply(ViewId::kBullsEye, {.kind = Kind::kCursor}, view_image));
  EXPECT_FALSE(control_.apply(ViewId::kAxial, {.kind = Kind::kCursor}, view_image)) << "not drawn";
  EXPECT_EQ(control_.number(), 0U);
}

TEST(SliceColourTest, NoStateHasTheColourOfASlice) {
  for (const ViewId id : {ViewId::kAxial, ViewId::kCoronal, ViewId::kSagittal}) {
    for (const SafetyState state :
         {SafetyState::kValid, SafetyState::kDegraded, SafetyState::kStale, SafetyState::kLost}) {
      EXPECT_NE(*slice_colour(id), theme::colour_of_state(state).rgb());
    }
  }
  EXPECT_FALSE(slice_colour(ViewId::kUltrasound));
}

TEST_F(SliceControlTest, ByEyeThePlaneFollowsTheMouseInSlices) {
  ViewImage view_image = seen(ViewId::kAxial);
  view_image.image = QImage(300, 200, QImage::Format_RGB32);
  const double mm_per_px = view_image.slice->mm_per_px;
  const auto shift = eye_movement(ViewId::kAxial, view_image, {100, 100}, {110, 95}, false);
  ASSERT_TRUE(shift);
  // Axial: right on the screen is the patient's left (+x), down is posterior (+y). The CT goes the
  // other way.
  EXPECT_NEAR(shift->shift_mm.x(), -10 * mm_per_px, kMm);
  EXPECT_NEAR(shift->shift_mm.y(), 5 * mm_per_px, kMm);
  EXPECT_EQ(shift->turn_rad.norm(), 0);
  const auto turn = eye_movement(ViewId::kAxial, view_image, {250, 100}, {150, 200}, true);
  ASSERT_TRUE(turn);
  EXPECT_NEAR(turn->turn_rad.norm(), M_PI / 2, 1e-9) << "a quarter about the middle";
  EXPECT_EQ(turn->shift_mm.norm(), 0);
  EXPECT_FALSE(
      eye_movement(ViewId::kUltrasound, test::view_image_of(moment_), {0, 0}, {1, 1}, false))
      << "no placed image is shown";
}

}  // namespace
}  // namespace nav::app
