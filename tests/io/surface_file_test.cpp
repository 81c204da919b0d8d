// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/surface_file.hpp"

#include <Eigen/Geometry>
#include <bit>
#include <gtest/gtest.h>

#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

using test::rejects;
using Code = ErrorCode;

double area_of(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const auto at = [&](int n) { return mesh.points_mm[static_cast<std::size_t>(n)]; };
    area += 0.5 * (at(j) - at(i)).cross(at(k) - at(i)).norm();
  }
  return area;
}

class SurfaceFileTest : public ::testing::Test {
 protected:
  Result<TriangleMesh> read(const std::string& name, const std::string& bytes) {
    test::put(folder_ / name, bytes);
    return read_surface(folder_ / name);
  }
  test::TemporaryFolder folder_;
};

const std::string kVtkPoints =
    "# vtk DataFile Version 3.0\nsurface\nASCII\nDATASET POLYDATA\nPOINTS 6 double\n"
    "0 0 0  1.5 0 0  0 2 0  1.5 2 0  0 4 0  1.5 4 0\n";

TEST_F(SurfaceFileTest, ReadsPolygonsAndStripsOfLegacyVtk) {
  const auto polygons = read("a.vtk", kVtkPoints + "POLYGONS 2 10\n4 0 1 3 2\n4 2 3 5 4\n");
  ASSERT_TRUE(test::has_value(polygons));
  EXPECT_EQ(polygons->triangles.size(), 4U);
  EXPECT_DOUBLE_EQ(area_of(*polygons), 6);
  const auto both =
      read("b.vtk", kVtkPoints + "POLYGONS 1 5\n4 0 1 3 2\nTRIANGLE_STRIPS 1 5\n4 2 3 4 5\n");
  ASSERT_TRUE(test::has_value(both));
  EXPECT_EQ(both->triangles.size(), 4U);
  EXPECT_DOUBLE_EQ(area_of(*both), 6) << "none is lost";
  // All triangles have the same orientation, although the order of the points of a strip
  // alternates.
  for (const auto& [i, j, k] : both->triangles) {
    const auto at = [&](int n) { return both->points_mm[static_cast<std::size_t>(n)]; };
    EXPECT_GT((at(j) - at(i)).cross(at(k) - at(i)).z(), 0);
  }
}

/// 3D Slicer marks the coordinate system of its models like this.
TEST_F(SurfaceFileTest, ConvertsSurfacesInRasToLps) {
  const auto vtk = [](const std::string& title) {
    std::string text = kVtkPoints + "POLYGONS 1 4\n3 0 1 2\n";
    return text.replace(text.find("surface"), 7, title);
  };
  const auto ply = [](const std::string& comment) {
    return "ply\nformat ascii 1.0\ncomment " + comment +
           "\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
           "0 0 0\n1.5 0 0\n0 2 0\n3 0 1 2\n";
  };
  const auto stl = [](const std::string& title) {
    return "solid " + title +
           "\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1.5 0 0\nvertex 0 2 0\n"
           "endloop\nendfacet\nendsolid\n";
  };
  const auto binary_stl = [](std::string title) {
    title.resize(80, ' ');
    title += test::bytes_of(std::vector<std::uint32_t>{1});
    title += test::bytes_of(std::vector<float>{0, 0, 1, 0, 0, 0, 1.5, 0, 0, 0, 2, 0});
    return title + std::string(2, '\0');
  };
  const auto expect = [&](const std::string& name, const auto& make) {
    for (const auto& [title, sign] : {std::pair("made by hand", 1),
                                      {"3D Slicer output. SPACE=LPS", 1},
                                      {"3D Slicer output. SPACE=RAS", -1},
                                      {"COLORSPACE=RGB of COLOR_SPACE=LAB", 1},
                                      {"COLORSPACE=LPS;SPACE=RAS;", -1},
                                      {"(SPACE=RAS) SPACE=RAS.", -1}}) {
      const auto mesh = read(name, make(title));
      ASSERT_TRUE(test::has_value(mesh)) << name;
      EXPECT_EQ(mesh->points_mm[1], Eigen::Vector3d(sign * 1.5, 0, 0)) << name << ' ' << title;
      EXPECT_EQ(mesh->points_mm[2], Eigen::Vector3d(0, sign * 2, 0)) << name << ' ' << title;
    }
    for (const auto& [title, found] : {std::pair("SPACE=LAS", "'LAS'"),
                                       {"SPACE=RASTER", "'RASTER'"},
                                       {"SPACE=LPS SPACE=RAS", "'LPS' and 'RAS'"}}) {
      EXPECT_TRUE(rejects(read(name, make(title)), Code::kUnsupportedData, {name, found})) << title;
    }
  };
  expect("a.vtk", vtk);
  expect("a.ply", ply);
  expect("a.stl", stl);
  expect("b.stl", binary_stl);
}

