// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests rays of difficult kinds through boxes of difficult kinds. The length of fog along a ray has
// a closed form. The test computes it in CT coordinates with planes, not with voxel indices. Also
// tests threads, jitter and dropped poses over several images.
#include <algorithm>
#include <cstring>
#include <random>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "tests/render/verification_engines.hpp"

namespace nav::render {
namespace {

using GeometryVerificationTest = test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, GeometryVerificationTest,
                         ::testing::ValuesIn(test::verified_engines()),
                         [](const auto& c) { return c.param.name; });

constexpr double kFogTau = 0.03;

/// The length of a ray inside the box of a grid, t >= 0. Uses the six planes of its faces, in long
/// double and CT coordinates.
double chord_mm(const VoxelGrid& grid, const Eigen::Vector3d& eye, const Eigen::Vector3d& d) {
  using Real = long double;
  Real begin = 0;
  Real end = std::numeric_limits<Real>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const int n = grid.size[static_cast<std::size_t>(axis)];
    const Real half = 0.5L * grid.spacing_mm[axis] * (n > 1 ? n - 1 : 1);
    const Eigen::Vector3d normal = grid.directions.col(axis);
    const auto from = static_cast<Real>(normal.dot(eye - grid.centre().mm));
    const auto along = static_cast<Real>(normal.dot(d));
    if (along == 0) {
      if (std::abs(from) > half) return 0;
      continue;
    }
    begin = std::max(begin, std::min((-half - from) / along, (half - from) / along));
    end = std::min(end, std::max((-half - from) / along, (half - from) / along));
  }
  return static_cast<double>(std::max<Real>(end - begin, 0));
}

/// The ray of a pixel from the definition of the camera.
std::pair<Eigen::Vector3d, Eigen::Vector3d> ray(const Scene& scene, int x, int y) {
  const Camera& c = scene.camera;
  const Eigen::Vector3d forward = (c.look_at_ct.mm - c.eye_ct.mm).normalized();
  const Eigen::Vector3d right = forward.cross(c.up_ct.v).normalized();
  const Eigen::Vector3d up = right.cross(forward);
  const double height =
      c.orthographic ? c.orthographic_height_mm : 2 * std::tan(0.5 * c.vertical_fov_rad);
  const double pixel = height / scene.height;
  const Eigen::Vector3d offset =
      (x + 0.5 - 0.5 * scene.width) * pixel * right + (0.5 * scene.height - y - 0.5) * pixel * up;
  if (c.orthographic) return {c.eye_ct.mm + offset, forward};
  return {c.eye_ct.mm, (forward + offset).normalized()};
}

/// Compares each pixel of an image of fog with its chord.
void expect_chords(Engine& engine, const Scene& scene, double tolerance, const std::string& what) {
  const RenderedImage image = test::draw(engine, scene);
  for (int y = 0; y < scene.height; ++y) {
    for (int x = 0; x < scene.width; ++x) {
      const auto [eye, d] = ray(scene, x, y);
      const double exact = -std::expm1(-kFogTau * chord_mm(scene.ct->grid(), eye, d));
      ASSERT_NEAR(image.pixels.at(x, y).g, exact, tolerance)
          << what << ", pixel " << x << ", " << y;
    }
  }
}

struct GridCase {
  const char* name;
  VoxelGrid grid;
};

std::vector<GridCase> awkward_grids() {
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  Eigen::Matrix3d left_handed = turned;
  left_handed.col(1) *= -1;
  VoxelGrid far = test::centred_grid({13, 9, 11}, {1, 2, 1.5}, turned);
  far.origin_mm += Eigen::Vector3d(1e5, -1e5, 1e5);
  return {{"cube", test::centred_grid({17, 17, 17}, {1, 1, 1})},
          {"1 : 1 : 20", test::centred_grid({33, 29, 4}, {0.5, 0.5, 10})},
          {"left-handed", test::centred_grid({12, 7, 19}, {1, 2, 0.7}, left_handed)},
          {"one slice", test::centred_grid({16, 1, 16}, {1, 3, 1})},
          {"a rod", test::centred_grid({1, 20, 1}, {4, 1, 4}, turned)},
          {"2 x 2 x 2", test::centred_grid({2, 2, 2}, {9, 11, 13})},
          {"one voxel", test::centred_grid({1, 1, 1}, {9, 11, 13}, left_handed)},
          {"far from the origin", far}};
}

