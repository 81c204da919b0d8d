// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Errors of images besides noise: speeds of sound, haze below gas, looks, persistence,
// pads, pressure.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "sim/error_level.hpp"
#include "sim/motion/pressure.hpp"
#include "sim/persistence.hpp"
#include "sim/ultrasound.hpp"
#include "tests/sim/block.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;

const Transform<Ct, Image> kPose(Eigen::Quaterniond::Identity(), Vec::Zero());

double layer_20mm(const Vec& p) { return std::abs(p.y() - 15) - 10; }  // From 5 to 25 mm.
double below_30mm(const Vec& p) { return 30 - p.y(); }                 // From 30 mm on.

class ImageErrorsTest : public testing::TestWithParam<AcousticModel> {
 protected:
  static ProbeModel probe() {
    ProbeModel p = linear_l14();
    p.model = GetParam();
    p.frequency_mhz = 6;
    p.lines = 96;
    p.tgc_db_per_cm_mhz = 0.5;
    p.tgc_error_db = 0;
    p.noise_level_db = -250;
    return p;
  }
  static ScanLineImage see(Tissue inside, Block::Shape shape, const ProbeModel& p,
                           const NeedleShaft& needle = {}) {
    return UltrasoundSimulator(std::make_shared<const Block>(inside, shape), p, 1)
        .envelope(kPose, 0, needle);
  }
};

/// Depth of the brightest sample of the middle line from 30 to 50 mm.
double brightest_mm(const ScanLineImage& image) {
  int best = static_cast<int>(30 / image.sample_mm);
  for (int s = best; s * image.sample_mm < 50; ++s) {
    if (image.at(image.lines / 2, s) > image.at(image.lines / 2, best)) best = s;
  }
  return best * image.sample_mm;
}

/// Mean amplitude over all lines between two depths.
double mean_between(const ScanLineImage& image, double from_mm, double to_mm) {
  double sum = 0;
  int n = 0;
  for (int l = 10; l < image.lines - 10; ++l) {
    for (int s = 0; s < image.samples; ++s) {
      const double depth = s * image.sample_mm;
      if (depth >= from_mm && depth < to_mm) sum += static_cast<double>(image.at(l, s)), ++n;
    }
  }
  return sum / n;
}

/// A needle across the beams, 40 mm deep: an echo at a known depth.
NeedleShaft wire() { return NeedleShaft({{Vec(-60, 40, 0)}, {Vec(60, 40, 0)}}); }

TEST_P(ImageErrorsTest, LayersOfOtherSpeedShowAnEchoAtItsTravelTime) {
  for (const Tissue layer : {Tissue::kFat, Tissue::kMuscle, Tissue::kTendon}) {
    ProbeModel p = probe();
    p.liver_level_db = -80;
    EXPECT_NEAR(brightest_mm(see(layer, layer_20mm, p, wire())), 40, 0.35) << to_string(layer);
    p.layered_speed = true;
    // 20 mm of the layer and 20 mm of liver.
    const double shown = 20 * kAssumedSoundSpeed / sound_speed(layer) +
                         20 * kAssumedSoundSpeed / sound_speed(Tissue::kLiver);
    EXPECT_NEAR(brightest_mm(see(layer, layer_20mm, p, wire())), shown, 0.35) << to_string(layer);
  }
}

TEST_P(ImageErrorsTest, AnAssumedSpeedThatIsTooHighShowsEchoesTooDeep) {
  ProbeModel p = probe();
  p.liver_level_db = -80;
  p.sound_speed = 1.05;
  EXPECT_NEAR(brightest_mm(see(Tissue::kLiver, nowhere, p, wire())), 42, 0.35);
  p.sound_speed = 0.95;
  EXPECT_NEAR(brightest_mm(see(Tissue::kLiver, nowhere, p, wire())), 38, 0.35);
  // The deepest rows show tissue although it lies deeper than the image is.
  p.liver_level_db = linear_l14().liver_level_db;
  const auto image = see(Tissue::kLiver, nowhere, p);
  EXPECT_GT(mean_between(image, p.depth_mm - 3, p.depth_mm - 1), 0.3 * mean_between(image, 40, 50));
}

TEST_P(ImageErrorsTest, GasCastsABlackShadowUnlessItHasHaze) {
  ProbeModel p = probe();
  const double clean = mean_between(see(Tissue::kGas, below_30mm, p), 36, 44);
  p.gas_haze_db = -30;
  const double hazy = mean_between(see(Tissue::kGas, below_30mm, p), 36, 44);
  p.gas_haze_db = -20;
  const double hazier = mean_between(see(Tissue::kGas, below_30mm, p), 36, 44);
  EXPECT_GT(hazy, 20 * clean);
  EXPECT_NEAR(hazier / hazy, std::sqrt(10.0), 0.2);
  // Bone throws a clean shadow.
  EXPECT_LT(mean_between(see(Tissue::kBone, below_30mm, p), 40, 44), 0.05 * hazier);
}

