// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/ndi/ndi_poses.hpp"
#include "devices/ndi/ndi_setup.hpp"
#include "nav/sample.hpp"

namespace nav::devices {

/// Makes samples of readings: one stream for each tool. Not thread-safe.
class NdiTracks {
 public:
  explicit NdiTracks(std::size_t streams) : tracks_(streams) {}

  /// A connection begins: frame numbers may be lower than before.
  void begin();
  /// The tracker is set up: each tool's handle. \p firmware tells how frame numbers count.
  void assign(const std::vector<NdiSetup::Tool>& tools, const std::string& firmware);

  /// Account of one reply.
  struct Taken {
    std::uint64_t repeats = 0;             ///< Readings whose number did not advance.
    std::uint64_t undeclared = 0;          ///< Readings of other tools.
    std::vector<std::size_t> unplugged{};  ///< Streams whose tool was unplugged just now.
  };
  /// Appends the new samples to \p out.
  Taken take(const NdiReadings& readings, Timestamp received, std::vector<Sample>& out);

  /// False for a tool without a handle, and for one that was unplugged.
  [[nodiscard]] bool is_usable(std::size_t stream) const;

 private:
  struct Track {
    std::optional<std::uint16_t> handle{};
    std::optional<std::uint32_t> number{};  ///< Newest.
    std::uint64_t count = 0;                ///< Samples since the beginning.
    bool unplugged = false;
  };
  [[nodiscard]] std::optional<DeviceTime> time_of(const NdiToolReading& reading) const;
  Sample sample_of(std::size_t stream, const NdiToolReading& reading, Timestamp received) const;

  std::vector<Track> tracks_;
  bool counts_at_60_hz_ = false;
};

}  // namespace nav::devices
