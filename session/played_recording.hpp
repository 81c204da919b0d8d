// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/source.hpp"
#include "session/options.hpp"
#include "session/session.hpp"

namespace nav::io {
class RecordingSource;
}

namespace nav::session {

/// Counts of the frames that were read so far.
struct ImagesRead {
  std::int64_t frames = 0;
  /// Earliest and latest stamp; absent while no frame has one.
  std::optional<Timestamp> first_time = std::nullopt, last_time = std::nullopt;
  std::int64_t bad_frames = 0;    ///< Frames whose data cannot be true.
  std::string first_bad_frame{};  ///< Its fault, one sentence; empty: none.
};

/// A recording as sources of a session on the virtual clock: a PLUS sequence, or a recording of
/// devices (MCAP). Not thread-safe.
class PlayedRecording {
 public:
  /// Opens the recording that the options name; *.mcap is a recording of devices. \p diagnostics
  /// must outlive it. Errors: those of the file, and kUsage for options that do not fit it.
  static Result<std::unique_ptr<PlayedRecording>> open(const SourceOptions& options,
                                                       Diagnostics& diagnostics);
  virtual ~PlayedRecording() = default;

  /// The sources at their first sample. The ones of an earlier call end.
  virtual Result<std::vector<std::shared_ptr<Source>>> rewind() = 0;
  /// Calibration, fixed reference and temporal offset of the session.
  [[nodiscard]] virtual SessionSetup setup() const = 0;
  /// Frames that the file declares.
  [[nodiscard]] virtual std::int64_t total_images() const = 0;
  [[nodiscard]] virtual ImagesRead read() const = 0;
  /// Name of the patient's frame; empty: the tracker's, because nothing tracks the patient.
  [[nodiscard]] virtual std::string reference_frame() const = 0;
  /// True when it tracks a needle that is drawn.
  [[nodiscard]] virtual bool has_needle() const = 0;
  /// Frames and transforms in use, for the report.
  [[nodiscard]] virtual const std::string& description() const = 0;
  /// kMalformedData for a file that is cut short and cannot be played.
  [[nodiscard]] virtual Result<void> check_complete() const = 0;
};

/// Opens a PLUS sequence with the calibration and the coordinate frames that the options name.
/// \p diagnostics must outlive it.
Result<std::shared_ptr<io::RecordingSource>> open_recording_source(
    const std::filesystem::path& sequence, const SourceOptions& options, Diagnostics& diagnostics);

/// The finding about damage of a recording of devices. \p damage: sentences of its reader, at least
/// one.
Finding damage_finding(const std::string& recording, const std::vector<std::string>& damage);

/// True for a recording of devices by its name.
bool is_device_recording(const std::filesystem::path& path);

}  // namespace nav::session