Scene fog_scene(const VoxelGrid& grid, const Eigen::Vector3d& from_centre, bool orthographic) {
  Camera camera;
  camera.eye_ct.mm = grid.centre().mm + from_centre;
  camera.look_at_ct.mm = grid.centre().mm;
  camera.up_ct.v = Eigen::Vector3d(0.1, 0.2, 1);
  camera.orthographic = orthographic;
  camera.orthographic_height_mm = 30;
  camera.vertical_fov_rad = 2 * std::atan(15 / from_centre.norm());
  Scene scene = test::plain_scene(test::make_volume(grid, [](int, int, int) { return 0; }),
                                  test::fog(kFogTau), camera);
  scene.quality.step_voxels = 0.7;
  return scene;
}

TEST_P(GeometryVerificationTest, EachBoxFromEachSideHasItsChords) {
  constexpr double kTolerance = 2e-5;
  for (const GridCase& c : awkward_grids()) {
    for (const Eigen::Vector3d& from :
         {Eigen::Vector3d(0, -80, 0), Eigen::Vector3d(80, 0, 0), Eigen::Vector3d(50, 60, 40)}) {
      for (const bool orthographic : {false, true}) {
        expect_chords(*engine_, fog_scene(c.grid, from, orthographic), kTolerance, c.name);
      }
    }
  }
}

TEST_P(GeometryVerificationTest, AnEyeInsideOrOnAFaceSeesTheFogAhead) {
  constexpr double kTolerance = 5e-5;
  for (const GridCase& c : awkward_grids()) {
    const Eigen::Vector3d half = 0.5 * (c.grid.extent_mm() - c.grid.spacing_mm);
    for (const double depth : {0.0, 0.4, 0.999}) {  // Share of the distance to a face. The face
                                                    // itself follows below.
      Scene scene = fog_scene(c.grid, {0, -1, 0}, false);
      scene.camera.vertical_fov_rad = 1.8;
      const Eigen::Vector3d in = c.grid.directions.col(2) * depth * half[2];
      scene.camera.eye_ct.mm = c.grid.centre().mm + in;
      scene.camera.look_at_ct.mm = scene.camera.eye_ct.mm + Eigen::Vector3d(0.3, 1, 0.2);
      expect_chords(*engine_, scene, kTolerance, c.name);
    }
  }
  Scene on_face = fog_scene(test::centred_grid({17, 17, 17}, {1, 1, 1}), {0, -8, 0}, false);
  expect_chords(*engine_, on_face, kTolerance, "on a face");
}

TEST_P(GeometryVerificationTest, AnEyeAThousandKilometresAwayKeepsFiveDigits) {
  // 1e6 mm. Single precision of the distance itself would have an error of 0.06 mm.
  constexpr double kTolerance = 5e-5;
  for (const GridCase& c : awkward_grids()) {
    expect_chords(*engine_, fog_scene(c.grid, {6e5, -8e5, 0}, true), kTolerance, c.name);
  }
}

TEST_P(GeometryVerificationTest, RaysAlongAFaceSeeTheWholeFaceOrNothing) {
  constexpr double kTolerance = 2e-5;
  const VoxelGrid grid = test::centred_grid({17, 17, 17}, {1, 1, 1});
  const double whole = -std::expm1(-kFogTau * 16);
  for (const double off : {0.0, 1e-9, -1e-9, 1e-3, -1e-3}) {
    Scene scene = fog_scene(grid, {0, -50, 0}, true);
    scene.width = scene.height = 1;
    scene.camera.up_ct.v = {0, 0, 1};
    scene.camera.eye_ct.mm.x() = scene.camera.look_at_ct.mm.x() = 8 + off;
    const float found = test::middle(test::draw(*engine_, scene)).g;
    if (off == 1e-3) {
      EXPECT_EQ(found, 0) << "beside the face";
    } else if (off == -1e-3) {
      EXPECT_NEAR(found, whole, kTolerance) << "inside the face";
    } else {
      EXPECT_TRUE(found == 0 || std::abs(found - whole) < kTolerance) << off << ": " << found;
    }
  }
}

