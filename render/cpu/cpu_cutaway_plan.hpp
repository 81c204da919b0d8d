// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "render/cpu/cpu_cutaway.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// The objects of a cutaway in the layout of the CPU engine. Thread-safe to read.
class CutPlan {
 public:
  explicit CutPlan(const spec::CutawayObjects<double>& objects);
  CutPlan(const CutPlan&) = delete;
  CutPlan& operator=(const CutPlan&) = delete;

  [[nodiscard]] bool empty() const { return view_.polygon_count == 0 && view_.ball_count == 0; }
  [[nodiscard]] const CutObjects& objects() const { return view_; }
  /// The reference point, local mm.
  [[nodiscard]] const Eigen::Vector3d& centre() const { return centre_; }

 private:
  void add(const spec::CutawayPolygon<double>& polygon);

  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  std::vector<CutEdge> edges_;
  std::vector<CutPolygon> polygons_;
  std::vector<CutBall> balls_;
  CutObjects view_{};
};

/// A CutChoice with its own arrays.
class CutSelection {
 public:
  /// Chooses all objects.
  explicit CutSelection(const CutObjects& objects);
  CutSelection(const CutSelection&) = delete;
  CutSelection& operator=(const CutSelection&) = delete;
  [[nodiscard]] CutChoice& choice() { return choice_; }
  [[nodiscard]] const CutChoice& choice() const { return choice_; }

 private:
  std::vector<int> edges_;
  std::vector<int> polygons_;
  std::unique_ptr<bool[]> inside_;
  std::vector<float> upper_;
  CutChoice choice_{};
};

/// The block of size × size pixels that begins at (x0, y0).
CutBlock cut_block(const spec::View<double>& view, const Eigen::Vector3d& centre, int x0, int y0,
                   int size);

/// The camera relative to the reference point of a cutaway.
CutView cut_view(const spec::View<double>& view, const Eigen::Vector3d& centre);

}  // namespace nav::render
