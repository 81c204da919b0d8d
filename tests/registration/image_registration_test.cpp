// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/image_registration.hpp"

#include <cstring>
#include <gtest/gtest.h>

#include "registration/acceptance.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

using test::BlobPatient;

constexpr double kStartMm = 10;
constexpr double kStartRad = 8 * M_PI / 180;
// A quarter of a 2 mm voxel on a patient that follows the model, with 4 grey levels of noise.
constexpr double kToleranceMm = 0.5;

ImageRegistrationOptions quick_options() {
  ImageRegistrationOptions options;
  options.levels = {{5.0, 7, 150, 9.0}, {3.0, 9, 250, 6.0}, {1.6, 11, 400, 4.0}};
  options.starts = 60;
  options.ridge = 0.005;  // This CT has rounding noise only: 0.3 HU.
  options.threads = 1;
  return options;
}

/// One patient for all tests: building the pictures is the slow part.
struct Scene {
  BlobPatient patient{11};
  Volume ct = test::blob_ct(patient, test::cubic_grid());
  Sweep sweep = test::blob_sweep(patient, {});
};
const Scene& scene() {
  static const Scene instance;
  return instance;
}

Result<ImageRegistrationResult> solve(const Transform<frames::Ct, frames::Reference>& start,
                                      const ImageRegistrationOptions& options = quick_options()) {
  CollectingDiagnostics diagnostics;
  return register_sweep(scene().ct, scene().sweep, start, options, diagnostics);
}

TEST(ImageRegistrationTest, FindsThePlantedPoseFromALadderOfStarts) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const auto result = solve(test::off_by(test::true_pose(), kStartMm, kStartRad, seed));
    ASSERT_TRUE(test::has_value(result));
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), kToleranceMm)
        << "start " << seed;
    EXPECT_LT(result->final_cost, result->initial_cost);
    const Decision decision = decide(*result, {}, {{0, 0, 0}});
    EXPECT_TRUE(decision.accepted) << (decision.reasons.empty() ? "" : decision.reasons[0]);
  }
}

}  // namespace
}  // namespace nav::registration
