// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/live_devices.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "session/live_session.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::session {
namespace {

DeviceOptions a_server() {
  return {.id = "plus",
          .kind = "openigtlink",
          .address = "tcp:127.0.0.1:18944",
          .bodies = {{"Probe", ""}, {"Reference", ""}},
          .image = "Image"};
}

std::string rejection(const DeviceOptions& device) {
  const auto valid = validate(std::vector<DeviceOptions>{device});
  return valid ? "" : valid.error().message;
}

TEST(LiveDevicesTest, NamesTheKeyThatCannotBeUsed) {
  EXPECT_EQ(rejection(a_server()), "");
  const auto changed = [](auto change) {
    DeviceOptions device = a_server();
    change(device);
    return rejection(device);
  };
  EXPECT_EQ(changed([](auto& d) { d.id = "a b"; }),
            "devices[0].id: expected 1 to 64 letters, digits and _ - ., found 'a b'");
  EXPECT_EQ(changed([](auto& d) { d.kind = "ndj"; }),
            "devices[0].kind: expected one of openigtlink, ndi, can-arm, simulated, recording, "
            "found 'ndj'");
  for (const char* address : {"127.0.0.1:18944", "tcp:18944", "tcp::18944", "tcp:host:0",
                              "tcp:host:65536", "tcp:host:12x", "tcp:host:", ""}) {
    EXPECT_NE(changed([&](auto& d) { d.address = address; }), "") << address;
  }
  for (const char* address : {"tcp:host:1", "tcp:[::1]:18944", "tcp:10.0.0.2:65535"}) {
    EXPECT_EQ(changed([&](auto& d) { d.address = address; }), "") << address;
  }
  EXPECT_NE(changed([](auto& d) { d.bodies.clear(), d.image.clear(); }), "");
  EXPECT_NE(changed([](auto& d) { d.bodies.push_back({"", "Tool"}); }), "");
  const auto twice = validate({a_server(), a_server()});
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().message,
            "devices[1].id: expected an id of its own, found 'plus' as in devices[0]");
}

TEST(LiveDevicesTest, NamesTheKeyOfAnNdiTrackerThatCannotBeUsed) {
  const DeviceOptions good{
      .id = "tracker",
      .kind = "ndi",
      .address = "serial:/dev/ttyUSB0",
      .bodies = {{"Probe", "probe.rom"}, {"Needle", "port:1"}, {"Stylus", ""}}};
  EXPECT_EQ(rejection(good), "");
  const auto changed = [&](auto change) {
    DeviceOptions device = good;
    change(device);
    return rejection(device);
  };
  EXPECT_EQ(changed([](auto& d) { d.address = "tcp:localhost:8765"; }), "");
  EXPECT_EQ(changed([](auto& d) { d.bodies[1].tool = "port:2.1"; }), "");
  EXPECT_EQ(changed([](auto& d) { d.address = "/dev/ttyUSB0"; }),
            "devices[0].address: expected serial:/dev/… or tcp:host:port, found '/dev/ttyUSB0'");
  for (const char* address : {"serial:", "tcp:host", ""}) {
    EXPECT_NE(changed([&](auto& d) { d.address = address; }), "") << address;
  }
  EXPECT_EQ(changed([](auto& d) { d.bodies[1].tool = "port:x"; }),
            "devices[0].bodies[1].tool: expected a .rom file, port:NUMBER, or nothing, found "
            "'port:x'");
  for (const char* tool : {"port:", "port:0", "port:1.", "port:1.x", "port:-1"}) {
    EXPECT_NE(changed([&](auto& d) { d.bodies[1].tool = tool; }), "") << tool;
  }
  EXPECT_NE(changed([](auto& d) { d.bodies[2].tool = "port:1"; }), "") << "two tools at one port";
  EXPECT_NE(changed([](auto& d) { d.bodies[2].name = "Probe"; }), "");
  EXPECT_NE(changed([](auto& d) { d.bodies.clear(); }), "");
  EXPECT_NE(changed([](auto& d) { d.baud = 300; }), "");
}

