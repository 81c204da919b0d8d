// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_poses.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "devices/ndi/ndi_bytes.hpp"
#include "devices/ndi/ndi_hex.hpp"

namespace nav::devices {
namespace {

constexpr std::uint32_t kOutOfVolume = 1U << 6;
constexpr std::uint32_t kPartlyOutOfVolume = 1U << 7;

Error bad_layout(const char* reply, const char* expected) {
  return {ErrorCode::kMalformedData, std::string("NDI: reply to ") + reply + ": expected " +
                                         expected + ", found something else"};
}

void set_port_flags(NdiToolReading& tool, std::uint32_t status) {
  tool.status = status;
  tool.out_of_volume = (status & kOutOfVolume) != 0;
  tool.partly_out_of_volume = (status & kPartlyOutOfVolume) != 0;
}

/// Reads a text from left to right.
class TextReader {
 public:
  explicit TextReader(std::string_view text) : rest_(text) {}
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  bool skip(std::string_view word) {
    if (!rest_.starts_with(word)) return false;
    rest_.remove_prefix(word.size());
    return true;
  }
  bool skip_line() {
    const auto end = rest_.find('\n');
    if (end == std::string_view::npos) return false;
    rest_.remove_prefix(end + 1);
    return true;
  }
  template <class T>
  bool hex(std::size_t digits, T& value) {
    if (rest_.size() < digits) return false;
    const auto found = ndi_from_hex<T>(rest_.substr(0, digits));
    rest_.remove_prefix(digits);
    if (found) value = *found;
    return found.has_value();
  }
  /// Sign and digits without a point; \p unit: value of the last digit.
  bool number(std::size_t digits, double unit, double& value) {
    if (rest_.size() < digits + 1) return false;
    const char sign = rest_[0];
    if (sign != '+' && sign != '-') return false;
    std::int64_t whole = 0;
    for (const char c : rest_.substr(1, digits)) {
      if (c < '0' || c > '9') return false;
      whole = 10 * whole + (c - '0');
    }
    rest_.remove_prefix(digits + 1);
    value = static_cast<double>(sign == '-' ? -whole : whole) * unit;
    return true;
  }

