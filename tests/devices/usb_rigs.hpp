// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <memory>

#include "devices/usb/interson_emulator.hpp"
#include "devices/usb/interson_source.hpp"
#include "devices/usb/polhemus_emulator.hpp"
#include "devices/usb/polhemus_source.hpp"
#include "devices/usb/usbip_link.hpp"

namespace nav::devices {

inline UsbTimes quick_usb_times() {
  return {.silence = std::chrono::milliseconds(150),
          .lost = std::chrono::milliseconds(800),
          .first_retry = std::chrono::milliseconds(20),
          .longest_retry = std::chrono::milliseconds(50)};
}

inline const UsbId kLibertyId{kPolhemusVendor, kLibertyProduct};
inline const UsbId kSeeMoreId{kIntersonVendor, kSeeMoreProduct};

/// Opens the device that a server on this machine exports.
inline UsbOpener usbip_opener(UsbipServer& server, const UsbId& id = kLibertyId) {
  return [port = server.port(), id] { return open_usbip("127.0.0.1", port, id); };
}

/// Step of a station along x for each frame, mm: the position tells the frame.
inline constexpr double kPolhemusStepMm = 0.125;

/// Truth of a station: it moves along x, and turns about an axis.
inline PolhemusReading polhemus_truth(int station, std::uint32_t frame) {
  const double angle = 0.01 * frame;
  const double axis = std::sqrt(1.0 / 3);
  const double s = std::sin(angle / 2) * axis;
  return {.position_mm = {kPolhemusStepMm * frame, 10.0 * station, -40.0},
          .rotation_wxyz = {std::cos(angle / 2), s, s, s}};
}

inline std::unique_ptr<PolhemusEmulator> emulated_liberty(int stations,
                                                          std::uint32_t first_ms = 0) {
  return *PolhemusEmulator::start(
      {.stations = stations, .first_ms = first_ms, .see = polhemus_truth});
}

inline IntersonOptions see_more_options() {
  return {.settings = {.high_voltage = 100},
          .shape = {.radius_mm = 20, .depth_mm = 80, .angle_deg = 60, .spacing_mm = 0.5},
          .times = quick_usb_times()};
}

/// Truth of an image: the middle line tells its number, modulo 120, and one side is darker.
inline IntersonLines see_more_truth(std::uint64_t image) {
  const std::size_t bright = 2 * (image % 120);
  IntersonLines lines;
  for (std::size_t line = 0; line < kIntersonLines; ++line) {
    const std::size_t dark = line < kIntersonLines / 2 ? (kIntersonLines / 2 - line) / 4 : 0;
    lines.insert(lines.end(), kIntersonSamples,
                 static_cast<std::uint8_t>(bright > dark ? bright - dark : 0));
  }
  return lines;
}

inline std::unique_ptr<IntersonEmulator> emulated_see_more() {
  return *IntersonEmulator::start({.see = see_more_truth});
}

}  // namespace nav::devices
