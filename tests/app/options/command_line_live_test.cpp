// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Live sessions on the command line.
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "devices/openigtlink/openigtlink_server.hpp"
#include "io/image_output.hpp"
#include "tests/app/options/command_line_support.hpp"

namespace nav::app {
namespace {

class CommandLineLiveTest : public CommandLineTest {
 protected:
  std::string write_session(const std::string& devices) {
    const auto path = folder_ / "live.toml";
    std::ofstream(path) << "[source]\nkind = \"live\"\n" << devices;
    return path.string();
  }
  std::string simulated_session(const std::string& more = "") {
    return write_session("[[devices]]\nid = \"bench\"\nkind = \"simulated\"\nduration_s = 20\n" +
                         more);
  }
  /// Calibration that places images on the probe.
  void write_calibration() const {
    std::ofstream(folder_ / "plus.xml")
        << "<PlusConfiguration><CoordinateDefinitions><Transform From=\"Image\" To=\"Probe\" "
           "Matrix=\"0.2 0 0 0 0 0.2 0 0 0 0 0.2 0 0 0 0 1\"/></CoordinateDefinitions>"
           "</PlusConfiguration>";
  }
};

TEST_F(CommandLineLiveTest, ShowsTheLivePlaneOfASimulatedDevice) {
  const std::string session = simulated_session("needle = true\n");
  const std::string out = (folder_ / "live").string();
  const Outcome live = sonde("live --session " + session + " --ct " + write_ct() + " --out " + out +
                             " --width 160 --height 120 --step 1 --frames 4");
  EXPECT_EQ(live.code, 0) << live.errors;
  const auto report = io::Json::parse(text_of(folder_ / "live" / "report.json"));
  EXPECT_EQ(report["images"], 4);
  EXPECT_EQ(report["ledger_balanced"], true);
  EXPECT_TRUE(report["latency_ms"]["rendered"].contains("p95"));
  const auto& device = report["devices"][0];
  EXPECT_EQ(device["id"], "bench");
  EXPECT_EQ(device["state"], "streaming");
  ASSERT_EQ(device["streams"].size(), 4U);
  for (const auto& stream : device["streams"]) {
    EXPECT_GT(stream["received"].get<int>(), 0) << stream["name"];
    EXPECT_TRUE(stream["period_ms"].contains("p99"));
  }
  for (const char* file : {"live_00000.png", "live_00003.png", "pose_log.csv", "session.toml"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "live" / file)) << file;
  }
  // The session file that it wrote starts the same session again.
  const Outcome again = sonde("live --print-session --session " + out + "/session.toml");
  EXPECT_EQ(again.code, 0) << again.errors;
  EXPECT_NE(again.output.find("bench"), std::string::npos) << again.output;
}

TEST_F(CommandLineLiveTest, SaysWhatComesFromEachDevice) {
  const Outcome devices = sonde("devices --seconds 1.5 --json - --session " + simulated_session());
  EXPECT_EQ(devices.code, 0) << devices.errors;
  const auto report = io::Json::parse(devices.output);
  EXPECT_EQ(report["devices"][0]["streams"][0]["name"], "Probe");
  EXPECT_EQ(report["ledger_balanced"], true);
  const Outcome text = sonde("devices --seconds 1.5 --session " + simulated_session());
  EXPECT_NE(text.output.find("bench (simulated): streaming"), std::string::npos) << text.output;
}

TEST_F(CommandLineLiveTest, ARecordingOfDevicesIsShownExportedAndReplayed) {
  const auto path = (folder_ / "recording.mcap").string();
  const std::string record =
      "record --seconds 2.5 --out " + path + " --session " + simulated_session("needle = true\n");
  const Outcome recorded = sonde(record + " --json -");
  EXPECT_EQ(recorded.code, 0) << recorded.errors;
  const auto account = io::Json::parse(recorded.output)["recording"];
  EXPECT_EQ(account["lost"], 0);
  EXPECT_EQ(account["written"], account["received"]);
  expect_rejection(record, 3, {"recording.mcap"});

  const Outcome info = sonde("info " + path + " --json -");
  EXPECT_EQ(info.code, 0) << info.errors;
  const auto shown = io::Json::parse(info.output);
  EXPECT_EQ(shown["samples"], account["written"]);
  EXPECT_EQ(shown["finished"], true);
  EXPECT_TRUE(shown["devices"]["bench"].contains("Needle"));

  const auto sequence = (folder_ / "sweep.igs.mha").string();
  const Outcome exported = sonde("export " + path + " --out " + sequence);
  EXPECT_EQ(exported.code, 0) << exported.errors;
  const Outcome read = sonde("info " + sequence + " --json -");
  EXPECT_TRUE(io::Json::parse(read.output)["transforms"].contains("NeedleTipToTracker"))
      << read.output;

  for (const std::string& sweep : {path, sequence}) {
    const Outcome replay =
        sonde("replay " + sweep + " --ct " + write_ct() + " --out " + (folder_ / "out").string() +
              " --width 160 --height 120 --step 1 --frames 2 --json " +
              (folder_ / "replay.json").string());
    EXPECT_EQ(replay.code, 0) << replay.errors;
    EXPECT_GT(read_json("replay.json")["ledger"]["received"].get<int>(), 10);
  }
}

TEST_F(CommandLineLiveTest, ButtonsCaptureFreezeAndMark) {
  // It is frozen long enough that the images of one second are missing.
  const std::string session = simulated_session(
      "buttons = [{name = \"left\", action = \"mark\", pressed_at_s = [0.5, 3.5]},\n"
      "{name = \"middle\", action = \"capture\", pressed_at_s = [2.0]},\n"
      "{name = \"right\", action = \"freeze\", pressed_at_s = [1.5, 3.0]}]\n");
  const Outcome live =
      sonde("live --session " + session + " --ct " + write_ct() + " --out " +
            (folder_ / "live").string() + " --width 160 --height 120 --step 2 --seconds 6");
  EXPECT_EQ(live.code, 0) << live.errors;
  const auto report = io::Json::parse(text_of(folder_ / "live" / "report.json"));
  EXPECT_EQ(report["captures"], 1);
  EXPECT_EQ(report["ledger_balanced"], true);
  ASSERT_EQ(report["buttons"].size(), 5U) << report["buttons"];
  EXPECT_EQ(report["buttons"][0]["action"], "mark");
  EXPECT_EQ(report["buttons"][1]["button"], "right");
  const auto seconds_of = [&](std::size_t i) {
    return report["buttons"][i]["time_s"].get<double>();
  };
  EXPECT_NEAR(seconds_of(3) - seconds_of(1), 1.5, 1e-6);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "live/capture_00000.png"));
  EXPECT_NE(live.errors.find("frozen at"), std::string::npos) << live.errors;
  EXPECT_NE(live.errors.find("live again at"), std::string::npos) << live.errors;
  EXPECT_NE(live.errors.find("nothing is recorded"), std::string::npos) << live.errors;
}

