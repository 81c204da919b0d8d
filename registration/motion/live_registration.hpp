// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/lc2_cost.hpp"
#include "registration/similarity/shadow_mask.hpp"

namespace nav::registration {

/// How a registration follows a patient who moves.
struct LiveOptions {
  LevelOptions level{1.6, 11, 300, 1.0};  ///< frame_step_mm is not used.
  int window = 1;                         ///< Newest pictures that share one pose, [1, 30].
  int mask_pictures = 4;   ///< Pictures that say how bright an unshadowed echo is, [1, 30].
  int max_iterations = 5;  ///< Of each update, [1, 50].
  double ridge = 0.01;     ///< As ImageRegistrationOptions::ridge, > 0.
  /// Tissue wanders about where it lay when the CT was accepted, and returns: standard deviation
  /// along and about each axis, and time. A breath of 12 mm reaches 15 mm/s and turns a degree. >
  /// 0.
  double wander_mm = 8;
  double wander_rad = 0.02;
  double return_s = 3;
  /// Weight of a patch: this power of its contrast, [0, 3]. Flat patches are noise, which two
  /// coefficients fit better the more structure the CT has there: few pictures cannot average that
  /// pull out, and drift along the probe's path.
  double contrast_power = 1.5;
  /// Patches overlap and share speckle: so many of them count as one independent measurement. >= 1.
  double patches_per_measurement = 8;
  int threads = 1;  ///< 1 to 64; the result does not depend on it.
  ShadowMaskOptions mask;

  /// A picture whose cost is higher does not move the pose, (0, 1]. Simulated abdomens cost 0.5 at
  /// the truth; what shows another patient is acceptance before, and the distinctness.
  double max_cost = 0.75;
  /// How much better the pictures match where they are than elsewhere: 1 − cost / the least cost of
  /// the six poses so far away along the axes of the CT. Another patient's CT matches elsewhere
  /// nearly as well, whatever its cost, which depends on patient and place. A lower mean over so
  /// many pictures withdraws the registration until another is accepted
  /// (docs/experiments/registration.md: how the limit was chosen).
  double elsewhere_mm = 24;        ///< > 0, < jump_mm.
  int evidence_pictures = 60;      ///< [1, 10000].
  double min_distinctness = 0.25;  ///< [0, 1).
  int lost_after = 5;  ///< Unusable pictures in a row until the registration is lost, >= 1.
  /// The pose's mean over drift_s may be this far from the accepted one: breathing averages out to
  /// less, a patient who was moved or a reference that was knocked does not. > 0.
  double drift_mm = 8;
  double drift_s = 8;   ///< > 0; two breaths.
  double jump_mm = 30;  ///< Farther from the accepted pose than any breath goes, > drift_mm.
};

/// A refusal that names the first option out of its range.
Result<void> validate(const LiveOptions& options);

enum class LiveState {
  kFollowing,  ///< The pose is that of the newest picture.
  kHolding,    ///< The newest picture was not usable: the pose is that of an earlier one.
  kDrifted,    ///< The patient does not lie any more as when the CT was accepted.
  /// Too long without a usable picture, or too many that do not match the CT. The pose must not be
  /// shown.
  kLost,
};
const char* to_string(LiveState state);

/// What one picture did.
struct LiveUpdate {
  Pose ct_from_reference;  ///< Follows the tissue; not the accepted registration.
  LiveState state;
  std::string cause;            ///< One sentence unless following.
  double cost;                  ///< Of the window at the pose, [0, 1]; 1 when not usable.
  double predicted_rms_mm;      ///< At the middle of the picture, from the filter's covariance.
  double displacement_mm;       ///< From the accepted pose, RMS over the picture.
  double mean_displacement_mm;  ///< Of the mean pose over drift_s.
  double distinctness;          ///< Over the evidence; NaN before there is enough.
  int patches;
  int iterations;
};

/// Refines a registration with each new picture: an iterated extended Kalman filter on the pose (an
/// Ornstein–Uhlenbeck process about the accepted one), whose measurement is the LC² of the newest
/// pictures against the CT. The accepted registration stays what the drift alarm compares with.
/// Memory is bounded by the window. Not thread-safe. Pictures of convex probes need the outline of
/// their sector (with_outline()): with columns taken for beams a patient's own CT costs 0.05 more.
class LiveRegistration {
 public:
  /// ct: the channels of the level (sigma 0.75 sample steps), as make_ct_channels() gives them.
  /// accepted: a registration that decide() accepted. Precondition: ct. Errors: validate().
  static Result<LiveRegistration> create(std::shared_ptr<const CtChannels> ct, const Pose& accepted,
                                         const LiveOptions& options);
  /// Takes in a picture in order of acquisition; one that is not later than the last is refused
  /// (kUsage). kMalformedData: geometry that cannot be. Never throws for what a picture shows.
  Result<LiveUpdate> update(const TrackedFrame& picture);
  [[nodiscard]] const Pose& accepted() const { return accepted_; }
  /// A new accepted registration; forgets the alarm.
  void accept(const Pose& pose);

 private:
  struct Picture {
    TrackedFrame tracked;
    PatchSet patches;
  };
  struct Solution {
    Pose pose;
    double cost;
    Matrix6d information;  ///< Scaled twist about the centre.
    int iterations;
    bool finite;
  };
  LiveRegistration(std::shared_ptr<const CtChannels> ct, const Pose& accepted,
                   const LiveOptions& options);
  Result<PatchSet> patches_of(const TrackedFrame& picture) const;
  [[nodiscard]] PatchSet window_patches() const;
  [[nodiscard]] Solution solve(const PatchSet& patches, const Eigen::Vector3d& centre,
                               const Matrix6d& prior) const;
  void predict(Timestamp now, const Eigen::Vector3d& centre);
  void weigh(const PatchSet& patches, const Solution& found);
  void judge(LiveUpdate& update, const TrackedFrame& picture);

  std::shared_ptr<const CtChannels> ct_;
  Pose accepted_;
  LiveOptions options_;
  Pose pose_;
  Matrix6d covariance_ = Matrix6d::Identity();  ///< Of the scaled twist about centre_ct_, mm².
  Eigen::Vector3d centre_ct_ = Eigen::Vector3d::Zero();
  std::optional<Timestamp> newest_;
  std::deque<Picture> window_;
  Vector6d mean_twist_ = Vector6d::Zero();  ///< From the accepted pose, low-pass, about its place.
  std::optional<Eigen::Vector3d> mean_centre_ct_;
  int unusable_ = 0;
  /// Of every kWeighEvery-th picture, over at most evidence_pictures.
  std::deque<double> distinctness_;
  double mean_distinctness_ = 0;     ///< NaN before there is enough.
  int unweighed_ = 0;                ///< Usable pictures since the last of them.
  std::optional<double> withdrawn_;  ///< The distinctness that the registration was withdrawn for.
};

}  // namespace nav::registration
