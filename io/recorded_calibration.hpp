// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "io/sequence.hpp"
#include "io/transform_tree.hpp"

namespace nav::io {

/// Calibration (Image to Probe) in one frame of a recording. Errors name frame and transform:
/// kMalformedData for an unreadable or impossible one, kUnsupportedData if its own status says that
/// it is invalid.
Result<ImageCalibration> calibration_of(const Chain& probe_from_pixels, const SequenceImage& frame,
                                        const SequenceHeader& header);

/// First calibration of a recording, in the order of its frames.
struct FirstCalibration {
  ImageCalibration calibration;
  std::int64_t frame;  ///< Index of the frame that has it.
};

/// Reads the fields of the frames up to the first that has a calibration, and none after it.
/// Without any, the error of the last frame.
Result<FirstCalibration> first_calibration(const Chain& probe_from_pixels,
                                           const SequenceReader& reader);

/// Rejects a calibration that differs from the first one by more than the rounding of text:
/// kMalformedData, which names both frames and where both calibrations put the image.
Result<void> same_calibration(const Chain& probe_from_pixels, const FirstCalibration& first,
                              const FirstCalibration& other, const SequenceHeader& header);

/// "0.2 x 0.3 mm"; with the angle between rows and columns where it is no right one.
std::string pixel_text(const PixelGrid& grid);

/// A finding about a calibration that no probe has: the identity of an uncalibrated one, one in
/// metres, pixels above 5 mm, five times as long as wide, or more than 8° from a right angle.
/// Subject: empty.
std::optional<Finding> placeholder_calibration(const ImageCalibration& calibration);

}  // namespace nav::io
