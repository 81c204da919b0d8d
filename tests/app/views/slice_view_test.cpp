// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/slice_view.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "app/views/bulls_eye.hpp"
#include "app/views/plane_overlays.hpp"

namespace nav::app {
namespace {

using Vec3 = Eigen::Vector3d;

constexpr double kMm = 1e-9;  // Rounding of positions.

/// A CT of 60 x 40 x 30 mm whose values tell the position: left half dark, upper half bright.
Volume stepped_ct() {
  VoxelGrid grid;
  grid.size = {31, 21, 11};
  grid.spacing_mm = {2, 2, 3};
  grid.origin_mm = {-30, -20, -15};
  std::vector<std::int16_t> hu;
  for (int k = 0; k < 11; ++k) {
    for (int j = 0; j < 21; ++j) {
      for (int i = 0; i < 31; ++i) {
        hu.push_back(static_cast<std::int16_t>(10 * i + 100 * (k > 5 ? 1 : 0)));
      }
    }
  }
  return *Volume::create(grid, std::move(hu), "steps");
}

class SliceViewTest : public ::testing::Test {
 protected:
  [[nodiscard]] PanelContext context() const {
    return {.epoch = epoch_,
            .ct = ct_,
            .plan = plan_,
            .window = {150, 400},
            .banner = banner_,
            .needle_length_mm = 100};
  }
  /// A live image of 20 x 20 mm across the patient, in the plane x = 0.
  void add_plane(SafetyState state) {
    UltrasoundImage frame;
    frame.pixels = Image2d<std::uint8_t>(21, 21, std::vector<std::uint8_t>(21 * 21, 90));
    frame.grid = PixelGrid::centred(21, 1, 1);
    epoch_.frame =
        TrackedImage{.frame = frame,
                     .reference_from_image = {Eigen::Quaterniond::Identity(), Vec3::Zero()},
                     .pose_gap = Duration::zero()};
    Eigen::Matrix3d axes;  // Columns of the image to the back, rows to the feet.
    axes << Vec3::UnitY(), -Vec3::UnitZ(), -Vec3::UnitX();
    epoch_.ct_from_image.emplace(Eigen::Quaterniond(axes), Vec3(0, 0, 10));
    epoch_.plane = {state, state == SafetyState::kValid ? "" : "planted"};
  }
  static std::vector<Rgba8> pixels_of(const Image2d<Rgba8>& image) {
    return {image.pixels().begin(), image.pixels().end()};
  }
  static int count(const Image2d<Rgba8>& image, Rgba8 colour) {
    return static_cast<int>(std::count(image.pixels().begin(), image.pixels().end(), colour));
  }

