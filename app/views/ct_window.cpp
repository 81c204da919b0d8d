// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/ct_window.hpp"

#include "render/default_window.hpp"

namespace nav::app {

std::vector<float> values_along(const StoredVolume& ct,
                                const Transform<frames::Ct, frames::Image>& ct_from_image,
                                const Eigen::AlignedBox2d& image_mm) {
  constexpr int kAcross = 24;
  std::vector<float> values;
  for (int row = 0; row < kAcross; ++row) {
    for (int column = 0; column < kAcross; ++column) {
      const Eigen::Vector2d share = (Eigen::Vector2d(column, row).array() + 0.5) / kAcross;
      const Eigen::Vector2d p = image_mm.min() + share.cwiseProduct(image_mm.sizes());
      const auto hu = ct.sample(ct_from_image * Point<frames::Image>{{p.x(), p.y(), 0}});
      if (hu) values.push_back(static_cast<float>(*hu));
    }
  }
  return values;
}

std::vector<float> values_along(const StoredVolume& ct,
                                const Transform<frames::Ct, frames::Image>& ct_from_image,
                                const UltrasoundImage& image) {
  Eigen::AlignedBox2d box(image.grid.at(0, 0).mm.head<2>());
  box.extend(image.grid.at(image.pixels.width() - 1, image.pixels.height() - 1).mm.head<2>());
  return values_along(ct, ct_from_image, box);
}

std::vector<float> values_along(const StoredVolume& ct,
                                const Transform<frames::Ct, frames::Reference>& ct_from_reference,
                                std::span<const TrackedImage> images) {
  std::vector<float> values;
  for (const TrackedImage& image : images) {
    const auto some = values_along(ct, ct_from_reference * image.reference_from_image, image.frame);
    values.insert(values.end(), some.begin(), some.end());
  }
  return values;
}

render::HuWindow ct_window(const SessionConfig::View& said, const StoredVolume& ct,
                           std::span<const float> shown) {
  if (said.window_level && said.window_width) return {*said.window_level, *said.window_width};
  const render::HuWindow usual = render::default_window(ct, shown);
  return {said.window_level.value_or(usual.level), said.window_width.value_or(usual.width)};
}

}  // namespace nav::app
