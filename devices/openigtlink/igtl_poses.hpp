// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "devices/openigtlink/igtl_bytes.hpp"
#include "nav/pose.hpp"
#include "nav/result.hpp"

/// Contents of TRANSFORM, POSITION, TDATA and QTDATA. Numbers are passed on as they came: NaN and
/// matrices that are not rigid are for the gate of poses to judge.
namespace nav::devices {

/// Content of TRANSFORM: the upper three rows of a matrix, column by column; translation in mm.
struct IgtlTransform {
  static constexpr std::size_t kWidth = 48;
  std::array<float, 12> columns{};

  static IgtlTransform read(IgtlReader& reader);
  static IgtlTransform from(const Eigen::Matrix4d& matrix);
  void write(IgtlWriter& writer) const { writer.floats(columns); }
  [[nodiscard]] Eigen::Matrix4d matrix() const;
};

/// Content of POSITION (also called QTRANS): position and orientation.
struct IgtlPosition {
  static constexpr std::size_t kWidth = 28;
  static constexpr std::size_t kShortWidth = 24;  ///< Without w of the quaternion.
  std::array<float, 3> position_mm{};
  std::array<float, 4> quaternion{};  ///< x, y, z, w; not normalised.
  /// 24 bytes: w was left out by the sender, and is the root of what the others leave; NaN if they
  /// are longer than 1.
  bool without_w = false;

  static IgtlPosition read(IgtlReader& reader);
  void write(IgtlWriter& writer) const;
  /// Not rigid where the quaternion has not the length 1.
  [[nodiscard]] Eigen::Matrix4d matrix() const;
};

/// One tool of TDATA.
struct IgtlTrackingElement {
  static constexpr std::size_t kWidth = 70;
  std::string_view name;  ///< At most 20 bytes.
  std::uint8_t type = 2;  ///< 1: tracker, 2: 6D instrument, 3: 3D, 4: 5D.
  std::uint8_t reserved = 0;
  IgtlTransform pose;

  static IgtlTrackingElement read(IgtlReader& reader);
  void write(IgtlWriter& writer) const;
};

/// One tool of QTDATA; members as IgtlTrackingElement.
struct IgtlQuaternionElement {
  static constexpr std::size_t kWidth = 50;
  std::string_view name;
  std::uint8_t type = 2;
  std::uint8_t reserved = 0;
  IgtlPosition pose;

  static IgtlQuaternionElement read(IgtlReader& reader);
  void write(IgtlWriter& writer) const;
};

/// Each rejects contents of another size than the format has.
Result<IgtlTransform> decode_igtl_transform(std::span<const std::byte> content);
Result<IgtlPosition> decode_igtl_position(std::span<const std::byte> content);
Result<IgtlRecords<IgtlTrackingElement>> decode_igtl_tdata(std::span<const std::byte> content);
Result<IgtlRecords<IgtlQuaternionElement>> decode_igtl_qtdata(std::span<const std::byte> content);

/// Status in the metadata of PLUS (TransformStatus); kInvalid for a text that PLUS does not write.
TrackingStatus igtl_tracking_status(std::string_view text);
/// Text that PLUS writes for a status.
std::string_view igtl_status_text(TrackingStatus status);

}  // namespace nav::devices
