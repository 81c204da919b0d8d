// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "devices/usb/interson_emulator.hpp"
#include "devices/usb/sector_scan.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// Sector in which an emulated probe scans an image: that of its outline, or for an image without
/// one a sector whose first samples lie along its upper edge.
struct EmulatedSector {
  SectorShape shape;
  Eigen::Vector2d apex_mm;  ///< Image frame of that image.
};
EmulatedSector sector_of(const UltrasoundImage& image);
/// Samples along the lines of a sector, nearest pixel; 0 outside of the image.
IntersonLines scan_lines_of(const UltrasoundImage& image, const EmulatedSector& sector);

/// Gives images of a session to an emulated Interson SeeMore. Each is sent once. Thread-safe.
class IntersonSender {
 public:
  /// Errors: those of IntersonEmulator::start().
  static Result<std::unique_ptr<IntersonSender>> start(IntersonFaultPlan plan,
                                                       const std::string& address,
                                                       std::uint16_t port);
  /// Shows the newest image. The sector is that of the first image. Samples that are no images are
  /// left out. Returns the sector when it has just been chosen.
  std::optional<EmulatedSector> send(const Sample& sample);
  [[nodiscard]] IntersonEmulator& emulator() { return *emulator_; }

 private:
  IntersonSender() = default;
  std::optional<IntersonLines> see();

  std::optional<EmulatedSector> sector_;  ///< Used by send() only.
  std::mutex mutex_;                      ///< Guards the newest lines.
  std::optional<IntersonLines> newest_;
  std::unique_ptr<IntersonEmulator> emulator_;
};

}  // namespace nav::devices
