// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "devices/ndi/ndi_commands.hpp"
#include "devices/ndi/ndi_forms.hpp"
#include "nav/source.hpp"

namespace nav::devices {

enum class NdiState { kWaiting, kConnecting, kResetting, kSetup, kTracking, kSilent, kStopped };

/// Account of a source.
struct NdiHealth {
  NdiState state = NdiState::kWaiting;
  std::string cause;              ///< Cause of the newest loss; empty: none yet.
  std::uint64_t connections = 0;  ///< That reached tracking.
  std::uint64_t silences = 0;
  std::uint64_t bytes = 0;
  std::uint64_t repeats = 0;     ///< Readings whose number did not advance; they were dropped.
  std::uint64_t undeclared = 0;  ///< Readings of tools that no stream names.
  std::map<std::string, std::uint64_t> bad_replies;  ///< Keys: NdiFault, "error_0C".
  std::map<std::string, std::uint64_t> losses;       ///< Keys: causes.
  NdiVersion version;
  NdiForm form = NdiForm::kBx2;          ///< In use.
  std::vector<std::string> tool_faults;  ///< One for each stream; empty: it can be tracked.
  std::vector<std::uint64_t> samples;    ///< One for each stream.
};
/// The account in the form that all sources have. The cause "tool": nothing was lost, but a tool
/// cannot be tracked.
SourceHealth source_health(const NdiHealth& health);

}  // namespace nav::devices
