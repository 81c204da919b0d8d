// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/deformable_registration.hpp"

#include <gmock/gmock.h>

#include "registration/motion/motion_evidence.hpp"
#include "registration/shape/deformed_registration.hpp"
#include "tests/registration/synthetic.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;
using ::testing::HasSubstr;

const CtBox kBox{Vec(-60, -50, -40), Vec(60, 50, 40)};

SplineField random_field(unsigned seed, double mm) {
  SplineField field(kBox, 30);
  std::mt19937 random(seed);
  Eigen::VectorXd c(field.coefficients().size());
  for (Eigen::Index i = 0; i < c.size(); ++i) {
    c[i] = mm * (static_cast<double>(random()) / 2147483648.0 - 1.0);
  }
  field.set_coefficients(c);
  return field;
}

TEST(SplineFieldTest, JacobianIsTheDerivativeAndWeightsSumToOne) {
  const auto field = random_field(1, 5);
  for (const Vec& p : {Vec(0, 0, 0), Vec(59, -49, 39), Vec(-60, 50, 40), Vec(12, 3, -30)}) {
    Eigen::Matrix3d numeric;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec step = 1e-3 * Vec::Unit(axis);
      numeric.col(axis) = (field.displacement(p + step) - field.displacement(p - step)) / 2e-3;
    }
    EXPECT_LE((numeric - field.jacobian(p)).norm(), 1e-7);
    const auto reach = field.reach(p);
    double sum = 0;
    for (int n = 0; n < reach.count; ++n) sum += reach.weight[static_cast<std::size_t>(n)];
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  EXPECT_EQ(field.displacement({1e5, 0, 0}), Vec(0, 0, 0));
  EXPECT_EQ(field.displacement(Vec::Constant(std::nan(""))), Vec(0, 0, 0));
}