TEST_F(SurfaceFileTest, TextOfAnStlIsNeverReadAsNumbersOfFacets) {
  // A library that took it for binary would make room for 2^32 facets.
  const std::string stl = "solid s\nfacet normal 0 0 1\nouter loop\n" + std::string(150, '\xff') +
                          "\nvertex 0 0 0\nendsolid s\n";
  EXPECT_TRUE(rejects(read("a.stl", stl), Code::kMalformedData,
                      {"a.stl: expected ASCII STL, found bytes that are no text"}));
}

TEST_F(SurfaceFileTest, PointsMayComeFromSpreadsheets) {
  for (const char* text :
       {"1.5 2 3\n4 5 6\n", "x,y,z\n1.5,2,3\n4,5,6\n",
        "\xef\xbb\xbf"
        "1.5,2,3\n4,5,6\n",
        "\"x\",\"y\",\"z\"\n\"1,5\",\"2\",3\n4,5,6\n", "x_mm;y_mm;z_mm\r\n1,5;2;3\r\n4;5;6\r\n"}) {
    test::put(folder_ / "s.csv", text);
    const auto groups = read_point_groups(folder_ / "s.csv");
    ASSERT_TRUE(test::has_value(groups)) << text;
    ASSERT_EQ(groups->size(), 1U) << text;
    ASSERT_EQ(groups->front().size(), 2U) << text;
    EXPECT_EQ(groups->front()[0], Eigen::Vector3d(1.5, 2, 3)) << text;
    EXPECT_EQ(groups->front()[1], Eigen::Vector3d(4, 5, 6)) << text;
  }
  test::put(folder_ / "s.csv", "1 2 3\nx y z\n");
  EXPECT_TRUE(rejects(read_point_groups(folder_ / "s.csv"), Code::kMalformedData, {"s.csv:2"}));
}

TEST_F(SurfaceFileTest, SaysInItsOwnWordsWhatIsWrongWithAnAsciiStl) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 x 0\n"
      "vertex 0 2 0\nendloop\nendfacet\n";
  EXPECT_TRUE(rejects(read("a.stl", "solid s\n" + facet + "endsolid s\n"), Code::kMalformedData,
                      {"a.stl: expected solid, facets and vertices", "found other text at line "}));
  EXPECT_TRUE(rejects(read("b.stl", facet + facet + "endsolid s\n"), Code::kMalformedData,
                      {"b.stl: expected solid at the beginning", "facet normal"}));
}

TEST_F(SurfaceFileTest, RejectsABinaryStlOfAnotherLengthThanItsFacetsNeed) {
  std::string stl(80, ' ');
  stl += test::bytes_of(std::vector<std::uint32_t>{1});
  stl += test::bytes_of(std::vector<float>{0, 0, 1, 0, 0, 0, 1.5, 0, 0, 0, 2, 0});
  stl += std::string(2, '\0');
  EXPECT_TRUE(test::has_value(read("a.stl", stl)));
  EXPECT_TRUE(rejects(read("b.stl", stl + "x"), Code::kMalformedData,
                      {"b.stl", "134 bytes for its 1 facets", "135"}));
}

const std::string kPlyHead =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kPlyPoints = "0 0 0\n1.5 0 0\n1.5 2 0\n0 2 0\n";

/// Returns the bytes of a value, the most significant byte first.
template <class T>
std::string big(T value) {
  return test::swapped_bytes_of(std::vector<T>{value});
}

