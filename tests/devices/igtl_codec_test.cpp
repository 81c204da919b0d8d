// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "devices/openigtlink/igtl_crc.hpp"
#include "devices/openigtlink/igtl_messages.hpp"
#include "devices/openigtlink/igtl_text.hpp"
#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

using test::Bytes;
using test::operator+;

/// Two foreign libraries gave these bytes for a TRANSFORM named StylusToTracker at 1234567890.25 s,
/// with the translation (10, 20, 30) mm.
constexpr const char* kTransformVector =
    "00015452414e53464f524d0000005374796c7573546f547261636b65720000000000499602d2400000000000000000"
    "0000"
    "30dcd28e1f46e9e6f73f8000000000000000000000000000003f8000000000000000000000000000003f8000004120"
    "00"
    "0041a0000041f00000";
/// The beginning of the same with header version 2, message id 42 and TransformStatus=OK.
constexpr const char* kTransformVersion2Start =
    "00025452414e53464f524d0000005374796c7573546f547261636b65720000000000499602d2400000000000000000"
    "0000"
    "574b042a5a5c51366b000c000a000000110000002a";
constexpr const char* kStringVector =
    "0001535452494e47000000000000436d6400000000000000000000000000000000000000000180000000000000"
    "000000000911bb731ffe0317650003000568656c6c6f";

Result<IgtlMessage> split(const Bytes& bytes) {
  const IgtlHeader header = read_igtl_header(
      std::span<const std::byte, kIgtlHeaderBytes>(bytes.data(), kIgtlHeaderBytes));
  return split_igtl_body(header, std::span(bytes).subspan(kIgtlHeaderBytes));
}

TEST(IgtlCrcTest, HasThePublishedCheckValueForEveryLength) {
  EXPECT_EQ(igtl_crc64(test::text_bytes("123456789")), 0x6C40DF5F0B497347u);
  // The wide steps agree with single bytes, wherever they begin.
  Bytes bytes(100);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * 37 + 11);
  std::uint64_t one_by_one = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_EQ(igtl_crc64(std::span(bytes).first(i)), one_by_one) << i;
    one_by_one = igtl_crc64(std::span(bytes).subspan(i, 1), one_by_one);
  }
}

TEST(IgtlCodecTest, WritesAndReadsATransformAsForeignLibrariesDo) {
  const Bytes expected = test::from_hex(kTransformVector);
  ASSERT_EQ(expected.size(), 106u);
  EXPECT_EQ(test::transform_message("StylusToTracker", test::translation(10, 20, 30)), expected);

  const auto message = split(expected);
  ASSERT_TRUE(test::has_value(message));
  EXPECT_EQ(message->header.type_name(), "TRANSFORM");
  EXPECT_EQ(message->header.device_name(), "StylusToTracker");
  EXPECT_EQ(message->header.device_time(),
            DeviceTime(std::chrono::milliseconds(1'234'567'890'250)));
  EXPECT_EQ(message->header.crc, igtl_crc64(std::span(expected).subspan(kIgtlHeaderBytes)));
  const auto pose = decode_igtl_transform(message->content);
  ASSERT_TRUE(test::has_value(pose));
  EXPECT_EQ(pose->matrix(), test::translation(10, 20, 30));
}

TEST(IgtlCodecTest, WritesAndReadsMetadataAsForeignLibrariesDo) {
  const IgtlMetadataEntry entry{.key = "TransformStatus", .value = "OK"};
  const Bytes bytes =
      test::message({.version = 2,
                     .type = "TRANSFORM",
                     .device = "StylusToTracker",
                     .stamp = test::kStamp,
                     .message_id = 42,
                     .metadata = std::span(&entry, 1)},
                    test::content_of(IgtlTransform::from(test::translation(10, 20, 30))));
  ASSERT_EQ(bytes.size(), 145u);
  const Bytes start = test::from_hex(kTransformVersion2Start);
  EXPECT_TRUE(std::ranges::equal(std::span(bytes).first(start.size()), start));

  const auto message = split(bytes);
  ASSERT_TRUE(test::has_value(message));
  EXPECT_EQ(message->message_id, 42u);
  EXPECT_EQ(message->content.size(), 48u);
  EXPECT_EQ(message->metadata.size(), 1u);
  EXPECT_EQ(message->metadata.find("TransformStatus"), "OK");
  EXPECT_EQ(message->metadata.find("Transform"), std::nullopt);
}

