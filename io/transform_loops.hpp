// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/transform_tree.hpp"

namespace nav::io {

/// Compares transforms that can be computed from each other, frame by frame.
class TransformLoops {
 public:
  /// \p used: names of the transforms by which images, patient and needle are placed. \p image:
  /// name of the frame whose coordinates are pixels of an image of \p width and \p height; a
  /// calibration between it and \p probe in both frames and configuration is not compared. \p
  /// subject: of the findings.
  TransformLoops(const TransformTree& tree, std::set<std::string> used, std::string image,
                 const std::string& probe, int width, int height, std::string subject);

  /// Findings about one frame, or with an empty one about those transforms that are in no frame:
  /// the two ways place a point more than 1 mm apart. Points are the corners of the image, or the
  /// origin and points at 50 mm from it along the axes. Poses without a valid status are not
  /// compared. A contradiction that is of no effect on what is used has the severity kInfo.
  [[nodiscard]] std::vector<Finding> findings(const SequenceImage& frame) const;

 private:
  struct Loop {
    ChainLink link;
    Chain other;
    std::string names;  ///< "ProbeToTracker and ReferenceToTracker".
    bool uses_link = false;
    bool uses_other = false;
  };
  [[nodiscard]] std::optional<double> apart_mm(const Loop& loop, const SequenceImage& frame) const;

  std::vector<Loop> loops_;
  std::string image_;
  int width_;
  int height_;
  std::string subject_;
};

}  // namespace nav::io
