// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/slice_planes.hpp"

#include <algorithm>
#include <array>
#include <sstream>

#include "app/views/plane_view.hpp"
#include "nav/positions.hpp"

namespace nav::app {
namespace {

constexpr const char* kAxial = "axial";
constexpr const char* kCoronal = "coronal";
constexpr const char* kSagittal = "sagittal";
constexpr const char* kOblique = "oblique";
constexpr const char* kUltrasoundPlane = "ultrasound";
constexpr std::array<const char*, 2> kNeedle{"needle-1", "needle-2"};
constexpr std::array<const char*, 2> kPath{"path-1", "path-2"};

using Vec3 = Eigen::Vector3d;
using Needle = std::array<Point<frames::Ct>, 2>;  ///< Hub and tip, or entry and target.

Error rejected_plane(const std::string& option, const std::string& expected, const Vec3& found) {
  std::ostringstream text;
  text << option << ": expected " << expected << ", found " << found.transpose();
  return {ErrorCode::kUsage, text.str()};
}

/// Error for a point outside the CT; absent for a point inside.
std::optional<Error> outside(const std::string& option, const std::string& point, const Volume& ct,
                             const Vec3& p) {
  const VoxelGrid& grid = ct.grid();
  const Vec3 half = 0.5 * grid.extent_mm();
  const Vec3 from_centre = grid.directions.transpose() * (p - grid.centre().mm);
  if ((from_centre.cwiseAbs().array() <= half.array()).all()) return std::nullopt;
  const Vec3 reach = grid.directions.cwiseAbs() * half;
  std::ostringstream text;
  text << point << " inside the CT, " << (grid.centre().mm - reach).transpose() << " to "
       << (grid.centre().mm + reach).transpose() << " mm";
  return rejected_plane(option, text.str(), p);
}

/// Scale, mm per pixel, at which the CT's box fits into an image around the plane's centre.
double fitted(const VoxelGrid& grid, const render::SlicePlane& plane, int size_px) {
  const Vec3 half = 0.5 * grid.extent_mm();
  const Vec3 centre = grid.centre().mm - plane.centre_ct.mm;
  double reach_mm = 0;
  for (const Vec3& axis : {plane.right.v, plane.down.v}) {
    const double box = (grid.directions.transpose() * axis).cwiseAbs().dot(half);
    reach_mm = std::max(reach_mm, std::abs(centre.dot(axis)) + box);
  }
  return 2 * reach_mm / size_px;
}

Result<render::SlicePlane> oblique(const SlicesOptions& options, const Point<frames::Ct>& at) {
  const auto usable = [](const Vec3& v) { return v.allFinite() && v.norm() > 1e-9; };
  if (options.normal_ct) {
    if (!usable(*options.normal_ct)) {
      return rejected_plane("--normal", "a direction, finite and not zero", *options.normal_ct);
    }
    return render::oblique_slice(at, {*options.normal_ct});
  }
  for (const auto& [option, v] :
       {std::pair("--right", *options.right_ct), {"--down", *options.down_ct}}) {
    if (!usable(v)) return rejected_plane(option, "a direction, finite and not zero", v);
  }
  const Vec3 right = options.right_ct->normalized();
  const Vec3 down = options.down_ct->normalized();
  const Vec3 square = down - down.dot(right) * right;
  constexpr double kLeastSine = 0.01;  // Below this, rounding of the numbers turns the plane.
  if (!(square.norm() > kLeastSine)) {
    return rejected_plane("--down", "a direction other than --right", *options.down_ct);
  }
  return render::SlicePlane{at, {right}, {square.normalized()}};
}

/// Needle of the options, else of the recording; absent when neither has one.
Result<std::optional<Needle>> needle_of(const SlicesOptions& options, const Volume& ct,
                                        const std::optional<PlacedImage>& image) {
  if (options.needle_ct) {
    const Vec3 tip = options.needle_ct->head<3>();
    const Vec3 hub = options.needle_ct->tail<3>();
    if (!is_place(hub) || !((tip - hub).norm() > 1e-3)) {
      return rejected_plane("--needle", "a tip and a hub apart from each other, within 1e7 mm",
                            hub);
    }
    if (auto error = outside("--needle", "a tip", ct, tip)) return *error;
    return std::optional(Needle{{{hub}, {tip}}});
  }
  if (!image || !image->ct_from_needle) return std::optional<Needle>();
  constexpr double kLengthMm = 150;  // A recording does not contain the needle's length.
  const auto tip = *image->ct_from_needle * Point<frames::Needle>{{0, 0, 0}};
  if (auto error = outside("--needle-frame", "a tip", ct, tip.mm)) return *error;
  return std::optional(
      Needle{*image->ct_from_needle * Point<frames::Needle>{{0, 0, -kLengthMm}}, tip});
}

}  // namespace

std::vector<std::string> slice_names() {
  return {kAxial,     kCoronal, kSagittal, kOblique,        kNeedle[0],
          kNeedle[1], kPath[0], kPath[1],  kUltrasoundPlane};
}

Result<std::vector<NamedPlane>> slice_planes(const SlicesOptions& options,
                                             const std::optional<NeedlePlan>& plan,
                                             const Volume& ct,
                                             const std::optional<PlacedImage>& image) {
  const auto needle = needle_of(options, ct, image);
  if (!needle) return needle.error();
  if (plan) {
    if (auto error = outside("plan.target_mm", "a target", ct, plan->target_ct.mm)) return *error;
  }
  Point<frames::Ct> at = ct.grid().centre();
  std::optional<render::SlicePlane> along;
  if (image) {
    const auto& pixels = image->plane.frame.pixels;
    const auto middle =
        image->plane.frame.grid.at(0.5 * (pixels.width() - 1), 0.5 * (pixels.height() - 1));
    along = render::ultrasound_slice(image->plane.ct_from_image, middle.mm.head<2>());
  }
  if (options.at_ct) {
    if (auto error = outside("--at", "a point", ct, *options.at_ct)) return *error;
    at = {*options.at_ct};
  } else if (along) {
    at = along->centre_ct;
    if (auto error = outside("--frame", "an image whose middle lies", ct, at.mm)) return *error;
  } else if (*needle) {
    at = (**needle)[1];
  } else if (plan) {
    at = plan->target_ct;
  }
  const auto scale = [&](const render::SlicePlane& plane) {
    return options.mm_per_pixel > 0 ? options.mm_per_pixel
                                    : fitted(ct.grid(), plane, options.size_px);
  };
  std::vector<NamedPlane> planes{{kAxial, render::axial_slice(at), 0},
                                 {kCoronal, render::coronal_slice(at), 0},
                                 {kSagittal, render::sagittal_slice(at), 0}};
  // One common scale, so that the slices can be compared.
  double common = 0;
  for (const NamedPlane& slice : planes) common = std::max(common, scale(slice.plane));
  for (NamedPlane& slice : planes) slice.mm_per_pixel = common;
  if (options.normal_ct || options.right_ct) {
    const auto plane = oblique(options, at);
    if (!plane) return plane.error();
    planes.push_back({kOblique, *plane, scale(*plane)});
  }
  const auto add_along = [&](const std::array<const char*, 2>& names, const Needle& line) {
    const auto two = render::needle_slices(line[0], line[1]);
    for (std::size_t i = 0; i < 2; ++i) planes.push_back({names[i], two[i], scale(two[i]), line});
  };
  if (*needle) add_along(kNeedle, **needle);
  if (plan) add_along(kPath, {plan->entry_ct, plan->target_ct});
  if (along) {
    const double fits = extent_mm(image->plane.frame) / options.size_px;
    planes.push_back(
        {kUltrasoundPlane, *along, options.mm_per_pixel > 0 ? options.mm_per_pixel : fits});
  }
  return planes;
}

}  // namespace nav::app