// ---- From image to image ----------------------------------------------------------------------

/// A scene with all parts of a navigation image: tissue, plane, needle, target, path, cutaway.
Scene full_scene() {
  const auto ct = test::make_volume(
      test::centred_grid({45, 41, 37}, {1.1, 1.2, 1.3}),
      [](int i, int j, int k) { return 400 * std::sin(0.2 * i) * std::cos(0.17 * j + 0.1 * k); });
  const auto transfer = TransferFunction::create("tissue", {{-400, {0.9, 0.7, 0.5}, 0, 0.1},
                                                            {-50, {0.9, 0.7, 0.5}, 0.01, 0.1},
                                                            {150, {0.8, 0.3, 0.3}, 0.1, 0.5},
                                                            {390, {1, 1, 0.9}, 0.5, 1}});
  Scene scene = test::plain_scene(ct, *transfer, test::frontal(150, 60, false));
  scene.shading.enabled = true;
  scene.shading.emphasis = 0.6;
  scene.shading.style = ShadingStyle::kGooch;
  scene.quality = Quality{};
  scene.quality.step_voxels = 0.8;
  scene.plane = test::upright_plane(test::grey_image(30, 20, 120), 1, {0, 2, 10});
  scene.needle = test::needle({2, -1, 3}, {20, -30, 20});
  scene.spheres.push_back({{{2, -1, 3}}, 5, {1, 0.8, 0.1}, 0.4});
  scene.lines.push_back({.from_ct = {{2, -1, 3}},
                         .to_ct = {{20, -30, 20}},
                         .radius_mm = 0.5,
                         .rgb = {0.2, 0.7, 1},
                         .opacity = 0.8});
  scene.cutaway = Cutaway{};
  return scene;
}

TEST_P(GeometryVerificationTest, ImageIsTheSameTwice) {
  const Scene scene = full_scene();
  const RenderedImage first = test::draw(*engine_, scene);
  EXPECT_TRUE(test::same_bytes(first, test::draw(*engine_, scene)));
  EXPECT_TRUE(test::same_bytes(first, test::draw(*GetParam().make(), scene)));
}

TEST(DeterminismTest, NoImageDependsOnTheNumberOfThreads) {
  const Scene scene = full_scene();
  const RenderedImage one = test::draw(*make_cpu_engine({1}), scene);
  const RenderedImage portable = test::draw(*make_cpu_engine({1, CpuLanes::kPortable}), scene);
  const RenderedImage reference = test::draw(*make_reference_engine({1}), scene);
  for (const int threads : {2, 3, 7}) {
    EXPECT_TRUE(test::same_bytes(one, test::draw(*make_cpu_engine({threads}), scene))) << threads;
    EXPECT_TRUE(test::same_bytes(
        portable, test::draw(*make_cpu_engine({threads, CpuLanes::kPortable}), scene)))
        << threads;
    EXPECT_TRUE(test::same_bytes(reference, test::draw(*make_reference_engine({threads}), scene)))
        << threads;
  }
}

#if defined(__SSE2__)
/// Sets denormal numbers to zero on the calling thread while it exists.
class FlushDenormals {
 public:
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }
  ~FlushDenormals() { _mm_setcsr(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_;
};

/// Callers such as audio or simulation programs set this for their threads.
TEST(DeterminismTest, ImagesDoNotDependOnDenormalNumbers) {
  Scene scene = full_scene();
  for (const bool faint : {false, true}) {
    if (faint) scene.transfer = test::fog(1e-39);
    for (const CpuLanes lanes : {CpuLanes::kFastest, CpuLanes::kPortable}) {
      const RenderedImage with = test::draw(*make_cpu_engine({1, lanes}), scene);
      const FlushDenormals flush;
      const RenderedImage without = test::draw(*make_cpu_engine({1, lanes}), scene);
      EXPECT_LE(test::max_difference(with, without), faint ? 1e-30F : 0.0F)
          << "lanes " << static_cast<int>(lanes);
    }
  }
}
#endif

/// One event of a live session: the plane that passed the gate, or its loss.
std::optional<UltrasoundPlane> jittered(std::mt19937& random, const UltrasoundPlane& rest) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const double chance = unit(random);
  if (chance > 0.8) return {};  // Dropped. The presenter shows no plane.
  Eigen::Vector3d shift(2 * unit(random), 2 * unit(random), 2 * unit(random));
  const Eigen::Vector3d axis(unit(random), unit(random), unit(random) + 2);
  if (chance > 0.6) shift.x() = std::numeric_limits<double>::quiet_NaN();
  if (!shift.allFinite()) {  // No transform can hold it, so the plane is lost, and the state
                             // contains the cause.
    UltrasoundPlane lost = rest;
    lost.safety = {SafetyState::kLost, "pose is not finite"};
    return lost;
  }
  UltrasoundPlane moved = rest;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.1 * unit(random), axis.normalized()));
  moved.ct_from_image = {turn * rest.ct_from_image.rotation(),
                         rest.ct_from_image.translation_mm() + shift};
  if (chance > 0.4) moved.safety = {SafetyState::kStale, "no pose for 0.1 s"};
  if (chance < -0.6) {  // A new image at the previous pose.
    moved = rest;
    moved.frame.pixels =
        test::grey_image(30, 20, static_cast<std::uint8_t>(127 + 100 * unit(random)));
  }
  return moved;
}

