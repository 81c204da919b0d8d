// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "devices/usb/polhemus_emulator.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// Gives poses of a session to an emulated Polhemus Liberty: each body is a station, the first
/// number 1. A pose is sent once, with the next frame; a body that is not seen sends nothing.
/// Thread-safe.
class PolhemusSender {
 public:
  /// Errors: those of PolhemusEmulator::start(), kUsage for no body or more than 16.
  static Result<std::unique_ptr<PolhemusSender>> start(const std::vector<std::string>& bodies,
                                                       PolhemusFaultPlan plan,
                                                       const std::string& address,
                                                       std::uint16_t port);
  /// Shows the newest pose of a body. Samples that are no poses, and streams of other names, are
  /// left out.
  void send(const StreamInfo& stream, const Sample& sample);
  [[nodiscard]] PolhemusEmulator& emulator() { return *emulator_; }

 private:
  explicit PolhemusSender(std::vector<std::string> bodies);
  std::optional<PolhemusReading> see(int station);

  std::vector<std::string> bodies_;
  mutable std::mutex mutex_;                              ///< Guards the readings.
  std::vector<std::optional<PolhemusReading>> readings_;  ///< Poses that were not sent yet.
  std::unique_ptr<PolhemusEmulator> emulator_;
};

}  // namespace nav::devices
