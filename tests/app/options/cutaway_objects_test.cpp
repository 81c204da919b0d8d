// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/cutaway_objects.hpp"

#include <array>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <sstream>

#include "app/options/session_config.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using V = Eigen::Vector3d;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class Reports final : public Diagnostics {
 public:
  void take(const DiagnosticEntry& entry) override {
    text += entry.source + ": " + entry.message + "\n";
  }
  std::string text;
};

/// ASCII STL of a tetrahedron at a position.
std::string tetrahedron(const V& at, double edge = 10) {
  std::ostringstream stl;
  const V p[4] = {at, at + edge * V::UnitX(), at + edge * V::UnitY(), at + edge * V::UnitZ()};
  stl << "solid lesion\n";
  for (const auto& [a, b, c] : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    stl << "facet normal 0 0 0\nouter loop\n";
    for (const int i : {a, b, c}) stl << "vertex " << p[i].transpose() << "\n";
    stl << "endloop\nendfacet\n";
  }
  stl << "endsolid lesion\n";
  return stl.str();
}

class CutawayObjectsTest : public ::testing::Test {
 protected:
  CutawayObjectsTest() {
    VoxelGrid grid;
    grid.size = {40, 40, 40};
    std::vector<std::int16_t> hu(grid.voxel_count(), 0);
    ct_ = std::make_shared<const Volume>(*Volume::create(grid, std::move(hu), "ct"));
  }
  std::string write(const std::string& name, const std::string& contents) {
    std::ofstream(folder_ / name, std::ios::binary) << contents;
    return (folder_ / name).string();
  }
  auto read_mesh(const std::string& file) {
    CutawayObject mesh;
    mesh.type = CutawayObject::Type::kMesh;
    mesh.file = file;
    return read_cutaway_objects({mesh}, *ct_, reports_);
  }
  static CutawayObject polygon(std::vector<V> vertices) {
    CutawayObject object;
    object.type = CutawayObject::Type::kPolygon;
    object.vertices_ct = std::move(vertices);
    return object;
  }
  std::shared_ptr<const Volume> ct_;
  Reports reports_;
  test::TemporaryFolder folder_;
};

TEST_F(CutawayObjectsTest, ReadsSeveralOfEachKindFromASession) {
  write("lesion.stl", tetrahedron({5, 5, 5}));
  const auto file = write("session.toml", R"(
[[cutaway_objects]]
type = "box"
centre_mm = [10, 20, 30]
half_edges_mm = [0,5,0, -6,0,0, 0,0,7]
[[cutaway_objects]]
type = "polygon"
vertices_mm = [[0,0,5], [20,0,5], [5,4,5], [0,15,5]]
[[cutaway_objects]]
type = "mesh"
file = "lesion.stl"
)");
  const auto config = read_session_config(file);
  ASSERT_TRUE(test::has_value(config));
  const auto shapes = read_cutaway_objects(config->cutaway_objects, *ct_, reports_);
  ASSERT_TRUE(test::has_value(shapes));
  ASSERT_EQ(shapes->boxes.size(), 1U);
  EXPECT_EQ(shapes->boxes[0].centre_ct.mm, V(10, 20, 30));
  EXPECT_EQ(shapes->boxes[0].half_edges_ct.col(1), V(-6, 0, 0));
  ASSERT_EQ(shapes->polygons.size(), 1U);
  EXPECT_EQ(shapes->polygons[0].vertices_ct.at(1).mm, V(20, 0, 5));
  ASSERT_EQ(shapes->meshes.size(), 1U);
  EXPECT_EQ(shapes->meshes[0]->triangles.size(), 4U);
  EXPECT_EQ(shapes->meshes[0]->vertices_ct.size(), 4U) << "shared by the facets";
  EXPECT_EQ(reports_.text, "");
  const auto again = read_session_config(write("again.toml", *to_toml(*config)));
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(*to_toml(*again), *to_toml(*config));
}

TEST_F(CutawayObjectsTest, SessionsNameTheInvalidObject) {
  const auto refused = [&](const std::string& keys, std::vector<std::string> pieces) {
    return test::rejects(
        read_session_config(write("bad.toml", "[[cutaway_objects]]\n" + keys + "\n")),
        ErrorCode::kMalformedData, {"bad.toml", "cutaway_objects[0]", pieces[0], pieces[1]});
  };
  EXPECT_TRUE(refused("type = \"ball\"", {"box, polygon or mesh", "ball"}));
  EXPECT_TRUE(refused("file = \"a.stl\"", {"type", "found none"}));
  EXPECT_TRUE(refused("type = \"box\"\nradius = 3", {"unknown key", "radius"}));
  EXPECT_TRUE(refused("type = \"box\"\ncentre_mm = [0, nan, 0]", {"centre_mm", "3 finite"}));
  EXPECT_TRUE(refused("type = \"box\"\ncentre_mm = [0, 0, 0]", {"half_edges_mm", "nan"}));
  EXPECT_TRUE(refused("type = \"mesh\"", {"file", "none"}));
  EXPECT_TRUE(refused("type = \"polygon\"", {"vertices_mm", "3 to 256 vertices"}));
  EXPECT_TRUE(
      refused("type = \"polygon\"\nvertices_mm = [[0, 0], [1, 1]]", {"vertices_mm", "3 finite"}));
  EXPECT_TRUE(refused("type = \"polygon\"\nvertices_mm = [[0,0,0], [1,nan,0], [0,1,0]]",
                      {"vertices_mm", "3 finite"}));
}