TEST(SplineFieldTest, ARowEqualsTheFieldAlongALine) {
  // The sums are computed in another order.
  constexpr double kRoundingMm = 1e-12;
  SplineField field({{-40, -30, -20}, {55, 30, 45}}, 22);
  Eigen::VectorXd c(3 * field.control_points());
  for (Eigen::Index i = 0; i < c.size(); ++i) c[i] = 3 * std::sin(1.7 * static_cast<double>(i));
  field.set_coefficients(c);
  int inside = 0;
  for (double z = -110; z < 140; z += 13.3) {
    for (double y = -110; y < 110; y += 17.9) {
      const SplineField::Row row = field.row(y, z);
      for (double x = -130; x < 160; x += 5.5) {
        const Vec expected = field.displacement({x, y, z});
        const Vec found = row.empty() ? Vec(Vec::Zero()) : row.displacement(x);
        EXPECT_LE((found - expected).norm(), kRoundingMm) << x << ' ' << y << ' ' << z;
        inside += expected.norm() > 1 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_TRUE(field.row(1e5, 0).empty());
  EXPECT_TRUE(field.row(std::nan(""), 0).empty());
  EXPECT_EQ(field.row(0, 0).displacement(1e9), Vec(0, 0, 0));
  EXPECT_EQ(field.row(0, 0).displacement(std::nan("")), Vec(0, 0, 0));
}

TEST(SplineFieldTest, BendingEnergyIsTheIntegralOfSquaredSecondDerivatives) {
  SplineField field(kBox, 30);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(field.coefficients().size());
  // One component of two neighbouring control points, away from the border.
  const auto reach = field.reach({0, 0, 0});
  c[3 * reach.index[21]] = 2;
  c[3 * reach.index[22]] = -1;
  field.set_coefficients(c);
  const Eigen::SparseMatrix<double> b = field.bending();
  Eigen::VectorXd x(b.rows());
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = c[3 * i];
  constexpr double kStep = 6;
  constexpr double kH = 0.05;
  double integral = 0;
  for (double i = -117; i < 120; i += kStep) {
    for (double j = -117; j < 120; j += kStep) {
      for (double k = -117; k < 120; k += kStep) {
        const Vec p(i, j, k);
        if (field.reach(p).count == 0) continue;
        for (int axis = 0; axis < 3; ++axis) {
          const Vec step = kH * Vec::Unit(axis);
          const Vec second =
              (field.jacobian(p + step).row(0) - field.jacobian(p - step).row(0)).transpose() /
              (2 * kH);
          integral += second.squaredNorm() * kStep * kStep * kStep;
        }
      }
    }
  }
  EXPECT_NEAR(x.dot(b * x) / integral, 1, 0.01);
}

TEST(SplineFieldTest, GradientBoundHoldsEverywhere) {
  const auto field = random_field(3, 4);
  double steepest = 0;
  for (double z = -120; z <= 120; z += 7) {
    for (double y = -120; y <= 120; y += 7) {
      for (double x = -120; x <= 120; x += 7) {
        steepest = std::max(steepest, field.jacobian({x, y, z}).norm());
      }
    }
  }
  EXPECT_LE(steepest, field.gradient_bound());
  SplineField peak(kBox, 30);
  Eigen::VectorXd c = Eigen::VectorXd::Zero(peak.coefficients().size());
  peak.set_coefficients(c);
  EXPECT_EQ(peak.gradient_bound(), 0);
  const auto reach = peak.reach({0, 0, 0});
  c[3 * reach.index[21]] = 3;  // One control point: the steepest difference is 3 mm over 30 mm in
                               // each direction.
  peak.set_coefficients(c);
  EXPECT_NEAR(peak.gradient_bound(), std::sqrt(3.0) * 0.1, 1e-12);
  const Eigen::VectorXd u = c;
  double energy = 0;
  const Eigen::SparseMatrix<double> b = peak.bending();
  for (Eigen::Index i = 0; i < b.rows(); ++i) energy += u[3 * i] * u[3 * i] * b.coeff(i, i);
  EXPECT_NEAR(peak.bending_energy_mm(), energy, 1e-12);
}

TEST(SplineFieldTest, DeterminantDistinguishesFoldsFromSmoothMaps) {
  EXPECT_GT(random_field(2, 1).min_determinant(), 0.7);
  EXPECT_LT(random_field(2, 60).min_determinant(), 0);
}

/// Images of a patient whose tissue has been displaced by a smooth bump since the CT.
struct Case {
  test::BlobPatient patient{7, 150};
  CtChannels ct;
  PatchSet patches;
  std::vector<Vec> targets;  ///< Current positions inside the sweep.

  static Vec bump(const Vec& p, double mm) {
    const double w = std::exp(-0.5 * (p - Vec(5, -5, 0)).squaredNorm() / (35.0 * 35.0));
    return mm * w * Vec(0.3, 0.5, 0.81);
  }
  explicit Case(double mm) {
    auto images = test::moved_images(patient, 24, 4,
                                     [&](int, const Vec& now, const Vec& beam) -> test::AtRest {
                                       return {now + bump(now, mm), beam};
                                     });
    targets = std::move(images.places_ct_mm);
    const Volume volume = test::blob_ct(patient, test::cubic_grid(75));
    auto seen = *motion_evidence(volume, images.sweep, test::true_pose(), {});
    ct = std::move(seen.ct);
    patches = std::move(seen.patches);
  }
  [[nodiscard]] double error_mm(const SplineField& field, double mm) const {
    double sum = 0;
    for (const Vec& p : targets) sum += (field.displacement(p) - bump(p, mm)).norm();
    return sum / static_cast<double>(targets.size());
  }
};

TEST(DeformableRegistrationTest, FindsASmoothDeformation) {
  const Case deformed(6);
  const auto result = refine_deformable(deformed.ct, deformed.patches, test::true_pose(), {});
  ASSERT_TRUE(result) << result.error().message;
  const double before = deformed.error_mm(SplineField(kBox, 35), 6);
  const double after = deformed.error_mm(result->field, 6);
  RecordProperty("before_um", static_cast<int>(1000 * before));
  RecordProperty("after_um", static_cast<int>(1000 * after));
  RecordProperty("reason", result->reason);
  EXPECT_TRUE(result->supported) << result->reason;
  EXPECT_GT(before, 2.5);
  EXPECT_LT(after, 0.4 * before);
  EXPECT_LT(result->final_cost, result->rigid_cost);
  EXPECT_GT(result->min_determinant, 0.5);
  EXPECT_GT(result->bending_energy_mm, 0);
  // The field is one-to-one everywhere, not only at the samples of the determinant.
  EXPECT_LT(result->max_gradient, 1);
}

TEST(DeformableRegistrationTest, KeepsARigidPatientRigid) {
  const Case rigid(0);
  const auto result = refine_deformable(rigid.ct, rigid.patches, test::true_pose(), {});
  ASSERT_TRUE(result) << result.error().message;
  const double added = rigid.error_mm(result->field, 0);
  RecordProperty("added_um", static_cast<int>(1000 * added));
  RecordProperty("reason", result->reason);
  EXPECT_FALSE(result->supported) << result->reason;
  EXPECT_EQ(added, 0);
  EXPECT_FALSE(result->reason.empty());
}

TEST(DeformedRegistrationTest, ADeformedCtHasTheValueAtTheDisplacedPosition) {
  VoxelGrid grid = test::cubic_grid(60);
  std::vector<std::int16_t> hu;
  const auto slope = [](const Vec& p) { return 3 * p.x() - 2 * p.y() + 5 * p.z(); };
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        hu.push_back(static_cast<std::int16_t>(std::lround(slope(grid.at(Vec(i, j, k)).mm))));
      }
    }
  }
  const Volume ct = *Volume::create(grid, std::move(hu), "slope");
  const SplineField field = random_field(4, 6);
  const auto bent = bent_ct(ct, field);
  ASSERT_TRUE(bent) << bent.error().message;
  int seen = 0;
  for (const Vec& p : {Vec(0, 0, 0), Vec(10, -20, 8), Vec(-24, 12, -16), Vec(20, 20, -20)}) {
    const Vec index = grid.index_of({p}).array().round();
    const Vec voxel = grid.at(index).mm;
    // The value was rounded twice.
    EXPECT_NEAR(*bent->sample({voxel}), slope(voxel + field.displacement(voxel)), 1.1);
    seen += field.displacement(voxel).norm() > 1;
  }
  EXPECT_GT(seen, 1) << "the field moves something";
}

