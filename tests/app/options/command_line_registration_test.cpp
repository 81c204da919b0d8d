// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Registrations by landmarks and surfaces on the command line.
#include <algorithm>
#include <array>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "app/report.hpp"
#include "tests/app/options/command_line_support.hpp"

namespace nav::app {
namespace {

TEST_F(CommandLineTest, ARegistrationNeverMentionsAReplay) {
  const std::string arguments =
      "register " + write_sweep() + " --ct " + write_ct() + " --config " + write_config();
  const Outcome refused = sonde(arguments + " --probe-frame Stylus --image-frame Sono");
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.errors.find("plus.xml: expected frames that place Stylus in Tracker"),
            std::string::npos)
      << refused.errors;
  // A warning says that nothing tracks the patient.
  const Outcome flat = sonde(arguments);
  EXPECT_NE(flat.errors.find("recording: nothing tracks the patient"), std::string::npos);
  EXPECT_EQ((refused.errors + flat.errors).find("replay"), std::string::npos) << flat.errors;
}

TEST_F(CommandLineTest, RegistersByLandmarksAndReplayUsesTheResult) {
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,"
                           "ct_z_mm\nA,0,0,0,10,0,0\nB,50,0,0,60,0,0\nC,0,40,0,10,40,0\nD,0,0,30,"
                           "10,0,30\n";
  const std::string sweep = write_sweep();
  const std::string ct = write_ct();
  const auto result = folder_ / "registration.json";
  const Outcome outcome = sonde("register --landmarks " + points.string() + " --ct " + ct +
                                " --json " + result.string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json report = read_json("registration.json");
  EXPECT_NEAR(report["registration"]["fre_rms_mm"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(report["registration"]["ct_from_reference_mm"][3].get<double>(), 10, 1e-9);
  const Outcome replay = sonde(replay_arguments(sweep) + " --registration " + result.string());
  ASSERT_EQ(replay.code, 0) << replay.errors;
  EXPECT_EQ(read_json("replay.json")["placement"]["kind"], "registered");
  // One that holds at a phase of the breath is not shown at all times.
  io::Json moving = report;
  moving["breath"] = {{"supported", true}, {"accepted", true}};
  std::ofstream(result) << moving;
  expect_rejection(replay_arguments(sweep) + " --registration " + result.string(), 5,
                   {"registration.json", "breath"});
}

/// Points as 3D Slicer writes them, four numbers and labels each.
std::string write_fcsv(const std::filesystem::path& path, const std::string& system,
                       const std::string& rows) {
  std::ofstream(path) << "# Markups fiducial file version = 5.4\n# CoordinateSystem = " << system
                      << "\n# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,"
                         "associatedNodeID\n"
                      << rows;
  return path.string();
}

std::string write_markups(const std::filesystem::path& path, const std::string& system,
                          const std::vector<std::pair<std::string, Eigen::Vector3d>>& points) {
  io::Json list = io::Json::array();
  for (const auto& [label, mm] : points) {
    list.push_back(
        {{"label", label}, {"position", {mm.x(), mm.y(), mm.z()}}, {"positionStatus", "defined"}});
  }
  const io::Json file{
      {"@schema",
       "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/"
       "Resources/Schema/markups-schema-v1.0.3.json#"},
      {"markups", io::Json::array({{{"type", "Fiducial"},
                                    {"coordinateSystem", system},
                                    {"coordinateUnits", "mm"},
                                    {"controlPoints", list}}})}};
  std::ofstream(path) << file.dump();
  return path.string();
}

TEST_F(CommandLineTest, RegistersByMarkupsOf3dSlicerAndGivesItTheTransform) {
  // The CT lies 10 mm to the left of the patient's frame. Coordinates of the tracker are RAS in
  // 3D Slicer, those of the CT are LPS in Sonde.
  const std::string ras = write_fcsv(folder_ / "ras.fcsv", "RAS",
                                     "1,0,0,0,0,0,0,1,1,1,0,A,,\n2,50,0,0,0,0,0,1,1,1,0,B,,\n"
                                     "3,0,40,0,0,0,0,1,1,1,0,C,,\n4,0,0,30,0,0,0,1,1,1,0,D,,\n"
                                     "5,9,9,9,0,0,0,1,1,1,0,E,,,0,0\n");
  const std::string lps =
      write_markups(folder_ / "lps.mrk.json", "LPS",
                    {{"A", {0, 0, 0}}, {"B", {-50, 0, 0}}, {"C", {0, -40, 0}}, {"D", {0, 0, 30}}});
  // Another order, and a fifth point, whose partner has no position.
  const std::string ct_of_five = write_markups(folder_ / "ct5.mrk.json", "RAS",
                                               {{"D", {-10, 0, 30}},
                                                {"E", {1, 1, 1}},
                                                {"C", {-10, -40, 0}},
                                                {"B", {-60, 0, 0}},
                                                {"A", {-10, 0, 0}}});
  const std::string ct_of_four = write_fcsv(folder_ / "ct4.fcsv", "1",
                                            "1,10,0,0,0,0,0,1,1,1,0,P,,\n"
                                            "2,60,0,0,0,0,0,1,1,1,0,Q,,\n"
                                            "3,10,40,0,0,0,0,1,1,1,0,R,,\n"
                                            "4,10,0,30,0,0,0,1,1,1,0,S,,\n");
  const std::string ct = write_ct();
  const auto transform = folder_ / "ReferenceToRas.tfm";
  for (const auto& [reference, seen] : {std::pair{ras, ct_of_five}, {lps, ct_of_four}}) {
    std::filesystem::remove(transform);
    const Outcome made = sonde("register --landmarks " + reference + " --ct-landmarks " + seen +
                               " --ct " + ct + " --json " + (folder_ / "r.json").string() +
                               " --save-transform " + transform.string());
    ASSERT_EQ(made.code, 0) << made.errors;
    const io::Json report = read_json("r.json");
    const io::Json& pose = report["registration"]["ct_from_reference_mm"];
    const std::vector<double> expected{1, 0, 0, 10, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(pose[i].get<double>(), expected[i], 1e-9);
    EXPECT_EQ(report["registration"]["landmarks"].size(), 4U);
    EXPECT_EQ(
        report["findings"].dump().find("1 of 5 points without a position: E") != std::string::npos,
        reference == ras)
        << report["findings"];
  }
  // From the CT to the patient's frame, both in LPS: x' = 10 - x, y' = -y.
  std::istringstream text(text_of(transform));
  std::string line;
  while (std::getline(text, line) && !line.starts_with("Parameters: ")) continue;
  std::istringstream numbers(line.substr(std::string("Parameters: ").size()));
  for (const double expected : {-1, 0, 0, 0, -1, 0, 0, 0, 1, 10, 0, 0}) {
    double found = 0;
    numbers >> found;
    EXPECT_NEAR(found, expected, 1e-9) << line;
  }
  const Outcome replay =
      sonde(replay_arguments(write_sweep()) + " --ct-from-reference " + transform.string());
  ASSERT_EQ(replay.code, 0) << replay.errors;
  const io::Json placement = read_json("replay.json")["placement"];
  EXPECT_EQ(placement["kind"], "declared");
  EXPECT_NEAR(placement["ct_from_reference_mm"][3].get<double>(), 10, 1e-9);
  EXPECT_NEAR(placement["ct_from_reference_mm"][0].get<double>(), 1, 1e-9);
}

TEST_F(CommandLineTest, NamesWhatIsWrongWithMarkupsAndTransforms) {
  const std::vector<std::pair<std::string, Eigen::Vector3d>> four{
      {"A", {0, 0, 0}}, {"B", {50, 0, 0}}, {"C", {0, 40, 0}}, {"D", {0, 0, 30}}};
  const std::string reference = write_markups(folder_ / "ref.mrk.json", "RAS", four);
  const std::string by = "register --landmarks " + reference + " --ct-landmarks ";
  expect_rejection("register --landmarks " + reference, 2, {"--ct-landmarks"});
  const auto table = folder_ / "points.csv";
  std::ofstream(table) << "a,0,0,0,0,0,0\nb,40,0,0,40,0,0\nc,0,40,0,0,40,0\n";
  expect_rejection("register --landmarks " + table.string() + " --ct-landmarks " + reference, 2,
                   {"--ct-landmarks requires --landmarks with a Markups file"});
  const auto named = [&](const std::vector<std::pair<std::string, Eigen::Vector3d>>& points,
                         const std::string& system = "LPS") {
    return write_markups(folder_ / "ct.mrk.json", system, points);
  };
  expect_rejection(by + named({{"A", {0, 0, 0}}, {"B", {50, 0, 0}}}), 3,
                   {"ct.mrk.json: expected 4 points, as in ", "ref.mrk.json, found 2"});
  auto other = four;
  other[2].first = "X";
  expect_rejection(by + named(other), 3, {"ct.mrk.json: expected the labels of", "not 'C'"});
  // A CT behind the origin, whose points are inside it only as RAS.
  VoxelGrid grid;
  grid.size = {20, 20, 20};
  grid.spacing_mm = {4, 4, 4};
  grid.origin_mm = {20, 20, 0};
  const auto ct = folder_ / "away.mha";
  ASSERT_TRUE(test::has_value(io::write_ct_mha(
      *StoredVolume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), -900), "ct"), ct)));
  auto inside = four;
  for (auto& [name, mm] : inside) mm = Eigen::Vector3d(-30 - mm.x(), -30 - mm.y(), mm.z());
  expect_rejection(by + named(inside) + " --ct " + ct.string(), 3,
                   {"ct.mrk.json", "expected its Ct point inside the CT", "RAS instead of LPS?"});
  const std::string replay = replay_arguments(write_sweep()) + " --ct-from-reference ";
  const auto bent = folder_ / "bent.tfm";
  std::ofstream(bent) << "#Insight Transform File V1.0\nTransform: AffineTransform_double_3_3\n"
                         "Parameters: 2 0 0 0 1 0 0 0 1 0 0 0\nFixedParameters: 0 0 0\n";
  expect_rejection(replay + bent.string(), 3, {"bent.tfm: Parameters:", "rigid"});
  expect_rejection(replay + (folder_ / "none.tfm").string(), 3, {"none.tfm", "cannot open"});
  expect_rejection(replay + "1", 2, {"--ct-from-reference", "16 numbers or a transform file"});
  // An output that is no transform stays.
  const auto mine = folder_ / "mine.tfm";
  std::ofstream(mine) << "mine";
  expect_rejection(by + named(four) + " --save-transform " + mine.string(), 2,
                   {"--save-transform", "mine.tfm"});
  EXPECT_EQ(text_of(mine), "mine");
  expect_rejection(by + named(four) + " --save-transform a.txt", 2, {"--save-transform", ".tfm"});
  expect_rejection(by + named(four) + " --save-transform " + reference, 2, {"--save-transform"});
}

TEST_F(CommandLineTest, ARefusedRegistrationLeavesNoTransform) {
  const std::string reference =
      write_markups(folder_ / "ref.mrk.json", "RAS",
                    {{"A", {0, 0, 0}}, {"B", {50, 0, 0}}, {"C", {0, 40, 0}}, {"D", {0, 0, 30}}});
  const std::string ct =
      write_markups(folder_ / "ct.mrk.json", "LPS",
                    {{"A", {0, 0, 0}}, {"B", {0, 90, 0}}, {"C", {0, 40, 7}}, {"D", {20, 0, 30}}});
  const auto transform = folder_ / "a.tfm";
  std::ofstream(transform) << "#Insight Transform File V1.0\nTransform: "
                              "AffineTransform_double_3_3\nParameters: 1 0 0 0 1 0 0 0 1 0 0 0\n"
                              "FixedParameters: 0 0 0\n";
  const Outcome refused =
      sonde("register --landmarks " + reference + " --ct-landmarks " + ct + " --json " +
            (folder_ / "r.json").string() + " --save-transform " + transform.string());
  EXPECT_EQ(refused.code, 5) << refused.errors;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "r.json"));
  EXPECT_FALSE(std::filesystem::exists(transform));
}

