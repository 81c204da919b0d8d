// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/result.hpp"
#include "sim/trackers/tracker_sensor.hpp"

namespace nav::sim {

/// Reflecting sphere of a tracked body.
struct OpticalMarker {
  Eigen::Vector3d position_mm;                        ///< Body frame.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< Body frame; faces away from the body.
};

/// Object that hides markers behind it: a head, a hand, a lamp.
struct Obstacle {
  Eigen::Vector3d centre_mm;  ///< Tracker frame.
  double radius_mm;           ///< >= 0.
};

/// Stereo camera with two parallel sensors. Defaults: a 500 mm baseline and a volumetric error of
/// about 0.2 mm RMS at 1.5 m (manufacturers state 0.12 to 0.25 mm RMS: NDI Polaris Vega, Vicra).
struct OpticalTrackerOptions {
  double baseline_mm = 500;        ///< Distance between the sensors, > 0.
  double focal_px = 2000;          ///< > 0.
  double centroid_px = 0.04;       ///< Standard deviation of a marker's centre in one sensor, >= 0.
  double bias_mm = 0.1;            ///< RMS of the factory calibration error, a smooth field, >= 0.
  double bias_length_mm = 400;     ///< Length over which that field changes, >= 50.
  double near_mm = 950;            ///< Start of the volume along z (Polaris Vega: 950 to 2400 mm).
  double far_mm = 2400;            ///< End of the volume along z, > near.
  double half_angle_rad = 0.45;    ///< Half opening angle of the volume, (0, 1.4).
  double max_incidence_rad = 1.0;  ///< Largest angle at which a marker is visible, (0, pi].
  int min_markers = 3;             ///< >= 3.
  std::vector<OpticalMarker> markers = {{{0, 0, 0}}, {{0, 50, 0}}, {{-25, 90, 0}}, {{35, 130, 0}}};
  /// True: markers that are turned away count as hidden. False for bodies that are always mounted
  /// to face the camera.
  bool check_incidence = false;
  std::vector<Obstacle> obstacles;
  std::uint64_t seed = 1;
};

/// Rejects invalid options; the message names the first one out of range. Markers on one line are
/// rejected.
Result<void> validate(const OpticalTrackerOptions& options);

/// Computes poses from noisy markers by least squares (Umeyama 1991), like the device: the rotation
/// noise follows from the size of the body. The triangulation noise of a marker at depth z is z s /
/// (f √2) across and √2 z² s / (f b) along the viewing axis (s: centroid, f: focal length, b:
/// baseline).
class OpticalTracker final : public TrackerSensor {
 public:
  /// Precondition: validate(options), otherwise a Bug.
  explicit OpticalTracker(const OpticalTrackerOptions& options);
  [[nodiscard]] Observation observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                    std::uint64_t sample) const override;
  [[nodiscard]] const char* name() const override { return "optical"; }
  /// Standard deviations of one marker's noise at a depth, mm: across and along the viewing axis.
  [[nodiscard]] Eigen::Vector2d marker_sigma_mm(double depth_mm) const;

 private:
  [[nodiscard]] bool inside(const Eigen::Vector3d& p) const;
  [[nodiscard]] bool seen(const Eigen::Vector3d& p, const Eigen::Vector3d& normal) const;
  [[nodiscard]] Eigen::Vector3d bias(const Eigen::Vector3d& p) const;
  OpticalTrackerOptions options_;
};

}  // namespace nav::sim
