// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/markups.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "io/json.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

class MarkupsTest : public ::testing::Test {
 protected:
  Result<Markups> table(const std::string& text) {
    const auto path = folder_ / "F.fcsv";
    std::ofstream(path) << text;
    return read_markups(path);
  }
  Result<Markups> json(const Json& content) {
    const auto path = folder_ / "F.mrk.json";
    std::ofstream(path) << content.dump();
    return read_markups(path);
  }
  /// A list of two points as 3D Slicer writes it.
  static Json good() {
    Json point{{"id", "1"},
               {"label", "F-1"},
               {"description", ""},
               {"position", {1.5, 2, 3}},
               {"orientation", {-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0}},
               {"selected", true},
               {"positionStatus", "defined"}};
    Json second = point;
    second["label"] = "F-2";
    second["position"] = {4, 5, 6};
    return {{"@schema",
             "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
             "Resources/Schema/markups-schema-v1.0.3.json#"},
            {"markups", Json::array({{{"type", "Fiducial"},
                                      {"coordinateSystem", "LPS"},
                                      {"coordinateUnits", "mm"},
                                      {"controlPoints", {point, second}}}})}};
  }
  test::TemporaryFolder folder_;
};

constexpr const char* kHead = "# Markups fiducial file version = 4.13\n";
constexpr const char* kColumns =
    "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";

std::string rows() {
  return "vtkMRMLMarkupsFiducialNode_0,1.5,-2,3e1,0,0,0,1,1,1,0,F-1,,\r\n"
         "vtkMRMLMarkupsFiducialNode_1,4,5,6,0,0,0,1,1,1,0,\"tip, \"\"left\"\"\",,\r\n";
}

TEST_F(MarkupsTest, TablesOfEitherSystemGiveTheSamePoints) {
  const Eigen::Vector3d lps(1.5, -2, 30);
  const Eigen::Vector3d ras(-1.5, 2, 30);
  for (const auto& [system, expected] :
       {std::pair{"LPS", lps}, {"1", lps}, {"RAS", ras}, {"0", ras}}) {
    const auto read =
        table(kHead + ("# CoordinateSystem = " + std::string(system) + "\n") + kColumns + rows());
    ASSERT_TRUE(test::has_value(read));
    ASSERT_EQ(read->lists.size(), 1U);
    ASSERT_EQ(read->lists[0].size(), 2U);
    EXPECT_EQ(read->lists[0][0].lps_mm, expected) << system;
    EXPECT_EQ(read->lists[0][0].name, "F-1");
    EXPECT_EQ(read->lists[0][1].name, "tip, \"left\"");
    EXPECT_TRUE(read->findings.empty());
    EXPECT_EQ(read->lists[0][0].ras_mm(), Eigen::Vector3d(-expected.x(), -expected.y(), 30));
  }
}

TEST_F(MarkupsTest, ColumnsOfATableAreFoundByTheirNames) {
  const auto read = table(kHead + std::string("# name = paths\n# coordinateSystem = LPS\n"
                                              "# columns = label,z,y,x\nentry,3,2,1\n"));
  ASSERT_TRUE(test::has_value(read));
  EXPECT_EQ(read->lists[0][0].lps_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read->lists[0][0].name, "entry");
}

TEST_F(MarkupsTest, PointsWithoutAPositionAreNamed) {
  // 3D Slicer 5.4 writes the status behind the columns that it names: 3 missing, 2 defined,
  // 0 undefined.
  const auto read = table(kHead + std::string("# CoordinateSystem = LPS\n") + kColumns +
                          "1,-322.5,0,-35.9,0,0,0,1,1,1,0,crossed,,,3,0\n"
                          "2,-517.4,1,122.9,0,0,0,1,1,1,1,locked,,,2,0\n"
                          "3,-361.6,2,44.8,0,0,0,1,1,1,0,editing,,,0,0\n");
  ASSERT_TRUE(test::has_value(read));
  ASSERT_EQ(read->lists[0].size(), 3U);
  EXPECT_FALSE(read->lists[0][0].placed);
  EXPECT_TRUE(read->lists[0][1].placed);
  EXPECT_FALSE(read->lists[0][2].placed);
  ASSERT_EQ(read->findings.size(), 1U);
  EXPECT_EQ(read->findings[0].key, "positionStatus");
  EXPECT_EQ(read->findings[0].values[0], "2 of 3 points without a position: crossed, editing");
  for (const char* status : {"undefined", "preview", "missing"}) {
    Json content = good();
    content["markups"][0]["controlPoints"][1]["positionStatus"] = status;
    content["markups"][0]["controlPoints"][1]["position"] = nullptr;
    const auto made = json(content);
    ASSERT_TRUE(test::has_value(made)) << status;
    EXPECT_FALSE(made->lists[0][1].placed);
    EXPECT_EQ(made->findings.at(0).values[0], "1 of 2 points without a position: F-2");
    content["markups"][0]["controlPoints"].erase(0);
    EXPECT_TRUE(test::rejects(json(content), ErrorCode::kMalformedData,
                              {"F.mrk.json: expected points, found none with a position"}));
  }
}

