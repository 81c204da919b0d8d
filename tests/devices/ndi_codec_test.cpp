// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

#include "devices/ndi/ndi_commands.hpp"
#include "devices/ndi/ndi_crc.hpp"
#include "devices/ndi/ndi_encode.hpp"
#include "devices/ndi/ndi_errors.hpp"
#include "devices/ndi/ndi_poses.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// Vectors that a foreign client, ndicapi, has accepted or sent; the first three constants of
/// KnowsTheVendorsChecks are those of the vendor.
namespace nav::devices {
namespace {

using test::Bytes;

constexpr const char* kTxVector =
    "0201+10000+00000+00000+00100+010100-020025-150049+012300000003100000001\n"
    "02MISSING0000003100000001\n000032EE\r";
constexpr const char* kBxVector =
    "c4a537003b23020101e5f27f3f00000000000000003ed4a33c0000ca42004048c35c8fbbc46de7fb3d3100000002"
    "0000000202310000000200000000008e5e";
constexpr const char* kBx2Vector =
    "c4a5580016d301000100010054000000000001000000020300000300000004ef006bffa58d2f0100010002003400"
    "00000000020000000100000083e27f3f000000000000000020b9f53c0000ca42004048c30a8fbbc46de7fb3d0200"
    "0d012941";

NdiFraming framed(const Bytes& bytes) { return frame_ndi_reply(bytes); }
NdiFraming framed(const std::string& text) {
  static Bytes kept;  // The reply points into it.
  kept = test::text_bytes(text);
  return framed(kept);
}

void expect_vector_tools(const NdiReadings& readings, double digit) {
  ASSERT_EQ(readings.tools.size(), 2U);
  const NdiToolReading& seen = readings.tools[0];
  EXPECT_EQ(seen.handle, 1);
  EXPECT_EQ(seen.presence, NdiPresence::kMeasured);
  EXPECT_NEAR(seen.translation_mm[0], 101, digit);
  EXPECT_NEAR(seen.translation_mm[1], -200.25, digit);
  EXPECT_NEAR(seen.translation_mm[2], -1500.48, 0.02);
  EXPECT_NEAR(seen.error_mm, 0.123, 1e-4);
  EXPECT_EQ(readings.tools[1].handle, 2);
  EXPECT_EQ(readings.tools[1].presence, NdiPresence::kMissing);
  const RawPose pose = ndi_pose(seen, Timestamp{});
  EXPECT_EQ(pose.status, TrackingStatus::kOk);
  EXPECT_NEAR(pose.tracker_from_body(0, 3), 101, digit);
  EXPECT_NEAR(pose.tracker_from_body.topLeftCorner(3, 3).determinant(), 1, 1e-9);
  const RawPose missing = ndi_pose(readings.tools[1], Timestamp{});
  EXPECT_EQ(missing.status, TrackingStatus::kOccluded);
  EXPECT_TRUE(std::isnan(missing.tracker_from_body(0, 0))) << "never the identity";
}

TEST(NdiCodecTest, KnowsTheVendorsChecks) {
  EXPECT_EQ(ndi_crc("123456789"), 0xBB3D);
  for (const char* text :
       {"OKAYA896", "RESETBE6F", "ERROR016BC2", "ERROR0C4E42", "001414", "0201031020313772"}) {
    const auto framing = framed(std::string(text) + "\r");
    EXPECT_EQ(framing.size, std::string(text).size() + 1) << text;
    EXPECT_FALSE(framing.fault) << text;
  }
  EXPECT_EQ(ndi_command("INIT"), "INIT:E3A5\r");
  EXPECT_EQ(ndi_command("COMM", "50000"), "COMM:500000048\r");
  EXPECT_EQ(ndi_command("PHSR", "02"), "PHSR:02E17E\r");
  EXPECT_EQ(ndi_command("PHRQ", "*********1****"), "PHRQ:*********1****A4C1\r");
  EXPECT_EQ(ndi_command("PHF", "01"), "PHF:01CF0C\r");
  EXPECT_EQ(ndi_command("TSTART"), "TSTART:5423\r");
  EXPECT_EQ(ndi_command("TSTOP"), "TSTOP:2C14\r");
  EXPECT_EQ(ndi_command("TX", "0001"), "TX:0001031A\r");
  EXPECT_EQ(ndi_command("BX", "0001"), "BX:0001C26D\r");
  EXPECT_EQ(ndi_command("PHINF", "010001"), "PHINF:010001CFAC\r");
}

TEST(NdiCodecTest, TellsTheKindsOfReplies) {
  EXPECT_EQ(framed("OKAYA896\r").reply.kind, NdiReplyKind::kOkay);
  EXPECT_EQ(framed("RESETBE6F\r").reply.kind, NdiReplyKind::kReset);
  EXPECT_EQ(framed("WARNING7423\r").reply.kind, NdiReplyKind::kWarning);
  EXPECT_EQ(framed("ERROR0C4E42\r").reply.code, 0x0C);
  EXPECT_EQ(framed("ERROR016BC2\r").reply.kind, NdiReplyKind::kError);
  EXPECT_EQ(framed("001414\r").reply.text, "00");
  EXPECT_EQ(frame_ndi_reply(ndi_text_reply("WARNING02")).reply.code, 2);
}

TEST(NdiCodecTest, SaysEachErrorInWords) {
  EXPECT_EQ(ndi_error_sentence(0x13),
            "error 13: the tool cannot be initialised; check the tool's .rom file, or have the "
            "tool's memory rewritten");
  EXPECT_NE(ndi_error_sentence(0xEE).find("not known"), std::string::npos);
  EXPECT_NE(ndi_warning_sentence(0x42).find("warning 42"), std::string::npos);
  for (unsigned code = 0; code < 256; ++code) {
    EXPECT_NE(ndi_error_sentence(static_cast<std::uint8_t>(code)).find("; "), std::string::npos);
  }
}

TEST(NdiCodecTest, ReadsTheSameTwoToolsFromTxBxAndBx2) {
  NdiReadings readings;
  const auto tx = framed(std::string(kTxVector));
  ASSERT_TRUE(test::has_value(read_ndi_tx(tx.reply.text, readings)));
  expect_vector_tools(readings, 1e-9);
  EXPECT_EQ(readings.tools[0].number, 1U);
  const Bytes bx_bytes = test::from_hex(kBxVector);
  const auto bx = framed(bx_bytes);
  ASSERT_EQ(bx.size, bx_bytes.size());
  ASSERT_TRUE(test::has_value(read_ndi_bx(bx.reply.body, readings)));
  expect_vector_tools(readings, 1e-4);
  EXPECT_EQ(readings.tools[0].number, 2U);
  EXPECT_EQ(readings.tools[0].time, std::nullopt);
  const Bytes bx2_bytes = test::from_hex(kBx2Vector);
  const auto bx2 = framed(bx2_bytes);
  ASSERT_EQ(bx2.size, bx2_bytes.size());
  ASSERT_TRUE(test::has_value(read_ndi_bx2(bx2.reply.body, readings)));
  expect_vector_tools(readings, 1e-4);
  EXPECT_EQ(readings.tools[0].number, 3U);
  EXPECT_EQ(readings.tools[0].time,
            DeviceTime(std::chrono::seconds(0x6b00ef04) + std::chrono::nanoseconds(0x2f8da5ff)));
}

TEST(NdiCodecTest, WritesTheVectorsBack) {
  NdiReadings readings;
  ASSERT_TRUE(test::has_value(read_ndi_tx(framed(std::string(kTxVector)).reply.text, readings)));
  EXPECT_EQ(ndi_text_reply(ndi_tx_text(readings)), test::text_bytes(kTxVector));
  const Bytes bx = test::from_hex(kBxVector);
  ASSERT_TRUE(test::has_value(read_ndi_bx(framed(bx).reply.body, readings)));
  EXPECT_EQ(ndi_binary_reply(ndi_bx_body(readings)), bx);
  const Bytes bx2 = test::from_hex(kBx2Vector);
  ASSERT_TRUE(test::has_value(read_ndi_bx2(framed(bx2).reply.body, readings)));
  EXPECT_EQ(ndi_binary_reply(ndi_bx2_body(readings)), bx2);
}

TEST(NdiCodecTest, ReadsTheExtendedForm) {
  const Bytes bx = test::from_hex(kBxVector);
  const auto body = framed(bx).reply.body;
  const Bytes extended = ndi_binary_reply(body, true);
  EXPECT_EQ(extended[0], std::byte{0xC8});
  const auto framing = framed(extended);
  ASSERT_EQ(framing.size, extended.size());
  EXPECT_TRUE(std::ranges::equal(framing.reply.body, body));
}

TEST(NdiCodecTest, KeepsTheHighestBitOfThePortStatus) {
  NdiReadings written;
  written.tools.push_back({.handle = 200, .status = 0x80000031, .number = 0xFFFFFFFF});
  NdiReadings read;
  ASSERT_TRUE(test::has_value(read_ndi_bx(ndi_bx_body(written), read)));
  EXPECT_EQ(read.tools[0].status, 0x80000031U);
  EXPECT_EQ(read.tools[0].number, 0xFFFFFFFFU);
  EXPECT_EQ(read.tools[0].handle, 200);
}

TEST(NdiCodecTest, MarksPosesOutOfTheVolumeAndRejectsImpossibleOnes) {
  NdiToolReading reading{.presence = NdiPresence::kMeasured, .rotation_wxyz = {1, 0, 0, 0}};
  EXPECT_EQ(ndi_pose(reading, {}).status, TrackingStatus::kOk);
  reading.partly_out_of_volume = true;
  EXPECT_EQ(ndi_pose(reading, {}).status, TrackingStatus::kOutOfVolume);
  EXPECT_TRUE(ndi_pose(reading, {}).tracker_from_body.allFinite());
  reading.unusable = true;
  EXPECT_EQ(ndi_pose(reading, {}).status, TrackingStatus::kInvalid);
  reading = {.presence = NdiPresence::kMeasured};
  for (const double bad : {0.0, 3.0, -3.7e28, std::nan("")}) {
    reading.rotation_wxyz = {bad, 0, 0, 0};
    EXPECT_EQ(ndi_pose(reading, {}).status, TrackingStatus::kInvalid) << bad;
    EXPECT_TRUE(std::isnan(ndi_pose(reading, {}).tracker_from_body(3, 3))) << bad;
  }
  reading.rotation_wxyz = {1, 0, 0, 0};
  reading.translation_mm[1] = std::nan("");
  EXPECT_EQ(ndi_pose(reading, {}).status, TrackingStatus::kInvalid);
}

TEST(NdiCodecTest, AsksForMoreUntilAReplyIsThere) {
  for (const Bytes& whole : {test::text_bytes(kTxVector), test::from_hex(kBxVector),
                             test::from_hex(kBx2Vector), ndi_text_reply("OKAY")}) {
    for (std::size_t size = 0; size < whole.size(); ++size) {
      const auto framing = frame_ndi_reply(std::span(whole).first(size));
      EXPECT_EQ(framing.size, 0U) << size;
    }
    for (std::size_t at = 0; at < whole.size(); ++at) {
      Bytes changed = whole;
      changed[at] ^= std::byte{1};
      const auto framing = frame_ndi_reply(changed);
      EXPECT_TRUE(framing.fault || framing.size != whole.size()) << at;
    }
  }
}

TEST(NdiCodecTest, RejectsContentsWhoseCountsAreWrong) {
  NdiReadings readings;
  for (const char* text :
       {"", "0", "01", "0101", "00", "0000", "ZZ", "0201MISSING\n0000", "0101+1000+00000",
        "0101MISSING0000003100000001\n00000", "0101UNOCCUPIED", "0101+1000a+00000"}) {
    const bool good = std::string(text) == "000000";
    EXPECT_EQ(read_ndi_tx(text, readings).has_value(), good) << text;
  }
  EXPECT_TRUE(read_ndi_tx("000000", readings));
  EXPECT_TRUE(read_ndi_tx("0201UNOCCUPIED\n02DISABLED0000000000000001\n0000", readings));
  for (const char* hex : {"", "01", "0101", "010500000000", "00", "0000", "00000000"}) {
    const bool good = std::string(hex) == "000000";
    EXPECT_EQ(read_ndi_bx(test::from_hex(hex), readings).has_value(), good) << hex;
  }
  // A component that is longer than the reply, more items than bytes, and components in components.
  for (const char* hex : {"0100", "01000100", "010001000100ffffffff000001000000",
                          "0100010002000c0000000000ffffffff", "01000100020008000000000001000000"}) {
    EXPECT_FALSE(read_ndi_bx2(test::from_hex(hex), readings)) << hex;
  }
  EXPECT_FALSE(read_ndi_handles("0201"));
  EXPECT_FALSE(read_ndi_handles(""));
  EXPECT_FALSE(read_ndi_tool_info("UNOCCUPIED"));
}

TEST(NdiCodecTest, ReadsHandlesAndToolsAsRecorded) {
  const auto handles = read_ndi_handles("020A0010B001");
  ASSERT_TRUE(test::has_value(handles));
  ASSERT_EQ(handles->size(), 2U);
  EXPECT_EQ((*handles)[1].handle, 0x0B);
  EXPECT_EQ((*handles)[1].status, 1);
  const auto info = read_ndi_tool_info("02000000Traxtal Tech0003408D4083FA3-0014210020");
  EXPECT_FALSE(info) << "one character is missing";
  const auto wired =
      read_ndi_tool_info("02000000Traxtal Tech0003408D4083FA3-0014210" + std::string("0200"));
  ASSERT_TRUE(test::has_value(wired));
  EXPECT_TRUE(wired->wired);
  EXPECT_EQ(wired->port, 2U);
  EXPECT_EQ(wired->channel, 0U);
  EXPECT_EQ(wired->manufacturer, "Traxtal Tech");
  EXPECT_EQ(wired->serial, "3408D408");
  const auto version = read_ndi_version(
      "Polaris Control Firmware\nNDI S/N: P4-03126\nFreeze Tag: POLARIS Rev 020\n");
  EXPECT_EQ(version.firmware, "Polaris Control Firmware, POLARIS Rev 020");
  EXPECT_EQ(version.serial, "P4-03126");
}

TEST(NdiCodecTest, RejectsFilesThatAreNoToolDefinition) {
  const test::TemporaryFolder folder;
  const auto read_as_rom = [&](const std::string& content) {
    std::ofstream(folder / "tool.rom", std::ios::binary) << content;
    return read_ndi_rom(folder / "tool.rom");
  };
  EXPECT_EQ(read_ndi_rom(folder / "absent.rom").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read_ndi_rom(folder.path()).error().code, ErrorCode::kNotFound);
  EXPECT_FALSE(read_as_rom(""));
  EXPECT_FALSE(read_as_rom("hello, this is no tool"));
  const std::string good("NDI\0\x03\0\x01\x02", 8);
  EXPECT_TRUE(test::has_value(read_as_rom(good)));
  EXPECT_FALSE(read_as_rom(good + "\x01"));
  EXPECT_FALSE(read_as_rom(good + std::string(70'000, '\0')));
  EXPECT_EQ(ndi_rom_arguments(3, good, 0).substr(0, 16), "0300004E44490003");
  EXPECT_EQ(ndi_rom_arguments(3, good, 64).size(), 6U + 128U);
}

/// Reads bytes as every reply that there is.
void read_all_ways(const Bytes& bytes) {
  const auto framing = frame_ndi_reply(bytes);
  ASSERT_LE(framing.size, bytes.size());
  NdiReadings readings;
  const auto text = std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  (void)read_ndi_tx(text, readings);
  (void)read_ndi_bx(bytes, readings);
  (void)read_ndi_bx2(bytes, readings);
  for (const NdiToolReading& one : readings.tools) (void)ndi_pose(one, {});
  (void)read_ndi_handles(text);
  (void)read_ndi_tool_info(text);
  (void)read_ndi_version(text);
}

TEST(NdiCodecTest, SurvivesMutatedReplies) {
  constexpr int kMutations = 40'000;
  const Bytes bx = test::from_hex(kBxVector);
  const Bytes bx2 = test::from_hex(kBx2Vector);
  const Bytes tx = test::text_bytes(kTxVector);
  const std::vector<Bytes> seeds = {tx,
                                    Bytes(tx.begin(), tx.end() - 5),
                                    bx,
                                    Bytes(bx.begin() + 6, bx.end() - 2),
                                    bx2,
                                    Bytes(bx2.begin() + 6, bx2.end() - 2),
                                    ndi_text_reply("020A0010B001"),
                                    ndi_binary_reply(bx, true)};
  std::mt19937_64 random(20050727);
  for (int i = 0; i < kMutations; ++i) {
    Bytes bytes = seeds[random() % seeds.size()];
    for (std::uint64_t changes = 1 + random() % 4; changes > 0; --changes) {
      const std::size_t at = random() % bytes.size();
      if (random() % 4 == 0) {
        bytes[at] = std::byte{0xFF};
      } else {
        bytes[at] ^= static_cast<std::byte>(1U << (random() % 8));
      }
    }
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    read_all_ways(bytes);
  }
}

}  // namespace
}  // namespace nav::devices
