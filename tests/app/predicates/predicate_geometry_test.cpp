// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <gtest/gtest.h>

#include "app/predicates/predicate_layers.hpp"
#include "app/predicates/predicate_scan_lines.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

VoxelGrid grid_of(const std::array<int, 3>& size) {
  VoxelGrid grid;
  grid.size = size;
  grid.spacing_mm = {0.5, 0.5, 2};
  return grid;
}

std::filesystem::path written(const char* name, const std::string& text) {
  const auto path = std::filesystem::path(::testing::TempDir()) / name;
  std::ofstream(path) << text;
  return path;
}

std::string flat_surface(double height_mm) {
  std::string heights = std::to_string(height_mm);
  for (int i = 1; i < 16; ++i) heights += "," + std::to_string(height_mm);
  return "{\"heights_mm\": [" + heights + "]}";
}

std::string layers_text(const std::string& surfaces, const std::string& more = "") {
  return "{\"sonde_layers\": 1, \"axis\": 1, \"columns\": 4, \"rows\": 4" + more +
         ", \"surfaces\": [" + surfaces + "]}";
}

TEST(PredicateLayersTest, FlatSurfacesLieAtTheirDepthInMillimetres) {
  const auto path =
      written("layers.json", layers_text(flat_surface(2.2) + "," + flat_surface(4.2)));
  const auto labels = read_layers(path, grid_of({6, 12, 5}));
  ASSERT_TRUE(test::has_value(labels));
  for (int j = 0; j < 12; ++j) {
    const double depth_mm = 0.5 * j;
    const std::uint32_t layer = depth_mm < 2.2 ? 0 : depth_mm < 4.2 ? 1 : 2;
    EXPECT_EQ(labels->bits()[static_cast<std::size_t>(6 * j + 2)], 1U << layer) << j;
  }
}

TEST(PredicateLayersTest, RejectsErrorsByName) {
  const VoxelGrid grid = grid_of({6, 12, 5});
  const auto refused = [&](const std::string& text, std::initializer_list<std::string> parts) {
    return test::rejects(read_layers(written("bad_layers.json", text), grid),
                         ErrorCode::kMalformedData, parts);
  };
  EXPECT_TRUE(refused(layers_text("{\"heights_mm\": [1, 2]}"), {"surfaces[0]", "16 numbers"}));
  EXPECT_TRUE(refused(layers_text("{}"), {"surfaces[0]", "heights_mm", "16 numbers"}));
  EXPECT_TRUE(refused(layers_text(flat_surface(1), ", \"colour\": 1"), {"colour"}));
  EXPECT_TRUE(refused("{\"sonde_layers\": 0}", {"sonde_layers", "expected 1", "0"}));
  EXPECT_TRUE(test::rejects(read_layers(written("bad_layers.json", "{\"sonde_layers\": 2}"), grid),
                            ErrorCode::kUnsupportedData,
                            {"sonde_layers", "version 1", "found 2", "a newer Sonde"}));
  EXPECT_TRUE(refused("{\"sonde_layers\": 1, \"axis\": 3}", {"axis", "0 to 2", "3"}));
  EXPECT_FALSE(read_layers(written("none.json", layers_text("")), grid)) << "no surface";
}

/// Scan lines of two images along +y of the volume, with depth 0 at its first row.
std::string sweep_text(const std::string& pose) {
  const std::string plane =
      "{\"ct_from_image\": " + pose + ", \"low_mm\": [-10, 0], \"high_mm\": [10, 20]}";
  return "{\"sonde_scan_lines\": 1, \"reach_mm\": 3, \"planes\": [" + plane + "]}";
}

TEST(PredicateScanLinesTest, RunAlongTheirPlaneWithDepthFromItsFace) {
  Console console(false);
  const VoxelGrid grid = grid_of({6, 12, 5});
  render::PredicateScene predicates;
  const auto path = written("lines.json", sweep_text("[1,0,0,0, 0,1,0,-1, 0,0,1,0, 0,0,0,1]"));
  ASSERT_TRUE(test::has_value(add_scan_lines(path, grid, 1, predicates, console)));
  const auto& scan = std::get<render::VoxelScan>(*predicates.scan);
  const auto& depth = predicates.features.volumes.at(render::feature::kDepth);
  const std::size_t voxel = 6 * 7 + 2;  // i 2, j 7, k 0.
  EXPECT_LT(((*scan.into_ct)[voxel] - Eigen::Vector3f(0, 1, 0)).norm(), 1e-3F);
  EXPECT_NEAR(depth.offset() + depth.scale() * depth.codes()->values()[voxel], 0.5 * 7 + 1, 0.01);
  // Nothing is known further than reach_mm from the only image.
  const std::size_t far = 12 * 6 * 4 + voxel;
  EXPECT_TRUE((*scan.into_ct)[far].hasNaN() || (*scan.into_ct)[far].isZero());
  EXPECT_EQ(depth.codes()->values()[far], render::FeatureVolume::kUndefined);
}

TEST(PredicateScanLinesTest, RejectsErrorsByName) {
  Console console(false);
  const VoxelGrid grid = grid_of({6, 12, 5});
  render::PredicateScene predicates;
  const auto rejection = [&](const std::string& text) {
    const auto found =
        add_scan_lines(written("bad_lines.json", text), grid, 1, predicates, console);
    return found ? std::string("accepted") : found.error().message;
  };
  EXPECT_NE(rejection(sweep_text("[2,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]")).find("planes[0]"),
            std::string::npos);
  EXPECT_NE(rejection(sweep_text("[1,0]")).find("16 numbers"), std::string::npos);
  EXPECT_NE(
      rejection("{\"sonde_scan_lines\": 1, \"planes\": []}").find("planes: expected at least one"),
      std::string::npos);
  EXPECT_NE(rejection("{\"sonde_scan_lines\": 1, \"plane\": []}").find("no such member"),
            std::string::npos);
  EXPECT_NE(rejection("{\"sonde_scan_lines\": 2}").find("version 1, found 2, which a newer Sonde"),
            std::string::npos);
  EXPECT_FALSE(predicates.scan);
}

}  // namespace
}  // namespace nav::app
