// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_poses.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <string>

namespace nav::devices {
namespace {

constexpr std::size_t kToolNameBytes = 20;

struct StatusName {
  std::string_view text;
  TrackingStatus status;
};
/// The first name of a status is the one that is written.
constexpr std::array kStatusNames = {StatusName{"OK", TrackingStatus::kOk},
                                     StatusName{"UNKNOWN", TrackingStatus::kUnknown},
                                     StatusName{"", TrackingStatus::kUnknown},
                                     StatusName{"MISSING", TrackingStatus::kOccluded},
                                     StatusName{"OUT_OF_VIEW", TrackingStatus::kOccluded},
                                     StatusName{"OUT_OF_VOLUME", TrackingStatus::kOutOfVolume},
                                     StatusName{"REQ_TIMEOUT", TrackingStatus::kTimeout},
                                     StatusName{"INVALID", TrackingStatus::kInvalid}};

/// w of a unit quaternion, >= 0; NaN if the rest is longer than 1 by more than rounding.
float missing_w(const std::array<float, 4>& q) {
  constexpr double kRounding = 1e-6;
  const double x = q[0];
  const double y = q[1];
  const double z = q[2];
  const double rest = 1 - x * x - y * y - z * z;
  if (rest < 0 && rest > -kRounding) return 0;
  return static_cast<float>(std::sqrt(rest));
}

template <class Element>
Result<IgtlRecords<Element>> decode_tools(const char* type, std::span<const std::byte> content) {
  if (content.size() % Element::kWidth == 0) return IgtlRecords<Element>(content);
  return Error{ErrorCode::kMalformedData,
               std::string(type) + ": expected " + std::to_string(Element::kWidth) +
                   " bytes for each tool, found " + std::to_string(content.size()) + " bytes"};
}

}  // namespace

IgtlTransform IgtlTransform::read(IgtlReader& reader) {
  IgtlTransform transform;
  reader.floats(transform.columns);
  return transform;
}

IgtlTransform IgtlTransform::from(const Eigen::Matrix4d& matrix) {
  IgtlTransform transform;
  for (std::size_t i = 0; i < 12; ++i) {
    transform.columns[i] =
        static_cast<float>(matrix(static_cast<int>(i % 3), static_cast<int>(i / 3)));
  }
  return transform;
}

Eigen::Matrix4d IgtlTransform::matrix() const {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (std::size_t i = 0; i < 12; ++i) {
    matrix(static_cast<int>(i % 3), static_cast<int>(i / 3)) = columns[i];
  }
  return matrix;
}

IgtlPosition IgtlPosition::read(IgtlReader& reader) {
  IgtlPosition position;
  position.without_w = reader.left() == kShortWidth;
  reader.floats(position.position_mm);
  for (std::size_t i = 0; i < 3; ++i) position.quaternion[i] = reader.float32();
  position.quaternion[3] = position.without_w ? missing_w(position.quaternion) : reader.float32();
  return position;
}

void IgtlPosition::write(IgtlWriter& writer) const {
  writer.floats(position_mm);
  for (std::size_t i = 0; i < (without_w ? 3u : 4u); ++i) writer.float32(quaternion[i]);
}

Eigen::Matrix4d IgtlPosition::matrix() const {
  const Eigen::Quaterniond q(quaternion[3], quaternion[0], quaternion[1], quaternion[2]);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = q.toRotationMatrix();
  for (int i = 0; i < 3; ++i) matrix(i, 3) = position_mm[static_cast<std::size_t>(i)];
  return matrix;
}

IgtlTrackingElement IgtlTrackingElement::read(IgtlReader& reader) {
  IgtlTrackingElement element;
  element.name = reader.text(kToolNameBytes);
  element.type = reader.number<std::uint8_t>();
  element.reserved = reader.number<std::uint8_t>();
  element.pose = IgtlTransform::read(reader);
  return element;
}

void IgtlTrackingElement::write(IgtlWriter& writer) const {
  writer.text(name, kToolNameBytes);
  writer.number(type);
  writer.number(reserved);
  pose.write(writer);
}

IgtlQuaternionElement IgtlQuaternionElement::read(IgtlReader& reader) {
  IgtlQuaternionElement element;
  element.name = reader.text(kToolNameBytes);
  element.type = reader.number<std::uint8_t>();
  element.reserved = reader.number<std::uint8_t>();
  element.pose = IgtlPosition::read(reader);
  return element;
}

void IgtlQuaternionElement::write(IgtlWriter& writer) const {
  NAV_CHECK(!pose.without_w);
  writer.text(name, kToolNameBytes);
  writer.number(type);
  writer.number(reserved);
  pose.write(writer);
}

Result<IgtlTransform> decode_igtl_transform(std::span<const std::byte> content) {
  if (content.size() != IgtlTransform::kWidth) {
    return Error{ErrorCode::kMalformedData,
                 "TRANSFORM: expected 48 bytes, found " + std::to_string(content.size())};
  }
  IgtlReader reader(content);
  return IgtlTransform::read(reader);
}

Result<IgtlPosition> decode_igtl_position(std::span<const std::byte> content) {
  if (content.size() != IgtlPosition::kWidth && content.size() != IgtlPosition::kShortWidth) {
    return Error{ErrorCode::kMalformedData,
                 "POSITION: expected 28 bytes, or 24 without w of the quaternion, found " +
                     std::to_string(content.size())};
  }
  IgtlReader reader(content);
  return IgtlPosition::read(reader);
}

Result<IgtlRecords<IgtlTrackingElement>> decode_igtl_tdata(std::span<const std::byte> content) {
  return decode_tools<IgtlTrackingElement>("TDATA", content);
}

Result<IgtlRecords<IgtlQuaternionElement>> decode_igtl_qtdata(std::span<const std::byte> content) {
  return decode_tools<IgtlQuaternionElement>("QTDATA", content);
}

TrackingStatus igtl_tracking_status(std::string_view text) {
  if (text.starts_with("TOOL_")) text.remove_prefix(5);
  for (const StatusName& name : kStatusNames) {
    if (name.text == text) return name.status;
  }
  return TrackingStatus::kInvalid;
}

std::string_view igtl_status_text(TrackingStatus status) {
  for (const StatusName& name : kStatusNames) {
    if (name.status == status) return name.text;
  }
  return "INVALID";
}

}  // namespace nav::devices