  session::Epoch epoch_;
  std::optional<NeedlePlan> plan_;
  std::string banner_;
  Volume ct_ = stepped_ct();
};

TEST_F(SliceViewTest, AWholeOrthogonalSliceFitsAndGoesThroughTheCursor) {
  for (const SliceKind kind : {SliceKind::kAxial, SliceKind::kCoronal, SliceKind::kSagittal}) {
    const SliceRequest request{.kind = kind, .size = {300, 200}, .cursor = {{7, -5, 4}}};
    const auto geometry = slice_geometry(context(), request);
    ASSERT_TRUE(geometry);
    const Vec3 cursor = geometry->pixel_of(request.cursor);
    EXPECT_NEAR(cursor.z(), 0, kMm) << "the cursor lies in the slice";
    EXPECT_NEAR((geometry->point_at(cursor.head<2>()).mm - request.cursor.mm).norm(), 0, kMm);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 index(corner & 1 ? 30 : 0, corner & 2 ? 20 : 0, corner & 4 ? 10 : 0);
      const Vec3 p = geometry->pixel_of(ct_.grid().at(index));
      EXPECT_TRUE(p.x() > 0 && p.x() < 299 && p.y() > 0 && p.y() < 199) << p.transpose();
    }
  }
}

TEST_F(SliceViewTest, ThePatientsRightIsAtTheLeftAndTheHeadIsUp) {
  const SliceRequest axial{.kind = SliceKind::kAxial, .size = {300, 200}};
  const auto at = [&](const SliceRequest& request, const Vec3& mm) {
    return slice_geometry(context(), request)->pixel_of({mm});
  };
  EXPECT_LT(at(axial, {-10, 0, 0}).x(), at(axial, {10, 0, 0}).x());
  EXPECT_LT(at(axial, {0, -10, 0}).y(), at(axial, {0, 10, 0}).y()) << "anterior is up";
  const SliceRequest coronal{.kind = SliceKind::kCoronal, .size = {300, 200}};
  EXPECT_LT(at(coronal, {-10, 0, 0}).x(), at(coronal, {10, 0, 0}).x());
  EXPECT_LT(at(coronal, {0, 0, 10}).y(), at(coronal, {0, 0, -10}).y());
  const SliceRequest sagittal{.kind = SliceKind::kSagittal, .size = {300, 200}};
  EXPECT_LT(at(sagittal, {0, -10, 0}).x(), at(sagittal, {0, 10, 0}).x()) << "nose left";
  SliceDrawer drawer;
  const Image2d<Rgba8> image = drawer.draw(context(), axial).image;
  EXPECT_LT(image.at(60, 100).r, image.at(240, 100).r) << "values grow to the patient's left";
}

TEST_F(SliceViewTest, StepsGoThroughVoxelsAndStayInTheCt) {
  const Point<frames::Ct> middle{{0, 0, 0}};
  EXPECT_EQ(stepped(ct_.grid(), SliceKind::kAxial, middle, 1).mm, Vec3(0, 0, 3));
  EXPECT_EQ(stepped(ct_.grid(), SliceKind::kCoronal, middle, 2).mm, Vec3(0, -4, 0));
  EXPECT_EQ(stepped(ct_.grid(), SliceKind::kSagittal, middle, -1).mm, Vec3(2, 0, 0));
  EXPECT_EQ(stepped(ct_.grid(), SliceKind::kAxial, middle, 1000).mm, Vec3(0, 0, 15));
  EXPECT_EQ(stepped(ct_.grid(), SliceKind::kAxial, middle, -1000).mm, Vec3(0, 0, -15));
}

TEST_F(SliceViewTest, TheTraceLiesWhereThePlaneCutsTheSlice) {
  add_plane(SafetyState::kValid);
  const SliceRequest request{.kind = SliceKind::kAxial, .size = {310, 210}, .cursor = {{0, 0, 5}}};
  const auto geometry = slice_geometry(context(), request);
  const auto trace = trace_of(epoch_.frame->frame, *epoch_.ct_from_image, *geometry);
  ASSERT_TRUE(trace);
  for (const Eigen::Vector2d& end : {trace->first, trace->second}) {
    const Vec3 mm = geometry->point_at(end).mm;
    EXPECT_NEAR(mm.x(), 0, kMm);
    EXPECT_NEAR(std::abs(mm.y()), 10, kMm) << "the image is 20 mm wide";
  }
  const SliceRequest above{.kind = SliceKind::kAxial, .size = {310, 210}, .cursor = {{0, 0, 12}}};
  EXPECT_FALSE(
      trace_of(epoch_.frame->frame, *epoch_.ct_from_image, *slice_geometry(context(), above)))
      << "the image begins at z = 10 mm";
}

TEST_F(SliceViewTest, TheTraceHasTheColourOfItsStateAndIsWithdrawnWhenStale) {
  const SliceRequest request{.kind = SliceKind::kAxial, .size = {310, 210}};
  SliceDrawer drawer;
  const auto without = drawer.draw(context(), request).image;
  for (const SafetyState state : {SafetyState::kValid, SafetyState::kDegraded}) {
    add_plane(state);
    const auto with = drawer.draw(context(), request).image;
    EXPECT_GT(count(with, colour_of(state)), 50) << to_string(state);
  }
  for (const SafetyState state : {SafetyState::kStale, SafetyState::kLost}) {
    add_plane(state);
    EXPECT_EQ(pixels_of(drawer.draw(context(), request).image), pixels_of(without))
        << to_string(state);
  }
  EXPECT_EQ(drawer.sampled(), 1) << "the CT slice is kept while only the plane moves";
}

TEST_F(SliceViewTest, AnotherCtOrWindowIsNeverShownFromMemory) {
  const SliceRequest request{.kind = SliceKind::kAxial, .size = {60, 40}};
  SliceDrawer drawer;
  const auto first = drawer.draw(context(), request).image;
  PanelContext brighter = context();
  brighter.window = {0, 400};
  EXPECT_NE(pixels_of(drawer.draw(brighter, request).image), pixels_of(first));
  const Volume empty =
      *Volume::create(ct_.grid(), std::vector<std::int16_t>(ct_.values().size(), 0), "empty");
  const PanelContext other{
      .epoch = epoch_, .ct = empty, .plan = plan_, .window = {150, 400}, .banner = banner_};
  EXPECT_NE(pixels_of(drawer.draw(other, request).image), pixels_of(first));
  EXPECT_EQ(drawer.sampled(), 3);
}

TEST_F(SliceViewTest, NeedleSlicesNeedANeedle) {
  SliceDrawer drawer;
  const SliceRequest request{.kind = SliceKind::kNeedleFirst, .size = {200, 200}};
  EXPECT_FALSE(drawer.draw(context(), request).geometry);
  epoch_.ct_from_needle.emplace(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), Vec3(1, 1, -1)),
                                Vec3(3, 2, 1));
  epoch_.needle = {SafetyState::kValid, ""};
  for (const SliceKind kind : {SliceKind::kNeedleFirst, SliceKind::kNeedleSecond}) {
    const auto geometry = slice_geometry(context(), {.kind = kind, .size = {200, 200}});
    ASSERT_TRUE(geometry);
    for (const double along : {0.0, -50.0}) {
      const Vec3 p =
          geometry->pixel_of(*epoch_.ct_from_needle * Point<frames::Needle>{{0, 0, along}});
      EXPECT_NEAR(p.z(), 0, kMm) << "the shaft lies in the slice";
      EXPECT_NEAR(p.x(), 99.5, 1e-6) << "and points down";
    }
  }
  epoch_.needle = {SafetyState::kStale, "old"};
  EXPECT_FALSE(drawer.draw(context(), request).geometry);
}

