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

/// One entry of CoordinateDefinitions: p_to = to_from_from * p_from. The matrix is not checked; it
/// may scale, because Image is in pixels.
struct CoordinateDefinition {
  std::string from;
  std::string to;
  Eigen::Matrix4d to_from_from;
  std::optional<double> error{};  ///< Value stored by PLUS, usually mm; not used.
  std::string date{};             ///< Text of the file.
};

/// DataSource of a device: a tool, a video port or a field.
struct PlusDataSource {
  std::string id;
  std::string type;               ///< "Tool", "Video", "FieldData".
  std::string image_orientation;  ///< PortUsImageOrientation; empty when absent.
  std::map<std::string, std::string> attributes;
};

/// Device of the data collection.
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

/// ScanConversion: geometry of the scan lines in the image. Members that the file lacks are absent.
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

/// VolumeReconstruction: what PLUS cuts out of every image, and its voxels. Members that the file
/// lacks are absent.
struct VolumeReconstruction {
  std::optional<Eigen::Vector3d> output_spacing_mm;
  std::optional<Eigen::Vector2d> clip_origin_px, clip_size_px;
  /// In degrees about +y, as in the file; both 0: no fan, as in PLUS.
  std::optional<Eigen::Vector2d> fan_angles_deg;
  std::optional<Eigen::Vector2d> fan_origin_px;
  std::optional<double> fan_radius_start_px, fan_radius_stop_px;
};

/// The part of a PLUS device-set configuration that Sonde uses. Unknown elements are ignored.
struct PlusConfig {
  std::filesystem::path path;
  std::string version;
  std::vector<CoordinateDefinition> transforms;
  std::vector<PlusDevice> devices;
  std::optional<ScanConversion> scan_conversion;  ///< The first in the file.
  std::optional<VolumeReconstruction> volume_reconstruction{};

  /// The definition From -> To as in the file, or nullptr.
  [[nodiscard]] const CoordinateDefinition* find(const std::string& from,
                                                 const std::string& to) const;
};

/// Reads a configuration. Entities, includes and network addresses are never followed. Rejects
/// files above 64 MiB, a missing PlusConfiguration root, a Matrix that is not 16 finite numbers, a
/// transform that is defined twice, and offsets and geometry that are not numbers. Messages name
/// the file and element.
Result<PlusConfig> read_plus_config(const std::filesystem::path& path);

}  // namespace nav::io
