// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <map>

#include "devices/openigtlink/igtl_messages.hpp"
#include "devices/openigtlink/igtl_parser.hpp"
#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// Messages that the tests of the protocol's reference library hold.
namespace nav::devices {
namespace {

using test::Bytes;

constexpr std::size_t kRecordedMessages = 23;

std::map<std::string, Bytes> read_wires(const std::filesystem::path& folder) {
  std::map<std::string, Bytes> wires;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    wires[entry.path().filename().string()] = test::text_bytes(text);
  }
  return wires;
}

/// Decodes a content and writes it again; absent for types without a decoder.
std::optional<Bytes> rewritten(const IgtlMessage& message) {
  const std::string_view type = message.header.type_name();
  const auto content = message.content;
  Bytes out;
  IgtlWriter writer(out);
  const auto all = [&](const auto& records) {
    EXPECT_TRUE(test::has_value(records)) << type;
    for (std::size_t i = 0; records && i < records->size(); ++i) (*records)[i].write(writer);
  };
  if (type == "TRANSFORM") {
    decode_igtl_transform(content)->write(writer);
  } else if (type == "POSITION") {
    decode_igtl_position(content)->write(writer);
  } else if (type == "TDATA") {
    all(decode_igtl_tdata(content));
  } else if (type == "POINT") {
    all(decode_igtl_point(content));
  } else if (type == "IMAGE") {
    append_igtl_image(out, *decode_igtl_image(content));
  } else if (type == "STATUS") {
    append_igtl_status(out, *decode_igtl_status(content));
  } else if (type == "STRING") {
    append_igtl_string(out, *decode_igtl_string(content));
  } else if (type == "COMMAND") {
    append_igtl_command(out, *decode_igtl_command(content));
  } else if (type == "CAPABILITY") {
    std::vector<std::string_view> names;
    const auto types = decode_igtl_capability(content);
    for (std::size_t i = 0; i < types->size(); ++i) names.push_back((*types)[i].name);
    append_igtl_capability(out, names);
  } else if (type == "SENSOR") {
    const auto sensor = decode_igtl_sensor(content);
    std::vector<double> values;
    for (std::size_t i = 0; i < sensor->size(); ++i) values.push_back(sensor->value(i));
    append_igtl_sensor(out, *sensor, values);
  } else {
    return std::nullopt;
  }
  return out;
}

TEST(IgtlRecordedTest, EveryMessageIsReadAndWrittenByteForByte) {
  SONDE_REQUIRE_DATA(folder, "wire-openigtlink/bin");
  const auto wires = read_wires(folder);
  EXPECT_EQ(wires.size(), kRecordedMessages);
  std::size_t decoded = 0;
  for (const auto& [name, bytes] : wires) {
    SCOPED_TRACE(name);
    IgtlParser parser;
    parser.feed(bytes);
    const auto message = parser.next();  // The CRC holds, or nothing is found.
    ASSERT_TRUE(message);
    EXPECT_EQ(parser.counts().faults_total(), 0u);
    EXPECT_EQ(parser.counts().skipped, 0u);
    EXPECT_FALSE(parser.next());

    std::vector<IgtlMetadataEntry> metadata;
    message->metadata.for_each([&](const IgtlMetadataEntry& one) { metadata.push_back(one); });
    const auto again = rewritten(*message);
    if (again) ++decoded;
    const IgtlHeader& header = message->header;
    const auto content = again ? std::span<const std::byte>(*again) : message->content;
    EXPECT_EQ(test::message({.version = header.version,
                             .type = header.type_name(),
                             .device = header.device_name(),
                             .stamp = header.stamp,
                             .message_id = message->message_id,
                             .metadata = metadata},
                            content),
              bytes);
  }
  EXPECT_EQ(decoded, 14u) << "messages whose content was written anew";
}

TEST(IgtlRecordedTest, FindsAllMessagesInOneStreamByteByByte) {
  SONDE_REQUIRE_DATA(folder, "wire-openigtlink/bin");
  const auto wires = read_wires(folder);
  IgtlParser parser;
  for (const auto& [name, bytes] : wires) {
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      parser.feed(std::span(bytes).subspan(i, 1));
      EXPECT_EQ(parser.next().has_value(), i + 1 == bytes.size()) << name << ", byte " << i;
    }
  }
  EXPECT_EQ(parser.counts().messages, wires.size());
  EXPECT_EQ(parser.counts().faults_total(), 0u);
}

TEST(IgtlRecordedTest, ReadsTheMetadataAndTheImage) {
  SONDE_REQUIRE_DATA(folder, "wire-openigtlink/bin");
  const auto wires = read_wires(folder);
  IgtlParser parser;
  parser.feed(wires.at("igtl_test_data_transformFormat2__test_transform_message_Format2.bin"));
  const auto transform = parser.next();
  ASSERT_TRUE(transform);
  EXPECT_EQ(transform->metadata.find("First patient age"), "22");
  EXPECT_EQ(transform->metadata.find("Second patient age"), "25");
  parser.feed(wires.at("igtl_test_data_image__test_image_message.bin"));
  const auto message = parser.next();
  ASSERT_TRUE(message);
  const auto image = decode_igtl_image(message->content);
  ASSERT_TRUE(test::has_value(image));
  EXPECT_EQ(image->size, (std::array<std::uint16_t, 3>{50, 50, 1}));
  constexpr double kSingle = 1e-5;
  EXPECT_LT((image->spacing_mm() - Eigen::Vector3d::Ones()).norm(), kSingle);
  EXPECT_EQ(image->centre_mm[0], 46.0531F);
}

}  // namespace
}  // namespace nav::devices
