// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <sstream>

#include "render/parallel.hpp"
#include "render/slices/slice.hpp"
#include "render/spec/ray_spec_surfaces.hpp"

namespace nav::render {
namespace {

Result<void> check(const Fusion& fusion) {
  const auto reject = [](const std::string& field, const std::string& expected, double found) {
    std::ostringstream text;
    text << "fusion: " << field << ": expected " << expected << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  const auto share = [](double x) { return x >= 0 && x <= 1; };
  if (!share(fusion.share)) return reject("share", "0 to 1", fusion.share);
  if (!share(fusion.wipe)) return reject("wipe", "0 to 1", fusion.wipe);
  if (!(fusion.square_mm > 0 && fusion.square_mm < 1e6)) {
    return reject("square_mm", "a length > 0 mm", fusion.square_mm);
  }
  if (!(fusion.reach_mm >= 0)) return reject("reach_mm", "a distance >= 0 mm", fusion.reach_mm);
  return {};
}

/// Share of the ultrasound in a pixel. place: mm from the slice's centre to the right and down.
double share_at(const Fusion& fusion, const Eigen::Vector2d& place, double x_share) {
  switch (fusion.mode) {
    case FusionMode::kBlend:
      return fusion.share;
    case FusionMode::kCheckerboard: {
      const double squares =
          std::floor(place.x() / fusion.square_mm) + std::floor(place.y() / fusion.square_mm);
      return std::fmod(std::abs(squares), 2) < 0.5 ? 1 : 0;
    }
    case FusionMode::kWipe:
      return x_share < fusion.wipe ? 1 : 0;
  }
  return 0;
}

/// The band in which the ultrasound plane shows where a slice crosses it; mm off that plane.
struct Trace {
  double reach_mm;  ///< Pixels farther off show only CT.
  double line_mm;   ///< Nearer pixels have the colour of the state; negative: none has.
};

/// slope: mm off the plane per mm to the right and down in the slice.
Trace trace_of(const Eigen::Vector2d& slope, double mm_per_pixel, double reach_mm) {
  constexpr double kHalfLinePx = 0.85;  // A thinner line would have gaps.
  constexpr double kSteepSine = 0.25;   // 15°.
  constexpr double kReadablePx = 4;     // A narrower image to each side cannot be read.
  const double sine = slope.norm();
  const double line_mm = kHalfLinePx * sine * mm_per_pixel;
  const bool steep = sine > kSteepSine || reach_mm < kReadablePx * sine * mm_per_pixel;
  return {std::max(reach_mm, line_mm), steep ? line_mm : -1};
}

Rgba8 mixed(const Rgba8& ct, const Eigen::Vector3d& rgb, double share) {
  const auto mix = [share](std::uint8_t under, double over) {
    return static_cast<std::uint8_t>(std::lround((1 - share) * under + share * 255 * over));
  };
  return {mix(ct.r, rgb.x()), mix(ct.g, rgb.y()), mix(ct.b, rgb.z()), 255};
}

}  // namespace

Result<Image2d<Rgba8>> fuse(const Image2d<Rgba8>& ct_slice, const SlicePlane& plane,
                            const SliceOptions& options, const UltrasoundPlane& ultrasound,
                            const Fusion& fusion) {
  if (const auto ok = validate(plane, options); !ok) return ok.error();
  if (const auto ok = check(fusion); !ok) return ok.error();
  NAV_CHECK(ct_slice.width() == options.width && ct_slice.height() == options.height,
            ct_slice.width(), ct_slice.height());
  // Local mm are relative to the slice's centre, so that a far origin costs no digits.
  VoxelGrid about;
  about.origin_mm = plane.centre_ct.mm;
  const auto surface = spec::make_plane<double>(ultrasound, about);
  if (!surface) return ct_slice;
  const auto one_pixel = [&](const Direction<frames::Ct>& way) {
    const Eigen::Vector3d image = options.mm_per_pixel * (surface->image_from_local * way.v);
    return Eigen::Vector2d(image.head<2>());
  };
  const spec::PlanePixel<double> step{one_pixel(plane.right), one_pixel(plane.down),
                                      Eigen::Vector2d::Zero()};
  const Trace trace = trace_of({(surface->image_from_local * plane.right.v).z(),
                                (surface->image_from_local * plane.down.v).z()},
                               options.mm_per_pixel, fusion.reach_mm);
  std::vector<Rgba8> pixels(ct_slice.pixels().begin(), ct_slice.pixels().end());
  for_each_index(options.height, options.threads, [&](int row) {
    for (int column = 0; column < options.width; ++column) {
      const Eigen::Vector2d place =
          options.mm_per_pixel *
          Eigen::Vector2d(column - 0.5 * (options.width - 1), row - 0.5 * (options.height - 1));
      const Eigen::Vector3d local = place.x() * plane.right.v + place.y() * plane.down.v;
      const Eigen::Vector3d image = surface->image_from_local * (local - surface->origin);
      const double off_mm = std::abs(image.z());
      if (!(off_mm <= trace.reach_mm)) continue;
      const Eigen::Vector2d p = image.head<2>();
      const Eigen::Vector2d pixel = surface->pixel_from_mm * (p - surface->grid_origin_mm);
      const double inside = spec::depth_inside<double>(*surface, p, pixel);
      if (!(inside >= 0)) continue;
      Rgba8& out = pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(options.width) +
                          static_cast<std::size_t>(column)];
      if (off_mm <= trace.line_mm || spec::on_border<double>(*surface, p, inside, step)) {
        out = mixed(out, surface->border_rgb, 1);
      } else if (surface->shows_image) {
        const double grey = spec::image_at<double>(*surface, pixel.x(), pixel.y());
        out = mixed(out, Eigen::Vector3d::Constant(grey),
                    share_at(fusion, place, (column + 0.5) / options.width));
      }
    }
  });
  return Image2d<Rgba8>(options.width, options.height, std::move(pixels));
}

Result<Image2d<Rgba8>> fuse(const Image2d<Rgba8>& ct_slice, const Image2d<Rgba8>& second,
                            const SliceOptions& options, const Fusion& fusion) {
  if (const auto ok = check(fusion); !ok) return ok.error();
  for (const auto* image : {&ct_slice, &second}) {
    NAV_CHECK(image->width() == options.width && image->height() == options.height, image->width(),
              image->height());
  }
  std::vector<Rgba8> pixels(ct_slice.pixels().begin(), ct_slice.pixels().end());
  for_each_index(options.height, options.threads, [&](int row) {
    for (int column = 0; column < options.width; ++column) {
      const Rgba8& over = second.at(column, row);
      if (over == kOutsideCt) continue;
      const Eigen::Vector2d place =
          options.mm_per_pixel *
          Eigen::Vector2d(column - 0.5 * (options.width - 1), row - 0.5 * (options.height - 1));
      Rgba8& out = pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(options.width) +
                          static_cast<std::size_t>(column)];
      const double share =
          out == kOutsideCt ? 1 : share_at(fusion, place, (column + 0.5) / options.width);
      out = mixed(out, Eigen::Vector3d::Constant(over.r / 255.0), share);
    }
  });
  return Image2d<Rgba8>(options.width, options.height, std::move(pixels));
}

}  // namespace nav::render
