// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/moving_patient.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "nav/matrices.hpp"

namespace nav::sim {

RestView rest_view(const Warp& warp, const Transform<frames::Ct, frames::Image>& ct_from_image,
                   const PixelGrid& grid, int width, int height) {
  constexpr int kSide = 7;
  Eigen::Matrix3Xd image(3, kSide * kSide);
  Eigen::Matrix3Xd rest(3, kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i) {
    const double column = (width - 1.0) * (i % kSide) / (kSide - 1);
    const double row = (height - 1.0) * (i / kSide) / (kSide - 1);
    const Point<frames::Image> p = grid.at(column, row);
    image.col(i) = p.mm;
    rest.col(i) = warp.invert((ct_from_image * p).mm);
  }
  const Eigen::Matrix4d fit = rigid_fit(image, rest);
  const Eigen::Quaterniond turn(Eigen::Matrix3d(fit.topLeftCorner<3, 3>()));
  const Transform<frames::Ct, frames::Image> pose(turn.normalized(), fit.topRightCorner<3, 1>());
  double square = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    square += ((pose * Point<frames::Image>{image.col(i)}).mm - rest.col(i)).squaredNorm();
  }
  return {pose, std::sqrt(square / (kSide * kSide))};
}

}  // namespace nav::sim
