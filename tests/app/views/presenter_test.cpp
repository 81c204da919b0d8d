// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/presenter.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "app/report.hpp"
#include "app/views/panels.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::app {
namespace {

constexpr int kViewWidth = 480;
constexpr int kViewHeight = 360;
constexpr int kSide = kViewHeight * 2 / 3;

std::shared_ptr<const Volume> cube() {
  VoxelGrid grid;
  grid.size = {40, 40, 40};
  grid.spacing_mm = {2, 2, 2};
  grid.origin_mm = {-39, -39, -39};
  std::vector<std::int16_t> hu(grid.voxel_count(), 40);
  return std::make_shared<const Volume>(*Volume::create(grid, std::move(hu), "cube"));
}

/// Cube with marbles of bone.
std::shared_ptr<const Volume> marbles() {
  const auto plain = cube();
  std::vector<std::int16_t> hu(plain->hu().begin(), plain->hu().end());
  for (std::size_t i = 0; i < hu.size(); i += 7) hu[i] = 700;
  return std::make_shared<const Volume>(*Volume::create(plain->grid(), std::move(hu), "marbles"));
}

/// Epoch with a bright ultrasound image in the middle of the cube.
session::Epoch epoch(SafetyState state, const std::string& cause) {
  UltrasoundImage frame{
      .acquired = Timestamp{},
      .received = Timestamp{},
      .pixels = Image2d<std::uint8_t>(20, 20, std::vector<std::uint8_t>(400, 250)),
      .grid = PixelGrid::centred(20, 2, 2)};
  session::Epoch made;
  made.ct_from_image =
      Transform<frames::Ct, frames::Image>(Eigen::Quaterniond::Identity(), {0, -20, 0});
  made.frame = TrackedImage{frame,
                            Transform<frames::Reference, frames::Image>(
                                Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()),
                            Duration::zero()};
  made.ultrasound = made.plane = {state, cause};
  made.placement = {SafetyState::kValid, ""};
  return made;
}

TEST(MostTellingTest, IsThePredictedErrorThenTheNeedleThenTheFirst) {
  const std::string cost = "cost of the match: 0.3";
  const std::string needle = "needle: this sweep cannot show a probe calibration error";
  const std::string predicted = "predicted error at the target: 1.8 mm";
  EXPECT_EQ(most_telling({cost, needle, predicted}), predicted);
  EXPECT_EQ(most_telling({cost, needle}), needle);
  EXPECT_EQ(most_telling({cost, "halves"}), cost);
  EXPECT_EQ(most_telling({}), "");
}

class PresenterTest : public ::testing::Test {
 protected:
  PresenterTest() : presenter_(made(options())) {}
  static PresenterOptions options() {
    return {.appearance = {.preset = "ct-bone"},
            .width = kViewWidth,
            .height = kViewHeight,
            .step_voxels = 2.0,
            .rms_error = 0.1};
  }
  static Presenter made(const PresenterOptions& options) {
    return *Presenter::create(options, cube(), render::make_cpu_engine({.threads = 1}));
  }
  /// Makes the presenter show an ultrasound volume by predicates.
  void show(PredicateView view) {
    PresenterOptions with = options();
    with.predicates = std::move(view);
    presenter_ = made(with);
  }
  Image2d<Rgba8> present(const session::Epoch& shown) {
    auto image = presenter_.present(shown);
    EXPECT_TRUE(test::has_value(image));
    return *image;
  }
  /// Number of bright grey pixels in the ultrasound panel, away from its text and scale.
  static int bright_pixels(const Image2d<Rgba8>& image) {
    int count = 0;
    for (int y = 40; y < kViewHeight / 2 - 10; ++y) {
      for (int x = kViewWidth + 20; x < kViewWidth + kSide - 20; ++x) {
        const Rgba8& p = image.at(x, y);
        count += p.r > 240 && p.g > 240 && p.b > 240 ? 1 : 0;
      }
    }
    return count;
  }
  Presenter presenter_;
};

TEST_F(PresenterTest, ShowsALiveImageInItsPanel) {
  const auto image = present(epoch(SafetyState::kValid, ""));
  EXPECT_EQ(image.width(), kViewWidth + kSide);
  EXPECT_GT(bright_pixels(image), 1000);
}

TEST_F(PresenterTest, DrawsThePlannedPathAndTheMarginOfTheTarget) {
  NeedlePlan plan{{{0, -30, 0}}, {{0, 10, 0}}, 6, 5};
  presenter_.set_facts({.plan = plan});
  const render::Scene scene = presenter_.scene(epoch(SafetyState::kValid, ""));
  ASSERT_EQ(scene.lines.size(), 1U);
  EXPECT_EQ(scene.lines[0].from_ct.mm, plan.entry_ct.mm);
  EXPECT_EQ(scene.lines[0].to_ct.mm, plan.target_ct.mm);
  ASSERT_EQ(scene.spheres.size(), 3U) << "target, entry, margin";
  EXPECT_EQ(scene.spheres[0].radius_mm, 6);
  EXPECT_EQ(scene.spheres[2].centre_ct.mm, plan.target_ct.mm);
  EXPECT_EQ(scene.spheres[2].radius_mm, 11);
  EXPECT_LT(scene.spheres[2].opacity, 0.3) << "hides nothing";
  EXPECT_TRUE(test::has_value(render::validate(scene)));
  plan.margin_mm = 0;
  presenter_.set_facts({.plan = plan});
  EXPECT_EQ(presenter_.scene(epoch(SafetyState::kValid, "")).spheres.size(), 2U);
}

TEST_F(PresenterTest, WithParallelRaysTheWholeCtLiesBeforeTheEye) {
  for (const double distance_mm : {0.0, 20.0, 500.0}) {
    SessionConfig::View view{.distance_mm = distance_mm};
    view.orthographic = true;
    auto parallel = Presenter::create({.view = view,
                                       .width = kViewWidth,
                                       .height = kViewHeight,
                                       .step_voxels = 2.0,
                                       .rms_error = 0.1},
                                      cube(), render::make_cpu_engine({.threads = 1}));
    ASSERT_TRUE(test::has_value(parallel));
    parallel->set_facts({.focus_ct = Point<frames::Ct>{{5, 5, -7}}});
    const render::Scene scene = parallel->scene(epoch(SafetyState::kValid, ""));
    const render::Camera& camera = scene.camera;
    EXPECT_TRUE(camera.orthographic);
    if (distance_mm > 0) {
      EXPECT_NEAR(camera.orthographic_height_mm, 2 * distance_mm * std::tan(15 * M_PI / 180), 1e-9);
    }
    const Eigen::Vector3d forward = (camera.look_at_ct.mm - camera.eye_ct.mm).normalized();
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p(corner & 1 ? 40 : -40, corner & 2 ? 40 : -40, corner & 4 ? 40 : -40);
      EXPECT_GT((p - camera.eye_ct.mm).dot(forward), -1e-9) << distance_mm;
    }
  }
}

