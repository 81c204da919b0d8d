// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/sequence.hpp"
#include "io/transform_tree.hpp"

namespace nav::io {

/// Calibration (Image to Probe) in one frame of a recording. Errors name frame and transform:
/// kMalformedData for an unreadable or impossible one, kUnsupportedData if its own status says that
/// it is invalid.
Result<ImageCalibration> calibration_of(const Chain& probe_from_pixels, const SequenceFrame& frame,
                                        const SequenceHeader& header);

/// Calibration of a whole recording: the one that all frames with a calibration share.
/// kMalformedData when two differ by more than the rounding of text; without any, the error of the
/// last frame.
Result<ImageCalibration> recorded_calibration(const Chain& probe_from_pixels,
                                              const SequenceReader& reader);

}  // namespace nav::io
