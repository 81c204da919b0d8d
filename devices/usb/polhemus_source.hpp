// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/usb/polhemus_codec.hpp"
#include "devices/usb/usb_source.hpp"

namespace nav::devices {

/// A sensor of the tracker.
struct PolhemusBody {
  std::string name = "Probe";  ///< Name of its stream; unique.
  int station = 1;             ///< Socket that it is plugged in at, 1 to 16; unique.
  ToolRole role = ToolRole::kOther;
};

struct PolhemusOptions {
  std::vector<PolhemusBody> bodies{};  ///< At least one.
  /// Half of space that the sensors stay in: a direction from the source, of any length but 0.
  std::array<double, 3> hemisphere = {1, 0, 0};
  /// Largest distortion of the field, on the device's own scale, with which a pose is *OK*; >= 0.
  int distortion_limit = 0;
  UsbTimes times{};
};
/// Rejects no bodies, equal names and stations, and values out of range.
Result<void> validate(const PolhemusOptions& options);

/// A magnetic tracker, Polhemus Liberty, on USB. Each body is a stream of poses in the frame of the
/// tracker's source:
///   - `device_time` is the device's clock, `sequence` follows its count of frames. Frames that did
///     not come are counted as "lost_frames", frames that came twice as repeats.
///   - kOk; kUnknown with the pose if the device finds the field distorted ("distortion"); kInvalid
///     without a matrix if it reports an error ("device_error"), or its numbers are no pose
///     ("not_finite", "no_rotation", "out_of_range").
/// The device is asked for centimetres with every connection, and poses are taken after that only.
/// A device that was switched off and on, whose clock and frames begin anew, is set up again.
/// Bytes that are no message are counted as in PolhemusParser. It has no thread of its own: call
/// next() from a thread that does nothing else.
class PolhemusSource final : public UsbSource {
 public:
  /// \p name: of the device in messages, such as "usb:0f44:ff20". Errors: those of validate().
  static Result<std::unique_ptr<PolhemusSource>> create(PolhemusOptions options, std::string name,
                                                        UsbOpener open, const Clock& clock,
                                                        Diagnostics& diagnostics);
  ~PolhemusSource() override { close(); }

 private:
  enum class Phase { kStopping, kSetup, kTracking };
  /// Newest frame that was taken.
  struct Newest {
    std::uint32_t frame = 0, time_ms = 0;
  };
  PolhemusSource(PolhemusOptions options, std::string name, UsbOpener open, const Clock& clock,
                 Diagnostics& diagnostics);
  void begin(Timestamp now) override;
  Timestamp step(Timestamp now) override;
  void take(const UsbTransfer& transfer, Timestamp received) override;
  void end() override;

  void send(const std::string& command);
  void begin_stopping(Timestamp now);
  void take_news(const PolhemusNews& news, Timestamp received);
  void take_record(const PolhemusRecord& record, Timestamp received);
  bool follows(const PolhemusRecord& record, Timestamp received);
  void restart_frames(const PolhemusRecord& record);
  PoseSample pose_of(const PolhemusRecord& record, Timestamp received);

  PolhemusOptions options_;

  // Used by next() only.
  Phase phase_ = Phase::kStopping;
  Timestamp stopping_since_{}, quiet_since_{};
  PolhemusParser parser_;
  std::optional<Newest> newest_;     ///< In this connection.
  std::optional<Newest> candidate_;  ///< A frame that does not follow; the next one confirms it.
  std::int64_t device_ms_ = 0;       ///< The device's clock, which wraps at 32 bits, without end.
  std::uint64_t sequence_ = 0;       ///< Number of the newest frame.
  std::vector<std::optional<std::uint64_t>> given_;  ///< Newest sequence of each stream.
};

}  // namespace nav::devices
