// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/streams.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/fault_plan.hpp"
#include "sim/motion/breathing.hpp"
#include "sim/motion/deformation.hpp"
#include "sim/motion/hand_path.hpp"
#include "sim/motion/needle_insertion.hpp"
#include "sim/session/moving_patient.hpp"
#include "sim/tracker_model.hpp"
#include "sim/trackers/sensor_pose_source.hpp"
#include "sim/ultrasound.hpp"

namespace nav::sim {

enum class TrackerKind { kIdeal, kOptical, kElectromagnetic, kArm };

/// Stable lower-case name ("optical"), and back; kUsage for a name that is none.
const char* to_string(TrackerKind kind);
Result<TrackerKind> tracker_kind_from(std::string_view name);

struct SimulatedSessionOptions {
  std::string family = "abdomen";  ///< Of patient_families().
  std::uint64_t seed = 1;          ///< Anatomy, room, hand, breath, noise.
  /// Of the CT; absent: only with a patient that is already there, whose CT has its own.
  std::optional<Contrast> contrast = Contrast::kPortal;
  HandPathOptions path;  ///< begin, end and seeds are set by the session.
  double duration_s = 4;
  double frame_rate_hz = 15;
  ProbeModel probe = convex_abdominal();
  /// Held as the family's first standard view says, unless its face would lose the skin at one
  /// side (kMostLeanRad); else where the way to the targets is free.
  bool standard_view = false;
  TrackerKind tracker = TrackerKind::kOptical;
  TrackerTiming timing;
  ImageTiming image_timing;
  BreathingOptions breathing;
  /// Of the tissue against the CT, before it breathes; the seed is set by the session.
  DeformationOptions deformation;
  /// A tracked needle that begins with the hand and, without a speed, arrives with the last
  /// picture.
  std::optional<NeedleInsertionOptions> needle;
  FaultPlan pose_faults;  ///< Of probe, reference and needle, each in its own way.
  FaultPlan frame_faults;
};

/// A refusal that names the first option out of range.
Result<void> validate(const SimulatedSessionOptions& options);

/// What was true when a picture was taken.
struct FrameTruth {
  Timestamp physical;
  /// Where the probe held the picture, patient axes, as the reference body sees it.
  Transform<frames::Ct, frames::Image> ct_from_image;
  RestView rest;  ///< The same in the patient as the CT shows him: at rest, undeformed.
  BreathingState breathing;
  std::shared_ptr<const Warp> warp;   ///< Of the patient at that moment. Never null.
  std::optional<NeedleTruth> needle;  ///< If there is one: in the room, as ct_from_image.
};

/// A patient who breathes and may lie deformed, a hand that leads a probe, a tracker that errs:
/// ordinary sources on the session clock, and the truth about them. The reference body stays still,
/// and so does the line that a needle is pushed along: it does not ride on the breath. Times are
/// physical; the hand and the needle move from 1 s on for the duration. Thread-safe to read.
class SimulatedSession {
 public:
  /// Errors: those of validate(); kUsage for a family that does not exist, or a patient in whom no
  /// free view, or no free way for a needle, was found; those of NeedleInsertion.
  static Result<SimulatedSession> create(const SimulatedSessionOptions& options);
  /// Of a patient that is already there; options.family and contrast are only names then.
  static Result<SimulatedSession> create(const SimulatedSessionOptions& options,
                                         const Patient& patient);

  [[nodiscard]] const SimulatedSessionOptions& options() const { return options_; }
  [[nodiscard]] const Anatomy& patient() const { return *patient_; }
  [[nodiscard]] const Breathing& breathing() const { return breathing_; }
  /// How the tissue lies at the end of expiration against the CT; null: as in it.
  [[nodiscard]] std::shared_ptr<const SmoothWarp> deformation() const { return deformation_; }
  /// The patient at a time, as a map of the patient in the CT. Never null.
  [[nodiscard]] std::shared_ptr<const Warp> warp(Timestamp time) const;
  /// Whether the tissue lies as in the CT all the time.
  [[nodiscard]] bool undeformed() const;
  /// Of the pictures.
  [[nodiscard]] PixelGrid grid() const { return ultrasound_.grid(); }
  [[nodiscard]] const Transform<frames::Ct, frames::Reference>& ct_from_reference() const {
    return ct_from_reference_;
  }
  [[nodiscard]] const Transform<frames::Probe, frames::Image>& probe_from_image() const {
    return probe_from_image_;
  }
  [[nodiscard]] Transform<frames::Tracker, frames::Probe> tracker_from_probe(Timestamp time) const;
  [[nodiscard]] Transform<frames::Tracker, frames::Reference> tracker_from_reference() const;
  /// Absent when options().needle is.
  [[nodiscard]] const std::optional<NeedleInsertion>& needle() const { return needle_; }
  /// Precondition: there is a needle, otherwise a Bug.
  [[nodiscard]] Transform<frames::Tracker, NeedleHub> tracker_from_hub(Timestamp time) const;

  [[nodiscard]] int frame_count() const;
  /// Physical time of a picture, 0 <= index < frame_count().
  [[nodiscard]] Timestamp frame_time(int index) const;
  [[nodiscard]] FrameTruth truth(int index) const;

  /// Poses as the tracker gives them, before any fault; begin 0.5 s before the first picture.
  [[nodiscard]] std::unique_ptr<PoseStream> probe_poses() const;
  [[nodiscard]] std::unique_ptr<PoseStream> reference_poses() const;
  /// Of the needle's hub (the body is NeedleHub). An arm's needle hangs on a second arm with errors
  /// of its own on the same base. Precondition: there is a needle, otherwise a Bug.
  [[nodiscard]] std::unique_ptr<PoseStream> needle_poses() const;
  /// Pictures, before any fault; their sequence is the index. The session must outlive the source.
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
