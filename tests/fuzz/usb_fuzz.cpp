// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Messages of a Polhemus Liberty, lines of an Interson SeeMore, and headers of USB/IP. Transfers
// may have any size.
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "devices/usb/interson_codec.hpp"
#include "devices/usb/polhemus_codec.hpp"
#include "devices/usb/polhemus_emulator.hpp"
#include "devices/usb/usbip_protocol.hpp"
#include "tests/fuzz/fuzz_input.hpp"

namespace {

using namespace nav::devices;

void check(const IntersonNews& news) {
  if (news.advance < 1 || news.advance > kIntersonNumbers) __builtin_trap();
  if (news.kind == IntersonNews::Kind::kImage &&
      news.samples.size() != kIntersonLines * kIntersonSamples) {
    __builtin_trap();
  }
}

void check(const PolhemusNews& news) {
  if (news.kind != PolhemusNews::Kind::kRecord) return;
  if (news.record.station < 1 || news.record.station > kMostPolhemusStations) __builtin_trap();
  (void)polhemus_trouble(news.record);
  (void)polhemus_error(news.record.error);
}

/// Lines in a few bytes: each byte of the input is a line with its number, or a part of one.
void assemble_lines(std::span<const std::uint8_t> input) {
  IntersonAssembler assembler;
  std::vector<std::byte> line(kIntersonLineBytes);
  for (const std::uint8_t one : input) {
    line[0] = static_cast<std::byte>(one % 20);
    const std::size_t size = one < 240 ? kIntersonLineBytes : 60U * (one - 239U);
    // A byte stands for many lines, so that a short input makes whole images.
    for (int i = 0; i < (one < 200 ? 241 : 1); ++i) {
      assembler.take(std::span(line).first(size), {}, [](IntersonNews&& news) { check(news); });
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto all = std::as_bytes(std::span(bytes, size));
  PolhemusParser parser;
  IntersonAssembler assembler;
  PolhemusEmulatedTracker tracker(
      {.see = [](int, std::uint32_t) { return std::optional<PolhemusReading>(PolhemusReading{}); }},
      {});
  std::size_t part = 1;
  for (auto rest = all; !rest.empty(); part = part % 97 + 7) {
    const auto now = rest.first(std::min(part, rest.size()));
    parser.take(now, [](const PolhemusNews& news) { check(news); });
    assembler.take(now, {}, [](IntersonNews&& news) { check(news); });
    (void)tracker.take(kLibertyOut, now, {});
    while (tracker.give(kLibertyIn, 512, {})) {
    }
    rest = rest.subspan(now.size());
  }
  constexpr std::size_t kMostLines = 64;
  assemble_lines(std::span(bytes, std::min(size, kMostLines)));
  for (std::size_t at = 0; at + kUsbipHeaderBytes <= size; at += kUsbipHeaderBytes) {
    const UsbipHeader header = read_usbip_header(all.subspan(at, kUsbipHeaderBytes));
    std::vector<std::byte> written;
    if (header.command >= 1 && header.command <= 4) append_usbip_header(written, header);
  }
  if (size >= kUsbipDeviceBytes) (void)read_usbip_device(all.first(kUsbipDeviceBytes));
  return 0;
}
