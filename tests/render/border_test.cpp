// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The border of the ultrasound plane shows its safety state. It is a line without gaps from every
// view. It is the only visible part of a stale plane.
#include <algorithm>
#include <cmath>
#include <vector>

#include "render/spec/ray_spec.hpp"
#include "tests/render/verification_engines.hpp"
#include "tests/support/trials.hpp"

namespace nav::render {
namespace {

using BorderTest = test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, BorderTest, ::testing::ValuesIn(test::verified_engines()),
                         [](const auto& c) { return c.param.name; });

constexpr int kWide = 100;  // Width of the ultrasound image, with pixels of 1 mm.
constexpr int kDeep = 80;
const SectorOutline kSector{{0, -20}, 30, 90, 0.6};

/// A stale plane around the origin, in air.
Scene stale_scene(bool sector) {
  static const auto ct = test::make_volume(test::centred_grid({5, 5, 5}, {20, 20, 20}),
                                           [](int, int, int) { return 0; });
  Scene scene = test::plain_scene(ct, test::fog(0), test::frontal(500, 300, true));
  scene.plane =
      test::upright_plane(test::grey_image(kWide, kDeep, 200), 1, {0, 0, 0.5 * (kDeep - 1)});
  if (sector) scene.plane->frame.outline = kSector;
  scene.plane->safety = {SafetyState::kStale, "test"};
  scene.width = 400;
  scene.height = 300;
  return scene;
}

/// \p elevation_rad: angle of the eye above the plane. At pi/2 the eye faces the plane.
void look_from(Scene& scene, double azimuth_rad, double elevation_rad, bool orthographic) {
  const Eigen::Vector3d along(std::cos(azimuth_rad), 0, std::sin(azimuth_rad));
  const Eigen::Vector3d off(0, -1, 0);
  scene.camera.eye_ct.mm = 500 * (std::cos(elevation_rad) * along + std::sin(elevation_rad) * off);
  scene.camera.up_ct.v = off + Eigen::Vector3d(0.1, 0, 0.2);
  scene.camera.orthographic = orthographic;
}

/// Points along the edges of the outline, image mm.
using Edge = std::vector<Eigen::Vector2d>;

std::vector<Edge> edges_of(bool sector) {
  constexpr int kSteps = 3000;
  std::vector<Edge> edges(4);
  for (int i = 0; i <= kSteps; ++i) {
    const double share = static_cast<double>(i) / kSteps;
    if (sector) {
      const double angle = kSector.half_angle_rad * (2 * share - 1);
      const double radius =
          kSector.radius_min_mm + share * (kSector.radius_max_mm - kSector.radius_min_mm);
      const auto at = [](double r, double a) {
        return Eigen::Vector2d(kSector.apex_mm + r * Eigen::Vector2d(std::sin(a), std::cos(a)));
      };
      edges[0].push_back(at(kSector.radius_min_mm, angle));
      edges[1].push_back(at(kSector.radius_max_mm, angle));
      edges[2].push_back(at(radius, kSector.half_angle_rad));
      edges[3].push_back(at(radius, -kSector.half_angle_rad));
    } else {
      const double x = (share - 0.5) * kWide;
      const double y = share * kDeep - 0.5;
      edges[0].push_back({x, -0.5});
      edges[1].push_back({x, kDeep - 0.5});
      edges[2].push_back({-0.5 * kWide, y});
      edges[3].push_back({0.5 * kWide, y});
    }
  }
  return edges;
}

bool is_border(const RgbaF& p) {
  const Eigen::Vector3d rgb(p.r, p.g, p.b);
  return (rgb - spec::kStaleRgb).norm() < 1e-3;
}

/// True if there is a border pixel within kNear of \p at.
bool border_near(const RenderedImage& image, const Eigen::Vector2d& at) {
  constexpr double kNear = 1.5;  // From the corner of a pixel to the second pixel inside.
  const int x0 = static_cast<int>(std::lround(at.x()));
  const int y0 = static_cast<int>(std::lround(at.y()));
  for (int y = y0 - 2; y <= y0 + 2; ++y) {
    for (int x = x0 - 2; x <= x0 + 2; ++x) {
      if (x < 0 || y < 0 || x >= image.pixels.width() || y >= image.pixels.height()) continue;
      if ((at - Eigen::Vector2d(x, y)).norm() > kNear) continue;
      if (is_border(image.pixels.at(x, y))) return true;
    }
  }
  return false;
}

/// Longest part of an edge without a border beside it, in pixels. The ends are excluded, because a
/// corner in an oblique view tapers to less than a pixel.
double longest_gap(const RenderedImage& image, const Scene& scene, const Edge& edge) {
  constexpr double kTaper = 6;  // At this distance, a corner seen at 10 degrees or more is 1 pixel
                                // thick.
  const auto& pose = scene.plane->ct_from_image;
  const auto seen = [&](const Eigen::Vector2d& p) {
    return test::project(scene, (pose * Point<frames::Image>{{p.x(), p.y(), 0}}).mm);
  };
  const Eigen::Vector2d first = seen(edge.front());
  const Eigen::Vector2d last = seen(edge.back());
  double longest = 0;
  double gap = 0;
  Eigen::Vector2d before = first;
  for (const Eigen::Vector2d& p : edge) {
    const Eigen::Vector2d at = seen(p);
    if ((at - first).norm() < kTaper || (at - last).norm() < kTaper || border_near(image, at)) {
      gap = 0;
    } else {
      gap += (at - before).norm();
    }
    longest = std::max(longest, gap);
    before = at;
  }
  return longest;
}

int border_pixels(const RenderedImage& image) {
  return static_cast<int>(
      std::count_if(image.pixels.pixels().begin(), image.pixels.pixels().end(), is_border));
}

TEST_P(BorderTest, IsALineWithoutGapsFromEveryView) {
  constexpr double kMostGapPixels = 2;
  constexpr double kDegree = M_PI / 180;
  for (const bool sector : {false, true}) {
    const std::vector<Edge> edges = edges_of(sector);
    for (const bool orthographic : {false, true}) {
      for (const double elevation : test::trials({10.0, 17.0, 35.0, 90.0})) {
        for (const double azimuth : test::trials({25.0, 0.0, 90.0, 140.0, 200.0, 290.0})) {
          Scene scene = stale_scene(sector);
          look_from(scene, azimuth * kDegree, elevation * kDegree, orthographic);
          const RenderedImage image = test::draw(*engine_, scene);
          for (const Edge& edge : edges) {
            EXPECT_LE(longest_gap(image, scene, edge), kMostGapPixels)
                << (sector ? "sector" : "rectangle") << ", orthographic " << orthographic
                << ", azimuth " << azimuth << ", elevation " << elevation;
          }
        }
      }
    }
  }
}

TEST_P(BorderTest, IsOneMillimetreWideFromNear) {
  Scene scene = stale_scene(false);
  scene.camera.orthographic_height_mm = 30;  // Ten pixels per mm.
  scene.camera.look_at_ct.mm.x() = scene.camera.eye_ct.mm.x() = 0.5 * kWide;
  const RenderedImage image = test::draw(*engine_, scene);
  // The edge is between pixels 199 and 200.
  for (int x = 0; x < 400; ++x) {
    EXPECT_EQ(is_border(image.pixels.at(x, 150)), x >= 190 && x < 200) << x;
  }
}

TEST_P(BorderTest, IsOneOrTwoPixelsWideFromFar) {
  for (const double elevation : {M_PI / 2, 0.3}) {
    Scene scene = stale_scene(false);
    look_from(scene, 0, elevation, true);
    scene.camera.up_ct.v = {0, 0, 1};
    scene.camera.orthographic_height_mm = 900;  // A third of a pixel per mm, and less in the
                                                // oblique direction.
    const RenderedImage image = test::draw(*engine_, scene);
    int columns = 0;
    int rows = 0;
    for (int i = 0; i < 300; ++i) {
      columns += is_border(image.pixels.at(i + 50, 150)) ? 1 : 0;
      rows += is_border(image.pixels.at(200, i)) ? 1 : 0;
    }
    for (const int both_sides : {columns, rows}) {
      EXPECT_GE(both_sides, 2) << elevation;
      EXPECT_LE(both_sides, 4) << elevation;
    }
  }
}

TEST_P(BorderTest, CoversAPlaneThatIsThinnerThanTwoLines) {
  Scene scene = stale_scene(false);
  look_from(scene, 1, 0.02, true);  // The plane is two pixels thick.
  const int stale = border_pixels(test::draw(*engine_, scene));
  EXPECT_GT(stale, 100);
  scene.plane->safety = {SafetyState::kValid, ""};
  const RenderedImage live = test::draw(*engine_, scene);
  int shown = 0;
  for (const RgbaF& p : live.pixels.pixels()) {
    if (!(p.g > 0)) continue;
    ++shown;
    EXPECT_NEAR(p.g, spec::kValidRgb.y(), 1e-5);
  }
  EXPECT_EQ(shown, stale) << "it lies inside the outline";
}

}  // namespace
}  // namespace nav::render
