// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>

#include "nav/diagnostics.hpp"
#include "nav/pose.hpp"
#include "nav/sample.hpp"

namespace nav::tracking {

/// Finds poses that no body has: positions of another unit than millimetres, and two bodies with
/// the same poses. Reports each once; changes nothing. Not thread-safe.
class PosePlausibility {
 public:
  /// \p diagnostics must outlive this.
  explicit PosePlausibility(Diagnostics& diagnostics) : diagnostics_(diagnostics) {}

  /// Takes the next pose of a body, as it came. Poses without a status that claims one count for
  /// nothing.
  void add(ToolRole body, const RawPose& pose);

 private:
  struct Body {
    Eigen::Matrix4d newest = Eigen::Matrix4d::Zero();
    Timestamp acquired{};
    int poses = 0;      ///< Poses so far.
    int different = 0;  ///< Those that differ from the pose before.
    int far = 0;        ///< Those beyond any working volume.
    double farthest_mm = 0;
  };
  void judge_unit(ToolRole role, Body& body);
  void judge_others(ToolRole role, const Body& body);
  void report(const std::string& subject, const std::string& key, const std::string& value,
              const std::string& used);

  Diagnostics& diagnostics_;
  std::map<ToolRole, Body> bodies_;
  std::map<std::pair<ToolRole, ToolRole>, int> same_;  ///< Poses in a row that are the same.
  std::set<std::string> said_;
};

}  // namespace nav::tracking
