// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/anatomy/patient.hpp"
#include "sim/error_level.hpp"
#include "sim/fault_plan.hpp"
#include "sim/motion/breathing.hpp"
#include "sim/motion/deformation.hpp"
#include "sim/motion/hand_path.hpp"
#include "sim/motion/needle_insertion.hpp"
#include "sim/motion/pressure.hpp"
#include "sim/session/moving_patient.hpp"
#include "sim/streams.hpp"
#include "sim/trackers/sensor_pose_source.hpp"
#include "sim/trackers/tracker_kind.hpp"
#include "sim/ultrasound.hpp"

namespace nav::sim {

/// Time stamps of simulated images.
struct ImageTiming {
  /// Stamped minus physical acquisition; the pairing has to correct it.
  Duration stamp_offset{0};
  Duration latency = std::chrono::milliseconds(30);  ///< Physical acquisition to reception.
};

/// Needle approach after the sweep: the hand moves to a view of the needle's planned path and holds
/// it while the needle advances from outside the patient to the target.
struct ApproachOptions {
  double pause_s = 2;     ///< Time in which the hand moves, (0, 60].
  double duration_s = 2;  ///< (0, 3600].
};

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
  /// Noise that is added to the tracker's own errors: standard deviation per axis, mm, and 0.01 rad
  /// for each mm about each axis, [0, 5].
  double tracker_noise_mm = 0;
  /// Error of the calibration: length of a shift of the images on the probe, mm, [0, 20], and of a
  /// rotation about the middle of the face, rad, [0, 0.2], each in a seeded direction.
  double calibration_mm = 0, calibration_rad = 0;
  TrackerTiming timing;
  ImageTiming image_timing;
  BreathingOptions breathing;
  /// Deformation of the tissue relative to the CT, before it breathes. The session sets its seed.
  DeformationOptions deformation;
  /// Displacement of the tissue under the face by the pressure of the probe, mm, [0,
  /// kMostPressureMm]; 0: tissue does not give way.
  double pressure_mm = 0;
  /// Tracked needle. It starts with the hand, or with the approach, and, without a speed, arrives
  /// with the last image.
  std::optional<NeedleInsertionOptions> needle;
  /// Absent: the session ends with the sweep. Without a needle of its own, an approach has a
  /// straight one that starts 30 mm outside the skin.
  std::optional<ApproachOptions> approach;
  FaultPlan pose_faults;  ///< Faults of probe, reference and needle poses, different for each.
  FaultPlan frame_faults;
};

/// Rejects invalid options; the message names the first one out of range.
Result<void> validate(const SimulatedSessionOptions& options);

/// Gives a session the errors of a whole system: its images, hand, tracker (an ideal one with
/// noise), calibration, and the delay of its images.
void set_errors(ErrorLevel level, SimulatedSessionOptions& options);

/// The procedure that Sonde demonstrates: the probe tilts over the liver, then a needle approaches
/// its target, with a hand so steady that the needle stays in the image.
SimulatedSessionOptions demonstrated_procedure(std::uint64_t seed);

enum class Phase { kSweep, kApproach };

struct PhaseInterval {
  Phase phase;
  Timestamp begin;  ///< Physical time of its first image.
  Timestamp end;    ///< Physical time of its last image.
  int first_frame;
  int frame_count;
};

/// Truth at the time of an image.
struct ImageTruth {
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
/// follows the breath. Times are physical. The hand moves from 1 s on for the duration, and then to
/// the approach if there is one. Reading is thread-safe.
class SimulatedSession {
 public:
  /// Errors: those of validate(); kUsage for an unknown family, or a patient without a free view, a
  /// free path for a needle, or a free view of that path; those of NeedleInsertion.
  static Result<SimulatedSession> create(const SimulatedSessionOptions& options);
  /// Creates a session with an existing patient; options.family and contrast are only names then.
  /// The needle of an approach follows the patient's plan if it has one, else needle_path().
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
  /// The calibration as the system knows it: probe_from_image() with the error of the options.
  [[nodiscard]] Transform<frames::Probe, frames::Image> calibration() const;
  [[nodiscard]] Transform<frames::Tracker, frames::Probe> tracker_from_probe(Timestamp time) const;
  [[nodiscard]] Transform<frames::Tracker, frames::Reference> tracker_from_reference() const;
  /// Present if and only if options().needle or options().approach is.
  [[nodiscard]] const std::optional<NeedleInsertion>& needle() const { return needle_; }
  /// Precondition: there is a needle, otherwise a Bug.
  [[nodiscard]] Transform<frames::Tracker, NeedleHub> tracker_from_hub(Timestamp time) const;

  /// The sweep and, if there is one, the approach.
  [[nodiscard]] const std::vector<PhaseInterval>& phases() const { return phases_; }
  [[nodiscard]] int frame_count() const;
  /// Physical time of an image, 0 <= index < frame_count().
  [[nodiscard]] Timestamp frame_time(int index) const;
  [[nodiscard]] ImageTruth truth(int index) const;

  /// Poses of the probe as the tracker measures them, without faults; they begin 0.5 s before the
  /// first image.
  [[nodiscard]] std::unique_ptr<PoseStream> probe_poses() const;
  [[nodiscard]] std::unique_ptr<PoseStream> reference_poses() const;
  /// Poses of the needle's hub (the body is NeedleHub). With an arm, the needle is on a second arm
  /// on the same base, with its own errors. Precondition: there is a needle, otherwise a Bug.
  [[nodiscard]] std::unique_ptr<PoseStream> needle_poses() const;
  /// Images without faults; their sequence is the index. They show the needle from its start on.
  /// The session must outlive the source.
  [[nodiscard]] std::unique_ptr<ImageStream> frames() const;

 private:
  SimulatedSession(const SimulatedSessionOptions& options, std::shared_ptr<const Anatomy> patient,
                   const Transform<frames::Ct, frames::Image>& middle,
                   std::shared_ptr<const SmoothWarp> deformation,
                   const std::optional<NeedleInsertion>& needle,
                   const std::optional<Transform<frames::Ct, frames::Image>>& approach);
  static Result<SimulatedSession> about(const SimulatedSessionOptions& options,
                                        const Patient& patient,
                                        const Transform<frames::Ct, frames::Image>& middle);
  [[nodiscard]] SensorStream stream(std::uint64_t body) const;

  SimulatedSessionOptions options_;
  std::vector<PhaseInterval> phases_;
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