TEST_P(GeometryVerificationTest, JitterAndDroppedPosesDrawTheSameAsANewEngine) {
  Scene scene = full_scene();
  scene.width = 33;
  scene.height = 25;
  const UltrasoundPlane rest = *scene.plane;
  Scene without = scene;
  without.plane.reset();
  const RenderedImage hidden = test::draw(*engine_, without);
  std::mt19937 random(30);
  int lost = 0;
  for (int event = 0; event < 40; ++event) {
    scene.plane = jittered(random, rest);
    const RenderedImage live = test::draw(*engine_, scene);  // draw() fails on NaN.
    ASSERT_TRUE(test::same_bytes(live, test::draw(*GetParam().make(), scene))) << "event " << event;
    if (scene.plane && scene.plane->safety.state != SafetyState::kLost) continue;
    ++lost;
    ASSERT_TRUE(test::same_bytes(live, hidden)) << "event " << event << ": a lost plane is hidden";
  }
  EXPECT_GT(lost, 5);
}

TEST_P(GeometryVerificationTest, EachChangeOfTheCutawayDrawsTheSameAsANewEngine) {
  constexpr double kForever = std::numeric_limits<double>::infinity();
  Scene scene = full_scene();
  for (const double overlay_mm : {0.0, kForever, 15.0, 3.0}) {
    for (const double theta2 : {0.9, 0.4, 0.6}) {
      scene.cutaway->theta1_rad = 0.4;
      scene.cutaway->theta2_rad = theta2;
      scene.cutaway->overlay_mm = overlay_mm;
      const RenderedImage live = test::draw(*engine_, scene);
      EXPECT_TRUE(test::same_bytes(live, test::draw(*GetParam().make(), scene)))
          << "overlay " << overlay_mm << ", theta2 " << theta2;
    }
    scene.cutaway->around_needle = !scene.cutaway->around_needle;
    EXPECT_TRUE(
        test::same_bytes(test::draw(*engine_, scene), test::draw(*GetParam().make(), scene)));
  }
  // Only the overlay changes. No surface moves, but the image changes.
  scene.cutaway->overlay_mm = 0;
  const RenderedImage none = test::draw(*engine_, scene);
  scene.cutaway->overlay_mm = kForever;
  const RenderedImage all = test::draw(*engine_, scene);
  EXPECT_TRUE(test::same_bytes(all, test::draw(*GetParam().make(), scene)));
  EXPECT_FALSE(test::same_bytes(all, none));
}

TEST(LivePlaneTest, DegeneratePlanesAreRejectedWithTheirName) {
  const auto engine = make_reference_engine();
  Scene scene = full_scene();
  scene.plane->frame.grid.mm_per_pixel(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(test::rejects(engine->render(scene), ErrorCode::kMalformedData, {"plane.frame"}));
  scene = full_scene();
  scene.plane->frame.grid.mm_per_pixel.setZero();
  EXPECT_TRUE(test::rejects(engine->render(scene), ErrorCode::kMalformedData, {"plane.frame"}));
}

}  // namespace
}  // namespace nav::render
