// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_health.hpp"

#include <algorithm>

namespace nav::devices {

SourceHealth source_health(const NdiHealth& own) {
  SourceHealth health{.cause = own.cause,
                      .firmware = own.version.firmware,
                      .serial = own.version.serial,
                      .reconnects = own.connections > 0 ? own.connections - 1 : 0,
                      .bytes = own.bytes,
                      .bad_messages = own.bad_replies,
                      .repeats = own.repeats};
  const bool faulty =
      std::ranges::any_of(own.tool_faults, [](const auto& f) { return !f.empty(); });
  if (faulty && health.cause.empty()) health.cause = "tool";
  const bool any = std::ranges::any_of(own.samples, [](auto count) { return count > 0; });
  switch (own.state) {
    case NdiState::kSetup:
    case NdiState::kTracking:
      health.state = any ? SourceState::kStreaming : SourceState::kStarting;
      break;
    case NdiState::kSilent:
      health.state = SourceState::kSilent;
      break;
    case NdiState::kStopped:
      health.state = SourceState::kEnded;
      break;
    default:
      health.state = SourceState::kWaiting;
      break;
  }
  return health;
}

}  // namespace nav::devices
