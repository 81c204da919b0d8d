// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares every engine with the reference for difficult cutaways.
#include <cmath>
#include <string>
#include <vector>

#include "render/transfer/smoothed_ct.hpp"
#include "render/transfer/transfer_presets.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/render/verification_engines.hpp"
#include "tests/support/trials.hpp"

namespace nav::render {
namespace {

using CutawayEnginesTest = test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, CutawayEnginesTest, ::testing::ValuesIn(test::verified_engines()),
                         [](const auto& c) { return c.param.name; });

constexpr double kStepMm = 0.5;

/// A ball with a hollow, seen from several distances, with importances from 0 to 1.
Scene uncut_scene(bool orthographic, double distance_mm) {
  Scene scene = test::ball_scene(test::cube_grid(32, 1.0), 60, 45);
  const Eigen::Vector3d away = scene.camera.eye_ct.mm.normalized();
  scene.camera.eye_ct.mm = distance_mm * away;
  scene.camera.orthographic = orthographic;
  scene.camera.vertical_fov_rad =
      2 * std::atan(0.5 * scene.camera.orthographic_height_mm / distance_mm);
  scene.quality.opaque_at = 1;  // The reference never ends early.
  scene.quality.step_voxels = kStepMm;
  return scene;
}

/// Axes of a view towards the origin.
struct ViewAxes {
  explicit ViewAxes(const Camera& camera)
      : eye(camera.eye_ct.mm),
        forward(-eye.normalized()),
        right(forward.cross(camera.up_ct.v).normalized()),
        up(right.cross(forward)) {}
  Eigen::Vector3d eye;
  Eigen::Vector3d forward;
  Eigen::Vector3d right;
  Eigen::Vector3d up;
};

struct CutShape {
  std::string name;
  std::vector<Eigen::Vector3d> vertices;
};

std::vector<Eigen::Vector3d> square(const Eigen::Vector3d& middle, const Eigen::Vector3d& u,
                                    const Eigen::Vector3d& v) {
  return {middle - u - v, middle + u - v, middle + u + v, middle - u + v};
}

/// A star: every second vertex is drawn in.
std::vector<Eigen::Vector3d> jagged(int count, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  std::vector<Eigen::Vector3d> vertices;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count;
    vertices.push_back((i % 2 == 0 ? 1.0 : 0.6) * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return vertices;
}

std::vector<CutShape> awkward_shapes(const ViewAxes& view) {
  const Eigen::Vector3d r = 8 * view.right;
  const Eigen::Vector3d u = 8 * view.up;
  const Eigen::Vector3d f = 8 * view.forward;
  const Eigen::Vector3d none(0, 0, 0);
  const Eigen::Vector3d a = r - 0.5 * f;
  const Eigen::Vector3d b = -0.7 * u + f;
  return {{"edge-on", square(none, r, f)},
          {"edge-on and aside", square(u, r, f)},
          {"behind the eye", square(view.eye - 2 * f, r, u)},
          {"through the plane of the eye", square(view.eye + 0.4 * u, r, 3 * f)},
          {"edge-on through the eye", square(view.eye, r, 3 * f)},
          {"around the eye", square(view.eye, r, u)},
          {"from the eye to behind the volume", square(0.5 * view.eye, r + u, 0.8 * view.eye)},
          {"without area", {a, none, b, 0.5 * (a + b), a}},
          {"a segment", {a, b}},
          {"a line there and back", {a, 0.5 * (a + b), b, 0.5 * (a + b)}},
          {"a point", {a, a, a}},
          {"three vertices in a line", {a, 0.3 * a + 0.7 * b, b, u}},
          {"every vertex twice", {a, a, b, b, u, u}},
          {"three vertices", {a, b, u}},
          {"four vertices, not convex", {a, 0.4 * a + 0.2 * b + 0.4 * u, u, b}},
          {"32 vertices", jagged(32, r, u + f)},
          {"as steep as a cone of 45 degrees", square(none, r, (u + f) * M_SQRT1_2)}};
}

struct CutAngles {
  double theta1_deg;
  double theta2_deg;
  double overlay_mm;
};

std::vector<CutAngles> awkward_angles() {
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  return {{30, 50, 6},      {45, 45, 0},     {0.1, 0.1, 3},       {0.1, 89.9, 6},
          {89.9, 89.9, 10}, {60, 89.9, 0.5}, {0.1, 50, kEndless}, {0.1, 89.9, 0}};
}

void set_angles(Scene& scene, const CutAngles& angles) {
  scene.cutaway->theta1_rad = angles.theta1_deg * M_PI / 180;
  scene.cutaway->theta2_rad = angles.theta2_deg * M_PI / 180;
  scene.cutaway->overlay_mm = angles.overlay_mm;
}

/// Share of the pixels whose difference is visible.
double visibly_different(const RenderedImage& a, const RenderedImage& b) {
  constexpr float kSeen = 2.0F / 255;  // The limit is that of kAgreement255.
  double count = 0;
  for (std::size_t i = 0; i < b.pixels.pixels().size(); ++i) {
    count += test::difference(a.pixels.pixels()[i], b.pixels.pixels()[i]) > kSeen ? 1 : 0;
  }
  return count / static_cast<double>(b.pixels.pixels().size());
}

/// Share of rays that graze an edge, where single and double precision differ.
constexpr double kGrazing = 1e-3;

TEST_P(CutawayEnginesTest, DifficultPolygonsAndAnglesAgreeWithTheReference) {
  const auto reference = make_reference_engine();
  int cut = 0;
  for (const bool orthographic : {false, true}) {
    Scene scene = uncut_scene(orthographic, 60);
    const RenderedImage uncut = test::draw(*reference, scene);
    const auto shapes = awkward_shapes(ViewAxes(scene.camera));
    constexpr std::size_t kEvery = test::kSanitized ? 5 : 1;
    for (std::size_t n = 0; n < shapes.size(); n += kEvery) {
      const CutShape& shape = shapes[n];
      PolygonObject polygon;
      for (const Eigen::Vector3d& p : shape.vertices) polygon.vertices_ct.push_back({p});
      scene.cutaway.emplace();
      scene.cutaway->polygons.push_back(polygon);
      for (const CutAngles& angles : awkward_angles()) {
        set_angles(scene, angles);
        const RenderedImage expected = test::draw(*reference, scene);
        EXPECT_LE(visibly_different(test::draw(*engine_, scene), expected), kGrazing)
            << shape.name << ", orthographic " << orthographic << ", theta " << angles.theta1_deg
            << " and " << angles.theta2_deg << ", overlay " << angles.overlay_mm;
        if (visibly_different(uncut, expected) > 0) ++cut;
      }
    }
  }
  EXPECT_GT(cut, test::trials(100)) << "of 272";
}

/// Returns the scene with one object of each kind and a cutaway around all.
Scene cut_around_everything(Scene scene) {
  const VoxelGrid& grid = scene.ct->grid();
  scene.plane = test::test_plane(grid, SafetyState::kValid);
  scene.plane->opacity = 0.7;
  scene.plane->frame.outline = SectorOutline{{0, -5}, 6, 25, 0.5};
  scene.needle = test::test_needle(grid, SafetyState::kValid);
  scene.spheres = test::test_spheres(grid);
  scene.cutaway.emplace();
  scene.cutaway->around_needle = scene.cutaway->around_spheres = true;
  scene.cutaway->boxes.push_back({{{-4, 3, 5}}, Eigen::Vector3d(3, 5, 2).asDiagonal()});
  return scene;
}

TEST_P(CutawayEnginesTest, ADistantEyeSeesTheSameAsParallelRays) {
  const auto reference = make_reference_engine();
  for (const CutAngles& angles : awkward_angles()) {
    for (const double distance_mm : test::trials({1e6, 1e3, 1e4, 1e5})) {
      Scene scene = cut_around_everything(uncut_scene(false, distance_mm));
      scene.shading.enabled = false;  // The last bit decides at how many points a cell is shaded.
      set_angles(scene, angles);
      const RenderedImage seen = test::draw(*engine_, scene);
      EXPECT_LE(visibly_different(seen, test::draw(*reference, scene)), kGrazing)
          << distance_mm << " mm, theta " << angles.theta1_deg << " and " << angles.theta2_deg;
      if (distance_mm < 1e6) continue;
      scene.camera.orthographic = true;
      EXPECT_LE(visibly_different(seen, test::draw(*reference, scene)), kGrazing)
          << "parallel, theta " << angles.theta1_deg << " and " << angles.theta2_deg;
    }
  }
}

TEST_P(CutawayEnginesTest, ConstantThresholdsAgreeAndLeaveImportanceOut) {
  const auto reference = make_reference_engine();
  Scene scene = uncut_scene(false, 60);
  scene.cutaway.emplace();
  scene.cutaway->polygons.push_back({});
  for (const Eigen::Vector3d& p : square({0, 0, 0}, {8, 0, 0}, {0, 0, 8})) {
    scene.cutaway->polygons.back().vertices_ct.push_back({p});
  }
  set_angles(scene, {30, 50, 6});
  const RenderedImage by_importance = test::draw(*reference, scene);
  for (const Cutaway::Thresholds tau : {Cutaway::Thresholds{0, 1}, {0.2, 0.3}, {0.5, 1}}) {
    scene.cutaway->constant = tau;
    const RenderedImage expected = test::draw(*reference, scene);
    const RenderedImage seen = test::draw(*engine_, scene);
    EXPECT_LE(visibly_different(seen, expected), kGrazing) << tau.lower << " " << tau.upper;
    EXPECT_GT(visibly_different(by_importance, expected), 0.05) << tau.lower << " " << tau.upper;
    Scene other = scene;
    other.shading.emphasis = scene.shading.emphasis = 0;
    other.transfer = *with_importance(scene.transfer, {{-1e9, 1e9, 0.5, ""}});
    EXPECT_LE(visibly_different(test::draw(*engine_, other), seen), kGrazing)
        << "the fade must not read the importance";
  }
}

TEST_P(CutawayEnginesTest, GradientsComeFromTheirSource) {
  const auto reference = make_reference_engine();
  Scene scene = uncut_scene(false, 60);
  scene.shading.enabled = true;
  const RenderedImage own = test::draw(*engine_, scene);
  scene.gradient_source = std::make_shared<const StoredVolume>(*StoredVolume::create(
      scene.ct->grid(), {scene.ct->values().begin(), scene.ct->values().end()}, "copy"));
  EXPECT_LE(visibly_different(test::draw(*engine_, scene), own), 0) << "the same values";
  scene.gradient_source = *smoothed_for_gradients(scene.ct, 2, 0);
  const RenderedImage smooth = test::draw(*engine_, scene);
  EXPECT_LE(visibly_different(smooth, test::draw(*reference, scene)), kGrazing);
  EXPECT_GT(visibly_different(smooth, own), 0.05);
  scene.shading.enabled = false;
  const RenderedImage unshaded = test::draw(*engine_, scene);
  scene.gradient_source.reset();
  EXPECT_LE(visibly_different(unshaded, test::draw(*engine_, scene)), 0)
      << "colours and opacities are those of the CT";
}

}  // namespace
}  // namespace nav::render
