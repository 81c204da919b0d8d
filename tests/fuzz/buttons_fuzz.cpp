// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Events of input devices, in parts of any size, and buttons in the frames of a CAN bus.
#include <algorithm>
#include <span>
#include <string>

#include "devices/buttons/evdev_codec.hpp"
#include "devices/can/can_button_source.hpp"
#include "tests/fuzz/fuzz_input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace nav::devices;
  const auto all = std::as_bytes(std::span(bytes, size));
  EvdevParser parser;
  std::size_t part = 1;
  for (auto rest = all; !rest.empty(); part = part % 31 + 3) {
    const std::size_t now = std::min(part, rest.size());
    parser.take(rest.first(now), [](const EvdevNews& news) {
      if (news.key > kMostEvdevKey) __builtin_trap();
    });
    rest = rest.subspan(now);
  }
  (void)evdev_key({reinterpret_cast<const char*>(bytes), size});
  for (std::size_t at = 0; at + kCanFrameBytes <= size; at += kCanFrameBytes) {
    const auto frame = decode_can(all.subspan(at, kCanFrameBytes));
    if (!frame) continue;
    const CanButton button{.name = "b",
                           .frame = frame->id,
                           .extended = frame->extended,
                           .byte = bytes[at] % 8,
                           .bit = bytes[at + 1] % 8};
    if (read_can_button(button, *frame) == CanButtonReading::kDown && frame->size == 0) {
      __builtin_trap();
    }
  }
  return 0;
}
