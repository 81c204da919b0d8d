// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/verbs/slices.hpp"
#include "app/views/placed_picture.hpp"
#include "nav/plan.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// A slice that is to be written.
struct NamedPlane {
  std::string name;  ///< Of the file, without its ending.
  render::SlicePlane plane;
  double mm_per_pixel;
  /// A line in the plane, drawn: of a needle from its hub to its tip, of a plan from the entry to
  /// the target; absent: none.
  std::optional<std::array<Point<frames::Ct>, 2>> line_ct{};
};

/// The names of all slices that there can be.
std::vector<std::string> slice_names();

/// The slices that options and the session's plan ask for. Unless options give a scale, the whole
/// CT fits, in one scale for axial, coronal and sagittal; along a picture that fits. Refuses, by
/// option or key: points outside the CT or not finite, a normal or in-plane directions that span no
/// plane, a needle without length.
Result<std::vector<NamedPlane>> slice_planes(const SlicesOptions& options,
                                             const std::optional<NeedlePlan>& plan,
                                             const Volume& ct,
                                             const std::optional<PlacedPicture>& picture);

}  // namespace nav::app
