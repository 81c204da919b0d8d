// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/recording_reader.hpp"
#include "nav/source.hpp"
#include "nav/warning_memory.hpp"

namespace nav::io {

/// A recording as a source: streams for the probe, the reference (if the recording tracks it), the
/// needle (if one was named) and the images. A frame of the file gives its poses first, then its
/// image. A recording does not say when its bytes arrived, so a sample arrives at the newest stamp
/// so far; the stamps of the samples themselves stay as recorded. It never waits. Not thread-safe
/// but for stop().
class RecordingSource final : public Source {
 public:
  /// Errors: as RecordingReader::open(), and kUnsupportedData for a recording without images.
  /// \p diagnostics must outlive the source.
  static Result<std::unique_ptr<RecordingSource>> open(const std::filesystem::path& sequence,
                                                       const PlusConfig* config,
                                                       const RecordingOptions& options,
                                                       Diagnostics& diagnostics);

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  Result<Sample> next(Deadline deadline) override;
  void stop() noexcept override { stopped_ = true; }
  /// Back to the first frame.
  void rewind();

  /// Position of the images on the probe, and their pixel grid.
  [[nodiscard]] const ImageCalibration& calibration() const { return *reader_.calibration(); }
  /// Why it is not to be relied on, one sentence; empty when it is.
  [[nodiscard]] const std::string& calibration_doubt() const { return reader_.calibration_doubt(); }
  [[nodiscard]] RecordingForm form() const { return reader_.form(); }
  [[nodiscard]] const std::string& reference_frame() const { return reader_.reference_frame(); }
  /// Frames that the header declares.
  [[nodiscard]] std::int64_t total_images() const { return reader_.total_images(); }
  /// The transforms in use, for reports: "Probe→Tracker: ProbeToTracker (frames)".
  [[nodiscard]] const std::string& description() const { return reader_.description(); }

  /// Frames read so far.
  [[nodiscard]] std::int64_t frames_read() const { return frames_read_; }
  /// Earliest and latest stamp of the frames read so far; absent while no frame has one.
  [[nodiscard]] std::optional<Timestamp> first_time() const { return first_time_; }
  [[nodiscard]] std::optional<Timestamp> last_time() const { return last_time_; }
  /// Frames read so far whose data cannot be true: times that do not increase, poses or
  /// calibrations that are not rigid or not numbers. A frame that says itself that nothing was
  /// tracked or seen is not among them.
  [[nodiscard]] std::int64_t bad_frames() const { return bad_frames_; }
  /// The fault of the first bad frame, one sentence; empty while there is none.
  [[nodiscard]] const std::string& first_bad_frame() const { return first_bad_frame_; }

 private:
  RecordingSource(RecordingReader reader, std::unique_ptr<WarningMemory> diagnostics,
                  std::string name);
  Result<void> read_frame();
  void deliver(RecordingImage frame);
  [[nodiscard]] std::string defect_of(const RecordingImage& frame) const;
  void note_long_periods();
  void note_unknown_status(const RecordingImage& frame);

  std::unique_ptr<WarningMemory> diagnostics_;  ///< Outlives the reader, which reports to it.
  RecordingReader reader_;
  std::string name_;
  std::vector<StreamInfo> streams_;
  std::deque<Sample> waiting_;  ///< Samples of the newest frame.
  std::atomic<bool> stopped_{false};
  Timestamp now_{};  ///< The newest stamp so far; the origin while there is none.
  std::int64_t frames_read_ = 0;
  std::optional<Timestamp> first_time_, last_time_;
  std::int64_t bad_frames_ = 0;
  std::string first_bad_frame_;
};

}  // namespace nav::io
