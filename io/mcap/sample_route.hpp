// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "io/mcap/mcap_reader.hpp"
#include "io/mcap/sample_layout.hpp"
#include "nav/source.hpp"

namespace nav::io::mcap {

/// The stream whose samples a channel carries.
struct SampleRoute {
  std::size_t device = 0;  ///< Below kMaxDevices.
  std::string device_id;
  std::size_t stream = 0;  ///< Below kMaxStreams.
  StreamInfo info;
  SampleKind kind = SampleKind::kPose;
};

/// Id of the recording that a channel belongs to; empty: none.
std::string recording_of(const Channel& channel);
/// The route of a channel; absent unless it is of the recording with that id and of a known kind.
std::optional<SampleRoute> route_of(const Channel& channel, const Schema* schema,
                                    const std::string& recording_id);

/// Remembers the routes of the channels of a reader. Not thread-safe.
class SampleRouter {
 public:
  explicit SampleRouter(std::string recording_id) : recording_id_(std::move(recording_id)) {}
  /// Route of a message; null: none. Valid until the next call.
  const SampleRoute* route(const Message& message);
  [[nodiscard]] const std::string& recording_id() const { return recording_id_; }

 private:
  struct Known {
    bool is_known = false;
    std::optional<SampleRoute> route;
  };
  std::string recording_id_;
  std::uint64_t definitions_ = 0;
  std::vector<Known> by_channel_;
};

}  // namespace nav::io::mcap
