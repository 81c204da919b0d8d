// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares the cutaway of the CPU engine, which culls by blocks of pixels, with
// spec::meet_cutaway().
#include "render/cpu/cpu_cutaway_plan.hpp"
#include "render/cpu/cpu_inputs.hpp"
#include "render/cpu/cpu_marches.hpp"
#include "render/cpu/cpu_rays.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/trials.hpp"

namespace nav::render {
namespace {

constexpr int kBlock = 8;
constexpr int kTile = 32;

std::shared_ptr<const StoredVolume> any_volume() {
  return test::make_volume(test::centred_grid({8, 8, 8}, {20, 20, 20}),
                           [](int, int, int) { return 0; });
}

/// A sector, a needle, spheres, a box, and a polygon that is not convex. Each has a probability of
/// one half.
Scene random_scene(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(size * unit(random), size * unit(random), size * unit(random));
  };
  Scene scene = test::plain_scene(any_volume(), test::fog(0.1), test::frontal(500, 200, false));
  scene.camera.eye_ct.mm += vector(200);
  scene.camera.look_at_ct.mm = vector(30);
  scene.camera.orthographic = unit(random) > 0.3;
  scene.width = scene.height = 96;
  scene.cutaway.emplace();
  scene.cutaway->theta1_rad = 0.7 + 0.6 * unit(random);
  scene.cutaway->theta2_rad = scene.cutaway->theta1_rad + 0.1 * (1 + unit(random));
  scene.cutaway->around_needle = scene.cutaway->around_spheres = true;
  if (unit(random) > 0) {
    scene.plane = test::upright_plane(test::grey_image(90, 120, 0), 1, vector(30));
    scene.plane->frame.outline = SectorOutline{{0, -10}, 15, 100, 0.5};
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(3 * unit(random), vector(1).normalized()));
    scene.plane->ct_from_image = {turn, vector(30)};
  }
  if (unit(random) > 0) scene.needle = test::needle(vector(30), vector(90));
  if (unit(random) > 0) scene.spheres.push_back({{vector(30)}, 12});
  if (unit(random) > 0) {
    scene.cutaway->boxes.push_back({{vector(30)}, Eigen::Vector3d(20, 8, 14).asDiagonal()});
  }
  if (unit(random) > 0) {
    const Eigen::Vector3d u = vector(1).normalized();
    const Eigen::Vector3d v = u.unitOrthogonal();
    PolygonObject arrow;
    for (const auto& [a, b] : {std::pair{0, 0}, {40, 15}, {0, 30}, {12, 15}}) {
      arrow.vertices_ct.push_back({a * u + b * v});
    }
    scene.cutaway->polygons.push_back(arrow);
  }
  return scene;
}

/// Largest error over all pixels, mm. \p share: share of the edges that were not culled.
double worst_error(const Scene& scene, const MarchSet& marches, double& share) {
  const auto objects = spec::make_cutaway(scene, true);
  const auto view =
      spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid());
  const CutPlan plan(objects);
  const RayInputs aim = ray_inputs(scene, 0);
  const CutView eye = cut_view(view, plan.centre());
  CutSelection all(plan.objects());
  CutSelection tile(plan.objects());
  CutSelection block(plan.objects());
  double worst = 0;
  double met = 0;
  for (int y0 = 0; y0 < scene.height; y0 += kBlock) {
    for (int x0 = 0; x0 < scene.width; x0 += kBlock) {
      const CutBlock large =
          cut_block(view, plan.centre(), x0 / kTile * kTile, y0 / kTile * kTile, kTile);
      marches.cull(plan.objects(), large, all.choice(), tile.choice());
      const CutBlock small = cut_block(view, plan.centre(), x0, y0, kBlock);
      const double most = marches.cull(plan.objects(), small, tile.choice(), block.choice());
      met += block.choice().edge_count;
      for (int packet = 0; packet < kBlock * kBlock / kPacketLanes; ++packet) {
        const int x = x0 + packet % 2 * kPacketWidth;
        const int y = y0 + packet / 2 * kPacketHeight;
        CutRays rays{};
        double feet[kPacketLanes];
        const PacketPixels pixels = block_pixels(x, y);
        marches.aim(aim, eye, pixels, rays, feet);
        marches.meet(plan.objects(), block.choice(), rays);
        for (int lane = 0; lane < kPacketLanes; ++lane) {
          const auto span =
              spec::meet_cutaway(objects, spec::ray_of(view, pixels.x[lane], pixels.y[lane]));
          EXPECT_LE(span.t2 - feet[lane], most);
          worst = std::max({worst, std::abs(feet[lane] + rays.t1[lane] - span.t1),
                            std::abs(feet[lane] + rays.t2[lane] - span.t2)});
        }
      }
    }
  }
  const double blocks = scene.width / kBlock * (scene.height / kBlock);
  if (plan.objects().edge_count > 0) share = met / blocks / plan.objects().edge_count;
  return worst;
}

TEST(CpuCutawayTest, MeetsEachRayLikeTheSpecification) {
  constexpr double kToleranceMm = 0.01;  // Single precision at theta = 0.1.
  for (const CpuLanes lanes : {CpuLanes::kPortable, CpuLanes::kAvx2, CpuLanes::kAvx512}) {
    const CpuMarches marches = cpu_marches(lanes);
    std::mt19937 random(21);
    double shares = 0;
    constexpr int kScenes = test::trials(40);
    for (int i = 0; i < kScenes; ++i) {
      const Scene scene = random_scene(random);
      if (spec::make_cutaway(scene, true).empty()) continue;
      double share = 0;
      EXPECT_LE(worst_error(scene, marches.rays, share), kToleranceMm)
          << marches.name << ", scene " << i;
      shares += share;
    }
    // Blocks of 8 pixels are large in an image of 96 pixels. In larger images far fewer edges
    // remain.
    EXPECT_LT(shares / kScenes, 0.6) << "nothing was culled";
  }
}

TEST(CpuCutawayTest, ADistantEyeLosesNoPrecision) {
  constexpr double kToleranceMm = 0.01;
  std::mt19937 random(22);
  Scene scene = random_scene(random);
  scene.camera.eye_ct.mm = {1e5, -9e5, 2e5};
  scene.camera.look_at_ct.mm = {0, 0, 0};
  scene.camera.orthographic = false;
  scene.camera.vertical_fov_rad = 2e-4;
  scene.cutaway->boxes.push_back({{{0, 0, 0}}, Eigen::Vector3d(20, 8, 14).asDiagonal()});
  double share = 0;
  EXPECT_LE(worst_error(scene, portable_marches(), share), kToleranceMm);
}

}  // namespace
}  // namespace nav::render
