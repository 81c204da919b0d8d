// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/result.hpp"
#include "sim/trackers/tracker_sensor.hpp"

namespace nav::sim {

/// Piece of metal near the field: displacement peak_mm / (1 + (d / radius)²)^(3/2). It falls with
/// the third power of the distance d, like the field of an induced dipole.
struct FieldDistorter {
  Eigen::Vector3d centre_mm;  ///< Tracker frame.
  Eigen::Vector3d peak_mm;    ///< Displacement at the centre.
  double radius_mm;           ///< > 0.
};

/// Field generator with small sensors. Defaults: in the middle of the volume about the 0.5 mm and
/// 0.3 degrees RMS that manufacturers state (NDI Aurora). The noise grows with the fourth power of
/// the distance: a dipole's field falls with the third, and the position follows from its slope
/// (Franz et al. 2014, IEEE Trans. Med. Imaging 33).
struct ElectromagneticTrackerOptions {
  double noise_mm = 0.12;             ///< Along each axis up to reference_mm, >= 0.
  double noise_rad = 0.0015;          ///< About each axis up to reference_mm, >= 0.
  double reference_mm = 300;          ///< Distance beyond which the noise grows, > 0.
  double near_mm = 50, far_mm = 550;  ///< Limits of the volume along z.
  double half_width_mm = 250;         ///< Half width of the volume along x and y, > 0.
  std::vector<FieldDistorter> distorters = {{{220, -150, 420}, {1.2, -0.8, 1.6}, 180},
                                            {{-260, 200, 300}, {-0.7, 0.9, 0.5}, 200}};
  std::uint64_t seed = 1;
};

/// Rejects invalid options; the message names the first one out of range. A field that folds is
/// rejected.
Result<void> validate(const ElectromagneticTrackerOptions& options);

/// Measured pose: the truth displaced by the distortion and rotated by half its curl, plus noise.
class ElectromagneticTracker final : public TrackerSensor {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit ElectromagneticTracker(const ElectromagneticTrackerOptions& options);
  [[nodiscard]] Observation observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                    std::uint64_t sample) const override;
  [[nodiscard]] const char* name() const override { return "electromagnetic"; }
  /// Systematic error of a position, mm.
  [[nodiscard]] Eigen::Vector3d distortion_mm(const Eigen::Vector3d& p) const;
  /// Derivative of distortion_mm(), closed form.
  [[nodiscard]] Eigen::Matrix3d distortion_jacobian(const Eigen::Vector3d& p) const;
  /// Systematic error of an orientation: half the curl of the distortion, rad.
  [[nodiscard]] Eigen::Vector3d distortion_rad(const Eigen::Vector3d& p) const;
  /// Factor of the noise at a distance from the generator, >= 1.
  [[nodiscard]] double noise_growth(double distance_mm) const;

 private:
  ElectromagneticTrackerOptions options_;
};

}  // namespace nav::sim
