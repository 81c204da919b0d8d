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
            "devices[0].kind: expected one of openigtlink, ndi, can-arm, footswitch, can-buttons, "
            "camera-markers, frame-grabber, polhemus, interson, simulated, recording, found 'ndj'");
  for (const char* address : {"127.0.0.1:18944", "tcp:18944", "tcp::18944", "tcp:host:0",
                              "tcp:host:65536", "tcp:host:12x", "tcp:host:", ""}) {
    EXPECT_NE(changed([&](auto& d) { d.address = address; }), "") << address;
  }
  for (const char* address : {"tcp:host:1", "tcp:[::1]:18944", "tcp:10.0.0.2:65535"}) {
    EXPECT_EQ(changed([&](auto& d) { d.address = address; }), "") << address;
  }
  EXPECT_NE(changed([](auto& d) { d.bodies.clear(), d.image.clear(); }), "");
  EXPECT_NE(changed([](auto& d) { d.bodies.push_back({"", "Tool"}); }), "");
  EXPECT_EQ(changed([](auto& d) {
              d.bodies.push_back({"Probe", "Other"});
            }),
            "devices[0].bodies: expected a name of its own for each, found 'Probe'");
  EXPECT_EQ(changed([](auto& d) {
              d.bodies = {{"Probe", "Tool"}, {"Reference", "Tool"}};
            }),
            "devices[0].bodies: expected a tool of its own for each (Probe, Reference), found "
            "'Tool'");
  const auto twice = validate({a_server(), a_server()});
  ASSERT_FALSE(twice);
  EXPECT_EQ(twice.error().message,
            "devices[1].id: expected an id of its own, found 'plus' as in devices[0]");
}

TEST(LiveDevicesTest, NamesTheKeyOfButtonsThatCannotBeUsed) {
  const DeviceOptions pedal{.id = "pedal",
                            .kind = "footswitch",
                            .address = "hid:05f3:00ff",
                            .buttons = {{.name = "left", .action = "mark", .key = "BTN_0"}}};
  const DeviceOptions box{.id = "box",
                          .kind = "can-buttons",
                          .address = "can:can0",
                          .buttons = {{.name = "left", .action = "freeze", .frame = 0x18A}}};
  EXPECT_EQ(rejection(pedal), "");
  EXPECT_EQ(rejection(box), "");
  const auto changed = [](DeviceOptions device, auto change) {
    change(device);
    return rejection(device);
  };
  EXPECT_EQ(changed(pedal, [](auto& d) { d.address = "input:/dev/input/event3"; }), "");
  for (const char* address :
       {"hid:05f3", "hid:5f3:00ff", "hid:05f3:00fg", "input:", "/dev/x", ""}) {
    EXPECT_NE(changed(pedal, [&](auto& d) { d.address = address; }), "") << address;
  }
  EXPECT_EQ(changed(pedal, [](auto& d) { d.buttons[0].action = "delete"; }),
            "devices[0].buttons[0].action: expected capture, freeze, mark or none, found 'delete'");
  EXPECT_EQ(changed(pedal, [](auto& d) { d.buttons[0].key = "BTN_X"; }),
            "devices[0].buttons[0].key: expected the name of a key (BTN_0, KEY_A, …) or its number "
            "up to 767, found 'BTN_X'");
  EXPECT_EQ(changed(pedal, [](auto& d) { d.buttons.clear(); }),
            "devices[0].buttons: foot switch: expected at least one button, found none");
  EXPECT_NE(changed(box, [](auto& d) { d.address = "can0"; }), "");
  EXPECT_NE(changed(box, [](auto& d) { d.buttons[0].byte = 8; }), "");
  EXPECT_NE(changed(box, [](auto& d) { d.silence_ms = -1; }), "");
  const DeviceOptions simulated{.id = "bench", .kind = "simulated"};
  const auto pressed = [&](std::vector<double> times) {
    return changed(simulated, [&](auto& d) {
      d.buttons = {{.name = "left", .action = "mark", .pressed_at_s = std::move(times)}};
    });
  };
  EXPECT_EQ(pressed({0, 1, 1.5}), "");
  EXPECT_NE(pressed({1, 1.1}), "");
  EXPECT_NE(pressed({2, 1}), "");
}

