// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "nav/ultrasound_frame.hpp"
#include "sim/abdomen_phantom.hpp"

namespace nav::sim {

enum class ProbeKind { kLinear, kConvex };

/// Geometry and settings of a transducer with its picture.
struct ProbeModel {
  ProbeKind kind = ProbeKind::kConvex;
  double width_mm = 38;         ///< Linear: length of the face.
  double radius_mm = 60;        ///< Convex: radius of the face.
  double half_angle_rad = 0.5;  ///< Convex: half of the field's opening.
  double depth_mm = 140;        ///< From the face.
  double frequency_mhz = 3.5;
  int columns = 400;  ///< Of the picture.
  int rows = 280;     ///< Of the picture.
  int lines = 192;    ///< Scan lines.
  double focus_mm = 80;
  double lateral_fwhm_mm = 1.6;     ///< Beam width at the focus.
  double elevation_fwhm_mm = 3.0;   ///< Slice thickness at the focus.
  double dynamic_range_db = 60;     ///< Black to white.
  double liver_level_db = -33;      ///< Mean liver, relative to white.
  double noise_level_db = -104;     ///< Electronic noise before depth gain, relative to white.
  double tgc_db_per_cm_mhz = 0.55;  ///< Attenuation that the depth gain assumes, one way.
  double tgc_error_db = 2.0;        ///< How far the operator's sliders are off, peak.
};

/// 66 degrees, 60 mm radius, 140 mm deep, 3.5 MHz, 400 x 280 pixels.
ProbeModel convex_abdominal();
/// 38 mm wide, 60 mm deep, 9 MHz.
ProbeModel linear_l14();

/// A refusal that names the first setting that cannot be.
Result<void> validate(const ProbeModel& probe);

/// Envelope signal: scan lines x samples, one line after the other.
struct ScanLineImage {
  int lines = 0;
  int samples = 0;
  double sample_mm = 0;  ///< Between samples; sample 0 lies on the face.
  std::vector<float> amplitude;
  [[nodiscard]] float at(int line, int sample) const {
    return amplitude[static_cast<std::size_t>(line) * static_cast<std::size_t>(samples) +
                     static_cast<std::size_t>(sample)];
  }
};

/// B-mode pictures of the phantom: attenuation per tissue with an imperfect depth gain, echoes of
/// interfaces (impedance step times incidence), fully developed speckle that sticks to the tissue,
/// beam and slice width, shadows of bone and gas, log compression, scan conversion. The same bytes
/// for any number of threads; simulate() is thread-safe.
class UltrasoundSimulator {
 public:
  /// Precondition: validate(probe), otherwise a Bug.
  UltrasoundSimulator(const AbdomenPhantom& phantom, const ProbeModel& probe, std::uint64_t seed);
  ~UltrasoundSimulator();
  UltrasoundSimulator(UltrasoundSimulator&&) noexcept;
  UltrasoundSimulator& operator=(UltrasoundSimulator&&) noexcept;

  /// One picture. received is set to acquired; sequence also seeds the electronic noise.
  /// needle: where a needle lies (shaft from the tip along -z), if there is one to be seen.
  [[nodiscard]] UltrasoundFrame simulate(
      const Transform<frames::Ct, frames::Image>& ct_from_image, Timestamp acquired,
      std::uint64_t sequence,
      const std::optional<Transform<frames::Ct, frames::Needle>>& ct_from_needle = {}) const;
  /// Envelope after depth gain and noise, before log compression; 1 is white.
  [[nodiscard]] ScanLineImage envelope(
      const Transform<frames::Ct, frames::Image>& ct_from_image, std::uint64_t sequence,
      const std::optional<Transform<frames::Ct, frames::Needle>>& ct_from_needle = {}) const;

  [[nodiscard]] const ProbeModel& probe() const;
  [[nodiscard]] PixelGrid grid() const;
  /// Absent for a linear probe.
  [[nodiscard]] std::optional<SectorOutline> outline() const;

 private:
  struct Tables;
  std::unique_ptr<const Tables> tables_;
};

}  // namespace nav::sim
