// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "app/views/panels.hpp"
#include "render/canvas.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// Slices of the CT that a user moves: three along the patient's axes, and two along the needle.
enum class SliceKind { kAxial, kCoronal, kSagittal, kNeedleFirst, kNeedleSecond };

/// Zoom and shift of one slice, as its user set them.
struct SliceZoom {
  double factor = 1;                                   ///< 1: the whole CT fits; in [0.25, 64].
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  ///< Moves the centre: right, down.
};

/// Position of a slice in the CT and on the screen.
struct SliceGeometry {
  render::SlicePlane plane;
  double mm_per_px = 1;
  PixelSize size{1, 1};

  /// Point of the CT at a position of the image, pixels from its upper left corner.
  [[nodiscard]] Point<frames::Ct> point_at(const Eigen::Vector2d& pixel) const;
  /// Position of a point of the CT in the image, pixels, and its distance behind the slice, mm.
  [[nodiscard]] Eigen::Vector3d pixel_of(const Point<frames::Ct>& point_ct) const;
};

/// Everything that one slice needs beside the epoch.
struct SliceRequest {
  SliceKind kind = SliceKind::kAxial;
  PixelSize size{1, 1};  ///< Device pixels.
  double ratio = 1;      ///< Device pixels of a pixel of the screen: widths of lines.
  Point<frames::Ct> cursor{Eigen::Vector3d::Zero()};  ///< The orthogonal slices lie through it.
  SliceZoom zoom{};
};

/// The geometry of a slice. Needle slices lie through the tip, which is in their middle; absent
/// for them while the needle is neither valid nor degraded.
std::optional<SliceGeometry> slice_geometry(const PanelContext& context,
                                            const SliceRequest& request);

/// The point nearest to a point that lies in the CT's box.
Point<frames::Ct> within_ct(const VoxelGrid& grid, const Point<frames::Ct>& point_ct);

/// A point moved across an orthogonal slice by a number of slices, each as thick as the voxels in
/// that direction: to the patient's head, front or right for positive numbers. It stays in the CT.
Point<frames::Ct> stepped(const VoxelGrid& grid, SliceKind kind, const Point<frames::Ct>& point_ct,
                          double slices);

/// Grey window after a drag over an image, as a share of its height: right is wider, up is
/// brighter.
render::HuWindow dragged_window(const render::HuWindow& window, const Eigen::Vector2d& drag);

/// One slice without text.
struct SliceDrawing {
  Image2d<Rgba8> image;
  std::optional<SliceGeometry> geometry;  ///< Absent: nothing is shown.
};

/// Draws slices of the CT with the line in which the live ultrasound plane cuts them, the needle,
/// the target and the planned path: solid where it lies in the slice, its projection dashed. Keeps
/// the last CT slice, which is drawn again only when it has changed. A plane that is stale or lost
/// has no line. Not thread-safe; one for each view.
class SliceDrawer {
 public:
  SliceDrawing draw(const PanelContext& context, const SliceRequest& request);
  /// CT slices that were sampled, for tests.
  [[nodiscard]] int sampled() const { return sampled_; }

 private:
  struct Key {
    StoredVolume ct;  ///< Shares its voxels, so that no other CT can have their address.
    SliceGeometry geometry;
    render::HuWindow window;
  };
  [[nodiscard]] bool is_kept(const Key& key) const;

  std::optional<Key> key_;
  Image2d<Rgba8> kept_;
  int sampled_ = 0;
};

/// The segment in which an ultrasound image cuts a slice, pixels of the slice; absent when it does
/// not. The image's outline is not regarded.
std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> trace_of(
    const UltrasoundImage& frame, const Transform<frames::Ct, frames::Image>& ct_from_image,
    const SliceGeometry& geometry);

}  // namespace nav::app
