// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "session/needle_size.hpp"

namespace nav::session {

/// The CT of a procedure.
struct CtOptions {
  std::filesystem::path path;
  std::string series_uid{};  ///< Series of a DICOM folder with several; empty: the largest.
  bool accept_unknown_orientation = false;
};

enum class SourceKind { kSimulated, kRecording, kLive };

/// A tracked body of a device.
struct DeviceBody {
  std::string name{};  ///< Coordinate frame: "Probe", "Reference", "Needle", …
  std::string tool{};  ///< The device's name or file for it; empty: usual for the kind.
};

/// One device of a live session.
struct DeviceOptions {
  std::string id{};    ///< Unique name in messages, reports and recordings.
  std::string kind{};  ///< One of device_kinds().
  /// "tcp:host:port", for ndi also "serial:/dev/ttyUSB0"; for can-arm "can:can0"; the file for a
  /// recording.
  std::string address{};
  std::vector<DeviceBody> bodies{};
  /// Name of the images on the device; empty: it gives none.
  std::string image{};
  bool announce_version_2 = true;  ///< openigtlink: OpenIgtLinkOptions'.
  int baud = 115200;               ///< ndi on a serial port: rate that the line is raised to.
  std::filesystem::path arm{};     ///< can-arm: file of its kinematics.
  double rate_hz = 200;            ///< can-arm: poses a second, [1, 1000].
  // Simulated devices.
  std::string family = "abdomen";   ///< Patient: sim::patient_families().
  std::string tracker = "optical";  ///< sim::TrackerKind.
  std::string path = "sweep";       ///< sim::HandPathKind.
  bool needle = false;              ///< A tracked needle is inserted.
  std::uint64_t seed = 1;
  double duration_s = 30;  ///< (0, 3600]
};

/// Source of the tracked ultrasound, and the names of its coordinate frames.
struct SourceOptions {
  SourceKind kind = SourceKind::kRecording;
  std::filesystem::path recording{};    ///< PLUS sequence metafile.
  std::filesystem::path plus_config{};  ///< Calibration (CoordinateDefinitions); may be empty.
  std::string image_frame = "Image";
  std::string probe_frame = "Probe";
  std::string tracker_frame = "Tracker";
  /// Patient-fixed frame; the name of the tracker frame declares the tracker itself to be it.
  /// Empty: "Reference" where the recording has it, otherwise the tracker frame, with a warning.
  std::string reference_frame{};
  std::string needle_frame{};  ///< Origin at the tip, +z from the hub to it; empty: no needle.
  NeedleSize needle_size{};
  double temporal_offset_ms = 0;  ///< Image stamps minus pose stamps.
  /// Draws the whole image, also outside the sector that the probe insonifies.
  bool whole_image = false;
  /// Plays on past frames whose data cannot be true; they are counted by cause.
  bool skip_bad_frames = false;
  /// A recording from a file: plays it once before the replay, to choose camera and grey window for
  /// the whole sweep. Otherwise they are chosen for the first image, as in a live session.
  bool survey = true;
  std::uint64_t seed = 1;                ///< Seed of a simulation.
  std::vector<DeviceOptions> devices{};  ///< Live only.

  /// A needle is tracked.
  [[nodiscard]] bool has_needle() const {
    return !needle_frame.empty() || std::any_of(devices.begin(), devices.end(),
                                                [](const auto& device) { return device.needle; });
  }
};

/// Position of the CT relative to the patient reference.
struct PlacementOptions {
  /// Declared ct_from_reference, 4 x 4, mm; absent: the sweep's centre lies at the CT's centre.
  std::optional<Eigen::Matrix4d> ct_from_reference{};
  /// JSON that 'sonde register' wrote; replaces the declaration.
  std::filesystem::path registration{};
  bool follow = false;  ///< After the registration, the CT follows moving tissue.
};

}  // namespace nav::session