TEST_F(PresenterTest, DrawsAnUltrasoundVolumeInsideTheCt) {
  const session::Epoch shown = epoch(SafetyState::kValid, "");
  render::UltrasoundVolume ultrasound;
  ultrasound.volume = cube();
  ultrasound.predicates.model = {{{"all", render::PredicateExpression::kind("intensity", {0, 1})}},
                                 *render::PredicateHistogram::create({{1, 120, 1}})};
  ultrasound.ct_importance = 0.25;
  show({.ultrasound = ultrasound});
  const render::Scene scene = presenter_.scene(shown);
  EXPECT_NE(scene.ct, ultrasound.volume);
  EXPECT_FALSE(scene.predicates);
  ASSERT_TRUE(scene.ultrasound);
  EXPECT_EQ(scene.ultrasound->volume, ultrasound.volume);
  EXPECT_EQ(scene.ultrasound->ct_importance, 0.25);
  EXPECT_TRUE(scene.plane);
  present(shown);

  PresenterOptions options;
  options.width = kViewWidth;
  options.height = kViewHeight;
  options.predicates = PredicateView{.ultrasound = ultrasound};
  auto both = Presenter::create(options, marbles(), render::make_cpu_engine({.threads = 1}));
  ASSERT_TRUE(test::has_value(both->choose_step(shown)));
  ASSERT_TRUE(both->step()) << "what the CT alone needs";
  EXPECT_TRUE(std::isnan(both->step()->rms)) << "how much both err was not measured";
  EXPECT_EQ(both->step()->pixel_error, 0) << "no ray is spared";
}