TEST_F(CommandLineLiveTest, MarksAreRecordedListedAndExported) {
  const auto path = (folder_ / "marked.mcap").string();
  const std::string session = simulated_session(
      "buttons = [{name = \"left\", action = \"mark\", pressed_at_s = [1.0, 1.5]}]\n");
  const Outcome recorded = sonde("record --seconds 4 --out " + path + " --session " + session);
  EXPECT_EQ(recorded.code, 0) << recorded.errors;
  const Outcome info = sonde("info " + path + " --json -");
  EXPECT_EQ(info.code, 0) << info.errors;
  const auto shown = io::Json::parse(info.output);
  EXPECT_EQ(shown["devices"]["bench"]["left"]["type"], "button");
  EXPECT_EQ(shown["devices"]["bench"]["left"]["action"], "mark");
  ASSERT_EQ(shown["buttons"].size(), 2U);
  EXPECT_EQ(shown["buttons"][1]["button"], "left");
  EXPECT_NEAR(
      shown["buttons"][1]["time_s"].get<double>() - shown["buttons"][0]["time_s"].get<double>(),
      0.5, 1e-6);
  const auto sequence = folder_ / "marked.igs.mha";
  const Outcome exported = sonde("export " + path + " --out " + sequence.string());
  EXPECT_EQ(exported.code, 0) << exported.errors;
  // An image names all marks since the one before it.
  const std::string header = text_of(sequence);
  EXPECT_THAT(header, testing::HasSubstr("_ButtonPresses = mark left"));
  std::size_t marks = 0;
  for (std::size_t at = 0; (at = header.find("mark left", at)) < header.size(); ++at) ++marks;
  EXPECT_EQ(marks, 2U);
}

