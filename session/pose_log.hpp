// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tracking/image_pairer.hpp"

namespace nav::session {

/// The shortest text that reads back to the same double; 0 for -0.
std::string shortest_text(double value);
/// A pose as the columns of a log, each behind a comma: tx ty tz qx qy qz qw, qw >= 0.
std::string pose_columns(const Eigen::Vector3d& translation_mm, const Eigen::Quaterniond& rotation);

/// The pose log: one line of text for every image, in order, paired or not. The same input gives
/// the same bytes. Columns: sequence, acquired_ns, received_ns, outcome (paired, degraded or the
/// cause of the rejection), pose_gap_ns, then reference_from_image as tx ty tz (mm) qx qy qz qw.
/// Numbers are the shortest text that reads back to the same double.
class PoseLog {
 public:
  PoseLog();
  void add(const tracking::PairedImage& frame);
  /// An image that the source could not deliver.
  void add_missing(std::uint64_t sequence, const std::string& cause);
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace nav::session