TEST_F(PresenterTest, TheNeedleHasTheSizeOfTheOptions) {
  PresenterOptions options;
  options.needle.length_mm = 90;
  options.needle.diameter_mm = 1.2;
  auto presenter = Presenter::create(options, cube(), render::make_cpu_engine({.threads = 1}));
  ASSERT_TRUE(test::has_value(presenter));
  session::Epoch shown = epoch(SafetyState::kValid, "");
  shown.needle = {SafetyState::kValid, ""};
  shown.ct_from_needle =
      Transform<frames::Ct, frames::Needle>(Eigen::Quaterniond::Identity(), {1, 2, 3});
  const render::Scene scene = presenter->scene(shown);
  ASSERT_TRUE(scene.needle);
  EXPECT_NEAR((scene.needle->tip_ct.mm - scene.needle->hub_ct.mm).norm(), 90, 1e-9);
  EXPECT_NEAR(scene.needle->radius_mm, 0.6, 1e-12);
}

TEST_F(PresenterTest, TheLegendNamesThePredicates) {
  const session::Epoch shown = epoch(SafetyState::kValid, "");
  const auto before = present(shown);
  render::PredicateScene predicates;
  predicates.model = {{{"vessel", render::PredicateExpression::kind("intensity", {0.9, 1})},
                       {"tissue", render::PredicateExpression::kind("intensity", {0.8, 0.9})}},
                      *render::PredicateHistogram::create({{0.75, 0, 1}, {0.25, 120, 1}})};
  show({.ultrasound = {cube(), predicates}});
  ASSERT_EQ(presenter_.legend().size(), 2u);
  EXPECT_EQ(presenter_.legend()[0].name, "vessel");
  EXPECT_EQ(presenter_.legend()[0].importance_words(), "0.750");
  EXPECT_EQ(presenter_.legend()[0].colour, bar_colour({0.75, 0, 1}));
  const auto after = present(shown);
  int changed = 0;
  for (int y = kViewHeight / 2; y < kViewHeight; ++y) {
    for (int x = 0; x < 40; ++x) changed += after.at(x, y) != before.at(x, y) ? 1 : 0;
  }
  EXPECT_GT(changed, 100) << "in the lower left corner";
}

TEST_F(PresenterTest, DrawsAnUltrasoundVolumeByPredicatesWithPlaneAndCtSlice) {
  const session::Epoch shown = epoch(SafetyState::kValid, "");
  const auto before = present(shown);
  render::PredicateScene predicates;
  predicates.model = {{{"all", render::PredicateExpression::kind("intensity", {0, 1})}},
                      *render::PredicateHistogram::create({{1, 120, 1}})};
  const auto ultrasound = cube();
  show({.ultrasound = {ultrasound, predicates}, .alone = true});
  const render::Scene scene = presenter_.scene(shown);
  EXPECT_EQ(scene.ct, ultrasound);
  EXPECT_TRUE(scene.predicates);
  EXPECT_TRUE(scene.plane);
  const auto after = present(shown);
  int green = 0;
  for (int y = 0; y < kViewHeight; ++y) {
    for (int x = 0; x < kViewWidth; ++x) {
      const Rgba8& p = after.at(x, y);
      green += p.g > p.r + 10 && p.g > p.b + 10 ? 1 : 0;
    }
  }
  EXPECT_GT(green, kViewWidth * kViewHeight / 50) << "the volume, in the predicate's hue";
  for (int y = kViewHeight / 2 + 20; y < kViewHeight - 20; ++y) {
    for (int x = kViewWidth + 20; x < kViewWidth + kSide - 20; ++x) {
      ASSERT_EQ(after.at(x, y).g, before.at(x, y).g) << "the slice of the CT";
    }
  }
}

/// Number of pixels of the 3D view with the hue of a predicate, without the legend.
int green_pixels(const Image2d<Rgba8>& image) {
  constexpr int kLegendColumns = 24;
  int count = 0;
  for (int y = 80; y < kViewHeight; ++y) {
    for (int x = kLegendColumns; x < kViewWidth; ++x) {
      const Rgba8& p = image.at(x, y);
      count += p.g > p.r + 10 && p.g > p.b + 10 ? 1 : 0;
    }
  }
  return count;
}

