// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/shadow_mask.hpp"
#include "registration/similarity/similarity_cost.hpp"

namespace nav::registration {

/// Options of a registration that follows a patient who moves.
struct LiveOptions {
  LevelOptions level{1.6, 11, 300, 1.0};  ///< frame_step_mm is not used.
  int window = 1;  ///< Number of newest ultrasound images that share one pose, [1, 30].
  /// Ultrasound images that tell the brightness of an unshadowed echo, [1, 30].
  int mask_images = 4;
  int max_iterations = 5;  ///< Limit for each update, [1, 50].
  double ridge = 0.01;     ///< See ImageRegistrationOptions::ridge, > 0.
  /// The tissue is modelled as wandering about its position at the time of acceptance and returning
  /// to it: standard deviation along and about each axis, and time constant. A breath of 12 mm
  /// reaches 15 mm/s and rotates by a degree. > 0.
  double wander_mm = 8;
  double wander_rad = 0.02;
  double return_s = 3;
  /// Weight of a patch: this power of its contrast, [0, 3]. Flat patches contain noise, which two
  /// coefficients fit better the more structure the CT has there. A few images cannot average out
  /// this bias, and the pose would drift along the path of the probe.
  double contrast_power = 1.5;
  /// Number of patches that count as one independent measurement, because patches overlap and share
  /// speckle. >= 1.
  double patches_per_measurement = 8;
  int threads = 1;  ///< 1 to 64; the result does not depend on it.
  ShadowMaskOptions mask;

  /// An ultrasound image whose cost is higher does not move the pose, (0, 1]. Simulated abdomens
  /// cost 0.5 at the true pose. This limit does not detect another patient: the earlier acceptance
  /// and the distinctness do.
  double max_cost = 0.75;
  /// Distance of the six comparison poses along the axes of the CT. The distinctness is 1 − cost /
  /// the least cost of these poses. Another patient's CT matches elsewhere nearly as well, whatever
  /// its cost, which depends on the patient and the anatomy. If the mean distinctness over
  /// evidence_images is below min_distinctness, the registration is withdrawn until another is
  /// accepted (docs/registration-experiments.md explains how the limit was chosen).
  double elsewhere_mm = 24;        ///< > 0, < jump_mm.
  int evidence_images = 60;        ///< [1, 10000].
  double min_distinctness = 0.25;  ///< [0, 1).
  /// Unusable ultrasound images in a row until the registration is lost, >= 1.
  int lost_after = 5;
  /// Distance that the mean pose over drift_s may have from the accepted pose. Breathing averages
  /// out to less; a patient who was moved or a reference that was knocked does not. > 0.
  double drift_mm = 8;
  double drift_s = 8;   ///< > 0; two breaths.
  double jump_mm = 30;  ///< Distance from the accepted pose that no breath exceeds, > drift_mm.
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const LiveOptions& options);

enum class LiveState {
  kFollowing,  ///< The pose is that of the newest ultrasound image.
  kHolding,    ///< The newest ultrasound image is not usable: the pose is that of an earlier one.
  kDrifted,    ///< The patient no longer lies as at the time of acceptance.
  /// No usable ultrasound image for too long, or too many that do not match the CT. The pose must
  /// not be shown.
  kLost,
};
const char* to_string(LiveState state);

/// The result of one ultrasound image.
struct LiveUpdate {
  Pose ct_from_reference;  ///< Pose that follows the tissue; not the accepted registration.
  LiveState state;
  std::string cause{};  ///< One sentence; empty while following.
  double cost;          ///< Cost of the window at the pose, [0, 1]; 1 if not usable.
  /// Predicted error in the middle of the image, from the filter's covariance.
  double predicted_rms_mm = 0;
  double displacement_mm = 0;       ///< Distance from the accepted pose, RMS over the image.
  double mean_displacement_mm = 0;  ///< Distance of the mean pose over drift_s.
  double distinctness = 0;          ///< Mean over the evidence; NaN until there is enough.
  int patches;
  int iterations = 0;
};

/// Refines a registration with each new ultrasound image. It is an iterated extended Kalman filter
/// on the pose (an Ornstein–Uhlenbeck process about the accepted pose); its measurement is the LC²
/// of the newest images against the CT. The drift alarm always compares with the accepted
/// registration. Memory is bounded by the window. Not thread-safe. Images of convex probes need the
/// outline of their sector (with_outline()): if columns are taken for beams, a patient's own CT
/// costs 0.05 more.
class LiveRegistration {
 public:
  /// \p ct: the channels of the level (sigma 0.75 sample steps) from make_ct_channels(). \p
  /// accepted: a registration that decide() accepted. Precondition: ct is not null. Errors:
  /// validate().
  static Result<LiveRegistration> create(std::shared_ptr<const CtChannels> ct, const Pose& accepted,
                                         const LiveOptions& options);
  /// Processes the next ultrasound image, in order of acquisition. Errors: kUsage if the image is
  /// not later than the last one; kMalformedData for an impossible geometry. The content of an
  /// image never causes an exception.
  Result<LiveUpdate> update(const TrackedImage& image);
  [[nodiscard]] const Pose& accepted() const { return accepted_; }
  /// Sets a new accepted registration and clears the alarm.
  void accept(const Pose& pose);
  /// A larger part of the same CT, prepared in the same way. Precondition: ct.
  void replace_ct(std::shared_ptr<const CtChannels> ct);

 private:
  struct WindowImage {
    TrackedImage tracked;
    PatchSet patches;
  };
  struct Solution {
    Pose pose;
    double cost;
    Matrix6d information;  ///< Information of a scaled twist about the centre.
    int iterations;
    bool finite;
  };
  LiveRegistration(std::shared_ptr<const CtChannels> ct, const Pose& accepted,
                   const LiveOptions& options);
  Result<PatchSet> patches_of(const TrackedImage& image) const;
  [[nodiscard]] PatchSet window_patches() const;
  [[nodiscard]] Solution solve(const PatchSet& patches, const Eigen::Vector3d& centre,
                               const Matrix6d& prior) const;
  void predict(Timestamp now, const Eigen::Vector3d& centre);
  void weigh(const PatchSet& patches, const Solution& found);
  void judge(LiveUpdate& update, const TrackedImage& image);

  std::shared_ptr<const CtChannels> ct_;
  Pose accepted_;
  LiveOptions options_;
  Pose pose_;
  /// Covariance of the scaled twist about centre_ct_, mm².
  Matrix6d covariance_ = Matrix6d::Identity();
  Eigen::Vector3d centre_ct_ = Eigen::Vector3d::Zero();
  std::optional<Timestamp> newest_;
  std::deque<WindowImage> window_;
  /// Low-pass filtered twist from the accepted pose, about mean_centre_ct_.
  Vector6d mean_twist_ = Vector6d::Zero();
  std::optional<Eigen::Vector3d> mean_centre_ct_;
  int unusable_ = 0;
  /// Distinctness of every kWeighEvery-th image, over at most evidence_images.
  std::deque<double> distinctness_;
  double mean_distinctness_ = 0;     ///< NaN until there is enough evidence.
  int unweighed_ = 0;                ///< Usable images since the last one in distinctness_.
  std::optional<double> withdrawn_;  ///< Distinctness at which the registration was withdrawn.
};

}  // namespace nav::registration
