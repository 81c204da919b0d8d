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

/// "corners of the image at (0 0 0), (40 0 0) and (0 60 0) mm on the probe".
std::string corners_text(const ImageCalibration& calibration, const SequenceHeader& header) {
  const Eigen::IOFormat numbers(6, Eigen::DontAlignCols, " ", " ", "", "", "(", ")");
  const auto at = [&](double column, double row) -> Eigen::Vector3d {
    return (calibration.probe_from_image * calibration.grid.at(column, row)).mm;
  };
  std::ostringstream text;
  text << "corners of the image at " << at(0, 0).format(numbers) << ", "
       << at(header.width - 1.0, 0).format(numbers) << " and "
       << at(0, header.height - 1.0).format(numbers) << " mm on the probe";
  return text.str();
}

}  // namespace

Result<ImageCalibration> calibration_of(const Chain& probe_from_pixels, const SequenceImage& frame,
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

Result<FirstCalibration> first_calibration(const Chain& probe_from_pixels,
                                           const SequenceReader& reader) {
  const SequenceHeader& header = reader.header();
  Error reason{ErrorCode::kNotFound, name_of(probe_from_pixels) + ": expected frames, found none"};
  for (std::int64_t i = 0; i < header.frame_count; ++i) {
    const auto frame = reader.frame_fields(i);
    auto found = frame ? calibration_of(probe_from_pixels, *frame, header) : frame.error();
    if (found) return FirstCalibration{*std::move(found), i};
    reason = found.error();
  }
  return reason;
}

Result<void> same_calibration(const Chain& probe_from_pixels, const FirstCalibration& first,
                              const FirstCalibration& other, const SequenceHeader& header) {
  const double mm = apart_mm(first.calibration, other.calibration, header);
  if (mm <= kSamePlaceMm) return {};
  std::ostringstream text;
  text << "frame " << other.frame << ": " << name_of(probe_from_pixels)
       << ": expected the calibration of frame " << first.frame << ", with "
       << corners_text(first.calibration, header) << ", found one with "
       << corners_text(other.calibration, header) << ", " << mm
       << " mm away at a corner; a probe has one calibration";
  return Error{ErrorCode::kMalformedData, text.str()};
}

std::string pixel_text(const PixelGrid& grid) {
  constexpr double kRight = 1e-3;
  std::ostringstream text;
  text << grid.mm_per_pixel.col(0).norm() << " x " << grid.mm_per_pixel.col(1).norm() << " mm";
  if (std::abs(grid.shear_rad()) > kRight) {
    text << ", sheared by " << grid.shear_rad() * 180 / M_PI << " degrees";
  }
  return text.str();
}

std::optional<Finding> placeholder_calibration(const ImageCalibration& calibration) {
  constexpr double kSmallest_mm = 0.01;
  constexpr double kLargest_mm = 5;
  constexpr double kMostRatio = 5;
  constexpr double kMostShear_rad = 8 * M_PI / 180;  // Real calibrations shear by some degrees.
  const auto doubt = [](const std::string& value) {
    return Finding{.subject = "", .key = "ImageToProbe", .values = {value}, .used = "as stated"};
  };
  const PixelGrid& grid = calibration.grid;
  const Eigen::Vector3d corner = (calibration.probe_from_image * grid.at(0, 0)).mm;
  const bool unit = grid.mm_per_pixel.isApprox(Eigen::Matrix2d::Identity(), 1e-9);
  const bool unturned =
      calibration.probe_from_image.rotation().isApprox(Eigen::Quaterniond::Identity(), 1e-9);
  if (unit && unturned && corner.norm() < 1e-9) {
    return doubt("the identity (is the probe calibrated?)");
  }
  const auto sides = grid.mm_per_pixel.colwise().norm();
  const std::string pixels = "pixels of " + pixel_text(grid);
  if (sides.maxCoeff() < kSmallest_mm) return doubt(pixels + " (is the calibration in metres?)");
  if (sides.maxCoeff() > kLargest_mm) return doubt(pixels + " (larger than those of any image)");
  if (sides.maxCoeff() > kMostRatio * sides.minCoeff()) {
    return doubt(pixels + " (far from square: is one axis scaled twice?)");
  }
  if (std::abs(grid.shear_rad()) > kMostShear_rad) {
    return doubt(pixels + " (columns and rows far from a right angle)");
  }
  return std::nullopt;
}

}  // namespace nav::io
