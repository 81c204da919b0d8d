// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "nav/result.hpp"

namespace nav::sim {

enum class ProbeKind {
  kLinear,
  kConvex,
  kSector  ///< Phased array: all lines start at the centre of a small flat face.
};

/// Method by which echoes are computed.
enum class AcousticModel {
  kRays,       ///< Along scan lines: impedance steps with a law of incidence, speckle on a lattice.
  kScatterers  ///< Points and mirrors with phase, projected and convolved (scatterer_model.hpp).
};

/// Geometry and settings of a transducer and its image.
struct ProbeModel {
  ProbeKind kind = ProbeKind::kConvex;
  double width_mm = 38;         ///< Linear: length of the face.
  double radius_mm = 60;        ///< Convex: radius of the face.
  double half_angle_rad = 0.5;  ///< Convex, sector: half of the opening angle of the field.
  double depth_mm = 140;        ///< Depth from the face.
  double frequency_mhz = 3.5;
  int columns = 400;  ///< Columns of the image.
  int rows = 280;     ///< Rows of the image.
  int lines = 192;    ///< Scan lines.
  double focus_mm = 80;
  double lateral_fwhm_mm = 1.6;     ///< Beam width at the focus.
  double elevation_fwhm_mm = 3.0;   ///< Slice thickness at the focus.
  double dynamic_range_db = 60;     ///< Difference between black and white.
  double liver_level_db = -33;      ///< Mean level of liver, relative to white.
  double noise_level_db = -104;     ///< Electronic noise before depth gain, relative to white.
  double tgc_db_per_cm_mhz = 0.55;  ///< Attenuation that the depth gain assumes, one way.
  double tgc_error_db = 2.0;        ///< Peak error of the operator's depth gain.
  double gain_db = 0;               ///< Overall gain.
  double clutter_level_db = -300;   ///< Haze at the face, relative to white; -300: none.
  double clutter_mm = 12;           ///< Depth over which the haze falls by 8.7 dB.
  double reverberation = 0;         ///< Amplitude reflected by the face, [0, 1).
  /// Amplitude of what returns from gas after its echo (dirty shadow), relative to that echo, dB;
  /// it falls with the depth below the gas. -300: none, a black shadow.
  double gas_haze_db = -300;
  /// Every tissue has its own speed of sound, so that echoes are shown above or below their true
  /// depth. False: the speed that the scanner assumes, everywhere.
  bool layered_speed = false;
  double sound_speed = 1;   ///< Speed that the scanner assumes, over the usual 1540 m/s.
  int looks = 1;            ///< Number of independent speckle patterns whose power is averaged.
  double persistence = 0;   ///< Share of the previous image in the next one, [0, 0.95].
  double stand_off_mm = 0;  ///< Thickness of a gel pad between face and skin; 0: none.
  bool marker_on_other_side = false;  ///< The image is mirrored, as if the probe were held wrongly.
  AcousticModel model = AcousticModel::kRays;
};

/// Convex probe: 66 degrees, 60 mm radius, 140 mm deep, 3.5 MHz, 400 x 280 pixels.
ProbeModel convex_abdominal();
/// Linear probe: 38 mm wide, 60 mm deep, 9 MHz.
ProbeModel linear_l14();

/// Phased array: 5 MHz, 80 degrees, 100 mm deep; intraoperative, through a craniotomy.
ProbeModel sector_cranial();

/// Probe by its name (convex, linear, sector); rejects other names with the list.
Result<ProbeModel> probe_model_from(std::string_view name);

/// Acoustic model by its name (rays, scatterers); rejects other names with the list.
Result<AcousticModel> acoustic_model_from(std::string_view name);

/// Least distance of a needle's entry from the middle of the face: beside the housing.
double beside_probe_mm(const ProbeModel& probe);

/// Rejects an invalid probe; the message names the first invalid setting.
Result<void> validate(const ProbeModel& probe);

}  // namespace nav::sim