TEST_P(ImageErrorsTest, LooksSmoothTheSpeckle) {
  const auto contrast = [&](int looks) {
    ProbeModel p = probe();
    p.looks = looks;
    const auto image = see(Tissue::kLiver, nowhere, p);
    double sum = 0, squares = 0;
    int n = 0;
    for (int l = 10; l < image.lines - 10; ++l) {
      for (int s = 0; s < image.samples; ++s) {
        if (std::abs(s * image.sample_mm - p.focus_mm) > 5) continue;
        const double power = static_cast<double>(image.at(l, s)) * image.at(l, s);
        sum += power, squares += power * power, ++n;
      }
    }
    const double mean = sum / n;
    return std::sqrt(squares / n - mean * mean) / mean;
  };
  // The power of fully developed speckle is exponential: its deviation is its mean.
  EXPECT_NEAR(contrast(1), 1, 0.15);
  EXPECT_NEAR(contrast(4), 0.5, 0.08);
}

INSTANTIATE_TEST_SUITE_P(Models, ImageErrorsTest,
                         testing::Values(AcousticModel::kRays, AcousticModel::kScatterers),
                         [](const auto& tested) {
                           return tested.param == AcousticModel::kRays ? "rays" : "scatterers";
                         });

TEST(PersistenceTest, EachImageIsAMeanWithTheLastShownOne) {
  const auto image = [](std::uint8_t grey) {
    UltrasoundImage frame;
    frame.pixels = {2, 1, {grey, grey}};
    return frame;
  };
  Persistence persistence(0.5);
  UltrasoundImage first = image(100), second = image(200), third = image(200);
  persistence.apply(first);
  persistence.apply(second);
  persistence.apply(third);
  EXPECT_EQ(first.pixels.at(0, 0), 100);
  EXPECT_EQ(second.pixels.at(1, 0), 150);
  EXPECT_EQ(third.pixels.at(0, 0), 175);
  Persistence none(0);
  UltrasoundImage same = image(7);
  none.apply(same);
  none.apply(second);
  EXPECT_EQ(second.pixels.at(0, 0), 150);
}

TEST(PressureTest, PushesTheSkinToTheFaceAndLeavesDeepTissue) {
  const Transform<Ct, Image> pose(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.8, Vec(1, 2, 3).normalized())), {30, -40, 10});
  const double mm = 8;
  const auto warp = pressed_by(pose, convex_abdominal(), mm);
  const auto at = [&](double x, double y, double z) { return (pose * Point<Image>{{x, y, z}}).mm; };
  EXPECT_LE((warp->apply(at(0, -mm, 0)) - at(0, 0, 0)).norm(), 1e-9);
  EXPECT_LE((warp->apply(at(0, 110, 0)) - at(0, 110, 0)).norm(), 0.01);
  EXPECT_LE((warp->apply(at(0, 10, 60)) - at(0, 10, 60)).norm(), 0.01);
  for (const Vec& p : {at(3, 5, 2), at(-20, 30, 8), at(40, 60, -10)}) {
    EXPECT_LE((warp->apply(warp->invert(p)) - p).norm(), Warp::kInverseToleranceMm);
    Eigen::Matrix3d slopes;
    constexpr double kStep = 1e-4;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec step = kStep * Vec::Unit(axis);
      slopes.col(axis) = (warp->apply(p + step) - warp->apply(p - step)) / (2 * kStep);
    }
    EXPECT_LE((warp->jacobian(p) - slopes).norm(), 1e-6);
    EXPECT_GT(warp->jacobian(p).determinant(), 0.4);
  }
}

TEST(ErrorLevelTest, EveryLevelIsValidAndWorseThanTheOneBefore) {
  const LevelErrors* before = nullptr;
  LevelErrors last{};
  for (const ErrorLevel level : kErrorLevels) {
    const LevelErrors errors = errors_of(level);
    EXPECT_EQ(*error_level_from(to_string(level)), level);
    ProbeModel probe = convex_abdominal();
    set_image_errors(errors, probe);
    EXPECT_TRUE(validate(probe).has_value());
    EXPECT_LE(errors.pressure_mm, kMostPressureMm);
    if (before != nullptr) {
      EXPECT_GT(errors.tracker_mm, before->tracker_mm);
      EXPECT_GT(errors.calibration_mm, before->calibration_mm);
      EXPECT_GT(errors.noise_level_db, before->noise_level_db);
      EXPECT_GE(errors.sound_speed, before->sound_speed);
    }
    last = errors;
    before = &last;
  }
  EXPECT_FALSE(error_level_from("perfect").has_value());
}

}  // namespace
}  // namespace nav::sim
