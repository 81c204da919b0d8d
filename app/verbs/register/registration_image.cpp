// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/registration_image.hpp"

#include <cmath>

#include "app/views/plane_view.hpp"

namespace nav::app {
namespace {

constexpr int kImagePanel = 400;
constexpr int kSquareMm = 12;

void draw_checkerboard(render::Canvas& canvas, const PlaneView& view, const Volume& ct,
                       const TrackedImage& frame,
                       const Transform<frames::Ct, frames::Reference>& ct_from_reference,
                       const render::HuWindow& window) {
  const auto slice =
      render::slice_along_image(ct, ct_from_reference * frame.reference_from_image, view.origin_mm,
                                view.mm_per_px, view.width, view.height, window);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const Eigen::Vector2d p = view.point_of(x, y);
      const double echo = intensity(frame.frame, p);
      if (echo < 0) continue;
      const long square =
          std::lround(std::floor(p.x() / kSquareMm)) + std::lround(std::floor(p.y() / kSquareMm));
      const bool show_ct = square % 2 == 0;
      const auto grey = static_cast<std::uint8_t>(std::lround(echo));
      canvas.set(view.x + x, view.y + y, show_ct ? slice.at(x, y) : Rgba8{grey, grey, grey, 255});
    }
  }
}

}  // namespace

Image2d<Rgba8> registration_image(const Volume& ct, const TrackedImage& frame,
                                  const Transform<frames::Ct, frames::Reference>& before,
                                  const Transform<frames::Ct, frames::Reference>& after,
                                  bool accepted, const render::HuWindow& window) {
  render::Canvas canvas(3 * kImagePanel, kImagePanel, render::rgb8(0x101418));
  const auto view = [&](int column) {
    return fit(frame.frame, column * kImagePanel, 24, kImagePanel, kImagePanel - 24);
  };
  draw_ultrasound(canvas, view(0), frame.frame);
  draw_checkerboard(canvas, view(1), ct, frame, before, window);
  draw_checkerboard(canvas, view(2), ct, frame, after, window);
  const Rgba8 words = render::rgb8(0xd8dee4);
  canvas.text(8, 20, 15, "Ultrasound", words);
  canvas.text(kImagePanel + 8, 20, 15, "with CT, before registration", words);
  canvas.text(2 * kImagePanel + 8, 20, 15,
              accepted ? "with CT, after registration" : "with CT, registration refused",
              accepted ? words : render::rgb8(0xe04040));
  return canvas.image();
}

}  // namespace nav::app
