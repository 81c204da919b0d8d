// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "render/slices/slice.hpp"

namespace nav::render {
namespace {

// LPS: +x the patient's left, +y posterior, +z superior.
const Eigen::Vector3d kLeft = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kPosterior = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kSuperior = Eigen::Vector3d::UnitZ();

std::string label_of(const Eigen::Vector3d& direction) {
  constexpr const char* kLetters[3][2] = {{"R", "L"}, {"A", "P"}, {"I", "S"}};
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return std::abs(direction[a]) > std::abs(direction[b]); });
  std::string label;
  constexpr double kOblique = 0.26;  // 15°: a smaller angle counts as straight.
  for (int i = 0; i < 2; ++i) {
    const int axis = order[static_cast<std::size_t>(i)];
    if (i > 0 && std::abs(direction[axis]) < kOblique) break;
    label += kLetters[axis][direction[axis] > 0 ? 1 : 0];
  }
  return label;
}

}  // namespace

SlicePlane axial_slice(const Point<frames::Ct>& through_ct) {
  return {through_ct, {kLeft}, {kPosterior}};
}

SlicePlane coronal_slice(const Point<frames::Ct>& through_ct) {
  return {through_ct, {kLeft}, {-kSuperior}};
}

SlicePlane sagittal_slice(const Point<frames::Ct>& through_ct) {
  return {through_ct, {kPosterior}, {-kSuperior}};
}

SlicePlane oblique_slice(const Point<frames::Ct>& through_ct, const Direction<frames::Ct>& normal) {
  const double length = normal.v.norm();
  NAV_CHECK(std::isfinite(length) && length > 0, length);
  const Eigen::Vector3d along = normal.v / length;
  const Eigen::Vector3d size = along.cwiseAbs();
  SlicePlane plane = size.z() >= size.x() && size.z() >= size.y() ? axial_slice(through_ct)
                     : size.y() >= size.x()                       ? coronal_slice(through_ct)
                                                                  : sagittal_slice(through_ct);
  // The normal points away from the viewer, as in the slice that this one is oriented like.
  const bool towards = along.dot(plane.right.v.cross(plane.down.v)) < 0;
  const Eigen::Vector3d away = towards ? Eigen::Vector3d(-along) : along;
  plane.down.v = (plane.down.v - plane.down.v.dot(away) * away).normalized();
  plane.right.v = plane.down.v.cross(away);
  return plane;
}

SlicePlane ultrasound_slice(const Transform<frames::Ct, frames::Image>& ct_from_image,
                            const Eigen::Vector2d& centre_mm) {
  return {ct_from_image * Point<frames::Image>{{centre_mm.x(), centre_mm.y(), 0}},
          ct_from_image * Direction<frames::Image>{{1, 0, 0}},
          ct_from_image * Direction<frames::Image>{{0, 1, 0}}};
}

std::array<SlicePlane, 2> needle_slices(const Point<frames::Ct>& hub_ct,
                                        const Point<frames::Ct>& tip_ct) {
  const Eigen::Vector3d shaft = tip_ct.mm - hub_ct.mm;
  NAV_CHECK(shaft.norm() > 0, shaft.norm());
  const Eigen::Vector3d down = shaft.normalized();
  // Facing the front: the normal, right × down, is as near to posterior as the needle allows.
  constexpr double kAlongFront = 0.95;
  const Eigen::Vector3d away =
      std::abs(down.dot(kPosterior)) < kAlongFront ? kPosterior : kSuperior;
  const Eigen::Vector3d right = down.cross(away).normalized();
  const Eigen::Vector3d other = right.cross(down);
  return {SlicePlane{tip_ct, {right}, {down}}, SlicePlane{tip_ct, {other}, {down}}};
}

SliceLabels labels_of(const SlicePlane& plane) {
  return {label_of(-plane.right.v), label_of(plane.right.v), label_of(-plane.down.v),
          label_of(plane.down.v)};
}

}  // namespace nav::render
