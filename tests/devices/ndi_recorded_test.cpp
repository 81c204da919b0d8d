// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <optional>
#include <sstream>
#include <string>

#include "devices/ndi/ndi_commands.hpp"
#include "devices/ndi/ndi_poses.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// The wire of four trackers, recorded in 2005 (IGSTK): every check and every content is read.
namespace nav::devices {
namespace {

struct Exchange {
  std::string command;  ///< Bytes with CR; empty: the tracker spoke by itself.
  std::string reply;
};

/// Bytes of a line of a log: "\x0D" and "\\\\" stand for one byte.
std::string unescaped(const std::string& text) {
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\' && i + 3 < text.size() && text[i + 1] == 'x') {
      bytes += static_cast<char>(std::stoi(text.substr(i + 2, 2), nullptr, 16));
      i += 3;
    } else if (text.compare(i, 2, "\\\\") == 0) {
      bytes += text[i++];
    } else {
      bytes += text[i];
    }
  }
  return bytes;
}

/// Lines "<time> : (INFO) <number>. command[<bytes>] …" and "receive[<bytes>] …".
std::map<int, Exchange> read_log(const std::filesystem::path& file) {
  std::map<int, Exchange> log;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    const auto info = line.find("(INFO) ");
    const auto open = line.find('[', info);
    const auto close = line.find("] ", open);
    if (info == std::string::npos || close == std::string::npos) continue;
    const int number = std::stoi(line.substr(info + 7));
    const std::size_t size = std::stoul(line.substr(open + 1));
    const std::string bytes = unescaped(line.substr(close + 2));
    EXPECT_EQ(bytes.size(), size) << line;
    const bool sent = line.substr(0, open).ends_with("command");
    (sent ? log[number].command : log[number].reply) += bytes;
  }
  return log;
}

const std::vector<std::string>& logs() {
  static const std::vector<std::string> names = {
      "aurora_stream_11_05_2005.txt", "polaris_stream_07_27_2005.txt",
      "polaris_stream_08_31_2005_NDICommandInterpreter.txt", "polaris_stream_09_29_2005.txt",
      "polaris_stream_11_05_2005.txt"};
  return names;
}

void read_content(const std::string& command, const NdiReply& reply, std::size_t& poses) {
  if (reply.kind != NdiReplyKind::kText && reply.kind != NdiReplyKind::kBinary) return;
  NdiReadings readings;
  if (command.starts_with("TX:")) {
    // Markers that belong to no tool follow the tools in that form.
    const bool plain = command.starts_with("TX:0001");
    const auto read = read_ndi_tx(reply.text, readings);
    EXPECT_TRUE(!plain || read.has_value()) << command << reply.text;
  } else if (command.starts_with("BX:0001")) {
    EXPECT_TRUE(test::has_value(read_ndi_bx(reply.body, readings))) << command;
  } else if (command.starts_with("PHSR:")) {
    EXPECT_TRUE(test::has_value(read_ndi_handles(reply.text))) << command;
  }
  for (const NdiToolReading& one : readings.tools) {
    if (one.presence != NdiPresence::kMeasured) continue;
    EXPECT_TRUE(ndi_pose(one, {}).tracker_from_body.allFinite());
    ++poses;
  }
}

TEST(NdiRecordedTest, ReadsEveryReplyOfTheRecordedTrackers) {
  SONDE_REQUIRE_DATA(folder, "wire-ndi");
  std::size_t replies = 0;
  std::size_t poses = 0;
  for (const std::string& name : logs()) {
    for (const auto& [number, exchange] : read_log(folder / name)) {
      SCOPED_TRACE(name + " " + std::to_string(number));
      if (exchange.reply.empty()) continue;
      const auto bytes = test::text_bytes(exchange.reply);
      // A tracker that is reset says so after its last reply.
      for (std::span<const std::byte> rest = bytes; !rest.empty(); ++replies) {
        const NdiFraming framing = frame_ndi_reply(rest);
        ASSERT_GT(framing.size, 0U);
        ASSERT_FALSE(framing.fault);
        read_content(exchange.command, framing.reply, poses);
        rest = rest.subspan(framing.size);
      }
    }
  }
  RecordProperty("replies", static_cast<int>(replies));
  RecordProperty("poses", static_cast<int>(poses));
  EXPECT_GE(replies, 300U);
  EXPECT_GE(poses, 50U);
}

TEST(NdiRecordedTest, WritesEveryCommandThatWasSent) {
  SONDE_REQUIRE_DATA(folder, "wire-ndi");
  for (const std::string& name : logs()) {
    for (const auto& [number, exchange] : read_log(folder / name)) {
      const auto colon = exchange.command.find(':');
      if (colon == std::string::npos) continue;
      const auto arguments =
          exchange.command.substr(colon + 1, exchange.command.size() - colon - 6);
      EXPECT_EQ(ndi_command(exchange.command.substr(0, colon), arguments), exchange.command)
          << name << " " << number;
    }
  }
}

TEST(NdiRecordedTest, ReadsToolDefinitionsAndUploadsThemAsRecorded) {
  SONDE_REQUIRE_DATA(folder, "wire-ndi");
  const auto planar = read_ndi_rom(folder / "Passive_4Marker_Planar_Rigid_Body_8700302.rom");
  ASSERT_TRUE(test::has_value(planar));
  EXPECT_EQ(planar->size(), 752U);
  const auto rom = read_ndi_rom(folder / "ta2p0003-3-120.rom");
  ASSERT_TRUE(test::has_value(rom));
  std::size_t chunks = 0;
  for (const auto& [number, exchange] : read_log(folder / "polaris_stream_11_05_2005.txt")) {
    if (!exchange.command.starts_with("PVWR:")) continue;
    EXPECT_EQ(exchange.command, ndi_command("PVWR", ndi_rom_arguments(1, *rom, 64 * chunks)));
    ++chunks;
  }
  EXPECT_GE(chunks, 12U);
}

}  // namespace
}  // namespace nav::devices
