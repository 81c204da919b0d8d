// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Throughput of the OpenIGTLink codec on one core: bytes that came are found as messages, checked
// by their CRC and decoded.
#include <benchmark/benchmark.h>
#include <cstring>
#include <vector>

#include "devices/openigtlink/igtl_image.hpp"
#include "devices/openigtlink/igtl_parser.hpp"
#include "devices/openigtlink/igtl_poses.hpp"

namespace nav::devices {
namespace {

/// Bytes are copied into the parser's buffer, as a socket does.
template <class Decode>
void parse(benchmark::State& state, const std::vector<std::byte>& stream, Decode decode) {
  IgtlParser parser;
  std::int64_t messages = 0;
  for (auto _ : state) {
    parser.feed(stream);
    while (const auto message = parser.next()) {
      decode(*message);
      ++messages;
    }
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
  state.SetItemsProcessed(messages);
}

void BM_DecodeImage(benchmark::State& state) {
  const std::vector<std::byte> pixels(std::size_t{820} * 616, std::byte{77});
  IgtlImage image;
  image.size = image.part_size = {820, 616, 1};
  image.steps_mm = {{{0.1F, 0, 0}, {0, 0.1F, 0}, {0, 0, 1}}};
  image.pixels = pixels;
  std::vector<std::byte> content;
  append_igtl_image(content, image);
  std::vector<std::byte> stream;
  append_igtl_message(stream, {.type = "IMAGE", .device = "Image"}, content);
  parse(state, stream, [](const IgtlMessage& message) {
    auto decoded = decode_igtl_image(message.content);
    benchmark::DoNotOptimize(decoded);
  });
}
BENCHMARK(BM_DecodeImage);

void BM_DecodeTransform(benchmark::State& state) {
  std::vector<std::byte> content;
  IgtlWriter writer(content);
  IgtlTransform::from(Eigen::Matrix4d::Identity()).write(writer);
  const IgtlMetadataEntry status{.key = "TransformStatus", .value = "OK"};
  std::vector<std::byte> stream;
  for (int i = 0; i < 100; ++i) {
    append_igtl_message(stream,
                        {.version = 2,
                         .type = "TRANSFORM",
                         .device = "ProbeToTracker",
                         .metadata = std::span(&status, 1)},
                        content);
  }
  parse(state, stream, [](const IgtlMessage& message) {
    auto decoded = decode_igtl_transform(message.content);
    auto found = message.metadata.find("TransformStatus");
    benchmark::DoNotOptimize(decoded);
    benchmark::DoNotOptimize(found);
  });
}
BENCHMARK(BM_DecodeTransform);

}  // namespace
}  // namespace nav::devices
