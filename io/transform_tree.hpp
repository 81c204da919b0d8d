// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/plus_config.hpp"
#include "io/sequence.hpp"
#include "nav/diagnostics.hpp"
#include "nav/pose.hpp"
#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "nav/ultrasound_image.hpp"

namespace nav::io {

/// One step of a chain: a known transform, used directly or inverted.
struct ChainLink {
  std::string name;         ///< Name in the file: "ProbeToTracker".
  bool from_frame = false;  ///< True: part of each sequence frame; false: from the configuration.
  bool inverted = false;
  Eigen::Matrix4d step;  ///< Matrix of the step, inverted if necessary; NaN if from_frame.
};

/// Chain of transforms between two coordinate frames: to_from_from = links[n-1].step * … *
/// links[0].step.
struct Chain {
  std::string from;
  std::string to;
  std::vector<ChainLink> links;  ///< Links in order, starting at \p from.

  /// Product for one sequence frame, with the worst status of its links (configuration links are
  /// ok). Errors name the transform that the sequence frame lacks, that cannot be inverted, or that
  /// contradicts the transform of the opposite direction if the sequence frame has both.
  [[nodiscard]] Result<NamedTransform> evaluate(const SequenceImage& frame) const;
};

/// Transforms between named coordinate frames: those of the frames of a recording and those of a
/// configuration. Each can be used in both directions. If both define a transform, the recording
/// takes precedence.
class TransformTree {
 public:
  /// The names of the recorded transforms are split at their "To"; names that cannot be split are
  /// left out. Rejects definitions that are not finite and invertible, and two definitions of
  /// opposite directions that are not inverse to each other.
  static Result<TransformTree> create(const std::vector<std::string>& frame_transforms,
                                      const std::vector<CoordinateDefinition>& definitions);

  /// Shortest chain; among equally short ones the first in order of definition. The error for a
  /// missing link names both ends and lists the existing transforms.
  [[nodiscard]] Result<Chain> find(const std::string& from, const std::string& to) const;
  /// Transforms that can be computed from others as well, each with the chain of the others.
  /// \p first: names of transforms ("ProbeToTracker") that are preferred in these chains. Two
  /// transforms of opposite directions in the frames are not among them: evaluate() compares these.
  [[nodiscard]] std::vector<std::pair<ChainLink, Chain>> loops(
      const std::set<std::string>& first) const;
  /// Text such as "Probe→Tracker (frames), Image→Probe (configuration)".
  [[nodiscard]] std::string describe() const;

 private:
  struct Edge {
    std::string from, to;
    bool from_frame = false;
    Eigen::Matrix4d to_from_from;
  };
  std::vector<Edge> edges_;
};

/// A finding if a frame that is taken as the tip of the needle has a tip of its own: the tree
/// places
/// "<needle>Tip" more than 5 mm from it. \p frame: has the transforms that are not of a
/// configuration.
std::optional<Finding> other_tip(const TransformTree& tree, const std::string& needle,
                                 const SequenceImage& frame);

/// A finding if the tip of a needle is not within 1 mm to 2 m of its tracked body, as positions in
/// metres or micrometres are not; one at its origin is its body. \p name: "NeedleTip on Needle".
std::optional<Finding> tip_of_another_unit(const Eigen::Matrix4d& body_from_tip,
                                           const std::string& name);

/// Splits a transform name at the "To" between two capitalised names ("StylusTipToStylus"); nothing
/// when there is no such position or more than one.
std::optional<std::pair<std::string, std::string>> split_transform_name(std::string_view name);

/// Decomposed probe calibration: positions of the pixels in the image plane, and pose of the plane
/// in the Probe frame.
struct ImageCalibration {
  Transform<frames::Probe, frames::Image> probe_from_image;
  PixelGrid grid;
};

/// Decomposes ImageToProbe of PLUS (pixels, MF, to mm): origin at the centre of the first row, +x
/// along the columns, +z = x × y of the image axes. The shear of real calibrations stays in grid,
/// exactly. The third column does not describe the plane and is ignored. Rejects NaN, a last row
/// that is not 0 0 0 1, zero columns, shear above 20 degrees, and an image without pixels.
Result<ImageCalibration> calibration_from_matrix(const Eigen::Matrix4d& probe_from_pixels,
                                                 int width, int height);

}  // namespace nav::io
