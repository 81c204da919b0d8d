// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Live sessions on the command line.
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "devices/openigtlink/openigtlink_server.hpp"
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

TEST_F(CommandLineLiveTest, ADeviceThatIsNotThereEndsWithCode4) {
  write_calibration();
  const std::string session = write_session(
      "calibration = \"plus.xml\"\n[[devices]]\nid = \"plus\"\nkind = \"openigtlink\"\n"
      "address = \"tcp:127.0.0.1:1\"\nimage = \"Image\"\nbodies = [{name = \"Probe\"}]\n");
  expect_rejection("devices --seconds 0.5 --session " + session, 4,
                   {"plus", "ProbeToTracker", "no_listener"});
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

TEST_F(CommandLineLiveTest, RejectsWhatCannotBeEmulated) {
  const std::string served = simulated_session();
  expect_rejection("emulate ndi --line /dev/ttyUSB0 --session " + served, 2,
                   {"--line: expected serial:PATH or tcp:PORT"});
  expect_rejection("emulate openigtlink --faults 0.1 --session " + served, 2,
                   {"--faults requires kind ndi"});
  expect_rejection("emulate polhemus --session " + served, 2, {"expected openigtlink or ndi"});
}

TEST_F(CommandLineLiveTest, OverwritesNothingThatItReads) {
  const std::string session = simulated_session();
  const std::string mcap = (folder_ / "r.mcap").string();
  for (const std::string& verb :
       {std::string("devices"), std::string("serve --port 0"), "record --out " + mcap}) {
    expect_rejection(verb + " --seconds 0.1 --session " + session + " --json " + session, 2,
                     {"--json", "--session"});
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