TEST_F(MarkupsTest, JsonOfEitherSystemGivesTheSamePoints) {
  const auto lps = json(good());
  ASSERT_TRUE(test::has_value(lps));
  EXPECT_EQ(lps->lists[0][0].lps_mm, Eigen::Vector3d(1.5, 2, 3));
  EXPECT_EQ(lps->lists[0][1].name, "F-2");
  Json content = good();
  content["markups"][0]["coordinateSystem"] = "RAS";
  content["markups"].push_back(good()["markups"][0]);
  const auto both = json(content);
  ASSERT_TRUE(test::has_value(both));
  ASSERT_EQ(both->lists.size(), 2U);
  EXPECT_EQ(both->lists[0][0].lps_mm, Eigen::Vector3d(-1.5, -2, 3));
  EXPECT_EQ(both->lists[1][0].lps_mm, Eigen::Vector3d(1.5, 2, 3));
}

TEST_F(MarkupsTest, NamesWhatIsWrongInATable) {
  const auto expect = [&](const std::string& text, std::initializer_list<std::string> pieces) {
    EXPECT_TRUE(test::rejects(table(text), ErrorCode::kMalformedData, pieces)) << text;
  };
  const std::string lps = "# CoordinateSystem = LPS\n";
  expect("", {"F.fcsv: expected points, found none"});
  expect("1,2,3\n", {"F.fcsv:1", "version"});
  expect(kHead + rows(), {"F.fcsv:2", "CoordinateSystem"});
  expect(kHead + std::string("# CoordinateSystem = 2\n"), {"F.fcsv:2", "CoordinateSystem", "'2'"});
  expect(kHead + lps + "# CoordinateSystem = RAS\n", {"F.fcsv:3", "LPS and RAS"});
  expect(kHead + lps + "0,1,x,3\n", {"F.fcsv:3", "y: expected a finite number, found 'x'"});
  expect(kHead + lps + "0,1,2\n", {"F.fcsv:3", "z: expected a finite number, found 'nothing'"});
  expect(kHead + lps + "0,1,nan,3\n", {"F.fcsv:3", "y: expected"});
  expect(kHead + lps + "0,1,1e300,3\n", {"F.fcsv:3", "within 1e7 mm"});
  expect(kHead + lps + "0,1,\x1b[31m,3\n", {"F.fcsv:3", "'\\x1b[31m'"});
  expect(kHead + lps + "# columns = id,y,z\n0,1,2\n", {"F.fcsv:4", "none named x"});
}

TEST_F(MarkupsTest, NamesWhatIsWrongInJson) {
  const auto expect = [&](const Json& content, std::initializer_list<std::string> pieces) {
    EXPECT_TRUE(test::rejects(json(content), ErrorCode::kMalformedData, pieces)) << content;
  };
  expect(Json::array(), {"F.mrk.json", "an object"});
  Json content = good();
  content.erase("@schema");
  expect(content, {"F.mrk.json.@schema", "markups-schema-v1"});
  content = good();
  content["@schema"] = "markups-schema-v2.0.0.json";
  expect(content, {"F.mrk.json.@schema", "v2.0.0"});
  content = good();
  content.erase("markups");
  expect(content, {"F.mrk.json.markups", "a list"});
  content = good();
  content["markups"][0].erase("coordinateSystem");
  expect(content, {"markups[0].coordinateSystem: expected LPS or RAS, found null"});
  content["markups"][0]["coordinateSystem"] = 0;
  expect(content, {"markups[0].coordinateSystem: expected text, found 0"});
  content["markups"][0]["coordinateSystem"] = "0";
  expect(content, {"markups[0].coordinateSystem: expected LPS or RAS, found \"0\""});
  content = good();
  content["markups"][0]["coordinateUnits"] = "m";
  expect(content, {"markups[0].coordinateUnits: expected mm, found \"m\""});
  content = good();
  content["markups"][0]["controlPoints"][1]["position"] = {1, 2};
  expect(content, {"markups[0].controlPoints[1].position: expected 3 numbers, found [1,2]"});
  content["markups"][0]["controlPoints"][1].erase("position");
  expect(content, {"markups[0].controlPoints[1].position: expected 3 numbers, found null"});
  content = good();
  content["markups"][0]["controlPoints"][0]["positionStatus"] = "lost";
  expect(content, {"controlPoints[0].positionStatus: expected defined, undefined, preview"});
}

}  // namespace
}  // namespace nav::io
