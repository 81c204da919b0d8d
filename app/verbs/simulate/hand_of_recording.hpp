// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "app/console.hpp"
#include "nav/result.hpp"
#include "sim/motion/recorded_hand.hpp"

namespace nav::app {

/// Motion of the probe in a recording: the poses of its images, about the middle of their upper
/// edge. \p config: PLUS configuration with its calibration; empty: the recording has it. Images
/// without a pose are left out, and stamps that do not increase. Errors: those of reading it; fewer
/// than two images with a pose.
Result<std::shared_ptr<const sim::RecordedHand>> hand_of_recording(
    const std::filesystem::path& recording, const std::filesystem::path& config, Console& console);

}  // namespace nav::app