render::PredicateScene near(const std::string& kind) {
  render::PredicateScene predicates;
  predicates.model = {{{"near", render::PredicateExpression::kind(kind, {-1e4, 12})}},
                      *render::PredicateHistogram::create({{1, 120, 1}})};
  return predicates;
}

TEST_F(PresenterTest, DistancesUseTheLiveNeedleAndNeverItsLastPose) {
  for (const bool alone : {true, false}) {
    show({.ultrasound = {cube(), near("needle_distance")}, .alone = alone});
    session::Epoch shown = epoch(SafetyState::kLost, "no image");
    shown.ct_from_needle = Transform<frames::Ct, frames::Needle>(Eigen::Quaterniond::Identity(),
                                                                 Eigen::Vector3d::Zero());
    shown.needle = {SafetyState::kValid, ""};
    const auto by_predicates = [&] {
      render::Scene scene = presenter_.scene(shown);
      if (!alone) scene.ct = scene.ultrasound->volume;
      return position_of(scene);
    };
    EXPECT_EQ(by_predicates().needle->a, Eigen::Vector3d(39, 39, 39)) << "grid mm";
    EXPECT_GT(green_pixels(present(shown)), 500);
    shown.ct_from_needle = Transform<frames::Ct, frames::Needle>(Eigen::Quaterniond::Identity(),
                                                                 Eigen::Vector3d(5, 0, 0));
    EXPECT_EQ(by_predicates().needle->a, Eigen::Vector3d(44, 39, 39)) << "of this image";
    shown.needle = {SafetyState::kStale, "the pose is 300 ms old"};
    const auto stale = present(shown);
    EXPECT_EQ(green_pixels(stale), 0);
    shown.needle = {SafetyState::kLost, "occluded"};
    const auto lost = present(shown);
    EXPECT_EQ(green_pixels(lost), 0);
    int words = 0;
    for (int y = 26; y < kViewHeight / 2; ++y) {
      for (int x = 0; x < kViewWidth; ++x) {
        const Rgba8& p = lost.at(x, y);
        words += p.r > 200 && p.b < 60 ? 1 : 0;
      }
    }
    EXPECT_GT(words, 50) << "the image says that it is withdrawn";
  }
}

TEST_F(PresenterTest, DistancesUseTheTargetOfTheSession) {
  session::Epoch shown = epoch(SafetyState::kLost, "no image");
  show({.ultrasound = {cube(), near("target_distance")},
        .alone = true,
        .target = render::SphereShape{{{7, -3, 2}}, 4}});
  NeedlePlan plan;
  plan.entry_ct = {{1, -50, 1}};
  plan.target_ct = {{1, 1, 1}};
  plan.target_radius_mm = 3;
  presenter_.set_facts({.plan = plan});
  EXPECT_EQ(position_of(presenter_.scene(shown)).target->a, Eigen::Vector3d(46, 36, 41));
  EXPECT_EQ(position_of(presenter_.scene(shown)).target->radius_mm, 4);
  EXPECT_GT(green_pixels(present(shown)), 500);
}

TEST_F(PresenterTest, WithdrawsAStaleOrLostImage) {
  EXPECT_LT(bright_pixels(present(epoch(SafetyState::kStale, "the image is 300 ms old"))), 50);
  EXPECT_LT(bright_pixels(present(epoch(SafetyState::kLost, "no image"))), 50);
}

TEST_F(PresenterTest, NeverShowsALostPlaneOrNeedle) {
  session::Epoch lost = epoch(SafetyState::kLost, "the CT is not registered");
  lost.ct_from_needle = Transform<frames::Ct, frames::Needle>(Eigen::Quaterniond::Identity(),
                                                              Eigen::Vector3d::Zero());
  lost.needle = {SafetyState::kLost, "occluded"};
  EXPECT_FALSE(presenter_.scene(lost).plane);
  EXPECT_FALSE(presenter_.scene(lost).needle);
  lost.plane = lost.needle = {SafetyState::kValid, ""};
  EXPECT_TRUE(presenter_.scene(lost).plane);
  EXPECT_TRUE(presenter_.scene(lost).needle);
}

