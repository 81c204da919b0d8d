// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/ct_patient.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "io/ct.hpp"
#include "nav/diagnostics.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/random.hpp"
#include "sim/ultrasound.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

/// Scan of the neck phantom. It replaces a recorded CT and has a known skin.
const Volume& neck_ct() {
  static const Volume volume = [] {
    const Patient neck = *make_patient("neck", {2, Contrast::kPortal});
    CtOptions options;
    options.region = region_of(*neck.anatomy);
    options.region.min_mm.array() -= 6;
    options.region.max_mm.array() += 6;
    options.spacing_mm = Vec(1.5, 1.5, 3);
    return *scan_ct(*neck.anatomy, options);
  }();
  return volume;
}

TEST(CtPatientTest, GradientIsTheDerivativeOfTheInterpolant) {
  const auto patient = *make_ct_patient(neck_ct());
  Random random(3, 1);
  int checked = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec p(random.uniform(-55, 55), random.uniform(-50, 50), random.uniform(-50, 50));
    const Vec index = neck_ct().grid().index_of({p});
    const Vec off = (index - index.array().round().matrix()).cwiseAbs();
    if (off.minCoeff() < 1e-3) continue;  // At a face between cells the slope jumps.
    const auto exact = patient->hu_with_gradient({p});
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kStep = 1e-5;
      const Vec h = kStep * Vec::Unit(axis);
      const double slope = (patient->hu({p + h}) - patient->hu({p - h})) / (2 * kStep);
      ASSERT_NEAR(exact.gradient_per_mm.v[axis], slope, 1e-4 * (1 + std::abs(slope)));
    }
    ++checked;
  }
  EXPECT_GT(checked, 1500);
}

TEST(CtPatientTest, FindsTheSkinAndTreatsTheAirwayAsInside) {
  const auto patient = *make_ct_patient(neck_ct());
  const Patient truth = *make_patient("neck", {2, Contrast::kPortal});
  Random random(4, 1);
  for (int i = 0; i < 4000; ++i) {
    const Vec p(random.uniform(-58, 58), random.uniform(-55, 55), random.uniform(-50, 50));
    const double distance = truth.anatomy->skin_distance_mm({p});
    if (std::abs(distance) > 2.5) {
      ASSERT_EQ(patient->skin_distance_mm({p}) < 0, distance < 0) << p.transpose();
    }
  }
  EXPECT_LT(patient->skin_distance_mm({Vec(0, -29, 0)}), 0);  // A point in the trachea.
  EXPECT_EQ(patient->tissue({Vec(0, -29, 0)}), Tissue::kGas);
  EXPECT_GT(patient->targets().size(), 50U);
}

TEST(CtPatientTest, ScatterIsNotAFunctionOfTheHu) {
  const auto patient = *make_ct_patient(neck_ct());
  // Muscle has nearly one HU value, but its scatter varies.
  double least = 1e9, most = 0;
  Random random(6, 1);
  for (int i = 0; i < 20000; ++i) {
    const Vec p(random.uniform(-45, 45), random.uniform(5, 40), random.uniform(-50, 50));
    if (std::abs(patient->hu({p}) - 65) > 4 || patient->skin_distance_mm({p}) > -10) continue;
    const auto scatter = static_cast<double>(patient->acoustics({p}).scatter);
    least = std::min(least, scatter);
    most = std::max(most, scatter);
  }
  EXPECT_GT(most, 1.6 * least);
}

TEST(CtPatientTest, RejectsAnEmptyCtAndInvalidOptions) {
  VoxelGrid grid;
  grid.size = {8, 8, 8};
  const Volume air = *Volume::create(grid, std::vector<std::int16_t>(512, -1000), "nothing");
  EXPECT_TRUE(test::rejects(make_ct_patient(air), ErrorCode::kMalformedData, {"nothing", "air"}));
  CtPatientOptions options;
  options.hidden_mm = std::nan("");
  EXPECT_TRUE(
      test::rejects(make_ct_patient(neck_ct(), options), ErrorCode::kUsage, {"hidden_mm", "nan"}));
}

TEST(CtPatientTest, ARecordedCtGivesUltrasoundImages) {
  SONDE_REQUIRE_DATA(file, "ct-abdomen-totalseg/example_ct.nii.gz");
  CollectingDiagnostics diagnostics;
  const auto ct = io::read_ct(file, diagnostics);
  ASSERT_TRUE(test::has_value(ct));
  const auto patient = make_ct_patient(*ct);
  ASSERT_TRUE(test::has_value(patient));
  // The probe looks from the front, above the middle.
  const Vec middle = (*patient)->region_mm().center();
  Vec face = middle;
  while ((*patient)->skin_distance_mm({face}) < -1 && (face - middle).norm() < 300) {
    face.y() -= 0.5;
  }
  const Eigen::Matrix3d axes =
      (Eigen::Matrix3d() << 1, 0, 0, 0, 1, 0, 0, 0, 1).finished();  // Image y is CT +y.
  const UltrasoundSimulator simulator(*patient, convex_abdominal(), 1);
  const auto image = simulator.simulate(
      Transform<frames::Ct, frames::Image>(Eigen::Quaterniond(axes), face), Timestamp{}, 0);
  double sum = 0;
  for (const std::uint8_t v : image.pixels.pixels()) sum += v;
  EXPECT_GT(sum / static_cast<double>(image.pixels.pixels().size()), 5);
}

}  // namespace
}  // namespace nav::sim