TEST(IgtlCodecTest, WritesAndReadsAStringAsForeignLibrariesDo) {
  Bytes content;
  append_igtl_string(content, {.text = "hello"});
  constexpr std::uint64_t kOneAndAHalf = std::uint64_t{3} << 31;
  const Bytes bytes =
      test::message({.type = "STRING", .device = "Cmd", .stamp = kOneAndAHalf}, content);
  EXPECT_EQ(bytes, test::from_hex(kStringVector));
  const auto string = decode_igtl_string(content);
  ASSERT_TRUE(test::has_value(string));
  EXPECT_EQ(string->text, "hello");
}

TEST(IgtlCodecTest, ConvertsTimeStampsToTheNanosecond) {
  IgtlHeader header;
  EXPECT_EQ(header.device_time(), std::nullopt) << "0 means that the sender gives none";
  for (const std::int64_t ns :
       {std::int64_t{1}, std::int64_t{999'999'999}, std::int64_t{1'234'567'890'123'456'789},
        std::int64_t{4'294'967'295'999'999'999}}) {
    const DeviceTime time{DeviceClock::duration(ns)};
    header.stamp = igtl_stamp(time);
    EXPECT_EQ(header.device_time(), time) << ns;
  }
}

TEST(IgtlCodecTest, AVersion1HeaderHasNeitherMetadataNorMessageId) {
  const IgtlMetadataEntry entry{.key = "TransformStatus", .value = "OK"};
  const Bytes bytes = test::message(
      {.type = "TRANSFORM", .message_id = 42, .metadata = std::span(&entry, 1)}, Bytes(48));
  EXPECT_EQ(bytes.size(), 106u);
}

TEST(IgtlCodecTest, ReadsAnExtendedHeaderThatHasGrown) {
  Bytes body = test::from_hex(
      "000e"
      "0002"
      "00000000"
      "00000007"
      "abcd");
  body = body + Bytes(48) + test::from_hex("0000");
  IgtlHeader header;
  header.version = 3;
  header.body_size = body.size();
  const auto message = split_igtl_body(header, body);
  ASSERT_TRUE(test::has_value(message));
  EXPECT_EQ(message->message_id, 7u);
  EXPECT_EQ(message->content.size(), 48u);
}

TEST(IgtlCodecTest, RejectsMetadataThatDoNotFitByName) {
  const auto with_extended_header = [](const char* hex) {
    const Bytes body = test::from_hex(hex);
    IgtlHeader header;
    header.version = 2;
    std::ranges::copy(std::string_view("TRANSFORM"), header.type.begin());
    header.body_size = body.size();
    return split_igtl_body(header, body);
  };
  constexpr ErrorCode kBad = ErrorCode::kMalformedData;
  EXPECT_TRUE(test::rejects(with_extended_header("000b00020000000000000000ffff"), kBad,
                            {"TRANSFORM", "extended header", "12", "11"}));
  EXPECT_TRUE(test::rejects(with_extended_header("000c0003000000000000000000000000"), kBad,
                            {"metadata header", "0 entries", "2", "3"}));
  EXPECT_TRUE(test::rejects(with_extended_header("000c0002ffffffff000000000000"), kBad,
                            {"within the body of 14 bytes", "4294967309"}));
  EXPECT_TRUE(test::rejects(with_extended_header("000c000a0000000200000000"
                                                 "00010003000300000009"
                                                 "4142"),
                            kBad, {"metadata", "12", "2"}));
  EXPECT_TRUE(test::rejects(with_extended_header("000c"), kBad, {"extended header", "12", "2"}));
}

TEST(IgtlCodecTest, PassesImpossiblePosesOnForTheGate) {
  IgtlTransform transform;
  transform.columns.fill(std::nanf(""));
  transform.columns[0] = 1e-42F;  // Denormal.
  const auto read = decode_igtl_transform(test::content_of(transform));
  ASSERT_TRUE(test::has_value(read));
  EXPECT_EQ(read->matrix()(0, 0), double{1e-42F});
  EXPECT_TRUE(std::isnan(read->matrix()(1, 0)));
}