/// Image of marker 0 of the dictionary 4x4_50, from the front.
Image2d<Rgba8> marker_image(int width, int height, std::uint8_t white) {
  constexpr int kCell = 14, kCells = 6, kLeft = 110, kTop = 80;
  constexpr const char* kBits =
      "000000"
      "010110"
      "001010"
      "000110"
      "000100"
      "000000";
  std::vector<Rgba8> pixels;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int column = (x - kLeft) / kCell, row = (y - kTop) / kCell;
      const bool inside = x >= kLeft && y >= kTop && column < kCells && row < kCells;
      const bool black = inside && kBits[row * kCells + column] == '0';
      const std::uint8_t grey = black ? 20 : white;
      pixels.push_back({grey, grey, grey, 255});
    }
  }
  return {width, height, std::move(pixels)};
}

TEST_F(CommandLineLiveTest, ACameraTracksMarkersAndGrabsAScreen) {
  for (int i = 0; i < 6; ++i) {
    const auto file = folder_ / ("frame_" + std::to_string(i) + ".png");
    const auto white = static_cast<std::uint8_t>(200 + i);  // No image repeats.
    ASSERT_TRUE(test::has_value(io::write_png(marker_image(320, 240, white), file)));
  }
  std::ofstream(folder_ / "camera.yml")
      << "%YAML:1.0\n---\nimage_width: 320\nimage_height: 240\ncamera_matrix: !!opencv-matrix\n"
         "   rows: 3\n   cols: 3\n   dt: d\n   data: [ 400., 0., 160., 0., 400., 120., 0., 0., 1. "
         "]\n"
         "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n"
         "   data: [ 0., 0., 0., 0. ]\n";
  const std::string film = "address = \"film:frame_%d.png\"\nimages_hz = 20\n";
  const std::string session = write_session(
      "[[devices]]\nid = \"camera\"\nkind = \"camera-markers\"\n" + film +
      "camera = \"camera.yml\"\nbodies = [{name = \"Probe\", tool = \"marker:0:30\"}]\n"
      "[[devices]]\nid = \"screen\"\nkind = \"frame-grabber\"\n" +
      film + "image = \"Image\"\ncrop = [10, 20, 200, 100]\n");
  const Outcome devices = built_sonde("devices --seconds 1.5 --json - --session " + session);
  if (devices.errors.find("has no cameras") != std::string::npos) {
    GTEST_SKIP() << "built without cameras";
  }
  EXPECT_EQ(devices.code, 0) << devices.errors;
  const auto report = io::Json::parse(devices.output);
  EXPECT_EQ(report["devices"][0]["streams"][0]["received"], 6);
  EXPECT_EQ(report["devices"][0]["streams"][0]["name"], "Probe");
  EXPECT_EQ(report["devices"][1]["streams"][0]["received"], 6);
  EXPECT_EQ(report["devices"][1]["cause"], "film_ended");
  std::filesystem::remove(folder_ / "camera.yml");
  const Outcome missing = built_sonde("devices --seconds 0.5 --session " + session);
  EXPECT_EQ(missing.code, 3) << missing.errors;
  EXPECT_NE(missing.errors.find("camera.yml: expected the calibration"), std::string::npos)
      << missing.errors;
}

TEST_F(CommandLineLiveTest, AFootSwitchThatIsNotThereIsNamedWithWhatToDo) {
  const std::string session = write_session(
      "[[devices]]\nid = \"pedal\"\nkind = \"footswitch\"\naddress = "
      "\"input:/nonexistent/event0\"\n"
      "buttons = [{name = \"left\", key = \"BTN_0\", action = \"mark\"}]\n");
  const Outcome away = sonde("devices --seconds 0.5 --session " + session);
  EXPECT_EQ(away.code, 4);
  for (const char* words : {"pedal: expected the device of button left, found it missing",
                            "/nonexistent/event0", "plug it in"}) {
    EXPECT_NE(away.errors.find(words), std::string::npos) << words << "\n" << away.errors;
  }
  const auto with = [&](const std::string& button) {
    return write_session(
        "[[devices]]\nid = \"pedal\"\nkind = \"footswitch\"\naddress = \"hid:05f3:00ff\"\n"
        "buttons = [{name = \"left\", key = \"BTN_0\", " +
        button + "}]\n");
  };
  expect_rejection("devices --session " + with("action = \"accept\""), 3,
                   {"buttons[0].action", "capture, freeze, mark or none", "accept"});
  expect_rejection("devices --session " + with("frame = 3"), 3, {"live.toml:7", "frame"});
}

