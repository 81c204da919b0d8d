// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "io/plus_config.hpp"
#include "io/transform_tree.hpp"
#include "nav/diagnostics.hpp"
#include "nav/pose.hpp"
#include "nav/ultrasound_frame.hpp"

namespace nav::io {

/// What the coordinate frames are called in a recording.
struct RecordingOptions {
  std::string image_frame = "Image";
  std::string probe_frame = "Probe";
  std::string tracker_frame = "Tracker";
  /// Patient-fixed frame. The name of the tracker frame says explicitly that there is none.
  std::string reference_frame = "Reference";
  /// The needle's tip, +z from the hub towards it ("NeedleTip"); empty: no needle is looked for.
  /// kUsage where no chain of transforms with the frames places it.
  std::string needle_frame;
};

/// How the poses of a recording are written.
enum class RecordingForm {
  kTracked,           ///< Probe (and reference) in the tracker.
  kProbeInReference,  ///< Probe in the reference already: the reference plays the tracker.
  kImageInReference,  ///< Pictures placed directly: calibration is part of every pose, so the
                      ///< image plays the probe and the reference the tracker.
};

/// One frame of a recording, unjudged.
struct RecordingFrame {
  std::int64_t index = 0;
  std::optional<Timestamp> acquired;  ///< As recorded; absent when the frame has no timestamp.
  /// Or why there is none: kMalformedData also where the frame's own calibration cannot be.
  Result<UltrasoundFrame> picture;
  RawPose probe;  ///< tracker_from_probe. Status and numbers as recorded; what cannot be read at
                  ///< all is kInvalid with NaN and is named in the diagnostics.
  std::optional<RawPose> reference;  ///< tracker_from_reference; absent when the reference is, or
                                     ///< plays, the tracker.
  std::optional<RawPose> needle;     ///< tracker_from_needle; absent when no needle was named.
};

/// A PLUS recording streamed through the live pipeline on the virtual clock: one frame at a time,
/// no threads, no sleeping. received equals acquired. Not thread-safe.
class RecordingReader {
 public:
  /// config: the device set with the calibration, or nullptr when the recording carries it;
  /// needed during the call only. diagnostics must outlive the session. Errors: those of the
  /// reader; kNotFound when no chain of transforms places the probe, the reference, the picture
  /// (the message lists what exists); kMalformedData for a calibration that cannot be, and where
  /// the frames have two: a probe has one. Reads all frames' fields where they carry it.
  static Result<RecordingReader> open(const std::filesystem::path& sequence,
                                    const PlusConfig* config, const RecordingOptions& options,
                                    Diagnostics& diagnostics);
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;
  ~RecordingReader();

  /// The next frame in order of the file; kEndOfStream after the last. A frame that cannot be read
  /// is an event with a refusal; only failures of the file itself are errors.
  Result<RecordingFrame> next();
  /// Back to the first frame.
  void rewind();

  /// Absent in recordings without pictures.
  [[nodiscard]] const std::optional<ImageCalibration>& calibration() const;
  [[nodiscard]] RecordingForm form() const;
  [[nodiscard]] std::int64_t total_frames() const;
  /// The chains in use, for reports: "Probe→Tracker: ProbeToTracker (frames)".
  [[nodiscard]] const std::string& description() const;

 private:
  struct State;
  explicit RecordingReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace nav::io