TEST_F(PresenterTest, CastsAnUnchangedEmptyViewOnce) {
  for (int i = 0; i < 5; ++i) present(epoch(SafetyState::kLost, "the CT is not registered"));
  EXPECT_EQ(presenter_.views_cast(), 1);
  EXPECT_EQ(presenter_.views_reused(), 4);
}

TEST_F(PresenterTest, AnEmptyViewIsCastAgainAfterAChangeOfThePlanButNotOfTheWarning) {
  const session::Epoch lost = epoch(SafetyState::kLost, "the CT is not registered");
  const auto before = present(lost);
  presenter_.set_facts({.warning = "predicted error at the target: 1.8 mm"});
  EXPECT_FALSE(std::ranges::equal(present(lost).pixels(), before.pixels()))
      << "the warning is shown";
  EXPECT_EQ(presenter_.views_cast(), 1);
  SessionFacts facts = presenter_.facts();
  EXPECT_EQ(facts.warning, "predicted error at the target: 1.8 mm");
  facts.plan = NeedlePlan{{{0, -30, 0}}, {{0, 10, 0}}, 6, 5};
  presenter_.set_facts(facts);
  present(lost);
  EXPECT_EQ(presenter_.views_cast(), 2);
  presenter_.set_facts({});
  EXPECT_TRUE(std::ranges::equal(present(lost).pixels(), before.pixels()))
      << "facts are replaced as a whole";
}

TEST_F(PresenterTest, AnEmptyViewIsCastAgainAfterAChangeOfTheStep) {
  PresenterOptions options;
  options.width = kViewWidth;
  options.height = kViewHeight;
  auto made = Presenter::create(options, marbles(), render::make_cpu_engine({.threads = 1}));
  ASSERT_TRUE(test::has_value(made));
  const session::Epoch lost = epoch(SafetyState::kLost, "the CT is not registered");
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(test::has_value(made->present(lost)));
  EXPECT_EQ(made->views_cast(), 1);
  ASSERT_TRUE(test::has_value(made->present(epoch(SafetyState::kValid, ""))));
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(test::has_value(made->present(lost)));
  EXPECT_EQ(made->views_cast(), 3) << "without the plane, before and after it was searched for";
  EXPECT_EQ(made->views_reused(), 2);
}

TEST(PatientDirectionTest, NamesDirectionsInLps) {
  EXPECT_EQ(patient_direction({1, 0, 0}), "L");
  EXPECT_EQ(patient_direction({-1, 0, 0}), "R");
  EXPECT_EQ(patient_direction({0, 1, 0}), "P");
  EXPECT_EQ(patient_direction({0, -1, 0}), "A");
  EXPECT_EQ(patient_direction({0, 0, 1}), "S");
  EXPECT_EQ(patient_direction({0, 0, -1}), "I");
  EXPECT_EQ(patient_direction({-2, -1, 0.1}), "RA");
}

TEST_F(PresenterTest, CutsObjectsFreeIfThereIsACutaway) {
  CutawayShapes shapes;
  shapes.boxes.push_back({{{0, 0, 0}}, 5 * Eigen::Matrix3d::Identity()});
  shapes.polygons.push_back({{{{0, 0, 0}}, {{9, 0, 0}}, {{0, 9, 0}}}});
  PresenterOptions with = options();
  with.cut_free = shapes;
  const render::Scene scene = made(with).scene(epoch(SafetyState::kLost, "no pose"));
  ASSERT_TRUE(scene.cutaway);
  EXPECT_EQ(scene.cutaway->boxes.size(), 1U);
  EXPECT_EQ(scene.cutaway->polygons.size(), 1U);
  EXPECT_TRUE(test::has_value(render::validate(scene)));
}

TEST(PresenterOptionsTest, SamplingOptionsReachTheScene) {
  PresenterOptions options;
  options.quality = {"post-classified", true};
  auto made = Presenter::create(options, cube(), render::make_cpu_engine());
  ASSERT_TRUE(test::has_value(made));
  const auto quality = made->scene(epoch(SafetyState::kValid, "")).quality;
  EXPECT_EQ(quality.classification, render::Classification::kPostClassified);
  EXPECT_TRUE(quality.jitter);
  options.quality = {"pre-integrated", false};
  made = Presenter::create(options, cube(), render::make_cpu_engine());
  const auto other = made->scene(epoch(SafetyState::kValid, "")).quality;
  EXPECT_EQ(other.classification, render::Classification::kPreIntegrated);
  EXPECT_FALSE(other.jitter);
}

