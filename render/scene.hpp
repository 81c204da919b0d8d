// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "nav/safety.hpp"
#include "nav/ultrasound_image.hpp"
#include "nav/volume.hpp"
#include "render/predicates/predicate_scene.hpp"
#include "render/transfer/transfer_function.hpp"

namespace nav::render {

/// The view of the scene. Right-handed: x right, y up, looking along -z of the view.
struct Camera {
  Point<frames::Ct> eye_ct;
  Point<frames::Ct> look_at_ct;
  Direction<frames::Ct> up_ct;    ///< Not parallel to the view; need not be orthogonal.
  double vertical_fov_rad = 0.5;  ///< Perspective, in (0, pi).
  bool orthographic = false;
  double orthographic_height_mm = 300;  ///< Height of the image when orthographic.
};

enum class ShadingStyle {
  kPhong,  ///< Blinn–Phong with a headlight at the eye.
  kGooch,  ///< Cool to warm (Gooch et al. 1998), lit from the upper left of the image, with
           ///< darkened silhouettes.
};

/// Shading by the central-difference gradient at one voxel of Scene::gradient_source or the CT,
/// weighted by importance.
struct Shading {
  bool enabled = true;  ///< false: no gradient is ever fetched.
  ShadingStyle style = ShadingStyle::kPhong;
  /// E of Burns et al. 2007 §3.2, [0, 1]: the shading of a sample of importance I has the weight
  /// 1 - E (1 - I). A weight of 0 fetches no gradient.
  double emphasis = 0;
  /// Gradient from which a sample is fully shaded, HU/mm, > 0. Below it the shading is in
  /// proportion to the gradient, so that homogeneous tissue stays unshaded and does not show noise
  /// as facets. For values of another scale: rescaled().
  double full_gradient_per_mm = 10;
  double ambient = 0.3;
  double diffuse = 0.7;
  double specular = 0.2;
  double shininess = 20;
  double cool_share = 0.25;  ///< Gooch: share of the own colour in the cool tone, [0, 1].
  double warm_share = 0.6;   ///< Gooch: share of it in the warm tone, [0, 1].
  double silhouette = 0.7;   ///< Gooch: darkening of surfaces seen edge-on, [0, 1]; 0: none.
};

/// Rejects numbers that are not finite or out of range, and names the field as shading.NAME.
Result<void> validate(const Shading& shading);

/// The live ultrasound image inside the CT. Its state decides how it is drawn: valid and degraded
/// show the image with a green or amber border; stale shows only a grey border; lost shows nothing.
struct UltrasoundPlane {
  UltrasoundImage frame;
  Transform<frames::Ct, frames::Image> ct_from_image;
  double opacity = 1.0;  ///< Opacity of the whole image, (0, 1].
  Safety safety;
};

/// A straight needle, drawn as an opaque capsule. Ghosted (40 % opacity) when stale, absent when
/// lost.
struct NeedleShape {
  Point<frames::Ct> tip_ct;
  Point<frames::Ct> hub_ct;
  double radius_mm = 0.8;
  Eigen::Vector3d rgb{0.95, 0.95, 1.0};
  Safety safety{};
};

/// A sphere: target lesion, entry point or margin.
struct SphereShape {
  Point<frames::Ct> centre_ct;
  double radius_mm = 5;
  Eigen::Vector3d rgb{1.0, 0.8, 0.1};
  double opacity = 1.0;  ///< Opacity of the front surface, (0, 1].
};

/// A straight line of some thickness: the planned path.
struct LineShape {
  Point<frames::Ct> from_ct;
  Point<frames::Ct> to_ct;
  double radius_mm = 0.5;
  Eigen::Vector3d rgb{0.2, 0.7, 1.0};
  double opacity = 1.0;  ///< Opacity of the front surface, (0, 1].
};

/// A flat object of interest: a simple polygon of 3 to 256 vertices in order, or a segment of 2.
/// The vertices must lie in one plane within 0.01 mm.
struct PolygonObject {
  std::vector<Point<frames::Ct>> vertices_ct;
};

/// A box: its centre, and three half edges from the centre to the middles of three faces.
struct BoxObject {
  Point<frames::Ct> centre_ct;
  Eigen::Matrix3d half_edges_ct;  ///< Columns, mm; at right angles to each other.
};

/// Triangles of any surface, for example a segmented organ. Immutable once shared.
struct MeshObject {
  std::vector<Point<frames::Ct>> vertices_ct;
  std::vector<std::array<int, 3>> triangles;
};

/// Contextual cutaway (Burns et al. 2007 §3.3 and §3.4): material between the eye and the objects
/// of interest fades by its importance. Regions along a ray, from the back: base (nothing fades),
/// transition (between the surfaces of theta2 and theta1), overlay (overlay_mm in front of the
/// surface of theta1), clear (only importance 1 is left). ray_spec_cutaway.hpp has the equations. A
/// simple cutaway has theta1 = theta2 and overlay_mm = 0.
struct Cutaway {
  double theta1_rad = 30 * M_PI / 180;  ///< Angle of the inner surface around the ray, (0, pi/2).
  double theta2_rad = 50 * M_PI / 180;  ///< Angle of the outer surface, [theta1, pi/2).
  double overlay_mm = 15;               ///< d, along the ray, >= 0; infinity: no clear region.
  /// Constant thresholds tau of Burns et al. 2007 §3.4 in place of those by importance: a sample of
  /// any importance is whole up to the occlusion `lower`, 0 from `upper` on, and fades linearly in
  /// between. [0, 1], lower < upper.
  struct Thresholds {
    double lower = 0;
    double upper = 1;
  };
  std::optional<Thresholds> constant{};
  bool around_plane = true;     ///< Cut by the ultrasound image's true outline, if drawn.
  bool around_needle = false;   ///< Cut by the needle, if it is drawn.
  bool around_spheres = false;  ///< Cut by target, margin and entry point.
  std::vector<PolygonObject> polygons;
  std::vector<BoxObject> boxes;
  std::vector<std::shared_ptr<const MeshObject>> meshes;
};

/// The values of the volume that a ray shows. With kMaximum, kMinimum and kMean the grey window
/// decides, surfaces lie over the image whatever their depth, and there is no cutaway.
enum class Projection {
  kComposite,  ///< Colours and opacities by the transfer function.
  kMaximum,    ///< Maximum intensity projection (MIP).
  kMinimum,
  kMean,
};

/// The values that are shown as black to white.
struct GreyWindow {
  double level_hu = 200;
  double width_hu = 1200;  ///< > 0.
};

enum class Classification {
  kPreIntegrated,   ///< Mean over the values between the ends of a cell: second order.
  kPostClassified,  ///< Value at the middle of a cell. Always used with gradient windows.
};

/// Trades run time against error.
struct Quality {
  double step_voxels = 0.5;  ///< Length of a cell in units of the smallest spacing.
  Classification classification = Classification::kPreIntegrated;
  double opaque_at = 0.996;       ///< Early ray termination at this opacity; 1: never.
  bool skip_empty_bricks = true;  ///< Gives the same bits on and off.
  bool jitter = false;            ///< Shifts each ray's cells by a fixed pseudo-random part of one.
  /// [0, 1]. > 0: a pixel takes the mean of the rays around it if they differ by no more than this
  /// in any channel, see sparse_rays.hpp. 0: every pixel has its own ray. The reference engine
  /// ignores it.
  double pixel_error = 0;
  /// An image by predicates may show only every second or fourth voxel while an engine prepares
  /// what the predicate set reads. It then sets RenderStatistics::provisional, and the scene
  /// becomes complete when it is rendered again. This flag does not count as a change of the scene.
  bool provisional = false;
};

/// A 3D ultrasound volume inside the CT, drawn by predicates: ray_spec.hpp, "Two volumes".
struct UltrasoundVolume {
  std::shared_ptr<const StoredVolume> volume;  ///< Required. Its grid lies in the CT frame.
  PredicateScene predicates;
  /// Importance of the CT beside it: an impact, [0, 1024], limited to the greatest impact of the
  /// model. 1: as much as a predicate of average importance; what is more important shines through
  /// the CT, and what is less important hides nothing of it. 0: everything that the predicates show
  /// shines through.
  double ct_importance = 1;
};

/// Everything that an image shows, without how it is drawn. A plain value.
struct Scene {
  /// Required: the CT, or 3D ultrasound that is drawn alone by its predicates.
  std::shared_ptr<const StoredVolume> ct;
  TransferFunction transfer;
  Shading shading{};
  std::optional<UltrasoundPlane> plane{};
  std::optional<NeedleShape> needle{};
  std::vector<SphereShape> spheres{};
  Camera camera{};
  Quality quality{};
  Eigen::Vector3d background_rgb{0, 0, 0};
  int width = 800;
  int height = 600;
  std::vector<LineShape> lines{};
  std::optional<Cutaway> cutaway{};  ///< Costs nothing when absent or without a drawn object.
  Projection projection = Projection::kComposite;
  GreyWindow grey{};  ///< Used by projections other than kComposite.
  /// If present, they classify the volume instead of transfer and shading.
  std::optional<PredicateScene> predicates{};
  /// A second volume. Costs nothing when absent. Not allowed together with predicates. Projections
  /// other than kComposite leave it out.
  std::optional<UltrasoundVolume> ultrasound{};
  /// Volume, on the grid of the CT, whose gradients shade samples and open gradient windows:
  /// shading_source.hpp. Null: the CT itself. Not used by predicates.
  std::shared_ptr<const StoredVolume> gradient_source{};
};

/// Checks a scene and names the field that it rejects: no CT, image sizes outside [1, 16384], a
/// degenerate camera, NaN anywhere, steps outside [1/64, 16], a plane whose grid is invalid,
/// theta1 > theta2, angles outside (0, pi/2), a negative overlay, polygons that are not flat;
/// a gradient_source on another grid; whatever validate(PredicateScene) rejects; ultrasound without
/// a volume, ultrasound beside predicates of the CT, or a ct_importance outside its range.
Result<void> validate(const Scene& scene);

}  // namespace nav::render
