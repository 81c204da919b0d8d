// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/verbs/slices.hpp"
#include "app/views/placed_image.hpp"
#include "nav/plan.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// Slice to be written.
struct NamedPlane {
  std::string name;  ///< Name of the file, without its ending.
  render::SlicePlane plane;
  double mm_per_pixel;
  /// Line to be drawn in the plane: a needle from its hub to its tip, or a plan from its entry to
  /// its target.
  std::optional<std::array<Point<frames::Ct>, 2>> line_ct{};
};

/// Names of all possible slices.
std::vector<std::string> slice_names();

/// Slices for the options and the session's plan. Unless the options give a scale, the whole CT
/// fits; axial, coronal and sagittal slices have one common scale; the slice along an ultrasound
/// image fits that image. Rejects points outside the CT or not finite, a normal or in-plane
/// directions that span no plane, and a needle without length, naming the option or key.
Result<std::vector<NamedPlane>> slice_planes(const SlicesOptions& options,
                                             const std::optional<NeedlePlan>& plan,
                                             const Volume& ct,
                                             const std::optional<PlacedImage>& image);

}  // namespace nav::app
