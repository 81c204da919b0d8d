// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/anatomy/patient.hpp"
#include "sim/fault_plan.hpp"
#include "sim/motion/breathing.hpp"
#include "sim/motion/deformation.hpp"
#include "sim/motion/hand_path.hpp"
#include "sim/motion/needle_insertion.hpp"
#include "sim/session/moving_patient.hpp"
#include "sim/streams.hpp"
#include "sim/tracker_model.hpp"
#include "sim/trackers/sensor_pose_source.hpp"
#include "sim/ultrasound.hpp"

namespace nav::sim {

enum class TrackerKind { kIdeal, kOptical, kElectromagnetic, kArm };

/// Stable lower-case name ("optical"), and its inverse; kUsage for an unknown name.
const char* to_string(TrackerKind kind);
Result<TrackerKind> tracker_kind_from(std::string_view name);

struct SimulatedSessionOptions {
  std::string family = "abdomen";  ///< One of patient_families().
  std::uint64_t seed = 1;          ///< Seed of anatomy, operating room, hand, breath, noise.
  /// Contrast of the CT. Absent: only for an existing patient, whose CT has its own.
  std::optional<Contrast> contrast = Contrast::kPortal;
  HandPathOptions path;  ///< begin, end and seeds are set by the session.
  double duration_s = 4;
  double frame_rate_hz = 15;
  ProbeModel probe = convex_abdominal();
  /// True: the probe is held as in the family's first standard view, unless its face would lose the
  /// skin at one side (kMostLeanRad). False: where the path to the targets is free.
  bool standard_view = false;
  TrackerKind tracker = TrackerKind::kOptical;
  TrackerTiming timing;
  ImageTiming image_timing;
  BreathingOptions breathing;
  /// Deformation of the tissue relative to the CT, before it breathes. The session sets its seed.
  DeformationOptions deformation;
  /// Tracked needle. It starts with the hand and, without a speed, arrives with the last image.
  std::optional<NeedleInsertionOptions> needle;
  FaultPlan pose_faults;  ///< Faults of probe, reference and needle poses, different for each.
  FaultPlan frame_faults;
};

/// Rejects invalid options; the message names the first one out of range.
Result<void> validate(const SimulatedSessionOptions& options);

/// Truth at the time of an image.
struct FrameTruth {
  Timestamp physical;
  /// Pose of the image held by the probe, patient axes, relative to the reference body.
  Transform<frames::Ct, frames::Image> ct_from_image;
  RestView rest;  ///< Pose in the patient of the CT: at rest, undeformed.
  BreathingState breathing;
  std::shared_ptr<const Warp> warp;     ///< Motion of the patient at that time. Never null.
  std::optional<NeedleTruth> needle{};  ///< Relative to the reference, if present.
};

/// Simulated session: a patient who breathes and may be deformed, a hand that moves a probe, a
/// tracker with errors. It provides ordinary sources on the session clock, and their truth. The
/// reference body does not move, nor does the line along which a needle is inserted: neither
/// follows the breath. Times are physical. The hand and the needle move from 1 s on for the
/// duration. Reading is thread-safe.
class SimulatedSession {
 public:
  /// Errors: those of validate(); kUsage for an unknown family, or a patient without a free view or
  /// a free path for a needle; those of NeedleInsertion.
  static Result<SimulatedSession> create(const SimulatedSessionOptions& options);
  /// Creates a session with an existing patient; options.family and contrast are only names then.
  static Result<SimulatedSession> create(const SimulatedSessionOptions& options,
                                         const Patient& patient);

  [[nodiscard]] const SimulatedSessionOptions& options() const { return options_; }
  [[nodiscard]] const Anatomy& patient() const { return *patient_; }
  [[nodiscard]] const Breathing& breathing() const { return breathing_; }
  /// Deformation of the tissue relative to the CT at the end of expiration; null: none.
  [[nodiscard]] std::shared_ptr<const SmoothWarp> deformation() const { return deformation_; }
  /// Motion of the patient at a time, as a map of the patient in the CT. Never null.
  [[nodiscard]] std::shared_ptr<const Warp> warp(Timestamp time) const;
  /// True when the tissue is always as in the CT.
  [[nodiscard]] bool undeformed() const;
  /// Pixel grid of the images.
  [[nodiscard]] PixelGrid grid() const { return ultrasound_.grid(); }
  [[nodiscard]] const Transform<frames::Ct, frames::Reference>& ct_from_reference() const {
    return ct_from_reference_;
  }
  [[nodiscard]] const Transform<frames::Probe, frames::Image>& probe_from_image() const {
    return probe_from_image_;
  }
  [[nodiscard]] Transform<frames::Tracker, frames::Probe> tracker_from_probe(Timestamp time) const;
  [[nodiscard]] Transform<frames::Tracker, frames::Reference> tracker_from_reference() const;
  /// Present if and only if options().needle is.
  [[nodiscard]] const std::optional<NeedleInsertion>& needle() const { return needle_; }
  /// Precondition: there is a needle, otherwise a Bug.
  [[nodiscard]] Transform<frames::Tracker, NeedleHub> tracker_from_hub(Timestamp time) const;

  [[nodiscard]] int frame_count() const;
  /// Physical time of an image, 0 <= index < frame_count().
  [[nodiscard]] Timestamp frame_time(int index) const;
  [[nodiscard]] FrameTruth truth(int index) const;

  /// Poses of the probe as the tracker measures them, without faults; they begin 0.5 s before the
  /// first image.
  [[nodiscard]] std::unique_ptr<PoseStream> probe_poses() const;
  [[nodiscard]] std::unique_ptr<PoseStream> reference_poses() const;
  /// Poses of the needle's hub (the body is NeedleHub). With an arm, the needle is on a second arm
  /// on the same base, with its own errors. Precondition: there is a needle, otherwise a Bug.
  [[nodiscard]] std::unique_ptr<PoseStream> needle_poses() const;
  /// Images without faults; their sequence is the index. The session must outlive the source.
  [[nodiscard]] std::unique_ptr<ImageStream> frames() const;

 private:
  SimulatedSession(const SimulatedSessionOptions& options, std::shared_ptr<const Anatomy> patient,
                   const Transform<frames::Ct, frames::Image>& middle,
                   std::shared_ptr<const SmoothWarp> deformation,
                   const std::optional<NeedleInsertion>& needle);
  static Result<SimulatedSession> about(const SimulatedSessionOptions& options,
                                        const std::shared_ptr<const Anatomy>& patient,
                                        const Transform<frames::Ct, frames::Image>& middle);
  [[nodiscard]] SensorStream stream(std::uint64_t body) const;

  SimulatedSessionOptions options_;
  std::shared_ptr<const Anatomy> patient_;
  Breathing breathing_;
  std::shared_ptr<const SmoothWarp> deformation_;  ///< Null: none.
  HandPath path_;
  UltrasoundSimulator ultrasound_;
  std::shared_ptr<const TrackerSensor> sensor_;
  Transform<frames::Ct, frames::Reference> ct_from_reference_;
  Transform<frames::Probe, frames::Image> probe_from_image_;
  Transform<frames::Tracker, frames::Ct> tracker_from_ct_;
  std::optional<NeedleInsertion> needle_;
};

}  // namespace nav::sim
