// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/plus_config.hpp"
#include "io/sequence.hpp"
#include "nav/pose.hpp"
#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "nav/ultrasound_frame.hpp"

namespace nav::io {

/// One step of a chain: a known transform, used as written or inverted.
struct ChainLink {
  std::string name;         ///< As written: "ProbeToTracker".
  bool from_frame = false;  ///< Comes with each frame; otherwise from the configuration.
  bool inverted = false;
  Eigen::Matrix4d step;  ///< Already inverted when inverted; configuration links only, else NaN.
};

/// The way from one coordinate frame to another: to_from_from = links[n-1].step * … *
/// links[0].step.
struct Chain {
  std::string from;
  std::string to;
  std::vector<ChainLink> links;  ///< In order of travel, starting at from.

  /// The product for one frame, with the worst status of the frame's links (configuration links are
  /// ok). Errors name the transform that the frame lacks, that cannot be inverted, or that
  /// contradicts the one of the other direction where the frame has both.
  [[nodiscard]] Result<NamedTransform> evaluate(const SequenceFrame& frame) const;
};

/// Which transforms exist between named coordinate frames: those of a recording's frames and those
/// of a configuration, each usable both ways. Where both know a transform, the frames win.
class TransformTree {
 public:
  /// Names of frame transforms are split at their "To"; those that cannot be split link nothing and
  /// are left out. Refuses definitions that are not finite and invertible, and two of opposite
  /// directions that are not each other's inverse.
  static Result<TransformTree> create(const std::vector<std::string>& frame_transforms,
                                      const std::vector<CoordinateDefinition>& definitions);

  /// Shortest chain; the first found in order of definition among equals. The error of a missing
  /// link names both ends and lists what exists.
  [[nodiscard]] Result<Chain> find(const std::string& from, const std::string& to) const;
  /// "Probe→Tracker (frames), Image→Probe (configuration)".
  [[nodiscard]] std::string describe() const;

 private:
  struct Edge {
    std::string from, to;
    bool from_frame = false;
    Eigen::Matrix4d to_from_from;
  };
  std::vector<Edge> edges_;
};

/// Splits a transform name at the "To" between two capitalised names ("StylusTipToStylus"), or
/// nothing when there is no such place.
std::optional<std::pair<std::string, std::string>> split_transform_name(std::string_view name);

/// A probe calibration taken apart: where the pixels lie in the plane, and the plane in the probe.
struct ImageCalibration {
  Transform<frames::Probe, frames::Image> probe_from_image;
  PixelGrid grid;
};

/// Splits ImageToProbe of PLUS (pixels, MF, to mm): origin at the middle of the first row, +x along
/// columns, +z = x × y of the picture's axes; the shear of real calibrations stays in grid,
/// exactly. The third column carries no information of the plane and is ignored. Refuses NaN, a
/// last row that is not 0 0 0 1, zero columns, shear above 20 degrees, a picture without pixels.
Result<ImageCalibration> calibration_from_matrix(const Eigen::Matrix4d& probe_from_pixels,
                                                 int width, int height);

}  // namespace nav::io