TEST_F(CommandLineTest, RegistersByAgreeingLandmarksAndNamesTheOthers) {
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,"
                           "ct_z_mm,reference_sigma_x_mm,reference_sigma_y_mm,"
                           "reference_sigma_z_mm,ct_sigma_x_mm,ct_sigma_y_mm,ct_sigma_z_mm\n"
                           "A,0,0,0,10,0,0,.2,.2,1,.3,.3,1\nB,50,0,0,60,0,0,.2,.2,1,.3,.3,1\n"
                           "C,0,40,0,10,40,0,.2,.2,1,.3,.3,1\nD,0,0,30,10,0,30,.2,.2,1,.3,.3,1\n"
                           "Slipped,40,40,0,50,40,25,.2,.2,1,.3,.3,1\n";
  const Outcome outcome =
      sonde("register --landmarks " + points.string() + " --ct " + write_ct() + " --json -");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("'Slipped' is not used"), std::string::npos) << outcome.errors;
  const io::Json found = io::Json::parse(outcome.output)["registration"];
  ASSERT_EQ(found["rejected"].size(), 1u);
  EXPECT_EQ(found["rejected"][0]["name"], "Slipped");
  EXPECT_NEAR(found["rejected"][0]["distance_mm"].get<double>(), 25, 1e-6);
  EXPECT_EQ(found["landmarks"].size(), 4u);
  EXPECT_EQ(found["anisotropic"], true);
  EXPECT_NEAR(found["ct_from_reference_mm"][3].get<double>(), 10, 1e-6);
  EXPECT_GT(found["error_map"]["worst_rms_mm"].get<double>(),
            found["target_error_rms_mm"].get<double>());
}