TEST(LiveDevicesTest, NamesTheKeyOfACameraThatCannotBeUsed) {
  const DeviceOptions camera{.id = "camera",
                             .kind = "camera-markers",
                             .address = "v4l2:/dev/video0",
                             .bodies = {{"Probe", "charuco:5x7:20:15"}, {"Needle", "marker:40:20"}},
                             .camera = "camera.yml"};
  const DeviceOptions grabber{.id = "screen",
                              .kind = "frame-grabber",
                              .address = "film:screen.avi",
                              .image = "Image",
                              .crop = {10, 20, 300, 200}};
  EXPECT_EQ(rejection(camera), "");
  EXPECT_EQ(rejection(grabber), "");
  const auto changed = [](DeviceOptions device, auto change) {
    change(device);
    return rejection(device);
  };
  EXPECT_EQ(changed(camera, [](auto& d) { d.address = "/dev/video0"; }),
            "devices[0].address: expected v4l2:/dev/video… or film:FILE, found '/dev/video0'");
  EXPECT_NE(changed(camera, [](auto& d) { d.camera.clear(); }).find("devices[0].camera"),
            std::string::npos);
  EXPECT_NE(changed(camera, [](auto& d) { d.bodies[1].tool = "marker:40"; })
                .find("devices[0].bodies[1].tool: expected marker:NUMBER:SIDE_MM"),
            std::string::npos);
  EXPECT_EQ(changed(camera, [](auto& d) { d.bodies[1].tool = "marker:3:20"; }),
            "devices[0].bodies[1].tool: expected markers of its own, found 3 as in bodies[0]");
  EXPECT_NE(changed(camera, [](auto& d) { d.dictionary = "4x5"; }), "");
  EXPECT_NE(changed(camera, [](auto& d) { d.width = -1; }), "");
  EXPECT_NE(changed(grabber, [](auto& d) { d.image.clear(); }), "");
  EXPECT_EQ(changed(grabber,
                    [](auto& d) {
                      d.depth_display = {1, 2, 3, 0};
                    }),
            "devices[0].depth_display: expected [left, top, width, height] in whole pixels, found "
            "'other numbers'");
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

TEST(LiveDevicesTest, NamesTheKeyOfAUsbDeviceThatCannotBeUsed) {
  const DeviceOptions tracker{
      .id = "tracker",
      .kind = "polhemus",
      .address = "usb:0f44:ff20",
      .bodies = {{.name = "Probe", .station = 1}, {.name = "Reference", .station = 2}}};
  const DeviceOptions probe{.id = "probe",
                            .kind = "interson",
                            .address = "usb:1921:0090:A7",
                            .image = "Image",
                            .high_voltage = 100,
                            .radius_mm = 20,
                            .depth_mm = 100,
                            .angle_deg = 60};
  EXPECT_EQ(rejection(tracker), "");
  EXPECT_EQ(rejection(probe), "");
  const auto changed = [](DeviceOptions device, auto change) {
    change(device);
    return rejection(device);
  };
  for (const char* address : {"usbip:127.0.0.1:3240", "usbip:[::1]:3240", "usb:0f44:ff20:A B"}) {
    EXPECT_EQ(changed(tracker, [&](auto& d) { d.address = address; }), "") << address;
  }
  for (const char* address : {"", "usb:", "usb:0f44", "usb:0f44:ff2", "usb:0f44:ff20:",
                              "usb:0f44:ff20x", "usb:0f44:fg20", "usbip:host", "hid:0f44:ff20"}) {
    EXPECT_NE(changed(tracker, [&](auto& d) { d.address = address; })
                  .find("devices[0].address: expected usb:VENDOR:PRODUCT (usb:0f44:ff20)"),
              std::string::npos)
        << address;
  }
  EXPECT_EQ(changed(tracker, [](auto& d) { d.bodies[1].station = 0; }),
            "devices[0]: Polhemus tracker: expected a station of 1 to 16, found 0");
  EXPECT_NE(changed(tracker, [](auto& d) { d.bodies[1].station = 1; }), "");
  EXPECT_NE(changed(tracker, [](auto& d) { d.bodies.clear(); }), "");
  EXPECT_NE(changed(tracker, [](auto& d) { d.hemisphere = {0, 0, 0}; }), "");
  EXPECT_EQ(changed(probe, [](auto& d) { d.high_voltage = 0; }),
            "devices[0]: Interson probe: expected 1 to 178 for high_voltage, found 0");
  EXPECT_NE(changed(probe, [](auto& d) { d.angle_deg = 0; }).find("angle_deg"), std::string::npos);
  EXPECT_NE(changed(probe, [](auto& d) { d.image.clear(); }), "");
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

TEST_F(LiveSessionFileTest, NamesABodyAndImagesThatSeveralDevicesGive) {
  write_calibration();
  DeviceOptions other = a_server();
  other.id = "other";
  other.bodies = {{"Probe", ""}};
  options_.devices.push_back(other);
  ASSERT_TRUE(test::has_value(open()));
  ASSERT_EQ(diagnostics_.entries().size(), 2U);
  const Finding poses = *diagnostics_.entries()[0].finding;
  EXPECT_EQ(poses.key, "source of the poses of Probe");
  EXPECT_EQ(poses.values, (std::vector<std::string>{"plus", "other"}));
  EXPECT_TRUE(poses.used.starts_with("plus; ")) << poses.used;
  EXPECT_EQ(diagnostics_.entries()[1].finding->key, "source of the images");
}

TEST_F(LiveSessionFileTest, ARecordingAsADeviceTakesItsCalibrationFromASequence) {
  const auto write = [&](const char* name, const char* transforms) {
    const auto path = folder_ / name;
    std::ofstream(path) << "ObjectType = Image\nNDims = 3\nBinaryData = True\n"
                           "DimSize = 3 2 1\nElementType = MET_UCHAR\n"
                           "UltrasoundImageOrientation = MF\nUltrasoundImageType = BRIGHTNESS\n"
                           "Seq_Frame0000_Timestamp = 1\nSeq_Frame0000_ImageStatus = OK\n"
                        << transforms << "ElementDataFile = LOCAL\nabcdef";
    return path;
  };
  const auto sweep =
      write("sweep.igs.mha",
            "Seq_Frame0000_ProbeToTrackerTransform = 1 0 0 9 0 1 0 0 0 0 1 0 0 0 0 1\n"
            "Seq_Frame0000_ProbeToTrackerTransformStatus = OK\n");
  options_.devices = {{.id = "file", .kind = "recording", .address = sweep.string()}};
  EXPECT_NE(error(), "") << "it has no calibration";
  options_.plus_config =
      write("calibration.mha",
            "Seq_Frame0000_ImageToProbeTransform = 0.2 0 0 1 0 0.2 0 2 0 0 0.2 3 0 0 0 1\n"
            "Seq_Frame0000_ImageToProbeTransformStatus = OK\n"
            "Seq_Frame0000_ProbeToTrackerTransform = 1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1\n");
  EXPECT_EQ(error(), "");
}

TEST_F(LiveSessionFileTest, NamesTheDeviceThatCannotBeOpened) {
  options_.devices = {{.id = "sim", .kind = "simulated", .family = "knee"}};
  EXPECT_TRUE(error().starts_with("sim: ")) << error();
  options_.devices = {{.id = "file", .kind = "recording", .address = "nothing.igs.mha"}};
  EXPECT_TRUE(error().starts_with("file: ")) << error();
}

}  // namespace
}  // namespace nav::session
