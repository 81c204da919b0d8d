// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "nav/result.hpp"
#include "render/predicates/feature.hpp"
#include "render/predicates/model.hpp"
#include "render/predicates/place.hpp"
#include "render/spec/predicate_spec.hpp"

namespace nav::render {

struct Scene;

/// Draws a scene's volume by predicates instead of by its transfer function. What else the scene
/// has stays as it is. A plain value.
///
/// Samples. Cells as in ray_spec.hpp, always post-classified: a cell, or the part of one between
/// the events of its ray, is one sample with the values at the middle of the whole cell, the index
/// clamped to [0, n - 1] per axis. The volume and features are trilinear between the voxels floor
/// and floor + 1 (at most n - 1); a feature is undefined when any of these eight is, also one of
/// weight 0. Labels: of the nearest voxel, halves up; where they are rastered from surfaces,
/// exactly those of the place, which engines other than the reference take from the raster.
///
/// Intensity: (value - black) / (white - black), clamped to [0, 1] as luminance and opacity; not
/// clamped for predicates.
///
/// Opacity. Intensity x means the opacity min(x, kMostOpacity) of opacity_length_mm of material, so
/// tau = -ln(1 - min(x, kMostOpacity)) / opacity_length_mm, tabulated at kTauEntries equidistant
/// intensities, linear between: the definition. A sample of some length has the opacity
/// -expm1(-tau · length_mm). Splitting it changes nothing (the semigroup of RENDERING.md b.1 holds
/// with importance too), so that opacity depends on neither step nor spacing.
///
/// Not shaded: luminance is the ultrasound's.
///
/// Surfaces are samples of the greatest impact of the model: nothing more important lies in front
/// of them, what is less important fades before them, and an opaque one ends the ray exactly. All
/// importances equal: compositing is plain over.
///
/// Cutaway: a sample counts with cutaway_importance · importance / greatest impact; its opacity is
/// faded by the mean of their visibility at the kFadeSteps midpoints of ray_spec.hpp.
///
/// Projections other than kComposite show the volume's values and ignore all this.
struct PredicateScene {
  static constexpr double kMostOpacity = 0.9995;
  static constexpr int kTauEntries = 1024;

  struct IntensityWindow {
    double black = 0;  ///< Stored values.
    double white = 255;
  };

  PredicateModel model;
  Features features{};  ///< Only those that the model asks for are looked at.
  IntensityWindow intensity{};
  double opacity_length_mm = 2;  ///< > 0.
  spec::HueMean hue_mean = spec::HueMean::kCircular;
  std::optional<ScanGeometry> scan{};
  /// There is a needle, but nobody knows where, and the scene has none: no distance from it is
  /// within any range. Without this such a scene is refused.
  bool needle_lost = false;
  /// [0, 1]; from kFullImportance on 1. With 1 what is most important stays in front of whatever is
  /// cut free.
  double cutaway_importance = 1;
  /// Most that leaving out what can hardly be seen may change a pixel, [0, 0.5]; 0: nothing is left
  /// out. quality.opaque_at plays no part.
  double termination_error = 1.0 / 255;
};

/// Refuses, naming the field: whatever validate(PredicateModel) does; features that the model asks
/// for and that are missing or of another grid than the volume's; predicates of scan lines without
/// a scan geometry, of the needle or a target when there is none; black >= white.
Result<void> validate(const PredicateScene& predicates, const Scene& scene);

/// Whether two draw the same; volumes compare by identity.
bool same_drawing(const PredicateScene& a, const PredicateScene& b);

/// What the scene's predicates know of it: needle and, as the target, first sphere. A needle that
/// is stale or lost has no distances: a pose of the past is none.
PredicatePlace place_of(const Scene& scene);

}  // namespace nav::render
