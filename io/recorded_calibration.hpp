// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/sequence.hpp"
#include "io/transform_tree.hpp"

namespace nav::io {

/// The calibration (Image to Probe) as one frame of a recording has it. Errors name frame and
/// transform: kMalformedData where it cannot be read or cannot be, kUnsupportedData where its own
/// status disowns it.
Result<ImageCalibration> calibration_of(const Chain& probe_from_pixels,
                                            const SequenceFrame& frame,
                                            const SequenceHeader& header);

/// The calibration of a whole recording: that of all frames that have one. kMalformedData where two
/// differ by more than rounding of text; without any, the error of the last frame.
Result<ImageCalibration> recorded_calibration(const Chain& probe_from_pixels,
                                                  const SequenceReader& reader);

}  // namespace nav::io
