// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "nav/pose.hpp"
#include "nav/result.hpp"
#include "nav/sample.hpp"

namespace nav::devices {

enum class NdiPresence {
  kMeasured,
  kMissing,     ///< Not seen.
  kDisabled,    ///< Not enabled.
  kUnoccupied,  ///< No tool is plugged in.
};

/// Reading of one tool in one reply. Its flags hold for all three forms of replies.
struct NdiToolReading {
  std::uint16_t handle = 0;
  NdiPresence presence = NdiPresence::kMissing;
  std::array<double, 4> rotation_wxyz{};   ///< kMeasured only.
  std::array<double, 3> translation_mm{};  ///< kMeasured only.
  double error_mm = 0;                     ///< kMeasured only: the tracker's own figure.
  bool out_of_volume = false;
  bool partly_out_of_volume = false;
  bool unusable = false;  ///< BX2 only: its code says that the pose is not valid.
  /// Port status of TX and BX; status of a tool in BX2. 0 where none is given.
  std::uint32_t status = 0;
  std::optional<std::uint32_t> number{};  ///< Counter of the measurement.
  std::optional<DeviceTime> time{};       ///< BX2 only.
};

/// One reply with poses.
struct NdiReadings {
  std::vector<NdiToolReading> tools;
  std::uint16_t system_status = 0;  ///< TX and BX; BX2 has none.
};

/// Bits of the system status.
inline constexpr std::uint16_t kNdiPortOccupied = 1U << 6;
inline constexpr std::uint16_t kNdiPortUnoccupied = 1U << 7;

/// Read the reply to TX:0801, BX:0801 and BX2:--6d=tools into `out`, whose memory is used again.
/// kMalformedData where the content does not have that form; `out` is then of no use.
Result<void> read_ndi_tx(std::string_view text, NdiReadings& out);
Result<void> read_ndi_bx(std::span<const std::byte> body, NdiReadings& out);
Result<void> read_ndi_bx2(std::span<const std::byte> body, NdiReadings& out);

/// Pose and status of a reading. A tool that is not measured has NaN, never the identity. One
/// partly out of the volume counts as out of it: its accuracy is not known there. `acquired` and
/// `received` are both \p received.
RawPose ndi_pose(const NdiToolReading& reading, Timestamp received);

}  // namespace nav::devices