TEST(IgtlCodecTest, ReadsBothFormsOfAPosition) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  IgtlPosition position{.position_mm = {1, -2, 3}};
  for (int i = 0; i < 4; ++i) {
    position.quaternion[static_cast<std::size_t>(i)] = static_cast<float>(turn.coeffs()[i]);
  }
  constexpr double kRounding = 1e-6;  // Single precision.
  for (const bool without_w : {false, true}) {
    position.without_w = without_w;
    const Bytes content = test::content_of(position);
    EXPECT_EQ(content.size(), without_w ? 24u : 28u);
    const auto read = decode_igtl_position(content);
    ASSERT_TRUE(test::has_value(read));
    const Eigen::Matrix4d matrix = read->matrix();
    EXPECT_TRUE((matrix.topLeftCorner<3, 3>()).isApprox(turn.toRotationMatrix(), kRounding));
    EXPECT_EQ(matrix(1, 3), -2);
    EXPECT_EQ(test::content_of(*read), content);
  }
  position.quaternion = {1, 1, 1, 0};
  const auto impossible = decode_igtl_position(test::content_of(position));
  ASSERT_TRUE(test::has_value(impossible));
  EXPECT_FALSE(impossible->matrix().allFinite()) << "no orientation is made up";
  EXPECT_TRUE(test::rejects(decode_igtl_position(Bytes(12)), ErrorCode::kMalformedData,
                            {"POSITION", "28", "24", "12"}));
}

TEST(IgtlCodecTest, ReadsTheToolsThatItWrote) {
  IgtlTrackingElement probe{.name = "ProbeToTracker", .type = 2, .pose = {}};
  probe.pose = IgtlTransform::from(test::translation(1, 2, 3));
  IgtlTrackingElement full{.name = "12345678901234567890", .type = 4, .pose = {}};
  const Bytes content = test::content_of(probe) + test::content_of(full);
  const auto tools = decode_igtl_tdata(content);
  ASSERT_TRUE(test::has_value(tools));
  ASSERT_EQ(tools->size(), 2u);
  EXPECT_EQ((*tools)[0].name, "ProbeToTracker");
  EXPECT_EQ((*tools)[0].pose.matrix(), test::translation(1, 2, 3));
  EXPECT_EQ((*tools)[1].name, "12345678901234567890") << "a full field has no NUL";
  EXPECT_EQ((*tools)[1].type, 4);
  EXPECT_TRUE(test::rejects(decode_igtl_tdata(std::span(content).first(139)),
                            ErrorCode::kMalformedData, {"TDATA", "70", "139"}));

  IgtlQuaternionElement turned{.name = "Needle", .pose = {}};
  turned.pose = {.position_mm = {4, 5, 6}, .quaternion = {0, 0, 0, 1}};
  const Bytes turned_content = test::content_of(turned);
  const auto turned_tools = decode_igtl_qtdata(turned_content);
  ASSERT_TRUE(test::has_value(turned_tools));
  EXPECT_EQ((*turned_tools)[0].pose.matrix(), test::translation(4, 5, 6));
  EXPECT_TRUE(
      test::rejects(decode_igtl_qtdata(Bytes(49)), ErrorCode::kMalformedData, {"QTDATA", "50"}));
}

TEST(IgtlCodecTest, ReadsTheTextsThatItWrote) {
  Bytes content;
  append_igtl_status(content, {13, -7, "ACTUATOR", "It is off."});
  const auto status = decode_igtl_status(content);
  ASSERT_TRUE(test::has_value(status));
  EXPECT_EQ(status->code, 13);
  EXPECT_EQ(status->subcode, -7);
  EXPECT_EQ(status->error_name, "ACTUATOR");
  EXPECT_EQ(status->message, "It is off.");
  content.pop_back();
  EXPECT_EQ(decode_igtl_status(content)->message, "It is off.") << "without its NUL";
  EXPECT_TRUE(
      test::rejects(decode_igtl_status(Bytes(29)), ErrorCode::kMalformedData, {"STATUS", "30"}));

  content.clear();
  append_igtl_command(content, {7, "Start", 3, "<Command/>"});
  const auto command = decode_igtl_command(content);
  ASSERT_TRUE(test::has_value(command));
  EXPECT_EQ(command->id, 7u);
  EXPECT_EQ(command->name, "Start");
  EXPECT_EQ(command->text, "<Command/>");

  content.clear();
  append_igtl_capability(content, std::array<std::string_view, 2>{"IMAGE", "STT_TDATA"});
  const auto types = decode_igtl_capability(content);
  ASSERT_TRUE(test::has_value(types));
  ASSERT_EQ(types->size(), 2u);
  EXPECT_EQ((*types)[1].name, "STT_TDATA");

  content.clear();
  append_igtl_sensor(content, {.unit = 5, .values = {}}, std::array{1.5, -2.5});
  const auto sensor = decode_igtl_sensor(content);
  ASSERT_TRUE(test::has_value(sensor));
  ASSERT_EQ(sensor->size(), 2u);
  EXPECT_EQ(sensor->unit, 5u);
  EXPECT_EQ(sensor->value(1), -2.5);

  content = test::content_of(IgtlPoint{"Fiducial", "Group", {1, 2, 3, 4}, {5, 6, 7}, 0.5F, "CT"});
  const auto points = decode_igtl_point(content);
  ASSERT_TRUE(test::has_value(points));
  ASSERT_EQ(points->size(), 1u);
  EXPECT_EQ((*points)[0].name, "Fiducial");
  EXPECT_EQ((*points)[0].owner, "CT");
  EXPECT_EQ((*points)[0].position_mm[2], 7);
}