TEST_F(SurfaceFileTest, ReadsBinaryAndNewerLegacyVtk) {
  static_assert(std::endian::native == std::endian::little);
  std::string points;
  for (const float x : {0.F, 0.F, 0.F, 1.5F, 0.F, 0.F, 1.5F, 2.F, 0.F, 0.F, 2.F, 0.F}) {
    points += big(x);
  }
  std::string cells;
  for (const std::int32_t i : {4, 0, 1, 2, 3}) cells += big(i);
  const auto old =
      read("a.vtk",
           "# vtk DataFile Version 4.2\nt\nBINARY\nDATASET POLYDATA\n"
           "POINTS 4 float\n" +
               points + "\nPOLYGONS 1 5\n" + cells + "\nCELL_DATA 1\nNORMALS n float\nabc");
  ASSERT_TRUE(test::has_value(old));
  EXPECT_EQ(old->triangles.size(), 2U);
  EXPECT_DOUBLE_EQ(area_of(*old), 3);
  const auto modern =
      read("b.vtk",
           "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\n"
           "Time 1 1 double\n7.5\nPOINTS 6 float\n0 0 0 1.5 0 0 0 2 0\n1.5 2 0 0 4 0 1.5 4 0\n"
           "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\n\n"
           "POLYGONS 3 8\nOFFSETS vtktypeint64\n0 4 8\nCONNECTIVITY vtktypeint64\n"
           "0 1 3 2\n2 3 5 4\nPOINT_DATA 6\n");
  ASSERT_TRUE(test::has_value(modern));
  EXPECT_EQ(modern->triangles.size(), 4U);
  EXPECT_DOUBLE_EQ(area_of(*modern), 6);
}

TEST_F(SurfaceFileTest, ReadsBinaryPlyOfBothByteOrders) {
  const auto file = [](const std::string& order, bool swap) {
    std::string bytes = "ply\r\nformat " + order +
                        " 1.0\r\ncomment made by hand\r\nelement vertex 3\r\n"
                        "property uchar red\r\nproperty double x\r\nproperty double y\r\n"
                        "property double z\r\nelement edge 1\r\nproperty int a\r\n"
                        "element face 1\r\nproperty list uchar short vertex_index\r\n"
                        "end_header\r\n";
    const auto add = [&](auto value) {
      const std::vector one{value};
      bytes += swap ? test::swapped_bytes_of(one) : test::bytes_of(one);
    };
    for (const Eigen::Vector3d& p :
         {Eigen::Vector3d(-1, 0, 0), Eigen::Vector3d(2, 0, 0), Eigen::Vector3d(2, 4, 0)}) {
      add(static_cast<std::uint8_t>(200));
      for (const double x : p) add(x);
    }
    add(std::int32_t{99});
    add(std::uint8_t{3});
    for (const std::int16_t i : std::vector<std::int16_t>{0, 1, 2}) add(i);
    return bytes;
  };
  for (const auto& [order, swap] :
       {std::pair("binary_little_endian", false), {"binary_big_endian", true}}) {
    const std::string whole = file(order, swap);
    const auto mesh = read("a.ply", whole);
    ASSERT_TRUE(test::has_value(mesh)) << order;
    EXPECT_EQ(mesh->points_mm[2], Eigen::Vector3d(2, 4, 0));
    EXPECT_DOUBLE_EQ(area_of(*mesh), 6);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_FALSE(read("a.ply", whole.substr(0, size))) << size;
    }
  }
}

TEST_F(SurfaceFileTest, RejectsSizesThatTheFileCannotHold) {
  const std::string vtk = "# vtk DataFile Version 3.0\nsurface\nASCII\nDATASET POLYDATA\n";
  const std::string three = vtk + "POINTS 3 double\n0 0 0 1 0 0 0 1 0\n";
  for (const std::string& text :
       {vtk + "POINTS 2000000000 double\n0 0 0\n", vtk + "POINTS -5 double\n0 0 0\n",
        vtk + "POINTS 99999999999999999999 double\n",
        three + "POLYGONS 2000000000 8000000000\n3 0 1 2\n",
        three + "POLYGONS 1 4\n3000000 0 1 2\n", three + "POLYGONS 1 4\n-3 0 1 2\n",
        three + "POLYGONS 1 4\n3 0 1 99\n", three + "POLYGONS 1 4\n3 0 1 -1\n",
        three + "POLYGONS 2 8\n3 0 1 2\n3 0", three + "POLYGONS 1 4\n3 0 1 1.5\n",
        vtk + "FIELD f 1\na 2000000000 2000000000 int\n1\n", vtk + "FIELD f 9\n", three}) {
    EXPECT_TRUE(rejects(read("a.vtk", text), Code::kMalformedData, {"a.vtk", "expected"})) << text;
  }
  const std::string modern =
      "# vtk DataFile Version 5.1\nt\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n"
      "0 0 0 1 0 0 0 1 0\nPOLYGONS 2 3\nOFFSETS vtktypeint64\n";
  for (const char* offsets : {"0 4", "-1 3", "3 0", "0"}) {
    EXPECT_FALSE(read("b.vtk", modern + offsets + "\nCONNECTIVITY vtktypeint64\n0 1 2\n"))
        << offsets;
  }
  for (const std::string& text :
       {std::string("ply\nformat ascii 1.0\nelement vertex 3\nend_header\n"),
        std::string("ply\nelement vertex 3\nend_header\n"),
        kPlyHead + kPlyPoints + "2000000000 0 1 2\n3 0 2 3\n",
        kPlyHead + kPlyPoints + "-3 0 1 2\n3 0 2 3\n",
        kPlyHead + kPlyPoints + "3 0 1 4\n3 0 2 3\n"}) {
    EXPECT_TRUE(rejects(read("a.ply", text), Code::kMalformedData, {"a.ply", "expected"})) << text;
  }
}

