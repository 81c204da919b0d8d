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
#include "nav/ultrasound_image.hpp"

namespace nav::io {

/// Names of the coordinate frames in a recording.
struct RecordingOptions {
  std::string image_frame = "Image";
  std::string probe_frame = "Probe";
  std::string tracker_frame = "Tracker";
  /// Patient-fixed frame. The name of the tracker frame declares that there is none. Empty:
  /// "Reference" if the recording has it, otherwise the tracker frame.
  std::string reference_frame = "Reference";
  /// Needle tip, with +z from the hub towards it ("NeedleTip"); empty: no needle. kUsage when no
  /// chain of transforms of the recording gives its pose.
  std::string needle_frame;
};

/// Form in which a recording stores its poses.
enum class RecordingForm {
  kTracked,           ///< Poses of the probe (and the reference) relative to the tracker.
  kProbeInReference,  ///< Poses of the probe relative to the reference, which is used as the
                      ///< tracker.
  kImageInReference,  ///< Poses of the images themselves: the calibration is part of every pose.
                      ///< The image is used as the probe and the reference as the tracker.
};

/// One frame of a recording, not yet checked.
struct RecordingImage {
  std::int64_t index = 0;
  std::optional<Timestamp> acquired{};  ///< Recorded time; absent when the frame has no timestamp.
  /// Ultrasound image, or the reason why there is none; kMalformedData also for a calibration of
  /// the frame itself that is impossible, or another than the recording's.
  Result<UltrasoundImage> image;
  /// tracker_from_probe, status and numbers as recorded. An unreadable pose is kInvalid with NaN
  /// and is reported in the diagnostics.
  RawPose probe{};
  /// tracker_from_reference; absent without a reference, or when the reference is used as the
  /// tracker.
  std::optional<RawPose> reference{};
  /// tracker_from_needle; absent when no needle was named.
  std::optional<RawPose> needle{};
};

/// Streams a PLUS recording through the live pipeline on the virtual clock: one frame at a time, no
/// threads, no waiting. received equals acquired. Not thread-safe.
class RecordingReader {
 public:
  /// \p config: device set with the calibration, or nullptr when the recording contains it; needed
  /// only during the call. \p diagnostics must outlive the session. Errors: those of the reader;
  /// kNotFound when no chain of transforms gives the pose of the probe, the reference or the image
  /// (the message lists the existing ones); kMalformedData for an impossible calibration. The first
  /// calibration in the frames is the recording's; no later one is read.
  static Result<RecordingReader> open(const std::filesystem::path& sequence,
                                      const PlusConfig* config, const RecordingOptions& options,
                                      Diagnostics& diagnostics);
  RecordingReader(RecordingReader&&) noexcept;
  RecordingReader& operator=(RecordingReader&&) noexcept;
  ~RecordingReader();

  /// Returns the next frame in the order of the file; kEndOfStream after the last. An unreadable
  /// frame is an event with an Error as image; only failures of the file itself are errors.
  Result<RecordingImage> next();
  /// Returns to the first frame.
  void rewind();

  /// Absent in recordings without images.
  [[nodiscard]] const std::optional<ImageCalibration>& calibration() const;
  /// Why the calibration is not to be relied on, one sentence; empty when it is.
  [[nodiscard]] const std::string& calibration_doubt() const;
  [[nodiscard]] RecordingForm form() const;
  /// Name of the patient-fixed frame, as given or chosen.
  [[nodiscard]] const std::string& reference_frame() const;
  [[nodiscard]] std::int64_t total_images() const;
  /// Chains in use, for reports: "Probe→Tracker: ProbeToTracker (frames)".
  [[nodiscard]] const std::string& description() const;

 private:
  struct State;
  explicit RecordingReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace nav::io
