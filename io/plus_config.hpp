// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::io {

/// One entry of CoordinateDefinitions: p_to = to_from_from * p_from. Not judged: it may scale, as
/// Image is in pixels.
struct CoordinateDefinition {
  std::string from;
  std::string to;
  Eigen::Matrix4d to_from_from;
  std::optional<double> error;  ///< As stored by PLUS, usually mm; used by nothing.
  std::string date;             ///< As in the file.
};

/// A DataSource of a device: a tool, a video port or a field.
struct PlusDataSource {
  std::string id;
  std::string type;               ///< "Tool", "Video", "FieldData".
  std::string image_orientation;  ///< PortUsImageOrientation; empty when absent.
  std::map<std::string, std::string> attributes;
};

/// A Device of the data collection.
struct PlusDevice {
  std::string id;
  std::string type;
  double local_time_offset_s = 0;    ///< LocalTimeOffsetSec; 0 when absent, as in PLUS.
  std::string tool_reference_frame;  ///< Empty when absent.
  std::string sequence_file;         ///< SavedDataSource: the recording to replay.
  std::string use_data;              ///< SavedDataSource: "IMAGE", "TRANSFORM", …
  bool use_original_timestamps = false;
  bool repeat = false;
  std::vector<PlusDataSource> data_sources;
  std::map<std::string, std::string> attributes;  ///< Every attribute as in the file.
};

enum class TransducerGeometry { kLinear, kCurvilinear };

/// ScanConversion: how the scanner laid its beams into the picture. Absent members were absent.
struct ScanConversion {
  TransducerGeometry geometry;
  std::optional<Eigen::Vector2d> output_spacing_mm;     ///< OutputImageSpacingMmPerPixel.
  std::optional<Eigen::Vector2d> output_size_px;        ///< OutputImageSizePixel.
  std::optional<Eigen::Vector2d> transducer_centre_px;  ///< TransducerCenterPixel.
  std::optional<double> radius_start_mm, radius_stop_mm;
  std::optional<double> theta_start_rad, theta_stop_rad;
  std::optional<double> imaging_depth_mm, transducer_width_mm;
  std::map<std::string, std::string> attributes;  ///< Every attribute as in the file.
};

/// What Sonde needs of a PLUS device-set configuration. Elements it does not know are ignored.
struct PlusConfig {
  std::filesystem::path path;
  std::string version;
  std::vector<CoordinateDefinition> transforms;
  std::vector<PlusDevice> devices;
  std::optional<ScanConversion> scan_conversion;  ///< The first in the file.

  /// The definition From -> To as written, or nullptr.
  [[nodiscard]] const CoordinateDefinition* find(const std::string& from,
                                                 const std::string& to) const;
};

/// Reads a configuration. No entity, include or network address is ever followed. Refuses: files
/// beyond 64 MiB, no PlusConfiguration root, a Matrix that is not 16 finite numbers, the same
/// transform twice, offsets and geometry that are not numbers. Messages name the file and element.
Result<PlusConfig> read_plus_config(const std::filesystem::path& path);

}  // namespace nav::io
