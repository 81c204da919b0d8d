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
  int station = 0;     ///< polhemus: socket of its sensor, [1, 16].
};

/// A button of a device.
struct DeviceButton {
  std::string name{};                  ///< Name of its stream.
  std::string action = "none";         ///< to_string(ButtonAction).
  std::string key{};                   ///< footswitch: "BTN_0", "KEY_A" or a number.
  std::uint32_t frame = 0;             ///< can-buttons: identifier of the frame.
  bool extended = false;               ///< can-buttons: the identifier has 29 bits.
  int byte = 0;                        ///< can-buttons: byte of the frame's data, [0, 7].
  int bit = 0;                         ///< can-buttons: bit of the byte, 0 the lowest, [0, 7].
  std::vector<double> pressed_at_s{};  ///< simulated: times of the session, rising.
  bool pressed_when_zero = false;      ///< can-buttons: the bit is 0 while the button is down.
};

/// One device of a live session.
struct DeviceOptions {
  std::string id{};    ///< Unique name in messages, reports and recordings.
  std::string kind{};  ///< One of device_kinds().
  /// "tcp:host:port", for ndi also "serial:/dev/ttyUSB0"; for can-arm and can-buttons "can:can0";
  /// for footswitch "hid:05f3:00ff" or "input:/dev/input/event3"; for cameras "v4l2:/dev/video0" or
  /// "film:FILE"; for polhemus and interson "usb:0f44:ff20", "usb:0f44:ff20:SERIAL" or
  /// "usbip:host:port"; the file for a recording.
  std::string address{};
  std::vector<DeviceBody> bodies{};
  /// Name of the images on the device; empty: it gives none.
  std::string image{};
  bool announce_version_2 = true;       ///< openigtlink: OpenIgtLinkOptions'.
  int baud = 115200;                    ///< ndi on a serial port: rate that the line is raised to.
  std::filesystem::path arm{};          ///< can-arm: file of its kinematics.
  double rate_hz = 200;                 ///< can-arm: poses a second, [1, 1000].
  std::vector<DeviceButton> buttons{};  ///< footswitch, can-buttons.
  double silence_ms = 0;  ///< can-buttons: longest time between two frames; 0: sent on change only.
  /// polhemus: direction from the source to the half of space that the sensors are in.
  std::vector<double> hemisphere = {1, 0, 0};
  int distortion_limit = 0;  ///< polhemus: largest distortion of a valid pose, device's scale.
  // interson: devices::IntersonSettings and devices::SectorShape.
  int frequency = 0;
  int band_pass = 0;
  int high_voltage = 0;
  double radius_mm = 0;
  double depth_mm = 0;
  double angle_deg = 0;
  double spacing_mm = 0.2;
  // camera-markers, frame-grabber.
  std::filesystem::path camera{};     ///< camera-markers: calibration of the camera.
  std::string dictionary = "4x4_50";  ///< camera-markers: devices::marker_dictionaries().
  int width = 0;                      ///< Asked of the camera; 0: as it is. Likewise:
  int height = 0;
  double images_hz = 0;        ///< interson: of its motor; 0: 15.
  std::vector<double> crop{};  ///< frame-grabber: left, top, width, height; empty: all.
  /// frame-grabber: part of the image that shows its depth: left, top, width, height; empty: none.
  std::vector<double> depth_display{};
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
  /// ITK transform file that declares it (io::read_ct_from_reference); empty: none.
  std::filesystem::path transform{};
  /// JSON that 'sonde register' wrote; replaces the declaration.
  std::filesystem::path registration{};
  bool follow = false;  ///< After the registration, the CT follows moving tissue.
};

}  // namespace nav::session
