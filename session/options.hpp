// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "session/needle_size.hpp"

namespace nav::session {

/// The CT of a procedure.
struct CtOptions {
  std::filesystem::path path;
  std::string series_uid{};  ///< Series of a DICOM folder with several; empty: the largest.
  bool accept_unknown_orientation = false;
};

enum class SourceKind { kSimulated, kRecording };

/// Source of the tracked ultrasound, and the names of its coordinate frames.
struct SourceOptions {
  SourceKind kind = SourceKind::kRecording;
  std::filesystem::path recording;    ///< PLUS sequence metafile.
  std::filesystem::path plus_config;  ///< Calibration (CoordinateDefinitions); may be empty.
  std::string image_frame = "Image";
  std::string probe_frame = "Probe";
  std::string tracker_frame = "Tracker";
  /// Patient-fixed frame; the name of the tracker frame declares the tracker itself to be it.
  /// Empty: "Reference" where the recording has it, otherwise the tracker frame, with a warning.
  std::string reference_frame;
  std::string needle_frame;  ///< Origin at the tip, +z from the hub to it; empty: no needle.
  NeedleSize needle_size;
  double temporal_offset_ms = 0;  ///< Image stamps minus pose stamps.
  /// Draws the whole image, also outside the sector that the probe insonifies.
  bool whole_image = false;
  /// Plays on past frames whose data cannot be true; they are counted by cause.
  bool skip_bad_frames = false;
  /// A recording from a file: plays it once before the replay, to choose camera and grey window for
  /// the whole sweep. Otherwise they are chosen for the first image, as in a live session.
  bool survey = true;
  std::uint64_t seed = 1;  ///< Seed of a simulation.
};

/// Position of the CT relative to the patient reference.
struct PlacementOptions {
  /// Declared ct_from_reference, 4 x 4, mm; absent: the sweep's centre lies at the CT's centre.
  std::optional<Eigen::Matrix4d> ct_from_reference;
  /// JSON that 'sonde register' wrote; replaces the declaration.
  std::filesystem::path registration;
  bool follow = false;  ///< After the registration, the CT follows moving tissue.
};

}  // namespace nav::session