 private:
  std::string_view rest_;
};

bool read_tx_status(TextReader& reader, NdiToolReading& tool) {
  std::uint32_t status = 0;
  std::uint32_t number = 0;
  if (!reader.hex(8, status) || !reader.hex(8, number)) return false;
  set_port_flags(tool, status);
  tool.number = number;
  return true;
}

bool read_tx_numbers(TextReader& reader, NdiToolReading& tool) {
  tool.presence = NdiPresence::kMeasured;
  for (double& value : tool.rotation_wxyz) {
    if (!reader.number(5, 1e-4, value)) return false;
  }
  for (double& value : tool.translation_mm) {
    if (!reader.number(6, 1e-2, value)) return false;
  }
  return reader.number(5, 1e-4, tool.error_mm);
}

bool read_tx_tool(TextReader& reader, NdiToolReading& tool) {
  std::uint8_t handle = 0;
  if (!reader.hex(2, handle)) return false;
  tool.handle = handle;
  // The fields after these two words differ between trackers.
  if (reader.skip("UNOCCUPIED")) {
    tool.presence = NdiPresence::kUnoccupied;
    return reader.skip_line();
  }
  if (reader.skip("DISABLED")) {
    tool.presence = NdiPresence::kDisabled;
    return reader.skip_line();
  }
  const bool begun = reader.skip("MISSING") || read_tx_numbers(reader, tool);
  return begun && read_tx_status(reader, tool) && reader.skip("\n");
}

bool read_pose(NdiByteReader& reader, NdiToolReading& tool) {
  tool.presence = NdiPresence::kMeasured;
  for (double& value : tool.rotation_wxyz) value = reader.float32();
  for (double& value : tool.translation_mm) value = reader.float32();
  tool.error_mm = reader.float32();
  return reader.good();
}

bool read_bx_tool(NdiByteReader& reader, NdiToolReading& tool) {
  constexpr unsigned kValid = 1;
  constexpr unsigned kMissing = 2;
  constexpr unsigned kDisabled = 4;
  tool.handle = reader.number<std::uint8_t>();
  const auto presence = reader.number<std::uint8_t>();
  if (presence == kDisabled) {
    tool.presence = NdiPresence::kDisabled;
    return reader.good();
  }
  if (presence != kValid && presence != kMissing) return false;
  if (presence == kValid && !read_pose(reader, tool)) return false;
  set_port_flags(tool, reader.number<std::uint32_t>());
  tool.number = reader.number<std::uint32_t>();
  return reader.good();
}

/// Codes in the low byte of the status of a tool in BX2.
enum Bx2Code : unsigned {
  kEnabled = 0,
  kPartlyOut = 3,
  kOutside = 9,
  kUnplugged = 33,
  kNotEnabled = 32,
};

void set_bx2_status(NdiToolReading& tool, std::uint16_t status) {
  constexpr unsigned kMissingBit = 1U << 8;
  tool.status = status;
  const unsigned code = status & 0xFFU;
  tool.partly_out_of_volume = code == kPartlyOut;
  tool.out_of_volume = code == kOutside;
  tool.unusable = code != kEnabled && code != kPartlyOut && code != kOutside;
  tool.presence = (status & kMissingBit) == 0 ? NdiPresence::kMeasured : NdiPresence::kMissing;
  if (code == kNotEnabled) tool.presence = NdiPresence::kDisabled;
  if (code == kUnplugged) tool.presence = NdiPresence::kUnoccupied;
}

/// Number and time of the frame around a component.
struct Bx2Frame {
  std::optional<std::uint32_t> number{};
  std::optional<DeviceTime> time{};
};

bool read_bx2_tools(NdiByteReader& reader, std::uint32_t items, const Bx2Frame& frame,
                    NdiReadings& out) {
  constexpr unsigned kMissingBit = 1U << 8;
  constexpr std::size_t kLeastItem = 4;
  if (items > reader.left() / kLeastItem) return false;
  for (std::uint32_t i = 0; i < items; ++i) {
    NdiToolReading tool;
    tool.handle = reader.number<std::uint16_t>();
    const auto status = reader.number<std::uint16_t>();
    if ((status & kMissingBit) == 0 && !read_pose(reader, tool)) return false;
    if (!reader.good()) return false;
    set_bx2_status(tool, status);
    tool.number = frame.number;
    tool.time = frame.time;
    out.tools.push_back(tool);
  }
  return true;
}

bool read_bx2_components(NdiByteReader& reader, const Bx2Frame& frame, NdiReadings& out, int depth);

bool read_bx2_frames(NdiByteReader& reader, std::uint32_t items, NdiReadings& out, int depth) {
  constexpr std::size_t kLeastItem = 16;
  constexpr std::uint32_t kSecond = 1'000'000'000;
  if (items > reader.left() / kLeastItem) return false;
  for (std::uint32_t i = 0; i < items; ++i) {
    reader.skip(1 + 1 + 2);  // Type, index in its sequence, status.
    Bx2Frame frame;
    frame.number = reader.number<std::uint32_t>();
    const auto seconds = reader.number<std::uint32_t>();
    const auto nanoseconds = reader.number<std::uint32_t>();
    if (!reader.good() || nanoseconds >= kSecond) return false;
    if (seconds != 0 || nanoseconds != 0) {
      frame.time =
          DeviceTime(std::chrono::seconds(seconds) + std::chrono::nanoseconds(nanoseconds));
    }
    if (!read_bx2_components(reader, frame, out, depth + 1)) return false;
  }
  return true;
}

bool read_bx2_component(NdiByteReader& reader, const Bx2Frame& frame, NdiReadings& out, int depth) {
  constexpr std::uint32_t kHeader = 12;
  constexpr std::uint16_t kFrames = 1;
  constexpr std::uint16_t kTools = 2;
  const auto type = reader.number<std::uint16_t>();
  const auto size = reader.number<std::uint32_t>();
  reader.skip(2);  // Options.
  const auto items = reader.number<std::uint32_t>();
  if (!reader.good() || size < kHeader || size - kHeader > reader.left()) return false;
  NdiByteReader content(reader.take(size - kHeader));
  if (type == kFrames) return read_bx2_frames(content, items, out, depth);
  return type != kTools || read_bx2_tools(content, items, frame, out);
}

bool read_bx2_components(NdiByteReader& reader, const Bx2Frame& frame, NdiReadings& out,
                         int depth) {
  constexpr int kDeepest = 2;
  if (depth > kDeepest) return false;
  reader.skip(2);  // Version.
  const auto components = reader.number<std::uint16_t>();
  for (std::uint16_t i = 0; i < components; ++i) {
    if (!reader.good() || !read_bx2_component(reader, frame, out, depth)) return false;
  }
  return reader.good();
}

std::optional<Eigen::Matrix4d> matrix_of(const NdiToolReading& reading) {
  // Four digits of TX and single precision are both better than this.
  constexpr double kMostOffUnit = 0.01;
  const auto& r = reading.rotation_wxyz;
  const Eigen::Quaterniond rotation(r[0], r[1], r[2], r[3]);
  const Eigen::Map<const Eigen::Vector3d> translation(reading.translation_mm.data());
  if (!(std::abs(rotation.norm() - 1) <= kMostOffUnit) || !translation.allFinite()) {
    return std::nullopt;
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = rotation.normalized().toRotationMatrix();
  matrix.topRightCorner<3, 1>() = translation;
  return matrix;
}

}  // namespace

Result<void> read_ndi_tx(std::string_view text, NdiReadings& out) {
  out.tools.clear();
  TextReader reader(text);
  std::uint8_t count = 0;
  if (!reader.hex(2, count)) return bad_layout("TX", "the number of tools");
  for (unsigned i = 0; i < count; ++i) {
    NdiToolReading tool;
    if (!read_tx_tool(reader, tool)) return bad_layout("TX", "one line for each tool");
    out.tools.push_back(tool);
  }
  if (!reader.hex(4, out.system_status) || !reader.empty()) {
    return bad_layout("TX", "the system status at the end");
  }
  return {};
}

Result<void> read_ndi_bx(std::span<const std::byte> body, NdiReadings& out) {
  out.tools.clear();
  NdiByteReader reader(body);
  const auto count = reader.number<std::uint8_t>();
  for (unsigned i = 0; i < count; ++i) {
    NdiToolReading tool;
    if (!read_bx_tool(reader, tool)) return bad_layout("BX", "each tool with its status");
    out.tools.push_back(tool);
  }
  out.system_status = reader.number<std::uint16_t>();
  if (!reader.good() || reader.left() != 0) return bad_layout("BX", "the system status at the end");
  return {};
}

Result<void> read_ndi_bx2(std::span<const std::byte> body, NdiReadings& out) {
  out.tools.clear();
  out.system_status = 0;
  NdiByteReader reader(body);
  if (!read_bx2_components(reader, {}, out, 0)) {
    return bad_layout("BX2", "components within the reply's length");
  }
  return {};
}

RawPose ndi_pose(const NdiToolReading& reading, Timestamp received) {
  RawPose pose{.acquired = received, .received = received};
  pose.status = TrackingStatus::kOccluded;
  if (reading.presence != NdiPresence::kMeasured) {
    if (reading.out_of_volume) pose.status = TrackingStatus::kOutOfVolume;
    return pose;
  }
  const auto matrix = matrix_of(reading);
  if (!matrix || reading.unusable) {
    pose.status = TrackingStatus::kInvalid;
    return pose;
  }
  pose.tracker_from_body = *matrix;
  pose.status = reading.out_of_volume || reading.partly_out_of_volume ? TrackingStatus::kOutOfVolume
                                                                      : TrackingStatus::kOk;
  return pose;
}

}  // namespace nav::devices