TEST(PresenterOptionsTest, StepAndPixelErrorReachTheScene) {
  const auto made = Presenter::create({.width = kViewWidth,
                                       .height = kViewHeight,
                                       .step_voxels = 0.25,
                                       .rms_error = 0.1,
                                       .pixel_error = 0.125},
                                      cube(), render::make_cpu_engine());
  ASSERT_TRUE(test::has_value(made));
  const render::Quality quality = made->scene(session::Epoch{}).quality;
  EXPECT_EQ(quality.step_voxels, 0.25);
  EXPECT_EQ(quality.pixel_error, 0.125);
}

TEST_F(PresenterTest, ChoosesTheStepForAnErrorUnlessItIsGiven) {
  const session::Epoch shown = epoch(SafetyState::kValid, "");
  present(shown);
  EXPECT_FALSE(presenter_.step()) << "2 voxels were asked for";
  EXPECT_EQ(presenter_.scene(shown).quality.step_voxels, 2);
  std::vector<double> steps;
  for (const double rms : {3e-2, 5e-3}) {
    PresenterOptions options;
    options.width = kViewWidth;
    options.height = kViewHeight;
    options.rms_error = rms;
    auto made = Presenter::create(options, marbles(), render::make_cpu_engine({.threads = 1}));
    ASSERT_TRUE(test::has_value(made));
    ASSERT_TRUE(test::has_value(made->present(shown)));
    ASSERT_TRUE(made->step());
    EXPECT_TRUE(made->step()->reached);
    EXPECT_LE(made->step()->rms, rms);
    EXPECT_EQ(made->scene(shown).quality.step_voxels, made->step()->step_voxels);
    steps.push_back(made->step()->step_voxels);
  }
  EXPECT_GT(steps[0], steps[1]);
}

TEST_F(PresenterTest, AnErrorThatWasNotMeasuredIsNotReported) {
  const session::Epoch shown = epoch(SafetyState::kValid, "");
  PresenterOptions options;
  options.width = kViewWidth;
  options.height = kViewHeight;
  options.pixel_error = 0.5;  // More than an error of 0.002 allows.
  auto spared = Presenter::create(options, marbles(), render::make_cpu_engine({.threads = 1}));
  ASSERT_TRUE(test::has_value(spared->present(shown)));
  ASSERT_TRUE(spared->step());
  EXPECT_TRUE(std::isnan(spared->step()->rms));
  EXPECT_EQ(spared->step()->pixel_error, 0.5);
  EXPECT_TRUE(json_of(spared->step())["estimated_rms"].is_null());
  EXPECT_TRUE(json_of(spared->step())["reached"].is_null());

  CollectingDiagnostics diagnostics;
  say_sampling(spared->step(), 0.002, diagnostics);
  say_sampling(render::StepChoice{0.5, 0.001, true, 0}, 0.002, diagnostics);
  EXPECT_TRUE(diagnostics.entries().empty());
  say_sampling(render::StepChoice{0.125, 0.004, false, 0}, 0.002, diagnostics);
  ASSERT_EQ(diagnostics.entries().size(), 1U);
  EXPECT_NE(diagnostics.entries()[0].message.find("found about 0.004"), std::string::npos);
}

TEST_F(PresenterTest, ProjectionsReachTheWantedError) {
  const session::Epoch shown = epoch(SafetyState::kValid, "");
  for (const char* projection : test::trials({"mean", "maximum", "minimum"})) {
    PresenterOptions options;
    options.width = kViewWidth;
    options.height = kViewHeight;
    options.appearance.projection = projection;
    std::vector<double> steps;
    for (const double rms : {2e-2, 2e-3}) {
      options.rms_error = rms;
      auto made = Presenter::create(options, marbles(), render::make_cpu_engine({.threads = 1}));
      ASSERT_TRUE(test::has_value(made));
      ASSERT_TRUE(test::has_value(made->present(shown)));
      ASSERT_TRUE(made->step()) << projection;
      EXPECT_EQ(made->step()->pixel_error, 0) << "no ray is spared";
      steps.push_back(made->step()->step_voxels);
      if (!made->step()->reached) continue;
      // Compared with the finest step, in the same grey window.
      render::Scene scene = made->scene(shown);
      const auto found = made->engine().render(scene);
      scene.quality.step_voxels = 1.0 / 64;
      const auto truth = made->engine().render(scene);
      EXPECT_LE(render::rms_difference(found->pixels, truth->pixels), 1.2 * rms)
          << projection << ", step " << made->step()->step_voxels << ", estimated "
          << made->step()->rms;
    }
    EXPECT_GE(steps[0], steps[1]) << projection;
    options.step_voxels = 1;
    auto made = Presenter::create(options, cube(), render::make_cpu_engine({.threads = 1}));
    EXPECT_EQ(made->scene(session::Epoch{}).quality.step_voxels, 1) << projection;
  }
}

