// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "session/live_devices.hpp"
#include "session/session.hpp"

namespace nav::session {

/// One device of a live session, as it is at a moment.
struct DeviceStatus {
  std::string id;
  std::string kind;
  std::string address;
  SourceHealth health;
  struct Stream {
    StreamAccount account;
    const tracking::ClockModel* clock = nullptr;  ///< Null: the device gives no time.
  };
  std::vector<Stream> streams;
};

/// ImageToProbe of the configuration of PLUS that the options name, pixels to mm. Errors name the
/// file.
Result<Eigen::Matrix4d> probe_from_pixels(const SourceOptions& options);

/// The devices of a session file as a session on a real clock. Not thread-safe.
class LiveSession {
 public:
  /// Opens every device and finds the calibration: that of the configuration of PLUS for devices
  /// that do not know their own. Without a tracked reference the tracker is taken as the patient's
  /// frame, with a warning. Errors: kUsage when no calibration places the images on the probe, or
  /// nothing gives images or the poses of the probe; those of open_device(). Clock and diagnostics
  /// must outlive it. \p tap: SessionSetup's.
  /// \p any_devices: devices that give no images, or do not track the probe, are enough, as for a
  /// check of a tracker or its recording; what lacks is a warning.
  static Result<LiveSession> open(
      const SourceOptions& options, const Clock& clock, Diagnostics& diagnostics,
      std::function<void(std::size_t source, const Sample& sample)> tap = {},
      bool any_devices = false);

  /// Starts the devices' threads.
  void start() { session_->start(*clock_); }
  [[nodiscard]] Session& session() { return *session_; }
  [[nodiscard]] const Session& session() const { return *session_; }
  [[nodiscard]] const std::vector<LiveDevice>& devices() const { return devices_; }
  [[nodiscard]] std::vector<DeviceStatus> status() const;
  /// Name of the frame that is taken as the patient's.
  [[nodiscard]] const std::string& reference_frame() const { return reference_frame_; }
  /// Which frame is taken as the patient's, and why.
  [[nodiscard]] const std::string& reference_statement() const { return reference_statement_; }
  /// Setup of the session, for a recording.
  [[nodiscard]] const SessionSetup& setup() const { return setup_; }
  /// Calibration in use, for reports.
  [[nodiscard]] const std::string& calibration_statement() const { return calibration_statement_; }

 private:
  LiveSession() = default;

  const Clock* clock_ = nullptr;
  std::vector<LiveDevice> devices_;
  SessionSetup setup_;
  std::string reference_frame_, reference_statement_, calibration_statement_;
  std::unique_ptr<Session> session_;
};

}  // namespace nav::session
