// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/phase_registration.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <limits>
#include <numbers>

#include "registration/motion/moving_registration.hpp"
#include "registration/similarity/shadow_mask.hpp"
#include "tests/registration/synthetic.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;
using ::testing::HasSubstr;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Images of a patient who moves rigidly with breathing: downwards, with a small rotation.
struct Breathing {
  test::BlobPatient patient;
  std::optional<Volume> volume;
  std::optional<Sweep> sweep;
  CtChannels ct;
  PatchSet patches;
  std::vector<double> phases;
  std::vector<Vec> places;  ///< Positions inside the sweep, Reference, mm.

  /// Displacement of tissue from its position at rest. The amplitude is \p mm at full depth of the
  /// breath.
  static Transform<frames::Ct, frames::Ct> motion(double phase, double mm) {
    const double depth = std::pow(std::sin(std::numbers::pi * phase), 4);
    return {Eigen::Quaterniond(Eigen::AngleAxisd(0.004 * mm * depth, Vec::UnitX())),
            mm * depth * Vec(0.1, -0.3, -0.95)};
  }
  [[nodiscard]] static Pose truth(double phase, double mm) {
    return motion(phase, mm).inverse() * test::true_pose();
  }

  explicit Breathing(double mm, unsigned seed = 7) : patient{seed, 150} {
    const auto grid = test::cubic_grid(75);
    volume = test::blob_ct(patient, grid);
    ct = *make_ct_channels(*volume, box_of(grid), 1.2);
    for (int f = 0; f < 36; ++f) phases.push_back(std::fmod(0.17 * f, 1.0));
    const auto images = test::moved_images(
        patient, 36, 2.6, [&](int f, const Vec& now, const Vec& beam) -> test::AtRest {
          const auto back = motion(phases[static_cast<std::size_t>(f)], mm).inverse();
          return {(back * Point<frames::Ct>{now}).mm, back.rotation() * beam};
        });
    for (const Vec& p : images.places_ct_mm) {
      places.push_back((test::true_pose().inverse() * Point<frames::Ct>{p}).mm);
    }
    sweep = images.sweep;
    patches = make_patches(*sweep, *shadow_masks(*sweep, {}), {1.6, 9, 1500, 1}, 1.2);
  }

  /// Root mean square over phases and positions.
  [[nodiscard]] double error_mm(const PhaseMotion& found, double mm) const {
    double sum = 0;
    int count = 0;
    for (double phase = 0; phase < 1; phase += 0.1) {
      for (const Vec& p : places) {
        sum += ((found.ct_from_reference(phase) * Point<frames::Reference>{p}).mm -
                (truth(phase, mm) * Point<frames::Reference>{p}).mm)
                   .squaredNorm();
        ++count;
      }
    }
    return std::sqrt(sum / count);
  }
};

TEST(PhaseMotionTest, MotionIsPeriodicAndReportsItsAmplitude) {
  Eigen::MatrixXd series = Eigen::MatrixXd::Zero(6, 3);
  series(5, 1) = 4;  // 4 mm · cos along z.
  const PhaseMotion motion(test::true_pose(), {1, 2, 3}, series);
  const Point<frames::Reference> p{{10, -20, 30}};
  const Vec at_rest = (motion.ct_from_reference(0) * p).mm;
  EXPECT_LT(((motion.ct_from_reference(3) * p).mm - at_rest).norm(), 1e-9);
  EXPECT_LT(((motion.ct_from_reference(0.5) * p).mm - at_rest + Vec(0, 0, 8)).norm(), 1e-9);
  EXPECT_NEAR(motion.amplitude_mm({{0, 0, 0}}), 8, 1e-9);
}