TEST_F(PresenterTest, LooksFromTheFrontByDefault) {
  PresenterOptions options;
  options.view.azimuth_deg = 0;
  options.view.elevation_deg = 0;
  const auto made = Presenter::create(options, cube(), render::make_cpu_engine());
  ASSERT_TRUE(test::has_value(made));
  const render::Camera camera = made->scene(session::Epoch{}).camera;
  const Eigen::Vector3d forward = (camera.look_at_ct.mm - camera.eye_ct.mm).normalized();
  EXPECT_EQ(patient_direction(forward), "P");
  // The viewer faces the patient, so the patient's left is at the viewer's right.
  EXPECT_EQ(patient_direction(forward.cross(camera.up_ct.v)), "L");
}

TEST_F(PresenterTest, RejectsAnUnknownPresetByName) {
  PresenterOptions options;
  options.appearance.preset = "ct-magic";
  const auto made = Presenter::create(options, cube(), render::make_cpu_engine());
  EXPECT_TRUE(test::rejects(made, ErrorCode::kUsage, {"ct-magic", "ct-bone"}));
}

TEST_F(PresenterTest, AProjectionKeepsTheGreyWindowOfItsFirstImage) {
  SessionConfig::Appearance appearance;
  appearance.projection = "maximum";
  auto projecting = Presenter::create({.appearance = appearance,
                                       .width = kViewWidth,
                                       .height = kViewHeight,
                                       .step_voxels = 2.0,
                                       .rms_error = 0.1},
                                      marbles(), render::make_cpu_engine({.threads = 1}));
  ASSERT_TRUE(test::has_value(projecting));
  EXPECT_FALSE(projecting->grey());
  const session::Epoch shown = epoch(SafetyState::kValid, "");
  ASSERT_TRUE(test::has_value(projecting->choose_step(shown)));
  ASSERT_TRUE(projecting->grey());
  const render::GreyWindow chosen = *projecting->grey();
  // Samples two voxels apart miss the middle of most marbles.
  EXPECT_GT(chosen.level_hu + chosen.width_hu / 2, 400);
  EXPECT_LT(chosen.level_hu + chosen.width_hu / 2, 750);
  EXPECT_EQ(projecting->scene(shown).grey.level_hu, chosen.level_hu);
  EXPECT_EQ(projecting->scene(shown).grey.width_hu, chosen.width_hu);
  EXPECT_TRUE(projecting->note().empty());
  projecting->set_facts({.focus_ct = Point<frames::Ct>{{10, 0, 0}}});
  ASSERT_TRUE(test::has_value(projecting->present(shown)));
  EXPECT_EQ(projecting->grey()->level_hu, chosen.level_hu);
}

TEST_F(PresenterTest, AProjectionWithASingleValueHasANote) {
  SessionConfig::Appearance appearance;
  appearance.projection = "mean";
  auto projecting = Presenter::create({.appearance = appearance,
                                       .width = kViewWidth,
                                       .height = kViewHeight,
                                       .step_voxels = 2.0,
                                       .rms_error = 0.1},
                                      cube(), render::make_cpu_engine({.threads = 1}));
  ASSERT_TRUE(test::has_value(projecting));
  ASSERT_TRUE(test::has_value(projecting->present(epoch(SafetyState::kValid, ""))));
  EXPECT_NE(projecting->note().find("projection mean: every ray finds one value"),
            std::string::npos)
      << projecting->note();
}

}  // namespace
}  // namespace nav::app
