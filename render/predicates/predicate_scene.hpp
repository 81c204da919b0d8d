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
struct Shading;

/// Shading of samples by predicates: Blinn–Phong with a headlight, by the central-difference
/// gradient at one voxel of a volume of its own, as spec::shade_sample() with a share of 1. A
/// sample's opacity, predicates and importance do not depend on it, and its colour stays in [0, 1],
/// so every bound of early termination holds as without shading.
struct PredicateShading {
  /// Required, on the grid of the volume: shading_of_predicates() makes it. Neighbours differ by at
  /// most 32767.
  std::shared_ptr<const StoredVolume> source;
  double full_gradient_per_mm = 10;  ///< Stored values of the source per mm, > 0; see Shading.
  double ambient = 0.3;
  double diffuse = 0.7;
  double specular = 0.2;
  double shininess = 20;
};

/// A Shading of style Phong without emphasis that has these values.
Shading phong_of(const PredicateShading& shading);

/// Draws a scene's volume by predicates instead of by its transfer function. The rest of the scene
/// stays the same. A plain value.
///
/// Samples. Cells are those of ray_spec.hpp, always post-classified. A cell, or its part between
/// the events of the ray, is one sample with the values at the middle of the whole cell, the index
/// clamped to [0, n - 1] per axis. The volume and features are trilinear between the voxels floor
/// and floor + 1 (at most n - 1). A feature is undefined when any of these eight voxels is, even
/// one of weight 0. Labels are those of the nearest voxel, with halves rounded up. Labels that are
/// rasterised from surfaces are exactly those of the position; engines other than the reference
/// read them from the raster.
///
/// Intensity: (value - black) / (white - black). It is clamped to [0, 1] as luminance and opacity,
/// but not for predicates.
///
/// Opacity. Intensity x means the opacity min(x, kMostOpacity) of opacity_length_mm of material, so
/// tau = -ln(1 - min(x, kMostOpacity)) / opacity_length_mm. The definition is its table with
/// kTauEntries equidistant intensities, linear between them. A sample with a length has the opacity
/// -expm1(-tau · length_mm). Splitting a sample changes nothing (the semigroup of RENDERING.md b.1
/// also holds with importance), so that the opacity depends neither on the step nor on the spacing.
///
/// Samples are not shaded unless `shading` is set: the luminance is that of the ultrasound. The
/// gradient is that of the middle of the whole cell.
///
/// Surfaces are samples with the greatest impact of the model. No sample in front of them is more
/// important, less important samples fade in front of them, and an opaque surface ends the ray
/// exactly. If all importances are equal, compositing is plain over.
///
/// Cutaway. A sample counts with cutaway_importance · importance / greatest impact. Its opacity is
/// faded by the mean visibility at the kFadeSteps midpoints of ray_spec.hpp.
///
/// Projections other than kComposite show the volume's values and ignore all of this.
struct PredicateScene {
  static constexpr double kMostOpacity = 0.9995;
  static constexpr int kTauEntries = 1024;

  struct IntensityWindow {
    double black = 0;  ///< Stored values.
    double white = 255;
  };

  PredicateModel model;
  Features features{};  ///< Only the features that the model uses are read.
  IntensityWindow intensity{};
  double opacity_length_mm = 2;  ///< > 0.
  spec::HueMean hue_mean = spec::HueMean::kCircular;
  std::optional<ScanGeometry> scan{};
  /// True: there is a needle, but its position is unknown and the scene has none. Then no distance
  /// from it is in any range. Without this flag such a scene is rejected.
  bool needle_lost = false;
  /// Importance in the cutaway, [0, 1]; values from kFullImportance on count as 1. With 1, the most
  /// important samples stay in front of the objects that the cutaway clears.
  double cutaway_importance = 1;
  /// Greatest change of a pixel by omitting samples that are hardly visible, [0, 0.5]; 0: nothing
  /// is omitted. quality.opaque_at has no effect.
  double termination_error = 1.0 / 255;
  std::optional<PredicateShading> shading{};  ///< Costs nothing when absent.
};

/// Rejects the following and names the field: models that validate(PredicateModel) rejects;
/// features that the model uses and that are missing or not on the volume's grid; predicates of
/// scan lines without a scan geometry; predicates of a needle or a target that the scene does not
/// have; black >= white; a shading without source, with a source on another grid, or with
/// numbers that Shading does not allow.
Result<void> validate(const PredicateScene& predicates, const Scene& scene);

/// True when two scenes draw the same. Volumes compare by identity.
bool same_drawing(const PredicateScene& a, const PredicateScene& b);

/// The scene data for predicates: the needle and, as the target, the first sphere. A stale or lost
/// needle has no distances, because a past pose does not count.
PredicatePosition position_of(const Scene& scene);

}  // namespace nav::render
