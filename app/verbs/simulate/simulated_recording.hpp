// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "sim/session/simulated_session.hpp"

namespace nav::app {

/// Record of one image as the recorder wrote it.
struct RecordedImage {
  std::uint64_t sequence;  ///< Index of the image in the session.
  Timestamp stamped;       ///< Time stamp from the device.
};

/// Recording and the faults of its streams.
struct SimulatedRecording {
  std::vector<RecordedImage> frames{};  ///< Images in the order of the file.
  std::vector<sim::FaultRecord> probe_faults{}, reference_faults{}, needle_faults{}, frame_faults{};
};

/// Records a session as a PLUS server does. The file has one entry per image, in order of arrival.
/// Each body's pose is interpolated at the image's stamp between two good samples at most 200 ms
/// apart; otherwise it is the nearest sample, unchanged. Every entry has ImageToProbe; with a
/// needle also NeedleToTracker (its hub) and NeedleTipToNeedle (its straight tip relative to the
/// hub). path: ends in .mha or .nrrd. progress: fraction in [0, 1].
Result<SimulatedRecording> record(const sim::SimulatedSession& session,
                                  const std::filesystem::path& path, bool compress,
                                  const std::function<void(double)>& progress);

/// Transform from pixels (column, row, 0) to the Image frame, mm; its third column is as long as
/// the first.
Eigen::Matrix4d image_from_pixels(const PixelGrid& grid);

}  // namespace nav::app
