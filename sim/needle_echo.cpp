// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/needle_echo.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "sim/beam.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kRadiusMm = 0.35;  // Standard deviation of the echo across the shaft.
constexpr double kSilent = 18;      // Exponent (times -2) beyond which the echo is ignored.
constexpr double kReachMm = 1.5;    // Distance across the shaft at which kSilent is reached.

}  // namespace

NeedleEcho::NeedleEcho(const NeedleShaft& needle,
                       const Transform<frames::Ct, frames::Image>& ct_from_image,
                       const ScanGeometry& geometry, const ProbeModel& probe)
    : geometry_(geometry), probe_(probe) {
  const auto& points = needle.points_ct();
  NAV_CHECK(points.size() != 1);
  const auto image_from_ct = ct_from_image.inverse();
  double behind = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vec front = (image_from_ct * points[i]).mm;
    const Vec way = front - (image_from_ct * points[i + 1]).mm;
    const double length = way.norm();
    if (!(length > 0)) continue;  // The needle has not been inserted yet.
    pieces_.push_back({front, way / length, length, behind});
    behind += length;
  }
}

void NeedleEcho::find_nearest(const Piece& piece, const ScanLine& ray,
                              std::span<Nearest> best) const {
  const double step = geometry_.sample_mm();
  // Only the samples beside the piece receive its echo.
  const Eigen::Vector2d front = piece.front.head<2>() - ray.start;
  const Eigen::Vector2d back = front - piece.length_mm * piece.axis.head<2>();
  const auto [near, far] = std::minmax({front.dot(ray.direction), back.dot(ray.direction)});
  const double first = std::max(0.0, std::ceil((near - kReachMm) / step));
  const double last =
      std::min(static_cast<double>(best.size()) - 1, std::floor((far + kReachMm) / step));
  const double facing = 1 - std::pow(piece.axis.head<2>().dot(ray.direction), 2);
  for (double i = first; i <= last; ++i) {
    const Eigen::Vector2d p = ray.start + i * step * ray.direction;
    const Vec offset = Vec(p.x(), p.y(), 0) - piece.front;
    const double behind = std::clamp(-offset.dot(piece.axis), 0.0, piece.length_mm);
    const Vec gap = offset + behind * piece.axis;
    const double in_plane = gap.head<2>().squaredNorm() / (kRadiusMm * kRadiusMm);
    if (in_plane > kSilent) continue;
    const double exponent = in_plane + std::pow(gap.z() / elevation_half_mm(probe_, i * step), 2);
    Nearest& here = best[static_cast<std::size_t>(i)];
    if (exponent < here.exponent) here = {exponent, piece.behind_tip_mm + behind, facing};
  }
}

void NeedleEcho::add(int line, std::span<const float> left,
                     std::span<std::complex<float>> samples) const {
  if (empty()) return;
  NAV_CHECK(left.size() == samples.size(), left.size(), samples.size());
  const ScanLine ray = geometry_.line(line);
  std::vector<Nearest> best(samples.size(), Nearest{kSilent, 0, 0});
  for (const Piece& piece : pieces_) find_nearest(piece, ray, best);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Nearest& n = best[i];
    if (!(n.exponent < kSilent)) continue;
    const double tip_boost = 1 + 1.5 * std::exp(-n.behind_tip_mm * n.behind_tip_mm / 2.0);
    const double amplitude = 0.12 * tip_boost * (0.15 + n.facing * n.facing);
    samples[i] += static_cast<float>(amplitude * std::exp(-0.5 * n.exponent)) * left[i];
  }
}

}  // namespace nav::sim
