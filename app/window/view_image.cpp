// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/view_image.hpp"

#include <QPainter>
#include <algorithm>
#include <cmath>
#include <vector>

#include "render/quality/progressive.hpp"

namespace nav::app {
namespace {

constexpr int kBeats = 12;
constexpr int kBeatRadius = 7;
constexpr int kBeatMargin = 14;

template <class T, class Bytes>
QImage converted(const Image2d<T>& image, const Bytes& bytes) {
  QImage out(image.width(), image.height(), QImage::Format_RGB32);
  const T* from = image.pixels().data();
  for (int y = 0; y < image.height(); ++y) {
    auto* to = reinterpret_cast<QRgb*>(out.scanLine(y));
    for (int x = 0; x < image.width(); ++x) *to++ = bytes(*from++);
  }
  return out;
}

/// round(255 · clamp(x, 0, 1)) without the slow library call: x is in [0, 255.5), and the float
/// just below .5 is not rounded up by the sum.
unsigned byte_of(float x) {
  const float scaled = 255.0F * std::clamp(x, 0.0F, 1.0F);
  const auto whole = static_cast<unsigned>(scaled);
  return whole + (scaled - static_cast<float>(whole) >= 0.5F ? 1U : 0U);
}

}  // namespace

QImage to_rgb32(const Image2d<Rgba8>& image) {
  return converted(image, [](const Rgba8& p) {
    return 0xff000000U | static_cast<unsigned>(p.r) << 16 | static_cast<unsigned>(p.g) << 8 | p.b;
  });
}

QImage to_rgb32(const Image2d<RgbaF>& image) {
  return converted(image, [](const RgbaF& p) {
    return 0xff000000U | byte_of(p.r) << 16 | byte_of(p.g) << 8 | byte_of(p.b);
  });
}

QImage to_rgb32(const Image2d<RgbaF>& image, PixelSize size) {
  if (image.width() == size.width && image.height() == size.height) return to_rgb32(image);
  const render::EnlargedRows rows(image, size.width, size.height);
  std::vector<RgbaF> between;
  std::vector<RgbaF> row(static_cast<std::size_t>(size.width));
  QImage out(size.width, size.height, QImage::Format_RGB32);
  for (int y = 0; y < size.height; ++y) {
    rows.write(y, between, row.data());
    auto* to = reinterpret_cast<QRgb*>(out.scanLine(y));
    for (const RgbaF& p : row) {
      *to++ = 0xff000000U | byte_of(p.r) << 16 | byte_of(p.g) << 8 | byte_of(p.b);
    }
  }
  return out;
}

void draw_heartbeat(QImage& image, std::uint64_t beat) {
  QPainter painter(&image);
  painter.setRenderHint(QPainter::Antialiasing);
  const QPointF centre(image.width() - kBeatMargin, image.height() - kBeatMargin);
  painter.setPen(QPen(QColor(0x5a, 0x66, 0x70), 1));
  painter.drawEllipse(centre, kBeatRadius, kBeatRadius);
  const double angle = 2 * M_PI * static_cast<double>(beat % kBeats) / kBeats;
  painter.setPen(Qt::NoPen);
  painter.setBrush(QColor(0xd8, 0xde, 0xe4));
  painter.drawEllipse(centre + kBeatRadius * QPointF(std::sin(angle), -std::cos(angle)), 2.5, 2.5);
}

}  // namespace nav::app
