// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "sim/session/simulated_session.hpp"

namespace nav::app {

/// What a recorder wrote for one picture.
struct RecordedFrame {
  std::uint64_t sequence;  ///< Index of the picture in the session.
  Timestamp stamped;       ///< As the device said.
};

/// A recording and what was done to its streams.
struct SimulatedRecording {
  std::vector<RecordedFrame> frames;  ///< In order of the file.
  std::vector<sim::FaultRecord> probe_faults, reference_faults, needle_faults, frame_faults;
};

/// Records a session as a PLUS server does: one frame of the file per picture, in order of arrival,
/// with each body's pose interpolated at the picture's stamp between two good samples at most
/// 200 ms apart, otherwise the nearest sample as it came. ImageToProbe comes with every frame; with
/// a needle, NeedleToTracker (its hub) and NeedleTipToNeedle (its straight tip on the hub) as well.
/// path ends in .mha or .nrrd. progress: fraction in [0, 1].
Result<SimulatedRecording> record(const sim::SimulatedSession& session,
                                  const std::filesystem::path& path, bool compress,
                                  const std::function<void(double)>& progress);

/// Where pixels (column, row, 0) lie in the Image frame, mm; the third column as long as the first.
Eigen::Matrix4d image_from_pixels(const PixelGrid& grid);

}  // namespace nav::app
