// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "nav/pose.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/tracker_model.hpp"
#include "sim/ultrasound.hpp"

namespace nav::sim {

struct ProcedureOptions {
  std::uint64_t seed = 1;  ///< Seed of anatomy, operating room, hand tremor and noise.
  Contrast contrast = Contrast::kPortal;
  int sweep_frames = 60;     ///< Number of images, >= 2.
  int approach_frames = 40;  ///< Number of images, >= 2.
  double frame_rate_hz = 20;
  double tremor_mm = 0.3;     ///< Amplitude of the hand's tremor.
  double tremor_rad = 0.004;  ///< Amplitude of the rotation by the tremor.
  ProbeModel probe = convex_abdominal();
  TrackerModel tracker;
  ImageTiming image_timing;
};

enum class Phase { kSweep, kApproach };

struct PhaseInterval {
  Phase phase;
  Timestamp begin;  ///< Physical time of its first image.
  Timestamp end;    ///< Physical time of its last image.
  int first_frame;
  int frame_count;
};

/// Simulated intervention on the session clock: a freehand sweep over the liver, then a needle that
/// advances to the lesion under in-plane ultrasound. All values are the truth, without noise. Times
/// are physical times; nothing moves before the first and after the last image. Reading is
/// thread-safe.
class Procedure {
 public:
  /// Precondition: options are within their ranges, otherwise a Bug.
  explicit Procedure(const ProcedureOptions& options);

  [[nodiscard]] const ProcedureOptions& options() const { return options_; }
  [[nodiscard]] const AbdomenPhantom& phantom() const { return phantom_; }
  [[nodiscard]] const NeedlePlan& plan() const { return plan_; }

  [[nodiscard]] const Transform<frames::Ct, frames::Reference>& ct_from_reference() const {
    return ct_from_reference_;
  }
  [[nodiscard]] const Transform<frames::Probe, frames::Image>& probe_from_image() const {
    return probe_from_image_;
  }
  [[nodiscard]] Transform<frames::Ct, frames::Image> ct_from_image(Timestamp time) const;
  [[nodiscard]] Transform<frames::Ct, frames::Needle> ct_from_needle(Timestamp time) const;
  [[nodiscard]] Transform<frames::Tracker, frames::Probe> tracker_from_probe(Timestamp time) const;
  [[nodiscard]] Transform<frames::Tracker, frames::Reference> tracker_from_reference(
      Timestamp time) const;
  [[nodiscard]] Transform<frames::Tracker, frames::Needle> tracker_from_needle(
      Timestamp time) const;

  [[nodiscard]] const std::vector<PhaseInterval>& phases() const { return phases_; }
  [[nodiscard]] int frame_count() const;
  /// Physical time of an image, 0 <= index < frame_count().
  [[nodiscard]] Timestamp frame_time(int index) const;
  [[nodiscard]] Timestamp end() const;

 private:
  ProcedureOptions options_;
  AbdomenPhantom phantom_;
  NeedlePlan plan_;
  Transform<frames::Ct, frames::Reference> ct_from_reference_;
  Transform<frames::Tracker, frames::Reference> tracker_from_reference_;
  Transform<frames::Probe, frames::Image> probe_from_image_;
  Transform<frames::Ct, frames::Image> approach_view_;
  std::vector<PhaseInterval> phases_;
};

}  // namespace nav::sim
