// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "nav/image.hpp"
#include "nav/volume.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// Grey window of a CT slice: black at level − width/2, white at level + width/2, HU.
struct HuWindow {
  double level = 60;
  double width = 400;
};

/// The position of a flat image of the CT. right and down are unit vectors at right angles, in CT
/// axes (LPS).
struct SlicePlane {
  Point<frames::Ct> centre_ct;  ///< Centre of the image.
  Direction<frames::Ct> right;
  Direction<frames::Ct> down;
};

/// Slices through a point in the radiological convention: the patient's right is at the image's
/// left.
///
/// Axial: seen from the feet, anterior at the top. Coronal: seen from the front, head at the top.
/// Sagittal: seen from the patient's left, anterior at the left, head at the top.
SlicePlane axial_slice(const Point<frames::Ct>& through_ct);
SlicePlane coronal_slice(const Point<frames::Ct>& through_ct);
SlicePlane sagittal_slice(const Point<frames::Ct>& through_ct);
/// An oblique slice through a point, oriented like the one of the three slices above whose plane is
/// nearest, and equal to it if the normal lies along an axis. Either sign of the normal gives the
/// same slice. Precondition: a finite normal that is not zero; otherwise a Bug.
SlicePlane oblique_slice(const Point<frames::Ct>& through_ct, const Direction<frames::Ct>& normal);
/// A slice along an ultrasound image: the image's columns to the right, its rows down. centre_mm:
/// Image frame.
SlicePlane ultrasound_slice(const Transform<frames::Ct, frames::Image>& ct_from_image,
                            const Eigen::Vector2d& centre_mm);
/// Two slices that contain a needle and stand at right angles to each other. The needle points
/// down, with its tip in the middle. The first slice faces the patient's front as far as possible
/// (the feet for a needle along the front). Precondition: hub and tip apart; otherwise a Bug.
std::array<SlicePlane, 2> needle_slices(const Point<frames::Ct>& hub_ct,
                                        const Point<frames::Ct>& tip_ct);

/// Letters at the image's edges: L, R (of the patient), A, P, S, I. An oblique edge has two, the
/// nearer axis first ("AL").
struct SliceLabels {
  std::string left;
  std::string right;
  std::string top;
  std::string bottom;
};
SliceLabels labels_of(const SlicePlane& plane);

/// Ways in which a thick slice combines the values across it.
enum class SlabMode { kMaximum, kMinimum, kMean };

struct SliceOptions {
  int width = 800;
  int height = 600;
  double mm_per_pixel = 0.5;
  double slab_mm = 0;  ///< Thickness, half to each side; 0: thin.
  SlabMode slab = SlabMode::kMaximum;
  int threads = 0;  ///< 0: all cores.
};

/// Rejects sizes outside [1, 16384], mm_per_pixel outside (0, 100], a slab outside [0, 1000] mm,
/// axes that are not unit vectors at right angles within 1e-6, and NaN. The message names the
/// field.
Result<void> validate(const SlicePlane& plane, const SliceOptions& options);

/// Trilinear HU at pixel centres, row by row; NaN outside the CT's box (ray_spec.hpp). A thick
/// slice along voxel planes combines its two ends and all voxel planes between them, so that its
/// maximum misses no voxel. An oblique thick slice combines layers at most half the smallest
/// spacing apart. A mean weights a layer by its distance to the next ones; parts outside the CT do
/// not count. Errors as in validate().
Result<Image2d<float>> slice_values(const StoredVolume& ct, const SlicePlane& plane,
                                    const SliceOptions& options);

/// The colour outside the CT. No grey value has this colour.
inline constexpr Rgba8 kOutsideCt{24, 28, 48, 255};

/// Converts values to grey, and outside to kOutsideCt.
/// Grey = round(255 · clamp((HU − level) / width + ½)).
Image2d<Rgba8> to_grey(const Image2d<float>& values, const HuWindow& window);

/// A thin slice of the CT along the plane of an ultrasound image. Pixel (column, row) shows the
/// point origin_mm + mm_per_pixel · (column, row) of the Image frame. Preconditions: those of
/// validate(); otherwise a Bug.
Image2d<Rgba8> slice_along_image(const StoredVolume& ct,
                                 const Transform<frames::Ct, frames::Image>& ct_from_image,
                                 const Eigen::Vector2d& origin_mm, double mm_per_pixel, int width,
                                 int height, const HuWindow& window);

enum class FusionMode {
  kBlend,         ///< A mean, weighted by the share of the ultrasound.
  kCheckerboard,  ///< Alternating squares of both.
  kWipe,          ///< Ultrasound left of a line, CT right of it.
};

struct Fusion {
  FusionMode mode = FusionMode::kBlend;
  double share = 0.5;     ///< kBlend: share of the ultrasound, [0, 1].
  double square_mm = 10;  ///< kCheckerboard, > 0.
  double wipe = 0.5;      ///< kWipe: share of the image's width, [0, 1].
  /// Beyond this distance from the ultrasound plane a pixel shows only CT, >= 0; at least 0.85
  /// pixel.
  double reach_mm = 0.5;
};

/// Draws ultrasound over a CT slice, each pixel by its own position in space: inside the true
/// outline, with the border of its state. If the slice crosses the ultrasound plane steeply, a line
/// in the border's colour marks it. A stale plane shows only its grey border (and line), a lost one
/// nothing: neither is ever drawn as live. Rejects options out of range. Errors as in validate().
Result<Image2d<Rgba8>> fuse(const Image2d<Rgba8>& ct_slice, const SlicePlane& plane,
                            const SliceOptions& options, const UltrasoundPlane& ultrasound,
                            const Fusion& fusion);

/// Draws a second volume over the CT; second: its values along the same plane as grey, from
/// to_grey(). Where one of the two has no value (kOutsideCt), only the other is shown. reach_mm
/// does not matter. Rejects options out of range. Precondition: images of the same size; otherwise
/// a Bug.
Result<Image2d<Rgba8>> fuse(const Image2d<Rgba8>& ct_slice, const Image2d<Rgba8>& second,
                            const SliceOptions& options, const Fusion& fusion);

}  // namespace nav::render
