// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_parser.hpp"

#include <cstring>
#include <gtest/gtest.h>

#include "devices/openigtlink/igtl_messages.hpp"
#include "tests/devices/igtl_wire.hpp"

namespace nav::devices {
namespace {

using test::Bytes;
using test::operator+;

/// Names of the devices of the messages that a parser finds, in order.
std::vector<std::string> names_in(IgtlParser& parser, std::span<const std::byte> bytes,
                                  std::size_t piece) {
  std::vector<std::string> names;
  for (std::size_t at = 0; at < bytes.size(); at += piece) {
    parser.feed(bytes.subspan(at, std::min(piece, bytes.size() - at)));
    while (const auto message = parser.next()) names.emplace_back(message->header.device_name());
  }
  return names;
}

/// Names of the devices, found in pieces of several sizes; expects the same from all.
std::vector<std::string> names_in_any_pieces(const Bytes& bytes, IgtlStreamCounts* counts = nullptr,
                                             const IgtlParserOptions& options = {}) {
  std::vector<std::string> first;
  IgtlStreamCounts first_counts;
  for (const std::size_t piece :
       {bytes.size(), std::size_t{1}, std::size_t{7}, std::size_t{58}, std::size_t{1000}}) {
    IgtlParser parser(options);
    const auto names = names_in(parser, bytes, piece);
    const IgtlStreamCounts& found = parser.counts();
    EXPECT_EQ(found.messages, names.size());
    EXPECT_EQ(found.bytes, bytes.size());
    if (piece == bytes.size()) {
      first = names;
      first_counts = found;
    } else {
      EXPECT_EQ(names, first) << "in pieces of " << piece;
      EXPECT_EQ(found.faults, first_counts.faults) << "in pieces of " << piece;
    }
  }
  if (counts != nullptr) *counts = first_counts;
  return first;
}

Bytes pose(std::string_view name) {
  return test::transform_message(name, test::translation(1, 2, 3), "OK");
}

using Names = std::vector<std::string>;

TEST(IgtlParserTest, FindsMessagesInPiecesOfAnySize) {
  const test::GreyImage grey(31, 17);
  const Bytes stream = pose("A") + grey.as_message("Image") +
                       test::transform_message("B", test::translation(0, 0, 0)) + pose("C");
  IgtlStreamCounts counts;
  EXPECT_EQ(names_in_any_pieces(stream, &counts), (Names{"A", "Image", "B", "C"}));
  EXPECT_EQ(counts.faults_total(), 0u);
  EXPECT_EQ(counts.skipped, 0u);
}

TEST(IgtlParserTest, GarbageCostsNoMessage) {
  const Bytes noise = test::text_bytes("GET / HTTP/1.1\r\nHost: scanner\r\n\r\n") + Bytes(100);
  const Bytes stream =
      noise + pose("A") + noise + noise + pose("B") + Bytes(3, std::byte{1}) + pose("C") + noise;
  IgtlStreamCounts counts;
  EXPECT_EQ(names_in_any_pieces(stream, &counts), (Names{"A", "B", "C"}));
  EXPECT_EQ(counts.of(IgtlFault::kGarbage), 4u);
  EXPECT_EQ(counts.faults_total(), 4u);
}

TEST(IgtlParserTest, GarbageFullOfHeadersCostsNoMessage) {
  // Bytes that look like the beginning of large messages, over and over.
  Bytes noise;
  for (int i = 0; i < 50; ++i) {
    Bytes header = test::message({.type = "VIDEO", .device = "Liar"}, Bytes());
    test::overwrite_64(header, test::kBodySizeOffset, 1'000'000);
    noise = noise + header;
  }
  EXPECT_EQ(names_in_any_pieces(noise + pose("A") + pose("B")), (Names{"A", "B"}));
}

TEST(IgtlParserTest, AWrongCrcCostsOneMessage) {
  for (const std::size_t offset : {test::kCrcOffset, test::kCrcOffset + 7, std::size_t{100}}) {
    Bytes broken = pose("B");
    broken[offset] ^= std::byte{1};
    IgtlStreamCounts counts;
    EXPECT_EQ(names_in_any_pieces(pose("A") + broken + broken + pose("C"), &counts),
              (Names{"A", "C"}));
    EXPECT_EQ(counts.of(IgtlFault::kCrc), 2u) << offset;
    EXPECT_EQ(counts.faults_total(), 2u);
    EXPECT_EQ(counts.skipped, 2 * broken.size());
  }
}

TEST(IgtlParserTest, NoSingleBitOfAMessageCostsAnother) {
  const Bytes before = pose("A");
  const Bytes middle = pose("B");
  const Bytes after = pose("C") + pose("D");
  for (std::size_t bit = 0; bit < 8 * middle.size(); ++bit) {
    Bytes broken = middle;
    broken[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    IgtlParser parser;
    const auto names = names_in(parser, before + broken + after, SIZE_MAX);
    // Version, type, device and stamp are outside the CRC: a flip there may leave the message
    // whole.
    ASSERT_GE(names.size(), 3u) << "bit " << bit;
    EXPECT_EQ(names.front(), "A") << "bit " << bit;
    EXPECT_EQ(names[names.size() - 2], "C") << "bit " << bit;
    EXPECT_EQ(names.back(), "D") << "bit " << bit;
  }
}

TEST(IgtlParserTest, BodySizesThatCannotBeAreSeenAtOnce) {
  struct Case {
    std::uint64_t size;
    IgtlFault fault;
  };
  for (const Case& one :
       {Case{UINT64_MAX, IgtlFault::kTooLarge}, Case{0, IgtlFault::kSize},
        Case{57, IgtlFault::kSize}, Case{std::uint64_t{64} << 20, IgtlFault::kSize},
        Case{(std::uint64_t{64} << 20) + 1, IgtlFault::kTooLarge}}) {
    Bytes broken = test::transform_message("B", test::translation(1, 2, 3));
    test::overwrite_64(broken, test::kBodySizeOffset, one.size);
    IgtlStreamCounts counts;
    EXPECT_EQ(names_in_any_pieces(pose("A") + broken + pose("C"), &counts), (Names{"A", "C"}));
    EXPECT_EQ(counts.of(one.fault), 1u) << one.size;
    EXPECT_EQ(counts.faults_total(), 1u) << one.size;
  }
}

TEST(IgtlParserTest, AnImageThatAnnouncesTooManyBytesDoesNotStopTheStream) {
  const test::GreyImage grey(31, 17);
  Bytes broken = grey.as_message("Image");
  test::overwrite_64(broken, test::kBodySizeOffset, 1'000'000);
  IgtlStreamCounts counts;
  EXPECT_EQ(names_in_any_pieces(broken + pose("A"), &counts), (Names{"A"}));
  EXPECT_EQ(counts.of(IgtlFault::kSize), 1u);
}

TEST(IgtlParserTest, AMessageOfUnknownTypeThatAnnouncesTooManyBytesDoesNotStopTheStream) {
  Bytes broken = test::message({.type = "NDARRAY", .device = "B"}, Bytes(40));
  test::overwrite_64(broken, test::kBodySizeOffset, 1'000'000);
  IgtlStreamCounts counts;
  EXPECT_EQ(names_in_any_pieces(broken + pose("A") + pose("C"), &counts), (Names{"A", "C"}));
  EXPECT_EQ(counts.of(IgtlFault::kSize), 1u);
}

TEST(IgtlParserTest, UnknownTypesPassByTheirSize) {
  IgtlStreamCounts counts;
  const Bytes stream = test::message({.type = "FUTURE_THING", .device = "X"}, Bytes(57)) +
                       pose("A") + test::message({.version = 3, .type = "Y", .device = "Y"}, {});
  EXPECT_EQ(names_in_any_pieces(stream, &counts), (Names{"X", "A", "Y"}));
  EXPECT_EQ(counts.faults_total(), 0u);
}

TEST(IgtlParserTest, HeaderVersionsBeyondThreeCostOneMessage) {
  for (const int version : {0, 4, 9, 255}) {
    Bytes broken = pose("B");
    broken[1] = static_cast<std::byte>(version);
    IgtlStreamCounts counts;
    EXPECT_EQ(names_in_any_pieces(pose("A") + broken + pose("C"), &counts), (Names{"A", "C"}));
    EXPECT_EQ(counts.of(IgtlFault::kVersion), 1u) << version;
  }
}

TEST(IgtlParserTest, MetadataBeyondTheBodyCostOneMessage) {
  Bytes content = Bytes(48);
  Bytes good = test::message({.version = 2, .type = "TRANSFORM", .device = "B"}, content);
  // One entry is announced and none is there; the CRC is made right again.
  Bytes body(good.begin() + kIgtlHeaderBytes, good.end());
  body[body.size() - 1] = std::byte{1};
  Bytes other = test::message({.type = "TRANSFORM", .device = "B"}, body);
  other[1] = std::byte{2};
  IgtlStreamCounts counts;
  EXPECT_EQ(names_in_any_pieces(pose("A") + other + pose("C"), &counts), (Names{"A", "C"}));
  EXPECT_EQ(counts.of(IgtlFault::kMetadata), 1u);
}

TEST(IgtlParserTest, MemoryGrowsOnlyWithBytesThatCame) {
  IgtlParser parser;
  Bytes header = test::message({.type = "VIDEO", .device = "B"}, Bytes());
  test::overwrite_64(header, test::kBodySizeOffset, std::uint64_t{60} << 20);
  parser.feed(header);
  EXPECT_FALSE(parser.next());
  EXPECT_EQ(parser.wanted(), std::size_t{60} << 20);
  EXPECT_LT(parser.prepare(1).size(), std::size_t{1} << 20);
}

TEST(IgtlParserTest, DoesNotMoveItsBufferOnceItHasGrown) {
  IgtlParser parser;
  const test::GreyImage grey(320, 240);
  const Bytes stream = pose("A") + grey.as_message("Image") + pose("B");
  names_in(parser, stream, 4096);
  const auto room = parser.prepare(4096);
  const std::byte* begin = room.data();
  const std::size_t size = room.size();
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(names_in(parser, stream, 4096).size(), 3u);
    EXPECT_EQ(parser.prepare(4096).data(), begin);
    EXPECT_EQ(parser.prepare(4096).size(), size);
  }
}

TEST(IgtlParserTest, BeginsAnewAfterALostConnection) {
  IgtlParser parser;
  const Bytes whole = pose("A");
  parser.feed(std::span(whole).first(70));
  EXPECT_FALSE(parser.next());
  parser.reset();
  EXPECT_EQ(names_in(parser, pose("B"), SIZE_MAX), (Names{"B"}));
  EXPECT_EQ(parser.counts().skipped, 70u);
  EXPECT_EQ(parser.counts().faults_total(), 0u);
}

}  // namespace
}  // namespace nav::devices
