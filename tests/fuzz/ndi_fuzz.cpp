// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// NDI combined API: framing of replies, and every reader on what it finds and on the bytes.
#include <algorithm>
#include <span>
#include <string_view>

#include "devices/ndi/ndi_commands.hpp"
#include "devices/ndi/ndi_poses.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "tests/fuzz/fuzz_input.hpp"

namespace {

void read_all(std::string_view text, std::span<const std::byte> body) {
  using namespace nav::devices;
  NdiReadings readings;
  (void)read_ndi_tx(text, readings);
  (void)read_ndi_bx(body, readings);
  (void)read_ndi_bx2(body, readings);
  (void)read_ndi_handles(text);
  (void)read_ndi_tool_info(text);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav::devices;
  auto rest = std::as_bytes(std::span(bytes, size));
  read_all({reinterpret_cast<const char*>(bytes), size}, rest);
  while (!rest.empty()) {
    const NdiFraming framing = frame_ndi_reply(rest);
    if (framing.size == 0) break;
    if (framing.size > rest.size()) __builtin_trap();
    if (!framing.fault) read_all(framing.reply.text, framing.reply.body);
    rest = rest.subspan(framing.size);
  }
  return 0;
}
