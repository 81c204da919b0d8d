// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sim/anatomy/dual.hpp"
#include "sim/random.hpp"
#include "sim/shapes.hpp"

/// Sheets: layers thinner than the blended boundaries. Ultrasound shows them, CT does not. Private
/// to sim/. CT coordinates, mm; values of double or Dual positions.
namespace nav::sim {

/// Profile across a sheet, 1 in the middle. \p thickness_mm: full width at half maximum. Zero
/// beyond 0.92 thicknesses.
template <class S>
S sheet_profile(const S& off_mm, const S& thickness_mm) {
  constexpr double kHalfOfWidth = 0.9239;  // End of (1 - u^2)^2 if it is 1/2 at width / 2.
  const S u = off_mm / (kHalfOfWidth * thickness_mm);
  const S rest = std::max(S(1.0 - u * u), S(0.0));
  return rest * rest;
}

/// Nearest integer; constant between its steps.
template <class S>
S nearest_integer(const S& a) {
  const double v = value_of(a);
  return S(static_cast<double>(static_cast<std::int64_t>(v < 0 ? v - 0.5 : v + 0.5)));
}

/// Wave of period 1 between -1 and 1, made of parabolas; takes a fifth of the time of a sine.
template <class S>
S ripple(const S& turns) {
  using std::abs;
  const S t = turns - nearest_integer(turns);
  return t * (8.0 - 16.0 * abs(t));
}

/// Layer of a wall, parallel to its surface.
struct WallLayer {
  /// Depth of its middle below the surface of the organ (the outer surface of a wall).
  double depth_mm;
  double thickness_mm;  ///< Full width at half maximum, > 0.
  double echo;          ///< Amplitude in the middle, relative to liver.
  template <class S>
  [[nodiscard]] S echo_at(const S& organ_distance_mm) const {
    return echo * sheet_profile<S>(organ_distance_mm + depth_mm, S(thickness_mm));
  }
};

/// Septa of a muscle (perimysium): wavy sheets along its fibres, beside each other, each 0.2 to 0.5
/// mm thick and interrupted at some positions.
class Septa {
 public:
  /// \p along, \p normal: perpendicular unit vectors along the fibres and normal to the sheets. \p
  /// spacing_mm: mean spacing, > 0.
  Septa(const Vec3d& along, const Vec3d& normal, double spacing_mm, double echo,
        std::uint64_t seed);

  /// Signed distance from the nearest septum across the mean sheet, mm.
  template <class S>
  [[nodiscard]] S offset_mm(const Vec3<S>& p) const;
  /// Echo amplitude relative to liver.
  template <class S>
  [[nodiscard]] S echo(const Vec3<S>& p) const;

 private:
  /// Point in the axes of the muscle, with its nearest septum.
  template <class S>
  struct Place {
    S along, beside, off;
    std::uint64_t septum;  ///< Random bits of the septum.
  };
  template <class S>
  [[nodiscard]] Place<S> place(const Vec3<S>& p) const;
  /// Two bytes of random bits as a number in [0, 1).
  static double share(std::uint64_t bits, int which) {
    return static_cast<double>((bits >> (16 * which)) & 0xffff) * 0x1p-16;
  }

  Vec3d along_, beside_, normal_;
  double spacing_mm_, echo_;
  std::uint64_t seed_;
  std::array<double, 2> phase_{};  ///< Turns.
};

template <class S>
Septa::Place<S> Septa::place(const Vec3<S>& p) const {
  const S a = along_.cast<S>().dot(p);
  const S b = beside_.cast<S>().dot(p);
  constexpr double kLong = 0.033;  // Waves per mm along the fibres.
  const double across = 0.175 / spacing_mm_;
  const S wave = 0.22 * ripple(S(kLong * a + 0.4 * across * b + phase_[0])) +
                 0.30 * ripple(S(across * b - 0.3 * kLong * a + phase_[1]));
  const S level = normal_.cast<S>().dot(p) / S(spacing_mm_) + wave;
  const S nearest = nearest_integer(level);
  const auto index = static_cast<std::int64_t>(value_of(nearest));
  const std::uint64_t bits = hash_bits(seed_ ^ static_cast<std::uint64_t>(index));
  const double shift = 0.44 * (share(bits, 0) - 0.5);  // Uneven spacing, as a share.
  return {a, b, spacing_mm_ * (level - nearest - shift), bits};
}

template <class S>
S Septa::offset_mm(const Vec3<S>& p) const {
  return place(p).off;
}

template <class S>
S Septa::echo(const Vec3<S>& p) const {
  const Place<S> at = place(p);
  const double thickness_mm = 0.2 + 0.3 * share(at.septum, 1);
  const S profile = sheet_profile<S>(at.off, S(thickness_mm));
  if (!(value_of(profile) > 0)) return S(0.0);
  const double pieces = 0.045 + 0.04 * share(at.septum, 2);  // Per mm along the fibres.
  const S here = ripple(S(pieces * at.along + share(at.septum, 3))) +
                 ripple(S(0.32 / spacing_mm_ * at.beside + share(at.septum, 2)));
  return echo_ * (0.5 + share(at.septum, 3)) * profile * shapes::smooth_step(S(0.7 + 1.2 * here));
}

}  // namespace nav::sim
