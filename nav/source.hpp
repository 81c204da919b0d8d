// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/sample.hpp"

namespace nav {

enum class StreamKind { kImages, kPoses, kButtons };
/// Stable name of one of its samples: "image", "pose", "button".
const char* to_string(StreamKind kind);

/// One stream of a source: images, the poses of one tool, or the changes of one button.
struct StreamInfo {
  std::string name;  ///< The tool's name or id in the source, or the name of the images or button.
  StreamKind kind = StreamKind::kPoses;
  ToolRole role = ToolRole::kOther;           ///< Poses only.
  ButtonAction action = ButtonAction::kNone;  ///< Buttons only.
};

enum class SourceState {
  kStarting,   ///< Nothing has come yet.
  kReady,      ///< The connection stands; the device speaks only when something happens.
  kStreaming,  ///< Samples come.
  kSilent,     ///< The connection stands, but nothing comes.
  kWaiting,    ///< The device is not there; it is tried again.
  kEnded,      ///< Nothing more will come.
};
/// Stable lower-case name, for reports.
const char* to_string(SourceState state);

/// State of what stands behind a source, and its account of what came over the wire.
struct SourceHealth {
  SourceState state = SourceState::kStarting;
  std::string cause{};           ///< Cause of the newest loss; empty: none yet.
  std::string firmware{};        ///< Empty: the device does not say.
  std::string serial{};          ///< Empty: the device does not say.
  std::uint64_t reconnects = 0;  ///< Connections after the first.
  std::uint64_t bytes = 0;       ///< Received.
  /// Messages and parts of messages that could not be used, by cause.
  std::map<std::string, std::uint64_t> bad_messages{};
  /// Samples that the device gave again because it had no newer ones; they are left out.
  std::uint64_t repeats = 0;
};

/// Everything that delivers samples: a recording, the simulator, a device. One source has one or
/// more streams. A source owns at most one thread and joins it in stop().
class Source {
 public:
  virtual ~Source() = default;
  /// The streams; constant from construction on.
  [[nodiscard]] virtual const std::vector<StreamInfo>& streams() const = 0;
  /// Next sample in order of arrival, over all streams. kTimeout at the deadline, kEndOfStream
  /// after the last sample, kCancelled after stop(). Any other error ends the source. One caller at
  /// a time.
  virtual Result<Sample> next(Deadline deadline) = 0;
  /// Ends a waiting next(). Idempotent; may be called from another thread.
  virtual void stop() noexcept = 0;
  /// Thread-safe. A source without a device behind it says nothing.
  [[nodiscard]] virtual SourceHealth health() const { return {}; }
};

}  // namespace nav
