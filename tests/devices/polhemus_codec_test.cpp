// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/polhemus_codec.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace nav::devices {
namespace {

using Bytes = std::vector<std::byte>;

PolhemusRecord liberty_record(int station, std::uint32_t frame) {
  return {.station = station,
          .error = ' ',
          .time_ms = 4 * frame,
          .frame = frame,
          .distortion = -3,
          .position_cm = {1.5F, -20.25F, 3},
          .rotation_wxyz = {0.5F, 0.5F, -0.5F, 0.5F}};
}

Bytes record_bytes(const PolhemusRecord& record) {
  Bytes bytes;
  append_polhemus_record(bytes, record);
  return bytes;
}

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

class PolhemusParserTest : public ::testing::Test {
 protected:
  void take(const Bytes& transfer) {
    parser_.take(transfer, [this](const PolhemusNews& news) {
      if (news.kind == PolhemusNews::Kind::kBad) causes_.emplace_back(news.cause);
      if (news.kind == PolhemusNews::Kind::kReply) replies_.push_back(news.command);
      if (news.kind == PolhemusNews::Kind::kRecord) frames_.push_back(news.record.frame);
    });
  }
  PolhemusParser parser_;
  std::vector<std::string> causes_;
  std::vector<std::uint32_t> frames_;
  std::vector<char> replies_;
};
using Frames = std::vector<std::uint32_t>;
using Causes = std::vector<std::string>;

TEST_F(PolhemusParserTest, ReadsAHandWrittenRecord) {
  // Station 2, continuous, no error, 40 bytes; 1000 ms, frame 240, distortion 7; 1, 2, 3 cm; a
  // rotation by nothing. Written from the layout of the manual, not by this program.
  const std::vector<unsigned> wire{0x4C, 0x59, 0x02, 0x43, 0x20, 0x00, 0x28, 0x00, 0xE8, 0x03,
                                   0x00, 0x00, 0xF0, 0x00, 0x00, 0x00, 0x07, 0x00, 0x00, 0x00,
                                   0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0x40, 0x00, 0x00,
                                   0x40, 0x40, 0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0x00,
                                   0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00};
  Bytes bytes;
  for (const unsigned one : wire) bytes.push_back(static_cast<std::byte>(one));
  int records = 0;
  parser_.take(bytes, [&](const PolhemusNews& news) {
    ASSERT_EQ(news.kind, PolhemusNews::Kind::kRecord);
    EXPECT_EQ(news.record.station, 2);
    EXPECT_EQ(news.record.time_ms, 1000U);
    EXPECT_EQ(news.record.frame, 240U);
    EXPECT_EQ(news.record.distortion, 7);
    EXPECT_EQ(news.record.position_cm, (std::array<float, 3>{1, 2, 3}));
    EXPECT_EQ(news.record.rotation_wxyz, (std::array<float, 4>{1, 0, 0, 0}));
    EXPECT_FALSE(polhemus_error(news.record.error));
    EXPECT_EQ(polhemus_trouble(news.record), nullptr);
    ++records;
  });
  EXPECT_EQ(records, 1);
}

TEST_F(PolhemusParserTest, TakesSeveralRecordsOfATransferAndOneOfTwoTransfers) {
  take(joined({record_bytes(liberty_record(1, 5)), record_bytes(liberty_record(2, 5))}));
  const Bytes third = record_bytes(liberty_record(1, 6));
  take({third.begin(), third.begin() + 7});
  EXPECT_EQ(frames_, (Frames{5, 5}));
  take({third.begin() + 7, third.end()});
  EXPECT_EQ(frames_, (Frames{5, 5, 6}));
  EXPECT_TRUE(causes_.empty());
}

TEST_F(PolhemusParserTest, ABrokenMessageCostsItselfOnly) {
  const Bytes good = record_bytes(liberty_record(1, 1));
  const auto with = [&](std::size_t at, unsigned value) {
    Bytes bytes = record_bytes(liberty_record(1, 99));
    bytes[at] = static_cast<std::byte>(value);
    return bytes;
  };
  take(joined({good, with(1, 'Z'), good}));
  EXPECT_EQ(causes_, Causes{"magic"});
  take(joined({good, with(6, 41), good}));
  take(joined({good, with(7, 200), good}));
  EXPECT_EQ(causes_, (Causes{"magic", "size", "size"}));
  take(joined({good, with(2, 17), good}));
  EXPECT_EQ(causes_.back(), "station");
  EXPECT_EQ(frames_, Frames(8, 1));
}

TEST_F(PolhemusParserTest, ACutMessageIsNoPoseOfTwoHalves) {
  const Bytes whole = record_bytes(liberty_record(1, 99));
  for (std::size_t length = 1; length < whole.size(); ++length) {
    parser_.restart();
    frames_.clear();
    causes_.clear();
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    // In one transfer with the next message, and in a transfer of its own.
    take(joined({cut, record_bytes(liberty_record(1, 7))}));
    take(cut);
    take(record_bytes(liberty_record(1, 8)));
    EXPECT_EQ(frames_, (Frames{7, 8})) << length;
    EXPECT_EQ(causes_.size(), 2U) << length;
  }
}

TEST_F(PolhemusParserTest, AnswersToCommandsAreTold) {
  Bytes reply;
  append_polhemus_header(reply, 0, 'u', 4, 0);
  append_polhemus_header(reply, 0, '\x15', 0, 3);
  reply.insert(reply.end(), 3, std::byte{9});
  take(joined({reply, record_bytes(liberty_record(1, 3))}));
  EXPECT_EQ(replies_, (std::vector<char>{'u', '\x15'}));
  EXPECT_EQ(frames_, Frames{3});
  EXPECT_TRUE(causes_.empty());
}

TEST_F(PolhemusParserTest, FindsItsStepAgainAfterAnyBytes) {
  std::mt19937 random(7);
  for (int round = 0; round < 300; ++round) {
    Bytes noise(random() % 200);
    for (std::byte& one : noise)
      one = static_cast<std::byte>(
          "LY\x01"
          "C (\0\xFF"[random() % 8]);
    parser_.restart();
    frames_.clear();
    take(noise);
    take(record_bytes(liberty_record(1, 11)));
    take(record_bytes(liberty_record(1, 12)));
    ASSERT_FALSE(frames_.empty()) << round;
    EXPECT_EQ(frames_.back(), 12U);
  }
}

TEST(PolhemusRecordTest, NamesNumbersThatAreNoPose) {
  PolhemusRecord record = liberty_record(1, 1);
  EXPECT_EQ(polhemus_trouble(record), nullptr);
  record.position_cm[0] = 1001;
  EXPECT_STREQ(polhemus_trouble(record), "out_of_range");
  record.rotation_wxyz[0] = 0.6F;
  EXPECT_STREQ(polhemus_trouble(record), "no_rotation");
  record.rotation_wxyz[3] = std::numeric_limits<float>::infinity();
  EXPECT_STREQ(polhemus_trouble(record), "not_finite");
  EXPECT_EQ(polhemus_error('S'), "error 83 ('S')");
  EXPECT_EQ(polhemus_error(4), "error 4");
}

TEST(PolhemusRecordTest, TheSetupAsksForBinaryCentimetresAndTheItems) {
  EXPECT_EQ(polhemus_setup({0, 0, -1}), (std::vector<std::string>{"f1\r", "u1\r", "O*,8,9,11,3,7\r",
                                                                  "h*,0.0000,0.0000,-1.0000\r"}));
}

}  // namespace
}  // namespace nav::devices
