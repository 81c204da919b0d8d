// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The step that an error asks for, against the double-precision reference.
#include "render/step_search.hpp"

#include <cmath>

#include "bench/support/synthetic_ct.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

Scene abdomen(const char* preset, bool shaded) {
  static const auto ct = test::SyntheticAbdomen::volume(64);
  Scene scene{ct, *preset_transfer_function(preset), {}, {}, {}, {}, {}, {}};
  scene.camera = {{{-180, -620, 160}}, {{0, 0, 0}}, {{0, 0, 1}}};
  scene.shading.enabled = shaded;
  scene.width = 320;
  scene.height = 240;
  return scene;
}

RenderedImage at_step(Engine& engine, Scene scene, double step) {
  scene.width = 64;
  scene.height = 48;
  scene.quality.step_voxels = step;
  return test::draw(engine, scene);
}

TEST(StepSearchTest, TheChosenStepErrsAboutAsMuchAsIsSaid) {
  // An estimate: it may be off by a third, and the next coarser step must err more than was asked.
  constexpr double kOff = 1.35;
  for (const char* preset : {"ct-bone", "ct-soft-tissue", "cta-vessels"}) {
    for (const bool shaded : {false, true}) {
      const Scene scene = abdomen(preset, shaded);
      const RenderedImage truth = at_step(*make_reference_engine(), scene, 1.0 / 16);
      const auto engine = make_cpu_engine();
      const auto error_at = [&](double step) {
        return rms_difference(at_step(*engine, scene, step).pixels, truth.pixels);
      };
      for (const double asked : {1e-2, 4e-3}) {
        const auto choice = step_for_error(*make_cpu_engine(), scene, asked);
        ASSERT_TRUE(test::has_value(choice));
        ASSERT_TRUE(choice->reached) << preset;
        const double found = error_at(choice->step_voxels);
        EXPECT_LE(found, kOff * asked) << preset << ", shaded " << shaded << ", " << asked;
        EXPECT_LE(found, kOff * choice->rms) << preset << ", shaded " << shaded << ", " << asked;
        if (choice->step_voxels >= 4) continue;
        EXPECT_GT(error_at(choice->step_voxels * std::sqrt(2.0)), asked / kOff)
            << preset << ", shaded " << shaded << ": " << choice->step_voxels << " was too fine";
      }
    }
  }
}

TEST(StepSearchTest, WhatCannotBeReachedIsSaid) {
  const auto choice = step_for_error(*make_cpu_engine(), abdomen("cta-vessels", true), 1e-7);
  ASSERT_TRUE(test::has_value(choice));
  EXPECT_FALSE(choice->reached);
  EXPECT_DOUBLE_EQ(choice->step_voxels, 0.125);
  EXPECT_GT(choice->rms, 1e-7);
}

TEST(StepSearchTest, AnEmptyPictureTakesTheCoarsestStep) {
  Scene scene = abdomen("ct-bone", false);
  scene.transfer =
      *TransferFunction::create("nothing", {{-1024, {0, 0, 0}, 0, 0}, {3000, {0, 0, 0}, 0, 0}});
  const auto choice = step_for_error(*make_cpu_engine(), scene, kDefaultRms);
  ASSERT_TRUE(test::has_value(choice));
  EXPECT_DOUBLE_EQ(choice->step_voxels, 4);
  EXPECT_EQ(choice->rms, 0);
}

TEST(StepSearchTest, WhatHidesTheVolumeDoesNotHideItsError) {
  const Scene bare = abdomen("ct-soft-tissue", true);
  Scene covered = bare;
  covered.spheres.push_back({{{0, -150, 0}}, 140, {1, 1, 1}, 1});
  covered.cutaway = Cutaway{};
  const auto engine = make_cpu_engine();
  const auto one = step_for_error(*engine, bare, kDefaultRms);
  const auto other = step_for_error(*engine, covered, kDefaultRms);
  ASSERT_TRUE(test::has_value(one) && test::has_value(other));
  EXPECT_EQ(one->step_voxels, other->step_voxels);
  EXPECT_EQ(one->rms, other->rms);
}

TEST(StepSearchTest, RefusesAnErrorThatIsNone) {
  for (const double rms : {0.0, -1.0, 1.5, std::nan("")}) {
    const auto choice = step_for_error(*make_cpu_engine(), abdomen("ct-bone", true), rms);
    EXPECT_TRUE(test::refuses(choice, ErrorCode::kUsage, {"rms in (0, 1]"}));
  }
}

}  // namespace
}  // namespace nav::render