TEST_F(SliceViewTest, ABullsEyeIsWithdrawnWithTheNumbers) {
  plan_ = NeedlePlan{{{0, -40, 0}}, {{0, 0, 0}}, 5, 0};
  // The tip is 12 mm to the patient's left of the path, and points along it.
  epoch_.ct_from_needle.emplace(Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), Vec3::UnitY()),
                                Vec3(12, -20, 0));
  epoch_.needle = {SafetyState::kValid, ""};
  EXPECT_FALSE(draw_bulls_eye(context(), {200, 200}, 1).geometry);
  epoch_.guidance = guide(*plan_, *epoch_.ct_from_needle);
  const SliceDrawing drawing = draw_bulls_eye(context(), {200, 200}, 1);
  ASSERT_TRUE(drawing.geometry);
  const Vec3 target = drawing.geometry->pixel_of(plan_->target_ct);
  const Vec3 tip = drawing.geometry->pixel_of({{12, -20, 0}});
  EXPECT_NEAR(target.x(), 99.5, 1e-6);
  EXPECT_NEAR(target.y(), 99.5, 1e-6);
  EXPECT_NEAR((tip.x() - target.x()) * drawing.geometry->mm_per_px, 12, 1e-6)
      << "as in a coronal slice: the patient's left is right";
  EXPECT_GT(count(drawing.image, kNeedleColour), 10);
}

TEST(DraggedWindowTest, RightIsWiderAndUpIsBrighter) {
  const render::HuWindow window{40, 400};
  EXPECT_GT(dragged_window(window, {0.1, 0}).width, 400);
  EXPECT_EQ(dragged_window(window, {0.1, 0}).level, 40);
  EXPECT_EQ(dragged_window(window, {0, 0.25}).level, -60);
  EXPECT_GE(dragged_window(window, {-1e9, 1e9}).width, 1) << "never zero";
}

TEST_F(SliceViewTest, ThePlannedPathIsSolidInItsSliceAndDashedElsewhere) {
  // Pixels that are blue on the grey of the CT, also those at the border of a line.
  const auto blue = [&] {
    const SliceRequest request{
        .kind = SliceKind::kAxial, .size = {300, 200}, .cursor = {{0, 0, 0}}};
    const auto image = SliceDrawer().draw(context(), request).image;
    return std::ranges::count_if(image.pixels(), [](Rgba8 p) { return p.b > p.r + 60; });
  };
  EXPECT_EQ(blue(), 0);
  plan_ = NeedlePlan{{{-20, 0, 0}}, {{20, 0, 0}}, 2, 0};
  const auto solid = blue();
  EXPECT_GT(solid, 150) << "40 mm at about 4.5 pixels each";
  plan_ = NeedlePlan{{{-20, 0, 9}}, {{20, 0, 9}}, 2, 0};
  const auto dashed = blue();
  EXPECT_GT(dashed, 40);
  EXPECT_LT(static_cast<double>(dashed), 0.8 * static_cast<double>(solid))
      << "9 mm beside the slice";
}

TEST_F(SliceViewTest, TheDotStandsAtTheMarkedSideOnly) {
  add_plane(SafetyState::kValid);
  const UltrasoundImage& frame = epoch_.frame->frame;
  EXPECT_EQ(marked_corner(frame).mm.x(), frame.grid.at(20, 0).mm.x()) << "the last column";
  EXPECT_EQ(marked_corner(frame).mm.y(), frame.grid.at(20, 0).mm.y()) << "the transducer's face";
  render::Canvas canvas(200, 200, render::rgb8(0));
  draw_depth_marks(canvas, fit(frame, 0, 0, 200, 200), frame, 12);
  int left = 0;
  int right = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      if (canvas.image().at(x, y) == kNeedleColour) ++(x < 100 ? left : right);
    }
  }
  EXPECT_EQ(left, 0);
  EXPECT_GT(right, 10);
}

}  // namespace
}  // namespace nav::app