TEST(IgtlCodecTest, RejectsTextsLongerThanTheirContent) {
  Bytes content;
  append_igtl_string(content, {.text = "hello"});
  content[3] = std::byte{6};
  EXPECT_TRUE(
      test::rejects(decode_igtl_string(content), ErrorCode::kMalformedData, {"STRING", "6", "5"}));
  EXPECT_TRUE(test::rejects(decode_igtl_string(Bytes(3)), ErrorCode::kMalformedData, {"STRING"}));
  content.clear();
  append_igtl_command(content, {1, "a", 3, "text"});
  content[134] = std::byte{255};
  EXPECT_TRUE(test::rejects(decode_igtl_command(content), ErrorCode::kMalformedData,
                            {"COMMAND", "4278190084", "4"}));
  content.clear();
  append_igtl_sensor(content, {.values = {}}, std::array{1.0});
  content[0] = std::byte{2};
  EXPECT_TRUE(
      test::rejects(decode_igtl_sensor(content), ErrorCode::kMalformedData, {"SENSOR", "16", "8"}));
}

TEST(IgtlCodecTest, KnowsTheNamesOfQueries) {
  ASSERT_TRUE(igtl_query("STT_TDATA"));
  EXPECT_EQ(igtl_query("STT_TDATA")->kind, IgtlQueryKind::kStart);
  EXPECT_EQ(igtl_query("STT_TDATA")->of, "TDATA");
  EXPECT_EQ(igtl_query("GET_CAPABIL")->kind, IgtlQueryKind::kGet);
  EXPECT_EQ(igtl_query("STP_TDATA")->kind, IgtlQueryKind::kStop);
  EXPECT_EQ(igtl_query("RTS_TDATA")->kind, IgtlQueryKind::kReply);
  EXPECT_FALSE(igtl_query("GET_"));
  EXPECT_FALSE(igtl_query("IMAGE"));
}

TEST(IgtlCodecTest, NamesFromTheWireAreBoundedAndEscaped) {
  EXPECT_EQ(igtl_escaped("Probe\x1b[31m\n\\"), "Probe\\x1b[31m\\x0a\\x5c");
  EXPECT_EQ(igtl_escaped(std::string(100, 'a'), 8), "aaaaaaaa...");
  const Bytes bytes =
      test::message({.type = "TRANSFORM", .device = "12345678901234567890123\n"}, Bytes(48));
  const auto message = split(bytes);
  ASSERT_TRUE(test::has_value(message));
  EXPECT_EQ(message->header.device_name(), "12345678901234567890");
  EXPECT_EQ(message->header.description(), "TRANSFORM 12345678901234567890");
}

TEST(IgtlCodecTest, AStatusThatIsMissingOrUnknownIsNeverOk) {
  EXPECT_EQ(igtl_tracking_status("OK"), TrackingStatus::kOk);
  EXPECT_EQ(igtl_tracking_status("TOOL_OK"), TrackingStatus::kOk);
  EXPECT_EQ(igtl_tracking_status(""), TrackingStatus::kUnknown);
  EXPECT_EQ(igtl_tracking_status("UNKNOWN"), TrackingStatus::kUnknown);
  EXPECT_EQ(igtl_tracking_status("MISSING"), TrackingStatus::kOccluded);
  EXPECT_EQ(igtl_tracking_status("OUT_OF_VOLUME"), TrackingStatus::kOutOfVolume);
  EXPECT_EQ(igtl_tracking_status("ok"), TrackingStatus::kInvalid);
  for (const TrackingStatus status : {TrackingStatus::kOk, TrackingStatus::kOccluded,
                                      TrackingStatus::kTimeout, TrackingStatus::kInvalid}) {
    EXPECT_EQ(igtl_tracking_status(igtl_status_text(status)), status);
  }
}

}  // namespace
}  // namespace nav::devices
