// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/canopen.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <linux/can/error.h>
#include <vector>

namespace nav::devices {
namespace {

std::vector<int> bytes_of(const CanFrame& frame) {
  return {frame.data.begin(), frame.data.begin() + frame.size};
}

TEST(CanFrameTest, HasTheLayoutOfTheKernel) {
  const CanFrame frame{.id = 0x583, .size = 3, .data = {0x43, 0x00, 0x10}};
  const auto bytes = encode_can(frame);
  const std::vector<int> expected{0x83, 0x05, 0, 0, 3, 0, 0, 0, 0x43, 0x00, 0x10, 0, 0, 0, 0, 0};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_EQ(std::to_integer<int>(bytes[i]), expected[i]) << i;
  }
  EXPECT_EQ(decode_can(bytes), frame);
  for (const bool extended : {false, true}) {
    for (const bool remote : {false, true}) {
      const CanFrame one{
          .id = extended ? 0x1ABCDEFFU : 0x7FFU, .extended = extended, .remote = remote};
      EXPECT_EQ(decode_can(encode_can(one)), one);
    }
  }
  const CanFrame error{.id = CAN_ERR_BUSOFF, .error = true, .size = 8};
  EXPECT_EQ(decode_can(encode_can(error)), error);
}

TEST(CanFrameTest, RejectsOtherSizes) {
  auto bytes = encode_can({.id = 1, .size = 8});
  bytes[4] = std::byte{9};
  EXPECT_EQ(decode_can(bytes), std::nullopt);
  EXPECT_EQ(decode_can(std::span(bytes).first(15)), std::nullopt);
  EXPECT_EQ(decode_can({}), std::nullopt);
}

TEST(CanFrameTest, NamesWhatAnErrorFrameTells) {
  const auto causes = [](std::uint32_t classes, std::uint8_t controller) {
    CanFrame frame{.id = classes, .error = true, .size = 8};
    frame.data[1] = controller;
    std::vector<std::string> texts;
    for (const char* cause : can_error_causes(frame)) texts.emplace_back(cause);
    return texts;
  };
  using Texts = std::vector<std::string>;
  EXPECT_EQ(causes(CAN_ERR_BUSOFF, 0), Texts{"bus_off"});
  EXPECT_EQ(causes(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), Texts{"error_passive"});
  EXPECT_EQ(causes(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), Texts{"receive_overflow"});
  EXPECT_EQ(causes(CAN_ERR_ACK | CAN_ERR_RESTARTED, 0), (Texts{"restarted", "no_ack"}));
  EXPECT_TRUE(can_error_causes({.id = CAN_ERR_BUSOFF}).empty()) << "no error frame";
}

/// Frames as CiA 301 writes them.
TEST(CanOpenTest, WritesTheBytesOfTheStandard) {
  EXPECT_EQ(can_nmt(NmtCommand::kStart, 5).id, 0U);
  EXPECT_EQ(bytes_of(can_nmt(NmtCommand::kStart, 5)), (std::vector<int>{0x01, 5}));
  EXPECT_EQ(can_sync().id, 0x80U);
  EXPECT_EQ(can_sync().size, 0);
  const CanFrame read = can_sdo_read(3, kDeviceType);
  EXPECT_EQ(read.id, 0x603U);
  EXPECT_EQ(bytes_of(read), (std::vector<int>{0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0}));
  const CanFrame two = can_sdo_write(3, kHeartbeatTime, 1000, 2);
  EXPECT_EQ(bytes_of(two), (std::vector<int>{0x2B, 0x17, 0x10, 0x00, 0xE8, 0x03, 0, 0}));
  const CanFrame one = can_sdo_write(3, kPdo2Transmission, 1, 1);
  EXPECT_EQ(bytes_of(one), (std::vector<int>{0x2F, 0x01, 0x18, 0x02, 1, 0, 0, 0}));
  EXPECT_EQ(can_position(6, 0x01020304).id, 0x286U);
  EXPECT_EQ(bytes_of(can_position(6, 0x01020304)), (std::vector<int>{4, 3, 2, 1}));
}

TEST(CanOpenTest, TellsFramesByTheirIdentifier) {
  const auto kind = [](std::uint32_t id) { return classify_canopen({.id = id}); };
  EXPECT_EQ(kind(0x000).kind, CanOpenKind::kNmt);
  EXPECT_EQ(kind(0x080).kind, CanOpenKind::kSync);
  EXPECT_EQ(kind(0x085).kind, CanOpenKind::kEmergency);
  EXPECT_EQ(kind(0x085).node, 5);
  EXPECT_EQ(kind(0x181).kind, CanOpenKind::kPdo1);
  EXPECT_EQ(kind(0x2FF).kind, CanOpenKind::kPdo2);
  EXPECT_EQ(kind(0x2FF).node, 127);
  EXPECT_EQ(kind(0x583).kind, CanOpenKind::kSdoReply);
  EXPECT_EQ(kind(0x603).kind, CanOpenKind::kSdoRequest);
  EXPECT_EQ(kind(0x701).kind, CanOpenKind::kHeartbeat);
  EXPECT_EQ(kind(0x300).kind, CanOpenKind::kOther);
  EXPECT_EQ(kind(0x280).kind, CanOpenKind::kOther) << "no node";
  EXPECT_EQ(classify_canopen({.id = 0x181, .extended = true}).kind, CanOpenKind::kOther);
  EXPECT_EQ(classify_canopen({.id = 0x181, .remote = true}).kind, CanOpenKind::kOther);
}

TEST(CanOpenTest, ReadsRepliesOfAllSizes) {
  // 43: four bytes, 47: three, 4B: two, 4F: one, 42: without a size.
  const auto reply = [](std::uint8_t command) {
    return read_sdo_reply({.id = 0x583, .size = 8, .data = {command, 1, 0x65, 0, 1, 2, 3, 4}});
  };
  EXPECT_EQ(reply(0x43)->value, 0x04030201U);
  EXPECT_EQ(reply(0x47)->value, 0x030201U);
  EXPECT_EQ(reply(0x4B)->value, 0x0201U);
  EXPECT_EQ(reply(0x4F)->value, 0x01U);
  EXPECT_EQ(reply(0x42)->value, 0x04030201U);
  EXPECT_EQ(reply(0x43)->object, kCountsPerTurn);
  EXPECT_FALSE(reply(0x60)->is_abort);
  EXPECT_EQ(reply(0x41), std::nullopt) << "a segmented transfer";
  EXPECT_TRUE(reply(0x80)->is_abort);
  EXPECT_EQ(read_sdo_reply({.id = 0x583, .size = 7}), std::nullopt);
  EXPECT_EQ(sdo_abort_sentence(0x06020000), "the object does not exist (0x06020000)");
}

TEST(CanOpenTest, RequestsAreReadAsTheyAreWritten) {
  for (const int bytes : {1, 2, 3, 4}) {
    const std::uint32_t value = 0x81C2D3E4U & (0xFFFFFFFFU >> (8 * (4 - bytes)));
    const auto request = read_sdo_request(can_sdo_write(9, {0x2345, 6}, value, bytes));
    ASSERT_TRUE(request);
    EXPECT_TRUE(request->writes);
    EXPECT_EQ(request->value, value);
    EXPECT_EQ(request->object, (CanObject{0x2345, 6}));
  }
  EXPECT_FALSE(read_sdo_request(can_sdo_read(9, kDeviceType))->writes);
  const auto emergency = read_emergency(can_emergency(4, {0x5003, 0x81}));
  EXPECT_EQ(emergency->code, 0x5003);
  EXPECT_EQ(emergency->error_register, 0x81);
  EXPECT_EQ(emergency_sentence(*emergency),
            "its hardware has failed; the position is not to be trusted (0x5003)");
  EXPECT_EQ(read_emergency({.id = 0x81, .size = 2}), std::nullopt);
  EXPECT_EQ(read_position({.id = 0x281, .size = 3}), std::nullopt);
  for (const CanNodeState state : {CanNodeState::kBooting, CanNodeState::kStopped,
                                   CanNodeState::kOperational, CanNodeState::kPreOperational}) {
    EXPECT_EQ(read_heartbeat(can_heartbeat(1, state)), state);
  }
}

}  // namespace
}  // namespace nav::devices