TEST(PhaseRegistrationTest, FollowsABreathOfEightMillimetres) {
  const Breathing moving(8);
  const auto result =
      refine_by_phase(moving.ct, moving.patches, moving.phases, test::true_pose(), {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_TRUE(result->supported) << result->reason;
  const double before = moving.error_mm(PhaseMotion(test::true_pose()), 8);
  const double after = moving.error_mm(result->motion, 8);
  RecordProperty("before_um", static_cast<int>(1000 * before));
  RecordProperty("after_um", static_cast<int>(1000 * after));
  EXPECT_GT(before, 3);
  EXPECT_LT(after, 0.8) << result->reason;
  EXPECT_LT(result->final_cost, result->rigid_cost);
  EXPECT_LT(result->held_out_moving, result->held_out_rigid);
  EXPECT_GT(result->motion.amplitude_mm({{0, 0, 0}}), 6);
  const auto alone =
      refine_by_phase(moving.ct, moving.patches, moving.phases, test::true_pose(), {.threads = 1});
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->motion.series(), result->motion.series()) << "whatever the threads";
  EXPECT_EQ(alone->final_cost, result->final_cost);
}

Result<MovingRegistration> hold_still(const Volume& ct, const Breathing& patient,
                                      std::span<const double> phases) {
  ImageRegistrationOptions solver;
  solver.speed_from_ct = false;  // Images of blobs have one speed of sound, and no pressure.
  solver.pressed_sigma_mm = 0;
  solver.starts = 100;
  CollectingDiagnostics diagnostics;
  return register_moving(ct, *patient.sweep, phases, test::true_pose(), {}, solver, diagnostics);
}

TEST(MovingRegistrationTest, RegistersImagesNearRestAndGivesThePoseOfEachPhase) {
  const Breathing moving(8);
  const auto found = hold_still(*moving.volume, moving, moving.phases);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_TRUE(found->at_rest) << found->phases.reason;
  const Decision decision = decide(*found, {}, {{0, 0, 0}});
  EXPECT_TRUE(decision.accepted) << (decision.reasons.empty() ? "" : decision.reasons[0]);
  EXPECT_LT(moving.error_mm(found->motion, 8), 0.8);
  // sin^4 is at rest at phase 0. The pose at rest is the one that is judged.
  EXPECT_LT(std::min(found->rest_phase, 1 - found->rest_phase), 0.1);
  const Vec p = moving.places.front();
  EXPECT_LT(((found->motion.ct_from_reference(found->rest_phase) * Point<frames::Reference>{p}) -
             (found->at_rest->ct_from_reference * Point<frames::Reference>{p}))
                .v.norm(),
            1e-6);
  // Only images from the half of the breath around rest are used.
  const auto near = std::ranges::count_if(moving.phases, [&](double phase) {
    const double apart = std::abs(phase - found->rest_phase);
    return std::min(apart, 1 - apart) <= 0.25;
  });
  ASSERT_TRUE(found->held_still);
  EXPECT_EQ(found->held_still->frames().size(), static_cast<std::size_t>(near));
  EXPECT_LT(static_cast<std::size_t>(near), moving.phases.size());
  // The limits for a patient who does not move apply, and the pose at rest must not move away.
  MovingRegistration bad = *found;
  bad.at_rest->final_cost = 0.5;
  EXPECT_FALSE(decide(bad, {}, {{0, 0, 0}}).accepted);
  bad = *found;
  bad.settled_mm = 5;
  EXPECT_FALSE(decide(bad, {}, {{0, 0, 0}}).accepted);
}

TEST(MovingRegistrationTest, RejectsTheCtOfAnotherPatient) {
  const Breathing moving(8);
  for (const unsigned seed : {8u, 9u}) {
    const auto other = test::blob_ct(test::BlobPatient{seed, 150}, test::cubic_grid(75));
    const auto found = hold_still(other, moving, moving.phases);
    if (!found || !found->at_rest) continue;  // In this case no motion was found.
    EXPECT_FALSE(decide(*found, {}, {{0, 0, 0}}).accepted) << seed;
  }
}

TEST(MovingRegistrationTest, AWrongBreathingPeriodIsNeverAccepted) {
  const Breathing moving(8);
  for (const double factor : {0.37, 1.3, 1.7}) {
    std::vector<double> phases;
    for (int f = 0; f < 36; ++f) phases.push_back(std::fmod(0.17 * f * factor, 1.0));
    const auto found = hold_still(*moving.volume, moving, phases);
    if (!found || !found->at_rest) continue;
    EXPECT_FALSE(decide(*found, {}, {{0, 0, 0}}).accepted) << factor << found->phases.reason;
  }
}

TEST(PhaseRegistrationTest, KeepsThePoseRigidIfThePatientHoldsTheBreath) {
  const Breathing still(0);
  const auto result = refine_by_phase(still.ct, still.patches, still.phases, test::true_pose(), {});
  ASSERT_TRUE(result) << result.error().message;
  EXPECT_FALSE(result->supported) << result->reason;
  EXPECT_LT(still.error_mm(result->motion, 0), 0.3);
  EXPECT_EQ(result->motion.amplitude_mm({{0, 0, 0}}), 0);
}

TEST(PhaseRegistrationTest, RejectsImagesThatDoNotCoverTheBreath) {
  Breathing still(0);
  const auto refine = [&](const PhaseOptions& options = {}) {
    return refine_by_phase(still.ct, still.patches, still.phases, test::true_pose(), options);
  };
  PhaseOptions bad;
  bad.harmonics = 0;
  ASSERT_FALSE(refine(bad));
  EXPECT_THAT(refine(bad).error().message, HasSubstr("harmonics"));
  const auto known = still.phases;
  for (double& phase : still.phases) phase *= 0.5;  // Only phases of breathing in.
  ASSERT_FALSE(refine());
  EXPECT_THAT(refine().error().message, HasSubstr("whole breath"));
  for (std::size_t i = 8; i < known.size(); ++i) still.phases[i] = kNan;
  ASSERT_FALSE(refine());
  EXPECT_THAT(refine().error().message, HasSubstr("at least 12 images"));
  still.phases = known;
  still.phases[3] = 1.5;
  ASSERT_FALSE(refine());
  EXPECT_THAT(refine().error().message, HasSubstr("phase of image 3"));
  still.phases.assign(2, 0.1);
  ASSERT_FALSE(refine());
  EXPECT_THAT(refine().error().message, HasSubstr("one for each image"));
  still.phases = known;
  for (auto& texel : still.ct.texels) texel[0] = std::nanf("");
  EXPECT_FALSE(refine());
}

}  // namespace
}  // namespace nav::registration
