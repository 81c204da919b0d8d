// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "registration/image_registration.hpp"
#include "registration/motion/image_motion.hpp"
#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/patches.hpp"
#include "registration/similarity/sweep_points.hpp"

namespace nav::registration {

/// Sigma of the Gaussian that smooths the ultrasound and the CT for samples this far apart, mm.
constexpr double sigma_of(double sample_step_mm) { return 0.75 * sample_step_mm; }

/// The channels of a CT on all levels, ready for every registration to it. Copies share the
/// channels; thread-safe to read.
class PreparedCt {
 public:
  /// Prepares the whole CT. Errors: those of validate(options) and make_ct_channels().
  static Result<PreparedCt> create(const Volume& ct, const ImageRegistrationOptions& options);

  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  /// One entry for each level of the options that it was made with.
  [[nodiscard]] const std::vector<std::shared_ptr<const CtChannels>>& levels() const {
    return levels_;
  }
  /// Sample steps of the levels, mm; a prepared sweep must have the same ones.
  [[nodiscard]] const std::vector<double>& sample_steps_mm() const { return steps_; }

 private:
  VoxelGrid grid_;
  std::string name_;
  std::vector<std::shared_ptr<const CtChannels>> levels_;
  std::vector<double> steps_;
};

/// The patches of one level of a sweep.
struct PreparedLevel {
  std::size_t index;  ///< Index of the level in the options.
  LevelOptions options;
  PatchSet patches;
  double seconds;  ///< Wall time of its preparation.
};

/// The part of a sweep's preparation that depends neither on the CT nor on the pose: masks and
/// patches on all levels. Thread-safe to read.
class PreparedSweep {
 public:
  /// keep_going: asked before every level; false ends with kCancelled. Errors: kUsage (options),
  /// kMalformedData (sweep geometry), kRefused (too few patches on the finest level).
  static Result<PreparedSweep> create(const Sweep& sweep, const ImageRegistrationOptions& options,
                                      Diagnostics& diagnostics,
                                      const std::function<bool()>& keep_going = {});

  [[nodiscard]] const SweepPoints& points() const { return points_; }
  /// Levels from coarse to fine; levels whose patches do not fit into the ultrasound images are
  /// missing.
  [[nodiscard]] const std::vector<PreparedLevel>& levels() const { return levels_; }
  [[nodiscard]] const std::vector<double>& sample_steps_mm() const { return steps_; }
  /// Motions of the ultrasound images that Patch::frame indexes.
  [[nodiscard]] const std::vector<ImageMotion>& motions() const { return motions_; }
  /// Motions of all recorded ultrasound images.
  [[nodiscard]] const std::vector<ImageMotion>& path() const { return path_; }

 private:
  SweepPoints points_;
  std::vector<ImageMotion> motions_, path_;
  std::vector<PreparedLevel> levels_;
  std::vector<double> steps_;
};

/// Distance that a solve from a start near the minimum may travel, mm: the margin around the sweep.
inline constexpr double kNearTravelMm = 12;

/// The part of the CT that a registration from this start can reach, its random poses included.
CtBox reachable_box(const PreparedSweep& sweep,
                    const Transform<frames::Ct, frames::Reference>& initial,
                    const ImageRegistrationOptions& options);

/// register_sweep() with the repeated work done before. Preparations whose levels differ from those
/// of the options are a Bug.
Result<ImageRegistrationResult> register_prepared(
    const PreparedCt& ct, const PreparedSweep& sweep,
    const Transform<frames::Ct, frames::Reference>& initial,
    const ImageRegistrationOptions& options,
    const std::function<bool(double fraction)>& progress = {});

/// register_sweep() for a prepared sweep and a CT that is used once: every level prepares only the
/// part of the CT that the poses of the level before can reach. Additional errors: those of
/// make_ct_channels().
Result<ImageRegistrationResult> register_prepared(
    const Volume& ct, const PreparedSweep& sweep,
    const Transform<frames::Ct, frames::Reference>& initial,
    const ImageRegistrationOptions& options,
    const std::function<bool(double fraction)>& progress = {});

}  // namespace nav::registration