TEST_F(CutawayObjectsTest, InvalidPolygonsAndBoxesAreRejected) {
  const auto refused = [](const CutawayObject& object, const std::string& piece) {
    return test::rejects(validate({object}), ErrorCode::kUsage, {"cutaway_objects[0]", piece});
  };
  const V a(0, 0, 1), b(10, 0, 1), c(10, 10, 1), d(0, 10, 1);
  EXPECT_TRUE(test::has_value(validate({polygon({a, b, c, d})})));
  EXPECT_TRUE(test::has_value(validate({polygon({a, b, V(4, 4, 1), d})}))) << "not convex";
  EXPECT_TRUE(refused(polygon({a, c, b, d}), "does not cross")) << "a bow tie";
  EXPECT_TRUE(refused(polygon({a, b, c, a, d}), "touch itself"));
  EXPECT_TRUE(refused(polygon({a, b, V(20, 0, 1)}), "an area"));
  EXPECT_TRUE(refused(polygon({a, a, a}), "an area"));
  EXPECT_TRUE(refused(polygon({a, b, c, V(0, 10, 2)}), "in one plane"));
  EXPECT_TRUE(refused(polygon({a, b, V(kNan, 0, 0)}), "10^6"));
  EXPECT_TRUE(refused(polygon({a, b}), "3 to 256"));
  CutawayObject box;
  EXPECT_TRUE(test::has_value(validate({box})));
  box.half_edges_ct.col(1) = V(0.1, 1, 0);
  EXPECT_TRUE(refused(box, "right angles"));
  box.half_edges_ct.col(1) = V::Zero();
  EXPECT_TRUE(refused(box, "edges of 0.001"));
  box = {};
  box.centre_ct.x() = kNan;
  EXPECT_TRUE(refused(box, "centre_mm"));
}

TEST_F(CutawayObjectsTest, UnreadableSurfacesAreRejectedByFile) {
  const auto refused = [&](const std::string& name, const std::string& contents,
                           const std::string& piece = "") {
    return test::rejects(read_mesh(write(name, contents)), ErrorCode::kMalformedData,
                         {name, piece});
  };
  EXPECT_TRUE(test::rejects(read_mesh((folder_ / "none.stl").string()), ErrorCode::kNotFound,
                            {"none.stl"}));
  EXPECT_TRUE(refused("empty.stl", ""));
  EXPECT_TRUE(refused("words.stl", "this is no surface at all, only words and more words"));
  EXPECT_TRUE(refused("flat.stl", tetrahedron({5, 5, 5}, 0), "flat.stl"));
  std::string nan = tetrahedron({5, 5, 5});
  nan.replace(nan.find("vertex 5"), 8, "vertex nan");
  EXPECT_TRUE(refused("nan.stl", nan));
  EXPECT_TRUE(refused("far.stl", tetrahedron({5, 5, 1e8}), "10^6"));
  EXPECT_TRUE(test::rejects(read_mesh(write("lesion.obj", "")), ErrorCode::kUnsupportedData,
                            {"lesion.obj"}));
}

TEST_F(CutawayObjectsTest, ReadsBinaryStlAndRejectsItCutShort) {
  std::string stl(80, ' ');
  const auto put = [&](const auto& value) {
    stl.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(std::uint32_t{2});
  for (int facet = 0; facet < 2; ++facet) {
    const float z = 5.0F + static_cast<float>(facet);
    for (const float x : {0.F, 0.F, 1.F, 0.F, 0.F, z, 9.F, 0.F, z, 0.F, 9.F, z}) put(x);
    put(std::uint16_t{0});
  }
  const auto shapes = read_mesh(write("two.stl", stl));
  ASSERT_TRUE(test::has_value(shapes));
  EXPECT_EQ(shapes->meshes[0]->triangles.size(), 2U);
  EXPECT_TRUE(test::rejects(read_mesh(write("short.stl", stl.substr(0, stl.size() - 30))),
                            ErrorCode::kMalformedData, {"short.stl"}));
}

TEST_F(CutawayObjectsTest, WarnsOfASurfaceOutsideTheCt) {
  const auto shapes = read_mesh(write("ras.stl", tetrahedron({-25, -25, 5})));
  ASSERT_TRUE(test::has_value(shapes));
  EXPECT_NE(reports_.text.find("ras.stl: it lies 21 mm outside of the CT"), std::string::npos);
}

}  // namespace
}  // namespace nav::app