TEST(DeformableRegistrationTest, HandlesNanAConstantCtAndTooFewImages) {
  Case rigid(0);
  PatchSet few = subset(rigid.patches, [](const Patch& p) { return p.frame < 3; });
  const auto refused = refine_deformable(rigid.ct, few, test::true_pose(), {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("4 images"));

  CtChannels constant = rigid.ct;
  for (auto& texel : constant.texels) texel = {0, 0, 0, 0};
  const auto nothing = refine_deformable(constant, rigid.patches, test::true_pose(), {});
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(nothing->supported) << nothing->reason;

  for (auto& texel : rigid.ct.texels) texel[0] = std::nanf("");
  EXPECT_FALSE(refine_deformable(rigid.ct, rigid.patches, test::true_pose(), {}));

  DeformableOptions options;
  options.bending = 0;
  EXPECT_FALSE(validate(options));
}

TEST(DeformableRegistrationTest, RejectsImagesThatAreFarApart) {
  Case rigid(0);
  // A tracker that is wrong for a few images: 9 m away, or 4 m along every axis.
  for (const Vec& away : {Vec(9000, 0, 0), Vec(4000, 4000, 4000)}) {
    PatchSet torn = rigid.patches;
    for (Patch& patch : torn.patches) {
      if (patch.frame < 3) patch.centre_mm += away;
    }
    const auto refused = refine_deformable(rigid.ct, torn, test::true_pose(), {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
    EXPECT_THAT(refused.error().message, HasSubstr("control points"));
  }
}

}  // namespace
}  // namespace nav::registration