TEST_F(CommandLineLiveTest, ADeviceThatIsNotThereEndsWithCode4) {
  write_calibration();
  const std::string session = write_session(
      "calibration = \"plus.xml\"\n[[devices]]\nid = \"plus\"\nkind = \"openigtlink\"\n"
      "address = \"tcp:127.0.0.1:1\"\nimage = \"Image\"\nbodies = [{name = \"Probe\"}]\n");
  expect_rejection("devices --seconds 0.5 --session " + session, 4,
                   {"plus", "ProbeToTracker", "nothing listens there"});
}

/// A port that nothing listens at.
std::uint16_t free_port() {
  CollectingDiagnostics diagnostics;
  return (*devices::OpenIgtLinkServer::start({}, diagnostics))->port();
}

TEST_F(CommandLineLiveTest, EmulatesATrackerThatAnotherSessionReads) {
  const std::string line = (folder_ / "ttyNDI").string();
  const std::string port = std::to_string(free_port());
  const std::string served = simulated_session();
  const std::string account = (folder_ / "emulated.json").string();
  const pid_t emulator = ::fork();
  ASSERT_GE(emulator, 0);
  if (emulator == 0) {
    ::_exit(sonde("emulate ndi --faults 0.02 --port " + port + " --seconds 12 --json " + account +
                  " --session " + served + " --line serial:" + line)
                .code);
  }
  for (int i = 0; i < 4000 && !std::filesystem::is_symlink(line); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const auto client = folder_ / "client.toml";
  std::ofstream(client) << "[source]\nkind = \"live\"\ncalibration = \"plus.xml\"\n"
                           "[[devices]]\nid = \"tracker\"\nkind = \"ndi\"\naddress = \"serial:"
                        << line
                        << "\"\nbodies = [{name = \"Probe\", tool = \"port:1\"}, {name = "
                           "\"Reference\", tool = \"port:2\"}]\n[[devices]]\nid = \"scanner\"\n"
                           "kind = \"openigtlink\"\nimage = \"Image\"\naddress = \"tcp:127.0.0.1:"
                        << port << "\"\n";
  write_calibration();
  const Outcome devices = sonde("devices --seconds 7 --json - --session " + client.string());
  int status = 0;
  ASSERT_EQ(::waitpid(emulator, &status, 0), emulator);
  EXPECT_EQ(devices.code, 0) << devices.errors;
  const auto report = io::Json::parse(devices.output);
  EXPECT_EQ(report["devices"][0]["state"], "streaming");
  EXPECT_EQ(report["devices"][0]["firmware"], "Sonde tracker, EMULATED");
  for (const auto& device : report["devices"]) {
    for (const auto& stream : device["streams"]) {
      EXPECT_GT(stream["received"].get<int>(), 3) << stream["name"];
    }
  }
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_GT(io::Json::parse(text_of(account))["commands"].get<int>(), 20);
}

/// The devices of USB are read over USB/IP, which needs no USB in this machine.
TEST_F(CommandLineLiveTest, EmulatesDevicesOfUsbThatAnotherSessionReads) {
  const std::string served = simulated_session();
  write_calibration();
  const auto run = [&](const std::string& kind, const std::string& keys) {
    const std::string line = std::to_string(free_port()), port = std::to_string(free_port());
    const std::string account = (folder_ / (kind + ".json")).string();
    const pid_t emulator = ::fork();
    if (emulator == 0) {
      ::_exit(sonde("emulate " + kind + " --port " + port + " --seconds 12 --json " + account +
                    " --session " + served + " --line tcp:" + line)
                  .code);
    }
    const auto client = folder_ / (kind + ".toml");
    std::ofstream(client) << "[source]\nkind = \"live\"\ncalibration = \"plus.xml\"\n"
                          << "[[devices]]\nid = \"usb\"\nkind = \"" << kind
                          << "\"\naddress = \"usbip:127.0.0.1:" << line << "\"\n"
                          << keys;
    const Outcome devices = sonde("devices --seconds 7 --json - --session " + client.string());
    int status = 0;
    EXPECT_EQ(::waitpid(emulator, &status, 0), emulator);
    EXPECT_EQ(WEXITSTATUS(status), 0);
    EXPECT_EQ(devices.code, 0) << devices.errors;
    const auto report = io::Json::parse(devices.output);
    EXPECT_EQ(report["devices"][0]["state"], "streaming") << devices.errors;
    for (const auto& stream : report["devices"][0]["streams"]) {
      EXPECT_GT(stream["received"].get<int>(), 3) << stream["name"];
    }
    EXPECT_GT(io::Json::parse(text_of(account))["transfers"].get<int>(), 20);
  };
  run("polhemus",
      "bodies = [{name = \"Probe\", station = 1}, {name = \"Reference\", station = 2}]\n");
  run("interson",
      "image = \"Image\"\nhigh_voltage = 100\nradius_mm = 60\ndepth_mm = 80\nangle_deg = 60\n");
}

TEST_F(CommandLineLiveTest, KeysOfUsbDevicesAreReadAndWritten) {
  const std::string session = write_session(
      "[[devices]]\nid = \"tracker\"\nkind = \"polhemus\"\naddress = \"usb:0f44:ff20\"\n"
      "hemisphere = [0, 0, -1]\ndistortion_limit = 7\n"
      "bodies = [{name = \"Probe\", station = 3}]\n"
      "[[devices]]\nid = \"probe\"\nkind = \"interson\"\naddress = \"usb:1921:0090\"\n"
      "image = \"Image\"\nhigh_voltage = 90\nfrequency = 2\nimages_hz = 12.5\nradius_mm = 21\n"
      "depth_mm = 99\nangle_deg = 61\n");
  const Outcome shown = sonde("live --print-session --session " + session + " --ct " + write_ct());
  EXPECT_EQ(shown.code, 0) << shown.errors;
  for (const char* key :
       {"hemisphere", "-1.0", "distortion_limit = 7", "station = 3", "high_voltage = 90",
        "frequency = 2", "images_hz = 12.5", "radius_mm = 21", "depth_mm = 99", "angle_deg = 61",
        "spacing_mm = 0.2"}) {
    EXPECT_NE(shown.output.find(key), std::string::npos) << key << "\n" << shown.output;
  }
  const std::string wrong = write_session(
      "[[devices]]\nid = \"tracker\"\nkind = \"polhemus\"\naddress = \"usb:0f44:ff20\"\n"
      "bodies = [{name = \"Probe\", tool = \"3\"}]\n");
  expect_rejection("live --session " + wrong + " --ct " + write_ct(), 3,
                   {"devices[0]", "tool", "name, station"});
}

TEST_F(CommandLineLiveTest, RejectsWhatCannotBeEmulated) {
  const std::string served = simulated_session();
  expect_rejection("emulate ndi --line /dev/ttyUSB0 --session " + served, 2,
                   {"--line: expected serial:PATH or tcp:PORT"});
  expect_rejection("emulate openigtlink --faults 0.1 --session " + served, 2,
                   {"--faults requires kind ndi"});
  expect_rejection("emulate polhemus --line serial:/tmp/x --session " + served, 2,
                   {"--line: expected tcp:PORT"});
  expect_rejection("emulate fastrak --session " + served, 2,
                   {"expected openigtlink, ndi, can-arm, polhemus or interson"});
  expect_rejection("emulate can-arm --session " + served, 2, {"can-arm requires --arm"});
  expect_rejection("emulate can-arm --arm " + served + " --session " + served, 2,
                   {"--arm", "--session"});
  const std::string arm = (folder_ / "arm.json").string();
  expect_rejection("emulate can-arm --line tcp:3 --arm " + arm + " --session " + served, 2,
                   {"--line: expected can:INTERFACE"});
  expect_rejection("emulate can-arm --line can:nocan7 --arm " + arm + " --session " + served, 4,
                   {"nocan7"});
  expect_rejection("emulate ndi --arm " + arm + " --session " + served, 2,
                   {"--arm requires kind can-arm"});
}

TEST_F(CommandLineLiveTest, OverwritesNothingThatItReads) {
  const std::string session = simulated_session();
  const std::string mcap = (folder_ / "r.mcap").string();
  for (const std::string& verb :
       {std::string("devices"), std::string("serve --port 0"), "record --out " + mcap}) {
    std::string run(verb);
    run.append(" --seconds 0.1 --session ").append(session).append(" --json ").append(session);
    expect_rejection(run, 2, {"--json", "--session"});
  }
  expect_rejection("record --session " + session + " --out " + mcap + " --json " + mcap, 2,
                   {"--json", "r.mcap"});
  const std::string out = (folder_ / "out").string();
  const std::string live = "live --session " + session + " --ct " + write_ct() + " --out " + out;
  expect_rejection(live + " --record " + out + "/report.json", 2, {"--record"});
  expect_rejection(live + " --record " + out + "/x.mkv", 2, {".mcap"});
  // A session that cannot start leaves no recording.
  expect_rejection("live --session " + session + " --ct " + (folder_ / "no.mha").string() +
                       " --out " + out + " --record " + mcap,
                   3, {"no.mha"});
  EXPECT_FALSE(std::filesystem::exists(mcap));
}

TEST_F(CommandLineLiveTest, RejectsKeysOfVeryManyParts) {
  std::string deep = "a";
  for (int i = 0; i < 60'000; ++i) deep += ".a";
  const auto path = folder_ / "deep.toml";
  std::ofstream(path) << deep << " = 1\n";
  expect_rejection("devices --session " + path.string(), 3, {"deep.toml:1", "128"});
}

/// A session with an NDI tracker, and images that never come.
std::string ndi_session(const std::string& address) {
  return "calibration = \"plus.xml\"\n[[devices]]\nid = \"tracker\"\nkind = \"ndi\"\naddress = \"" +
         address +
         "\"\nbaud = 57600\nbodies = [{name = \"Probe\", tool = \"probe.rom\"}, "
         "{name = \"Needle\", tool = \"port:2\"}]\n"
         "[[devices]]\nid = \"images\"\nkind = \"openigtlink\"\naddress = \"tcp:127.0.0.1:1\"\n"
         "image = \"Image\"\n";
}

TEST_F(CommandLineLiveTest, AnNdiTrackerIsNamedWithTheCause) {
  write_calibration();
  expect_rejection("devices --session " + write_session(ndi_session("/dev/ttyUSB0")), 3,
                   {"devices[0].address", "serial:/dev/"});
  expect_rejection(
      "devices --seconds 0.5 --session " + write_session(ndi_session("serial:/dev/no_such_port")),
      4, {"tracker", "Probe", "absent"});
}

TEST_F(CommandLineLiveTest, AToolDefinitionLiesBesideTheSessionFile) {
  write_calibration();
  const std::string session = write_session(ndi_session("tcp:127.0.0.1:1"));
  const Outcome printed = sonde("live --print-session --session " + session + " --ct " +
                                write_ct() + " --out " + (folder_ / "out").string());
  EXPECT_EQ(printed.code, 0) << printed.errors;
  const std::string file = (folder_ / "probe.rom").string();
  EXPECT_NE(printed.output.find("'" + file + "'"), std::string::npos) << printed.output;
  EXPECT_NE(printed.output.find("baud = 57600"), std::string::npos) << printed.output;
  EXPECT_NE(printed.output.find("'port:2'"), std::string::npos) << printed.output;
}

TEST_F(CommandLineLiveTest, NamesTheLineOfWhatItCannotUse) {
  const std::string live = "live --ct " + write_ct() + " --out " + (folder_ / "out").string();
  expect_rejection(live, 2, {"--session", "source.kind"});
  expect_rejection(live + " --session " + simulated_session("colour = 3\n"), 3,
                   {"live.toml:7", "devices[0].colour", "tracker"});
  expect_rejection(live + " --session " + write_session("[[devices]]\nkind = \"simulated\"\n"), 3,
                   {"devices[0].id"});
  expect_rejection(live + " --session " + write_session(""), 2, {"at least one device"});
  expect_rejection("replay --session " + simulated_session(), 2, {"sonde live"});
  const auto recording = folder_ / "recording.toml";
  std::ofstream(recording) << "[[devices]]\nid = \"a\"\nkind = \"simulated\"\n";
  expect_rejection(live + " --session " + recording.string(), 3, {"devices", "source.kind"});
}

}  // namespace
}  // namespace nav::app
