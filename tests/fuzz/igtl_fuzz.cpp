// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// OpenIGTLink: the parser of a stream in two pieces, and every decoder on what it finds and on the
// bytes themselves.
#include <span>
#include <string_view>

#include "devices/openigtlink/igtl_image.hpp"
#include "devices/openigtlink/igtl_messages.hpp"
#include "devices/openigtlink/igtl_parser.hpp"
#include "devices/openigtlink/igtl_poses.hpp"
#include "tests/fuzz/fuzz_input.hpp"

namespace {

void decode(std::span<const std::byte> content) {
  using namespace nav::devices;
  (void)decode_igtl_status(content);
  (void)decode_igtl_string(content);
  (void)decode_igtl_command(content);
  (void)decode_igtl_capability(content);
  (void)decode_igtl_sensor(content);
  (void)decode_igtl_point(content);
  (void)decode_igtl_transform(content);
  (void)decode_igtl_position(content);
  (void)decode_igtl_tdata(content);
  (void)decode_igtl_qtdata(content);
  (void)decode_igtl_image(content);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav::devices;
  const auto all = std::as_bytes(std::span(bytes, size));
  IgtlParser parser;
  for (const auto piece : {all.first(size / 3), all.subspan(size / 3)}) {
    parser.feed(piece);
    while (const auto message = parser.next()) decode(message->content);
  }
  if (parser.counts().bytes != size) __builtin_trap();
  decode(all);
  return 0;
}
