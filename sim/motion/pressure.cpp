// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/pressure.hpp"

#include <cmath>

#include "nav/check.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

/// A warp whose coordinates are those of the image.
class WarpOfImage final : public Warp {
 public:
  WarpOfImage(SmoothWarp warp, const Transform<frames::Ct, frames::Image>& ct_from_image)
      : warp_(std::move(warp)), ct_(ct_from_image), image_(ct_from_image.inverse()) {}
  [[nodiscard]] Vec apply(const Vec& rest) const override { return ct(warp_.apply(image(rest))); }
  [[nodiscard]] Eigen::Matrix3d jacobian(const Vec& rest) const override {
    const Eigen::Matrix3d turn = ct_.rotation().toRotationMatrix();
    return turn * warp_.jacobian(image(rest)) * turn.transpose();
  }
  [[nodiscard]] Vec invert(const Vec& now) const override { return ct(warp_.invert(image(now))); }

 private:
  [[nodiscard]] Vec image(const Vec& p) const { return (image_ * Point<frames::Ct>{p}).mm; }
  [[nodiscard]] Vec ct(const Vec& p) const { return (ct_ * Point<frames::Image>{p}).mm; }

  SmoothWarp warp_;
  Transform<frames::Ct, frames::Image> ct_;
  Transform<frames::Image, frames::Ct> image_;
};

double face_width_mm(const ProbeModel& probe) {
  if (probe.kind == ProbeKind::kLinear) return probe.width_mm;
  if (probe.kind == ProbeKind::kConvex) return 2 * probe.radius_mm * std::sin(probe.half_angle_rad);
  constexpr double kSmallFaceMm = 20;
  return kSmallFaceMm;
}

}  // namespace

std::shared_ptr<const Warp> pressed_by(const Transform<frames::Ct, frames::Image>& ct_from_image,
                                       const ProbeModel& probe, double pressure_mm) {
  NAV_CHECK(pressure_mm > 0 && pressure_mm <= kMostPressureMm, pressure_mm);
  constexpr double kDepthMm = 25;
  constexpr double kAcrossMm = 15;
  // The skin, which is now at the face, was there at rest.
  const WarpBump bump{
      .centre_mm = {0, -pressure_mm, 0},
      .sigma_mm = {std::max(0.6 * face_width_mm(probe), kAcrossMm), kDepthMm, kAcrossMm},
      .peak_mm = {0, pressure_mm, 0}};
  auto warp = SmoothWarp::create({bump});
  NAV_CHECK(warp.has_value());
  return std::make_shared<WarpOfImage>(std::move(*warp), ct_from_image);
}

}  // namespace nav::sim
