// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/transform_tree.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/support/matchers.hpp"

namespace nav::io {
namespace {

using test::rejects;
using Code = ErrorCode;

constexpr double kRounding = 1e-12;

Eigen::Matrix4d rigid(double angle, const Eigen::Vector3d& axis, const Eigen::Vector3d& mm) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  m.topRightCorner<3, 1>() = mm;
  return m;
}

const Eigen::Matrix4d kTrackerFromProbe = rigid(0.7, {1, 2, 3}, {10, 20, 30});
const Eigen::Matrix4d kTrackerFromReference = rigid(-1.2, {3, -1, 2}, {-5, 6, 7});

Eigen::Matrix4d probe_from_image() {
  Eigen::Matrix4d m = rigid(0.3, {0, 1, 1}, {1, 2, 3});
  m.topLeftCorner<3, 3>() *= Eigen::Vector3d(0.1, 0.2, 0.15).asDiagonal();
  return m;
}

SequenceImage frame(TrackingStatus probe = TrackingStatus::kOk) {
  SequenceImage f;
  f.index = 3;
  set_transform(f, {"ProbeToTracker", kTrackerFromProbe, probe});
  set_transform(f, {"ReferenceToTracker", kTrackerFromReference, TrackingStatus::kOk});
  return f;
}

TransformTree tree() {
  auto t = TransformTree::create(
      {"ProbeToTracker", "ReferenceToTracker", "Odd"},
      {{.from = "Image", .to = "Probe", .to_from_from = probe_from_image()},
       {.from = "Phantom", .to = "Wire", .to_from_from = Eigen::Matrix4d::Identity()}});
  return std::move(t).value();
}

TEST(SplitTransformNameTest, SplitsNamesOnlyIfThereIsOneWay) {
  using Pair = std::pair<std::string, std::string>;
  EXPECT_EQ(split_transform_name("ProbeToTracker"), (Pair{"Probe", "Tracker"}));
  EXPECT_EQ(split_transform_name("StylusTipToStylus"), (Pair{"StylusTip", "Stylus"}));
  EXPECT_EQ(split_transform_name("ToolToTracker"), (Pair{"Tool", "Tracker"}));
  EXPECT_EQ(split_transform_name("ImageToTorso"), (Pair{"Image", "Torso"}));
  EXPECT_EQ(split_transform_name("Image"), std::nullopt);
  EXPECT_EQ(split_transform_name("ProbeTo"), std::nullopt);
  EXPECT_EQ(split_transform_name("ToTracker"), std::nullopt);
  EXPECT_EQ(split_transform_name("Bottom"), std::nullopt);
  EXPECT_EQ(split_transform_name("AToBToC"), std::nullopt);
}

TEST(TransformTreeTest, ChainsForwardAndBackward) {
  const auto chain = tree().find("Image", "Reference");
  ASSERT_TRUE(test::has_value(chain));
  ASSERT_EQ(chain->links.size(), 3U);
  EXPECT_EQ(chain->links[0].name, "ImageToProbe");
  EXPECT_FALSE(chain->links[0].from_frame);
  EXPECT_EQ(chain->links[1].name, "ProbeToTracker");
  EXPECT_FALSE(chain->links[1].inverted);
  EXPECT_EQ(chain->links[2].name, "ReferenceToTracker");
  EXPECT_TRUE(chain->links[2].inverted);
  const auto there = chain->evaluate(frame());
  ASSERT_TRUE(test::has_value(there));
  const Eigen::Matrix4d expected =
      kTrackerFromReference.inverse() * kTrackerFromProbe * probe_from_image();
  EXPECT_LT((there->to_from_from - expected).norm(), kRounding * 100);
  EXPECT_EQ(there->name, "ImageToReference");
  EXPECT_EQ(there->status, TrackingStatus::kOk);
  const auto back = tree().find("Reference", "Image")->evaluate(frame());
  ASSERT_TRUE(test::has_value(back));
  EXPECT_LT((back->to_from_from * expected - Eigen::Matrix4d::Identity()).norm(), 1e-9);
  const auto self = tree().find("Probe", "Probe");
  ASSERT_TRUE(test::has_value(self));
  EXPECT_TRUE(self->links.empty());
}

TEST(TransformTreeTest, TheWorstStatusWins) {
  const auto chain = tree().find("Image", "Reference");
  ASSERT_TRUE(test::has_value(chain));
  EXPECT_EQ(chain->evaluate(frame(TrackingStatus::kUnknown))->status, TrackingStatus::kUnknown);
  EXPECT_EQ(chain->evaluate(frame(TrackingStatus::kOccluded))->status, TrackingStatus::kOccluded);
  // A NaN pose whose status is not OK keeps its status and does not fail.
  SequenceImage lost = frame();
  lost.fields["ReferenceToTrackerTransform"] = "nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  lost.fields["ReferenceToTrackerTransformStatus"] = "MISSING";
  const auto t = chain->evaluate(lost);
  ASSERT_TRUE(test::has_value(t));
  EXPECT_EQ(t->status, TrackingStatus::kOccluded);
  EXPECT_TRUE(std::isnan(t->to_from_from(0, 0)));
}

TEST(TransformTreeTest, FindsATipOfAFrameThatIsTakenAsTheTip) {
  const auto with_tip = [](double mm) {
    auto made = TransformTree::create(
        {"NeedleToTracker"},
        {{.from = "NeedleTip", .to = "Needle", .to_from_from = rigid(0, {1, 0, 0}, {0, 0, mm})}});
    return std::move(made).value();
  };
  const auto found = other_tip(with_tip(150), "Needle", {});
  ASSERT_TRUE(found);
  EXPECT_EQ(sentence_of(*found),
            "needle: tip (--needle-frame): the origin of Needle is taken as the tip against "
            "NeedleTip lies 150 mm from Needle; used: Needle; if it is the hub, name NeedleTip");
  EXPECT_FALSE(other_tip(with_tip(150), "NeedleTip", {}));
  EXPECT_FALSE(other_tip(with_tip(1), "Needle", {}));
  EXPECT_FALSE(other_tip(tree(), "Probe", {}));
}

TEST(TransformTreeTest, NamesTheMissingLinkAndTheKnownTransforms) {
  EXPECT_TRUE(rejects(tree().find("Image", "Phantom"), Code::kNotFound,
                      {"from Image to Phantom", "Probe→Tracker (frames)",
                       "Image→Probe (configuration)", "Phantom→Wire (configuration)"}));
  EXPECT_TRUE(rejects(tree().find("Image", "Ct"), Code::kNotFound, {"from Image to Ct"}));
  EXPECT_TRUE(
      rejects(TransformTree::create({}, {})->find("A", "B"), Code::kNotFound, {"known: nothing"}));
  SequenceImage bare;
  bare.index = 9;
  const auto chain = tree().find("Image", "Reference");
  EXPECT_TRUE(rejects(chain->evaluate(bare), Code::kNotFound, {"frame 9", "ProbeToTracker"}));
  SequenceImage flat = frame();
  set_transform(flat, {"ReferenceToTracker", Eigen::Matrix4d::Zero(), TrackingStatus::kOk});
  EXPECT_TRUE(rejects(chain->evaluate(flat), Code::kMalformedData,
                      {"frame 3", "ReferenceToTrackerTransform", "inverted"}));
  EXPECT_TRUE(rejects(TransformTree::create(
                          {}, {{.from = "A", .to = "B", .to_from_from = Eigen::Matrix4d::Zero()}}),
                      Code::kMalformedData, {"AToB", "inverted"}));
}

/// Returns the matrix as a program that prints four decimals writes it.
Eigen::Matrix4d in_four_decimals(const Eigen::Matrix4d& m) {
  return (m * 1e4).array().round().matrix() * 1e-4;
}

TEST(TransformTreeTest, RejectsAPoseThatContradictsItsInverse) {
  const auto t =
      TransformTree::create({"ProbeToTracker", "ReferenceToTracker", "TrackerToProbe"}, {});
  const auto chain = t->find("Probe", "Reference");
  ASSERT_TRUE(test::has_value(chain));
  const Eigen::Matrix4d expected = kTrackerFromReference.inverse() * kTrackerFromProbe;
  const auto with = [](const Eigen::Matrix4d& probe_from_tracker,
                       TrackingStatus status = TrackingStatus::kOk) {
    SequenceImage f = frame();
    set_transform(f, {"TrackerToProbe", probe_from_tracker, status});
    return f;
  };
  const Eigen::Matrix4d probe_from_tracker = kTrackerFromProbe.inverse();
  for (const Eigen::Matrix4d& same : {probe_from_tracker, in_four_decimals(probe_from_tracker)}) {
    const auto there = chain->evaluate(with(same));
    ASSERT_TRUE(test::has_value(there));
    EXPECT_LT((there->to_from_from - expected).norm(), kRounding * 100);
  }
  Eigen::Matrix4d moved = probe_from_tracker;
  moved(0, 3) += 0.1;  // mm
  // The most frequent mistake is that both directions have the same numbers.
  for (const Eigen::Matrix4d& other : {moved, kTrackerFromProbe}) {
    EXPECT_TRUE(rejects(chain->evaluate(with(other)), Code::kMalformedData,
                        {"frame 3", "ProbeToTracker", "TrackerToProbe", "inverse"}));
  }
  // A pose whose status is not OK contradicts nothing.
  EXPECT_TRUE(test::has_value(chain->evaluate(with(moved, TrackingStatus::kOccluded))));
  EXPECT_TRUE(rejects(
      TransformTree::create({}, {{.from = "A", .to = "B", .to_from_from = kTrackerFromProbe},
                                 {.from = "B", .to = "A", .to_from_from = moved}}),
      Code::kMalformedData, {"configuration", "AToB", "BToA", "inverse"}));
  EXPECT_TRUE(test::has_value(TransformTree::create(
      {}, {{.from = "A", .to = "B", .to_from_from = probe_from_image()},
           {.from = "B", .to = "A", .to_from_from = probe_from_image().inverse()}})));
}

TEST(TransformTreeTest, TransformsOfFramesOverrideTheConfiguration) {
  const auto t = TransformTree::create(
      {"ProbeToTracker"},
      {{.from = "Probe", .to = "Tracker", .to_from_from = rigid(1, {1, 0, 0}, {0, 0, 0})}});
  const auto chain = t->find("Probe", "Tracker");
  ASSERT_TRUE(test::has_value(chain));
  EXPECT_TRUE(chain->links.at(0).from_frame);
}

/// Returns the position of a pixel (column, row) in mm in the Probe frame, computed directly from
/// the matrix.
Eigen::Vector3d straight(const Eigen::Matrix4d& m, double column, double row) {
  return (m.col(0) * column + m.col(1) * row + m.col(3)).head<3>();
}

TEST(ImageCalibrationTest, ReproducesEveryPixelOfAShearedCalibration) {
  // The axes are like those of a real N-wire calibration, with 3 degrees of shear and unequal
  // spacing.
  Eigen::Matrix4d m = rigid(0.9, {2, -1, 1}, {12.7, 50.8, -0.5});
  const Eigen::Vector3d x = m.col(0).head<3>() * 0.085;
  const double shear = 3 * M_PI / 180;
  const Eigen::Vector3d y =
      (m.col(1).head<3>() * std::cos(shear) + m.col(0).head<3>() * std::sin(shear)) * 0.09;
  m.col(0).head<3>() = x;
  m.col(1).head<3>() = y;
  m.col(2).setConstant(std::numeric_limits<double>::quiet_NaN());  // The third column does not
                                                                   // affect the image plane.
  const auto c = calibration_from_matrix(m, 820, 616);
  ASSERT_TRUE(test::has_value(c));
  for (const auto& [column, row] :
       {std::pair(0.0, 0.0), {819.0, 0.0}, {0.0, 615.0}, {123.25, 456.5}}) {
    const Point<frames::Probe> p = c->probe_from_image * c->grid.at(column, row);
    EXPECT_LT((p.mm - straight(m, column, row)).norm(), 1e-10);
  }
  // The origin is the middle of the first row, +x runs along the columns and +z = x × y of the
  // image.
  EXPECT_LT((c->probe_from_image.translation_mm() - straight(m, 409.5, 0)).norm(), 1e-10);
  const Eigen::Matrix4d axes = c->probe_from_image.matrix();
  EXPECT_LT((axes.col(0).head<3>() - x.normalized()).norm(), kRounding);
  EXPECT_GT(axes.col(2).head<3>().dot(x.cross(y)), 0);
  EXPECT_NEAR(c->grid.shear_rad(), shear, 1e-12);
  EXPECT_EQ(c->grid.mm_per_pixel(1, 0), 0);
}

TEST(ImageCalibrationTest, RejectsEachDefectOfACalibration) {
  const auto refused = [](auto change, std::initializer_list<std::string> pieces) {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    m.topLeftCorner<3, 3>() *= 0.1;
    change(m);
    return rejects(calibration_from_matrix(m, 10, 10), Code::kMalformedData, pieces);
  };
  EXPECT_TRUE(refused([](auto& m) { m(1, 1) = std::nan(""); }, {"ImageToProbe", "finite"}));
  EXPECT_TRUE(refused([](auto& m) { m.col(0).setZero(); }, {"1e-4 mm"}));
  EXPECT_TRUE(refused([](auto& m) { m.col(1).setZero(); }, {"1e-4 mm"}));
  EXPECT_TRUE(refused([](auto& m) { m(3, 3) = 2; }, {"last row 0 0 0 1"}));
  EXPECT_TRUE(refused([](auto& m) { m(3, 0) = 0.5; }, {"last row 0 0 0 1"}));
  EXPECT_TRUE(refused([](auto& m) { m(0, 1) = 0.05; }, {"20 degrees"}));  // The shear is 26
                                                                          // degrees.
  EXPECT_TRUE(refused([](auto& m) { m.col(1) = m.col(0); }, {"pixel grid"}));
  EXPECT_TRUE(rejects(calibration_from_matrix(Eigen::Matrix4d::Identity(), 0, 5),
                      Code::kMalformedData, {"0 x 5"}));
}

}  // namespace
}  // namespace nav::io
