// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <gtest/gtest.h>
#include <random>

#include "devices/openigtlink/igtl_messages.hpp"
#include "devices/openigtlink/igtl_parser.hpp"
#include "tests/devices/igtl_wire.hpp"

/// Random damage. The address sanitizer sees every read past an end.
namespace nav::devices {
namespace {

using test::Bytes;
using test::operator+;

/// Decodes a content as every type, and reads all that the decoders give. Returns a sum, so that no
/// read is left out.
double read_everything(std::span<const std::byte> content) {
  double sum = 0;
  const auto text = [&](std::string_view s) {
    for (const char c : s) sum += c;
  };
  const auto records = [&](const auto& found, auto visit) {
    for (std::size_t i = 0; found && i < found->size(); ++i) visit((*found)[i]);
  };
  if (const auto pose = decode_igtl_transform(content)) sum += pose->matrix()(0, 3);
  if (const auto pose = decode_igtl_position(content)) sum += pose->matrix()(0, 3);
  records(decode_igtl_tdata(content), [&](const auto& tool) { text(tool.name); });
  records(decode_igtl_qtdata(content), [&](const auto& tool) { text(tool.name); });
  records(decode_igtl_capability(content), [&](const auto& type) { text(type.name); });
  records(decode_igtl_point(content), [&](const auto& point) { text(point.owner); });
  if (const auto status = decode_igtl_status(content)) text(status->message);
  if (const auto string = decode_igtl_string(content)) text(string->text);
  if (const auto command = decode_igtl_command(content)) text(command->text);
  if (const auto sensor = decode_igtl_sensor(content); sensor && sensor->size() > 0) {
    sum += sensor->value(sensor->size() - 1);
  }
  if (const auto image = decode_igtl_image(content)) {
    sum += image->value(image->part_size[0] - 1u, image->part_size[1] - 1u,
                        image->part_size[2] - 1u, image->components - 1u);
  }
  return sum;
}

/// Copy in memory of exactly its size, where a read past the end is seen.
double read_exactly(std::span<const std::byte> content) {
  const std::vector<std::byte> copy(content.begin(), content.end());
  return read_everything(copy);
}

std::vector<Bytes> contents_of_all_types() {
  std::vector<Bytes> all;
  all.push_back(test::content_of(IgtlTransform::from(test::translation(1, 2, 3))));
  all.push_back(test::content_of(IgtlPosition{.quaternion = {0, 0, 0, 1}}));
  all.push_back(test::content_of(IgtlTrackingElement{.name = "A", .pose = {}}) +
                test::content_of(IgtlTrackingElement{.name = "B", .pose = {}}));
  all.push_back(test::content_of(IgtlQuaternionElement{.name = "A", .pose = {}}));
  all.push_back(test::GreyImage(7, 5).content());
  append_igtl_status(all.emplace_back(), {13, 1, "NAME", "message"});
  append_igtl_string(all.emplace_back(), {.text = "hello"});
  append_igtl_command(all.emplace_back(), {1, "name", 3, "text"});
  append_igtl_capability(all.emplace_back(), std::array<std::string_view, 2>{"A", "B"});
  append_igtl_sensor(all.emplace_back(), {.values = {}}, std::array{1.0, 2.0, 3.0});
  all.push_back(test::content_of(IgtlPoint{.name = "P", .group = "G", .owner = "O"}));
  return all;
}

void damage(Bytes& bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  for (std::size_t i = below(4); i-- > 0 && !bytes.empty();) {
    switch (below(4)) {
      case 0:
        bytes[below(bytes.size())] ^= static_cast<std::byte>(1u << below(8));
        break;
      case 1:
        bytes[below(bytes.size())] = std::byte{255};
        break;
      case 2:
        bytes.resize(below(bytes.size() + 1));
        break;
      default:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size())), below(5),
                     std::byte{0});
    }
  }
}

TEST(IgtlDamageTest, DecodersSurviveTruncationAtEveryByte) {
  for (const Bytes& content : contents_of_all_types()) {
    for (std::size_t size = 0; size <= content.size(); ++size) {
      read_exactly(std::span(content).first(size));
    }
  }
}

TEST(IgtlDamageTest, DecodersSurviveRandomDamage) {
  std::mt19937 random(48);
  const auto contents = contents_of_all_types();
  for (int i = 0; i < 20'000; ++i) {
    Bytes content = contents[static_cast<std::size_t>(i) % contents.size()];
    damage(content, random);
    read_exactly(content);
  }
}

TEST(IgtlDamageTest, TheParserSurvivesRandomDamageAndFindsTheNextMessage) {
  std::mt19937 random(49);
  const auto contents = contents_of_all_types();
  constexpr std::array<const char*, 11> kTypes = {"TRANSFORM",  "POSITION", "TDATA",  "QTDATA",
                                                  "IMAGE",      "STATUS",   "STRING", "COMMAND",
                                                  "CAPABILITY", "SENSOR",   "POINT"};
  const Bytes last = test::transform_message("Last", test::translation(1, 2, 3), "OK");
  const IgtlMetadataEntry entry{.key = "Key", .value = "Value"};
  constexpr int kFollowing = 40;  // Longer than any size that is believed at once.
  for (int round = 0; round < 2000; ++round) {
    Bytes stream;
    for (std::size_t i = 0; i < kTypes.size(); ++i) {
      const auto version = static_cast<std::uint16_t>(1 + random() % 3);
      Bytes bytes = test::message({.version = version,
                                   .type = kTypes[i],
                                   .device = "Device",
                                   .stamp = test::kStamp,
                                   .metadata = std::span(&entry, 1)},
                                  contents[i]);
      damage(bytes, random);
      stream = stream + bytes;
    }
    // A message that was cut short takes what follows for its end, until enough has come.
    for (int i = 0; i < kFollowing; ++i) stream = stream + last;
    IgtlParser parser;
    const std::size_t piece = 1 + random() % 200;
    bool found_last = false;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      parser.feed(std::span(stream).subspan(at, std::min(piece, stream.size() - at)));
      while (const auto message = parser.next()) {
        read_exactly(message->content);
        std::size_t length = 0;
        message->metadata.for_each([&](const IgtlMetadataEntry& one) {
          for (const char c : one.value) length += c != '\0';
        });
        found_last = message->header.device_name() == "Last";
      }
    }
    EXPECT_TRUE(found_last) << "round " << round;
    EXPECT_LE(parser.counts().skipped, stream.size());
  }
}

}  // namespace
}  // namespace nav::devices
