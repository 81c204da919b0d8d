// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "devices/ndi/ndi_emulator.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// Gives poses of a session to an emulated NDI tracker: each body is a tool that is plugged in, the
/// first at port 1. The tracker's counter of a tool is the number of its samples; it gives no
/// times. Thread-safe.
class NdiSender {
 public:
  /// Errors: those of NdiEmulator::start(), kUsage for no body or more than 250.
  static Result<std::unique_ptr<NdiSender>> start(const std::vector<std::string>& bodies,
                                                  NdiEmulatorLine line, NdiFaultPlan plan);
  /// Shows the newest pose of a body. Samples that are no poses, and streams of other names, are
  /// left out.
  void send(const StreamInfo& stream, const Sample& sample);
  [[nodiscard]] const NdiEmulator& emulator() const { return *emulator_; }

 private:
  explicit NdiSender(std::vector<std::string> bodies);
  NdiToolReading see(std::size_t tool) const;

  std::vector<std::string> bodies_;
  mutable std::mutex mutex_;  ///< Guards the readings.
  std::vector<NdiToolReading> readings_;
  std::unique_ptr<NdiEmulator> emulator_;
};

}  // namespace nav::devices