class LiveSessionFileTest : public ::testing::Test {
 protected:
  /// Calibration that places the image on the probe, and more definitions.
  void write_calibration(const std::string& more = "") {
    options_.plus_config = folder_ / "plus.xml";
    std::ofstream(options_.plus_config) << "<PlusConfiguration><CoordinateDefinitions>"
                                           "<Transform From=\"Image\" To=\"Probe\" "
                                           "Matrix=\"0.2 0 0 1  0 0.2 0 2  0 0 0.2 3  0 0 0 1\"/>"
                                        << more << "</CoordinateDefinitions></PlusConfiguration>";
  }
  Result<LiveSession> open() { return LiveSession::open(options_, clock_, diagnostics_); }
  std::string error() {
    const auto opened = open();
    return opened ? "" : opened.error().message;
  }

  test::TemporaryFolder folder_;
  SourceOptions options_{.kind = SourceKind::kLive, .devices = {a_server()}};
  CollectingDiagnostics diagnostics_;
  MonotonicClock clock_;
};

TEST_F(LiveSessionFileTest, SaysWhatASessionLacks) {
  EXPECT_NE(error().find("source.calibration"), std::string::npos) << error();
  write_calibration();
  EXPECT_EQ(error(), "");
  options_.devices[0].image.clear();
  EXPECT_NE(error().find("ultrasound images"), std::string::npos) << error();
  options_.devices[0] = a_server();
  options_.devices[0].bodies = {{"Reference", ""}};
  EXPECT_NE(error().find("tracks the probe"), std::string::npos) << error();
  options_.devices.clear();
  EXPECT_NE(error().find("at least one device"), std::string::npos) << error();
}

TEST_F(LiveSessionFileTest, ATrackerAloneCanBeTried) {
  options_.devices[0].image.clear();
  EXPECT_NE(error().find("ultrasound images"), std::string::npos) << error();
  const auto opened = LiveSession::open(options_, clock_, diagnostics_, {}, true);
  ASSERT_TRUE(test::has_value(opened));
  ASSERT_FALSE(diagnostics_.entries().empty());
  EXPECT_NE(diagnostics_.entries()[0].message.find("no ultrasound plane can be shown"),
            std::string::npos);
}

TEST_F(LiveSessionFileTest, TakesTheTrackerAsReferenceWhereNothingTracksThePatient) {
  write_calibration();
  auto opened = open();
  ASSERT_TRUE(test::has_value(opened));
  EXPECT_EQ(opened->reference_frame(), "Reference");
  EXPECT_TRUE(diagnostics_.entries().empty());
  options_.devices[0].bodies = {{"Probe", "ProbeToReference"}};
  opened = open();
  ASSERT_TRUE(test::has_value(opened));
  EXPECT_EQ(opened->reference_frame(), "Tracker");
  ASSERT_EQ(diagnostics_.entries().size(), 1U);
  EXPECT_NE(diagnostics_.entries()[0].message.find("nothing tracks the patient"),
            std::string::npos);
}

TEST_F(LiveSessionFileTest, FindsTheBodyThatCarriesTheNeedle) {
  const auto role_of_stylus = [](const LiveSession& live) {
    return live.devices()[0].source->streams()[2].role;
  };
  write_calibration(
      "<Transform From=\"NeedleTip\" To=\"Stylus\" "
      "Matrix=\"1 0 0 0  0 1 0 0  0 0 1 150  0 0 0 1\"/>");
  options_.devices[0].bodies.push_back({"Stylus", ""});
  auto opened = open();
  ASSERT_TRUE(test::has_value(opened));
  EXPECT_EQ(role_of_stylus(*opened), ToolRole::kStylus);
  options_.needle_frame = "NeedleTip";
  opened = open();
  ASSERT_TRUE(test::has_value(opened));
  EXPECT_EQ(role_of_stylus(*opened), ToolRole::kNeedle);
  options_.needle_frame = "Stylus";  // Its origin is the tip.
  opened = open();
  ASSERT_TRUE(test::has_value(opened));
  EXPECT_EQ(role_of_stylus(*opened), ToolRole::kNeedle);
  options_.needle_frame = "CauteryTip";
  EXPECT_NE(error().find("CauteryTip"), std::string::npos) << error();
}

TEST_F(LiveSessionFileTest, NamesTheDeviceThatCannotBeOpened) {
  options_.devices = {{.id = "sim", .kind = "simulated", .family = "knee"}};
  EXPECT_TRUE(error().starts_with("sim: ")) << error();
  options_.devices = {{.id = "file", .kind = "recording", .address = "nothing.igs.mha"}};
  EXPECT_TRUE(error().starts_with("file: ")) << error();
}

}  // namespace
}  // namespace nav::session
