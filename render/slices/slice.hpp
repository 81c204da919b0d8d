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

/// Where a flat picture of the CT lies. right, down: unit, at right angles, CT axes (LPS).
struct SlicePlane {
  Point<frames::Ct> centre_ct;  ///< Of the picture.
  Direction<frames::Ct> right;
  Direction<frames::Ct> down;
};

/// Slices as radiologists hang them, through a point: the patient's right at the picture's left.
/// Axial: seen from the feet, anterior at the top. Coronal: from the front, head at the top.
/// Sagittal: from the patient's left, anterior at the left, head at the top.
SlicePlane axial_slice(const Point<frames::Ct>& through_ct);
SlicePlane coronal_slice(const Point<frames::Ct>& through_ct);
SlicePlane sagittal_slice(const Point<frames::Ct>& through_ct);
/// Oblique through a point, hung as that of the three above whose plane is the nearest, and the
/// same where the normal is along an axis. Either sign of the normal gives the same slice.
/// Precondition: normal finite and not zero, otherwise a Bug.
SlicePlane oblique_slice(const Point<frames::Ct>& through_ct, const Direction<frames::Ct>& normal);
/// Along an ultrasound picture: its columns to the right, its rows down. centre_mm: image frame.
SlicePlane ultrasound_slice(const Transform<frames::Ct, frames::Image>& ct_from_image,
                            const Eigen::Vector2d& centre_mm);
/// Two slices that hold a needle and stand at right angles to each other; it points down, its tip
/// in the middle. The first faces the patient's front as far as it can (his feet for a needle along
/// the front). Precondition: hub and tip apart, otherwise a Bug.
std::array<SlicePlane, 2> needle_slices(const Point<frames::Ct>& hub_ct,
                                        const Point<frames::Ct>& tip_ct);

/// Letters of the picture's edges: L, R (the patient's), A, P, S, I; two for an oblique edge, the
/// nearer axis first ("AL").
struct SliceLabels {
  std::string left;
  std::string right;
  std::string top;
  std::string bottom;
};
SliceLabels labels_of(const SlicePlane& plane);

/// What a thick slice shows of the values across it.
enum class SlabMode { kMaximum, kMinimum, kMean };

struct SliceOptions {
  int width = 800;
  int height = 600;
  double mm_per_pixel = 0.5;
  double slab_mm = 0;  ///< Thickness, half to each side; 0: thin.
  SlabMode slab = SlabMode::kMaximum;
  int threads = 0;  ///< 0: all cores.
};

/// Refuses, naming the field: sizes outside [1, 16384], mm_per_pixel outside (0, 100], a slab
/// outside [0, 1000] mm, axes that are not unit and at right angles within 1e-6, NaN.
Result<void> validate(const SlicePlane& plane, const SliceOptions& options);

/// Trilinear HU at pixel centres, row by row; NaN outside the CT's box (ray_spec.hpp). A thick
/// slice combines its two ends and, along voxel planes, each of these between them, so that its
/// maximum misses no voxel; oblique ones, layers at most half the smallest spacing apart. Means
/// weigh a layer by how far it is to the next; what lies outside the CT does not count. Refuses as
/// validate().
Result<Image2d<float>> slice_values(const Volume& ct, const SlicePlane& plane,
                                    const SliceOptions& options);

/// Colour of what lies outside the CT: none that a grey value has.
inline constexpr Rgba8 kOutsideCt{24, 28, 48, 255};

/// Values as grey, outside as kOutsideCt. Grey = round(255 · clamp((HU − level) / width + ½)).
Image2d<Rgba8> to_grey(const Image2d<float>& values, const HuWindow& window);

/// CT along the plane of an ultrasound picture, thin. Pixel (column, row) shows the point of the
/// Image frame origin_mm + mm_per_pixel · (column, row). Preconditions: those of validate(), else a
/// Bug.
Image2d<Rgba8> slice_along_image(const Volume& ct,
                                 const Transform<frames::Ct, frames::Image>& ct_from_image,
                                 const Eigen::Vector2d& origin_mm, double mm_per_pixel, int width,
                                 int height, const HuWindow& window);

enum class FusionMode {
  kBlend,         ///< Share of the ultrasound.
  kCheckerboard,  ///< Squares of both in turn.
  kWipe,          ///< Ultrasound left of a line, CT right of it.
};

struct Fusion {
  FusionMode mode = FusionMode::kBlend;
  double share = 0.5;     ///< kBlend: of the ultrasound, [0, 1].
  double square_mm = 10;  ///< kCheckerboard, > 0.
  double wipe = 0.5;      ///< kWipe: share of the picture's width, [0, 1].
  /// Farther from the ultrasound plane a pixel shows CT alone, >= 0; 0.85 pixel at the least.
  double reach_mm = 0.5;
};

/// Ultrasound over a CT slice, each pixel by its own place in space: inside the true outline, with
/// the border of its state; where the slice crosses its plane steeply, a line of the border's
/// colour marks it. A stale plane shows its grey border (and line) alone, a lost one nothing:
/// neither is ever drawn as live. Refuses options out of range, and as validate().
Result<Image2d<Rgba8>> fuse(const Image2d<Rgba8>& ct_slice, const SlicePlane& plane,
                            const SliceOptions& options, const UltrasoundPlane& ultrasound,
                            const Fusion& fusion);

/// A second volume over the CT: its values along the same plane as grey, of to_grey(). Where one of
/// the two does not reach (kOutsideCt) the other is shown alone. reach_mm does not matter. Refuses
/// options out of range. Precondition: pictures of one size, otherwise a Bug.
Result<Image2d<Rgba8>> fuse(const Image2d<Rgba8>& ct_slice, const Image2d<Rgba8>& second,
                            const SliceOptions& options, const Fusion& fusion);

}  // namespace nav::render