TEST_F(SurfaceFileTest, RejectsTruncatedFiles) {
  const auto whole = read("a.ply", kPlyHead + kPlyPoints + "3 0 1 2\n3 0 2 3\n");
  ASSERT_TRUE(test::has_value(whole));
  EXPECT_DOUBLE_EQ(area_of(*whole), 3);
  EXPECT_FALSE(read("b.ply", kPlyHead + kPlyPoints + "3 0 1 2\n"));
  EXPECT_FALSE(read("c.ply", kPlyHead + "0 0 0\n1.5 0 0\n1.5 2 0\n"));
  EXPECT_FALSE(read("d.vtk", kVtkPoints + "POLYGONS 2 10\n4 0 1 3 2\n4 2 3"));
  EXPECT_FALSE(read("e.vtk", kVtkPoints.substr(0, kVtkPoints.size() - 12) + "\n"));
  const std::string stl =
      "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1.5 0 0\nvertex 0 2 0\n"
      "endloop\nendfacet\n";
  ASSERT_TRUE(test::has_value(read("f.stl", stl + "endsolid a\n")));
  EXPECT_TRUE(rejects(read("f.stl", stl), Code::kMalformedData, {"f.stl", "endsolid"}));
}

TEST_F(SurfaceFileTest, ReportsAnStlWithoutFacets) {
  const std::string count(4, '\0');
  for (const std::string& stl :
       {std::string(80, ' ') + count, "solid" + std::string(75, ' ') + count,
        std::string("solid a\nendsolid a\n")}) {
    EXPECT_TRUE(
        rejects(read("a.stl", stl), Code::kMalformedData, {"a.stl: expected facets, found none"}));
  }
}

TEST_F(SurfaceFileTest, RejectsInvalidNumbers) {
  EXPECT_FALSE(read("a.ply", kPlyHead + "0 0 0\n1,5 0 0\n1.5 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n"));
  EXPECT_FALSE(read("b.ply", kPlyHead + "0 0 0\n1.5 0 x\n1.5 2 0\n0 2 0\n3 0 1 2\n3 0 2 3\n"));
  EXPECT_FALSE(read("c.vtk",
                    "# vtk DataFile Version 3.0\nsurface\nASCII\nDATASET POLYDATA\n"
                    "POINTS 3 double\n0 0 0  1,5 0 0  0 2 0\nPOLYGONS 1 4\n3 0 1 2\n"));
  EXPECT_FALSE(read("d.stl",
                    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1,5 0 0\n"
                    "vertex 0 2 0\nendloop\nendfacet\nendsolid a\n"));
}

TEST_F(SurfaceFileTest, ReadsGroupsOfPoints) {
  test::put(folder_ / "p.txt", "# tracked\n1 2 3\n4,5,6\r\n\n\n7\t8\t-9.5e0\n");
  const auto groups = read_point_groups(folder_ / "p.txt");
  ASSERT_TRUE(test::has_value(groups));
  ASSERT_EQ(groups->size(), 2U);
  EXPECT_EQ((*groups)[0][1], Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ((*groups)[1][0], Eigen::Vector3d(7, 8, -9.5));
  for (const char* line : {"1 2", "1 2 3 4", "1 2 nan", "1,5 2,5 3,5", "x 1 2"}) {
    test::put(folder_ / "p.txt", std::string("1 2 3\n") + line);
    EXPECT_TRUE(rejects(read_point_groups(folder_ / "p.txt"), Code::kMalformedData,
                        {"p.txt:2", "three finite numbers"}))
        << line;
  }
}

}  // namespace
}  // namespace nav::io