TEST_F(CommandLineTest, NamesAWrongScaleOfLandmarksAndPointsOutsideTheCt) {
  const auto points = folder_ / "scaled.csv";
  const auto write = [&](double x_scale, double last_z) {
    std::ofstream file(points);
    file << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm\n";
    const std::vector<std::array<double, 3>> places = {{-8, -6, 1}, {7, -7, 9}, {0, 8, -7},
                                                       {-7, 4, 8},  {8, 3, -8}, {1, -8, -6}};
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto& [x, y, z] = places[i];
      file << "Point" << i << ',' << 6 * x << ',' << 6 * y << ',' << 6 * z << ',' << 6 * x * x_scale
           << ',' << 6 * y << ',' << (i == 5 ? last_z : 6 * z) << '\n';
    }
    return points.string();
  };
  expect_rejection("register --landmarks " + write(0.82, -36), 5,
                   {"18 % too close together along x", "pixel size"});
  const Outcome outcome = sonde("register --json - --landmarks " + points.string());
  const io::Json found = io::Json::parse(outcome.output)["registration"];
  EXPECT_TRUE(found["rejected"].empty()) << "innocent points are blamed";
  EXPECT_EQ(found["scale"]["axes"], "ct");
  EXPECT_NEAR(found["scale"]["factors"][0].get<double>(), 0.82, 0.01);
  EXPECT_EQ(found["reasons"].size(), 1u);
  expect_rejection("register --ct " + write_ct() + " --landmarks " + write(1, 5000), 3,
                   {"'Point5'", "inside the CT", "5000"});
}

