// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/recorded_calibration.hpp"

#include <algorithm>
#include <sstream>

namespace nav::io {
namespace {

/// Tolerance for the positions of the corners. The calibration may have been written through poses
/// 2 m away with six digits, which move a corner by less than this.
constexpr double kSamePlaceMm = 0.05;

std::string name_of(const Chain& chain) { return chain.from + "To" + chain.to; }

/// Largest distance between corresponding corners of the image.
double apart_mm(const ImageCalibration& a, const ImageCalibration& b,
                const SequenceHeader& header) {
  double most = 0;
  for (const double column : {0.0, header.width - 1.0}) {
    for (const double row : {0.0, header.height - 1.0}) {
      const auto in_a = a.probe_from_image * a.grid.at(column, row);
      const auto in_b = b.probe_from_image * b.grid.at(column, row);
      most = std::max(most, (in_a.mm - in_b.mm).norm());
    }
  }
  return most;
}

}  // namespace

Result<ImageCalibration> calibration_of(const Chain& probe_from_pixels, const SequenceFrame& frame,
                                        const SequenceHeader& header) {
  const std::string where = "frame " + std::to_string(frame.index) + ": ";
  const auto value = probe_from_pixels.evaluate(frame);
  if (!value) return Error{ErrorCode::kMalformedData, value.error().message};
  if (value->status != TrackingStatus::kOk && value->status != TrackingStatus::kUnknown) {
    return Error{ErrorCode::kUnsupportedData, where + name_of(probe_from_pixels) +
                                                  ": expected a calibration with the status ok, "
                                                  "found " +
                                                  to_string(value->status)};
  }
  auto calibration = calibration_from_matrix(value->to_from_from, header.width, header.height);
  if (!calibration) return Error{calibration.error().code, where + calibration.error().message};
  return calibration;
}

Result<ImageCalibration> recorded_calibration(const Chain& probe_from_pixels,
                                              const SequenceReader& reader) {
  const SequenceHeader& header = reader.header();
  std::optional<ImageCalibration> found;
  std::int64_t first = 0;
  Error reason{ErrorCode::kNotFound, name_of(probe_from_pixels) + ": expected frames, found none"};
  for (std::int64_t i = 0; i < header.frame_count; ++i) {
    const auto frame = reader.frame_fields(i);
    const auto calibration =
        frame ? calibration_of(probe_from_pixels, *frame, header) : frame.error();
    // The error is reported when the frame itself is replayed, unless no other calibration exists.
    if (!calibration) {
      reason = calibration.error();
    } else if (!found) {
      found = *calibration;
      first = i;
    } else if (const double mm = apart_mm(*found, *calibration, header); !(mm <= kSamePlaceMm)) {
      std::ostringstream text;
      text << "frame " << i << ": " << name_of(probe_from_pixels)
           << ": expected the calibration of frame " << first
           << " (a probe has one calibration), found one that places corners of the image " << mm
           << " mm away";
      return Error{ErrorCode::kMalformedData, text.str()};
    }
  }
  if (!found) return reason;
  return *found;
}

}  // namespace nav::io
