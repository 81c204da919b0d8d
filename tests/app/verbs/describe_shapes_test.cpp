// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/describe_shapes.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "app/verbs/info.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

class DescribeShapesTest : public ::testing::Test {
 protected:
  /// The report of `sonde info FILE --json`, for a file of that name and text.
  io::Json info(const std::string& name, const std::string& text) {
    const auto path = folder_ / name;
    std::ofstream(path) << text;
    const std::string report = folder_ / "info.json";
    EXPECT_TRUE(test::has_value(run_info(path, report, false, console_)));
    std::ifstream in(report);
    return io::Json::parse(in);
  }
  Console console_{false};
  test::TemporaryFolder folder_;
};

TEST_F(DescribeShapesTest, PointsOf3dSlicerAreListedInLps) {
  const io::Json json =
      info("F.fcsv",
           "# Markups fiducial file version = 4.11\n# CoordinateSystem = RAS\n# columns = "
           "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
           "1,10,20,30,0,0,0,1,1,1,0,Tip,,\n2,-10,40,0,0,0,0,1,1,1,0,Base,,\n");
  EXPECT_EQ(json["kind"], "markups");
  ASSERT_EQ(json["lists"].size(), 1U);
  EXPECT_EQ(json["lists"][0][0]["name"], "Tip");
  EXPECT_EQ(json["lists"][0][0]["lps_mm"], io::Json({-10.0, -20.0, 30.0}));
  EXPECT_EQ(json["box_mm"], io::Json({{-10.0, -40.0, 0.0}, {10.0, -20.0, 30.0}}));
}

TEST_F(DescribeShapesTest, ATransformSaysHowItTurnsScalesAndMirrors) {
  // A quarter turn about z, seen from the CT to the patient's frame.
  const std::string head =
      "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\n";
  const io::Json turned =
      info("a.tfm", head + "Parameters: 0 1 0 -1 0 0 0 0 1 20 -10 -30\nFixedParameters: 0 0 0\n");
  EXPECT_EQ(turned["kind"], "transform");
  EXPECT_NEAR(turned["turn_deg"].get<double>(), 90, 1e-9);
  EXPECT_FALSE(turned["mirrors"].get<bool>());
  EXPECT_TRUE(console_.entries().empty());
  const io::Json squeezed =
      info("b.tfm", head + "Parameters: -2 0 0 0 1 0 0 0 1 0 0 0\nFixedParameters: 0 0 0\n");
  EXPECT_TRUE(squeezed["mirrors"].get<bool>());
  EXPECT_TRUE(squeezed["turn_deg"].is_null());
  EXPECT_NEAR(squeezed["scales"][2].get<double>(), 0.5, 1e-9);
  ASSERT_EQ(console_.entries().size(), 1U);
  EXPECT_NE(console_.entries()[0].message.find("places no CT"), std::string::npos);
}

TEST_F(DescribeShapesTest, ASurfaceSaysWhetherItIsClosed) {
  const auto ply = [](const std::string& last) {
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
           "float z\nelement face " +
           std::string(last.empty() ? "3" : "4") +
           "\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n9 0 0\n0 8 0\n0 0 7\n3 0 "
           "2 "
           "1\n3 0 1 3\n3 0 3 2\n" +
           last;
  };
  const io::Json closed = info("closed.ply", ply("3 1 2 3\n"));
  EXPECT_EQ(closed["kind"], "surface");
  EXPECT_EQ(closed["triangles"], 4);
  EXPECT_EQ(closed["open_edges"], 0);
  EXPECT_EQ(closed["box_mm"][1], io::Json({9.0, 8.0, 7.0}));
  EXPECT_EQ(info("open.ply", ply(""))["open_edges"], 3);
}

TEST_F(DescribeShapesTest, ATableOfLandmarksNamesItsPairs) {
  const io::Json json =
      info("points.csv",
           "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm\n"
           "Tip,1,2,3,-4,5,10\nBase,7,2,0,-4,6,-10\n");
  EXPECT_EQ(json["kind"], "landmarks");
  EXPECT_EQ(json["names"], io::Json({"Tip", "Base"}));
  EXPECT_EQ(json["ct_box_mm"], io::Json({{-4.0, 5.0, -10.0}, {-4.0, 6.0, 10.0}}));
}

}  // namespace
}  // namespace nav::app