TEST_F(CommandLineTest, RegistersPointsToASurfaceAndNamesWhatSlides) {
  // A hip roof of 80 x 60 mm, and the roof without its ends, which slides along the ridge.
  const auto points = folder_ / "points.txt";
  std::ofstream touched(points);
  for (int i = -9; i <= 9; ++i) {
    for (int j = -6; j <= 6; ++j) {
      const double x = 4.0 * i;
      const double y = 4.0 * j;
      touched << x + 5 << ' ' << y << ' ' << std::min(30 - std::abs(y), 40 - std::abs(x)) << '\n';
    }
  }
  touched.close();
  const auto mesh = [&](const std::string& name, const std::string& polygons) {
    std::ofstream(folder_ / name)
        << "# vtk DataFile Version 3.0\nroof\nASCII\nDATASET POLYDATA\nPOINTS 6 float\n-40 -30 0 "
           "40 -30 0 40 30 0 -40 30 0 -10 0 30 10 0 30\nPOLYGONS "
        << polygons << '\n';
    return (folder_ / name).string();
  };
  const std::string tail = " --points " + points.string() +
                           " --ct-from-reference '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1' --json -";
  const std::string on_roof = "register --surface " +
                              mesh("roof.vtk", "4 18\n4 0 1 5 4\n4 3 4 5 2\n3 0 4 3\n3 1 2 5") +
                              tail;
  // Half a turn leaves the roof as it is, so the start must be vouched for.
  expect_rejection(on_roof, 5, {"as well when turned by 180 degrees", "landmarks"});
  const Outcome outcome = sonde(on_roof + " --start-within 10");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json found = io::Json::parse(outcome.output);
  EXPECT_EQ(found["method"], "surface");
  EXPECT_NEAR(found["registration"]["ct_from_reference_mm"][3].get<double>(), -5, 0.2);
  // Cells of 4 mm make the ridges round.
  EXPECT_LT(found["registration"]["distance"]["mean_mm"].get<double>(), 0.5);
  // These points set in 3D Slicer, whose files have the tracker's x and y negated in LPS.
  std::vector<std::pair<std::string, Eigen::Vector3d>> set;
  std::ifstream again(points);
  for (Eigen::Vector3d mm; again >> mm.x() >> mm.y() >> mm.z();) {
    set.emplace_back("", Eigen::Vector3d(-mm.x(), -mm.y(), mm.z()));
  }
  const std::string markups = write_markups(folder_ / "points.mrk.json", "LPS", set);
  std::string by_markups = on_roof + " --start-within 10";
  by_markups.replace(by_markups.find(points.string()), points.string().size(), markups);
  const Outcome same = sonde(by_markups);
  ASSERT_EQ(same.code, 0) << same.errors;
  EXPECT_EQ(io::Json::parse(same.output)["registration"], found["registration"]);
  const std::string tent =
      "register --surface " + mesh("tent.vtk", "2 10\n4 0 1 5 4\n4 3 4 5 2") + tail;
  expect_rejection(tent, 5, {"does not determine"});
  const io::Json slides = io::Json::parse(sonde(tent).output)["registration"];
  EXPECT_FALSE(slides.contains("ct_from_reference_mm"));
  EXPECT_EQ(slides["refused_ct_from_reference_mm"].size(), 16U);
  expect_rejection("register --points " + points.string(), 2, {"--landmarks"});
  // Points have no breath, so the option has no effect and is rejected.
  const std::string by_points = "register --surface x.vtk --points " + points.string();
  expect_rejection(by_points + " --breath-period 4", 2, {"--points", "--breath-period"});
  expect_rejection(by_points + " --deformable", 2, {"--points", "--deformable"});
  // An offset that all points share goes into the pose by the surface; landmarks show it.
  const auto landmarks = [&](double shared_mm) {
    const auto path = folder_ / "second.csv";
    std::ofstream file(path);
    file << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm\n";
    for (int i = 0; i < 6; ++i) {
      const double x = 25.0 * (i % 3) - 25;
      const double y = 30.0 * (i / 3) - 15;
      const double z = 4.0 * i;
      file << i << ',' << x + 5 << ',' << y << ',' << z + shared_mm << ',' << x << ',' << y << ','
           << z << '\n';
    }
    return path.string();
  };
  const std::string by_both =
      "register --surface " + (folder_ / "roof.vtk").string() + " --points " + points.string();
  const Outcome agreed = sonde(by_both + " --landmarks " + landmarks(0) + " --json -");
  ASSERT_EQ(agreed.code, 0) << agreed.errors;
  const io::Json said = io::Json::parse(agreed.output)["registration"]["landmarks"];
  EXPECT_LT(said["apart_mm"].get<double>(), 0.5);
  EXPECT_LT(said["apart_mm"].get<double>(), said["limit_mm"].get<double>());
  expect_rejection(by_both + " --landmarks " + landmarks(8), 5, {"landmarks and shape", "apart"});
  expect_rejection(on_roof + " --start-within 2", 5, {"within 2.0 mm", "the start put them"});
  expect_rejection("register --start-within 2 --landmarks " + landmarks(0), 2, {"--points"});
  expect_rejection("register --surface x.vtk", 2, {"--points"});
  const std::string by_image = "register " + write_sweep() + " --ct " + write_ct();
  expect_rejection(by_image + " --effort lazy", 2, {"--effort", "quick", "usual", "lazy"});
  expect_rejection(by_image + " --effort quick --deformable", 2,
                   {"--effort quick", "--deformable"});
  expect_rejection(by_image + " --time-limit 0", 2, {"--time-limit", "more than 0", "found 0"});
  expect_rejection(by_image + " --loss huber", 2, {"--loss", "cauchy", "huber"});
  expect_rejection(by_image + " --scale wide", 2, {"--scale", "wide"});
  expect_rejection(by_image + " --breath-period 0.5", 2, {"--breath-period", "1 to 20", "0.5"});
  expect_rejection("register --deformable --ct " + write_ct(), 2, {"--deformable", "sweep"});
  expect_rejection(by_image + " --marker-towards up", 2, {"--marker-towards", "anterior", "up"});
  expect_rejection(by_image + " --marker-towards left" +
                       " --ct-from-reference '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'",
                   2, {"--marker-towards", "no start pose"});
  expect_rejection(by_points + " --marker-towards left", 2, {"--marker-towards", "sweep"});
}

TEST_F(CommandLineTest, LandmarksThatDoNotFitAreNeverShownAsRegistered) {
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,"
                           "ct_z_mm\nA,0,0,0,50,0,0\nB,50,0,0,0,0,0\nC,0,40,0,0,0,30\nD,0,0,30,"
                           "0,40,0\n";
  const auto result = folder_ / "registration.json";
  expect_rejection("register --landmarks " + points.string() + " --ct " + write_ct() + " --json " +
                       result.string(),
                   5, {"residual of the landmarks"});
  const io::Json refused = read_json("registration.json")["registration"];
  EXPECT_EQ(refused["accepted"], false);
  EXPECT_FALSE(refused.contains("ct_from_reference_mm"));
  EXPECT_EQ(refused["refused_ct_from_reference_mm"].size(), 16U);
  expect_rejection(replay_arguments(write_sweep()) + " --registration " + result.string(), 5,
                   {"registration.json", "not accepted"});
}

}  // namespace
}  // namespace nav::app
