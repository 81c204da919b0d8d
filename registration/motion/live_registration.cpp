// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/live_registration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>

#include "nav/check.hpp"
#include "nav/matrices.hpp"
#include "registration/assessment.hpp"
#include "registration/pose_solver.hpp"
#include "registration/prepared.hpp"
#include "registration/uncertainty/sandwich.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;

/// Least number of patches of a usable image; the filter's prior also constrains the six unknowns.
constexpr std::size_t kMinImagePatches = 10;
constexpr double kTinyStepMm = 1e-3;
/// Consecutive images show nearly the same content: every third one is weighed.
constexpr int kWeighEvery = 3;

/// Maps scaled twists about one centre to scaled twists about another: the translation includes the
/// lever arm of the rotation.
Matrix6d recentred(const Vec& from, const Vec& to) {
  Matrix6d m = Matrix6d::Identity();
  m.bottomLeftCorner<3, 3>() = -cross_matrix(to - from) / kRotationScaleMm;
  return m;
}

/// The scaled twist about a centre that moves one pose to another.
Vector6d scaled_twist(const Pose& from, const Pose& to, const Vec& centre) {
  const Eigen::AngleAxisd turn((to.rotation() * from.rotation().conjugate()).normalized());
  const Vec there =
      to.rotation() * (from.rotation().conjugate() * (centre - from.translation_mm())) +
      to.translation_mm();
  Vector6d twist;
  // AngleAxis gives [0, 2 pi); use the shorter rotation.
  const double angle = turn.angle() > M_PI ? turn.angle() - 2 * M_PI : turn.angle();
  twist.head<3>() = kRotationScaleMm * angle * turn.axis();
  twist.tail<3>() = there - centre;
  return twist;
}

/// Corners and middle of an ultrasound image at a pose, Ct.
std::array<Vec, 5> image_points(const TrackedImage& image, const Pose& pose) {
  const double right = image.frame.pixels.width() - 1;
  const double below = image.frame.pixels.height() - 1;
  const auto at = [&](double column, double row) {
    return (pose * (image.reference_from_image * image.frame.grid.at(column, row))).mm;
  };
  return {at(0, 0), at(right, 0), at(0, below), at(right, below), at(0.5 * right, 0.5 * below)};
}

double image_distance_mm(const TrackedImage& image, const Pose& a, const Pose& b) {
  const auto pa = image_points(image, a);
  const auto pb = image_points(image, b);
  double sum = 0;
  for (std::size_t i = 0; i < pa.size(); ++i) sum += (pa[i] - pb[i]).squaredNorm() / pa.size();
  return std::sqrt(sum);
}

}  // namespace

const char* to_string(LiveState state) {
  switch (state) {
    case LiveState::kFollowing:
      return "following";
    case LiveState::kHolding:
      return "holding";
    case LiveState::kDrifted:
      return "drifted";
    case LiveState::kLost:
      return "lost";
  }
  return "unknown";
}

Result<void> validate(const LiveOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("live registration: expected ") + what};
  };
  const auto positive = [](double v) { return v > 0 && std::isfinite(v); };
  if (!positive(o.level.sample_step_mm)) return reject("sample_step_mm > 0");
  if (o.level.patch_side < 5 || o.level.patch_side > 21 || o.level.patch_side % 2 == 0) {
    return reject("an odd patch_side of 5 to 21");
  }
  if (o.level.patches < 50) return reject("at least 50 patches");
  if (o.window < 1 || o.window > 30) return reject("a window of 1 to 30 images");
  if (o.mask_images < 1 || o.mask_images > 30) return reject("1 to 30 mask_images");
  if (o.max_iterations < 1 || o.max_iterations > 50) return reject("1 to 50 iterations");
  if (!positive(o.ridge)) return reject("ridge > 0");
  if (!positive(o.wander_mm) || !positive(o.wander_rad) || !positive(o.return_s)) {
    return reject("wander_mm, wander_rad and return_s > 0");
  }
  if (!(o.contrast_power >= 0 && o.contrast_power <= 3)) return reject("contrast_power in [0, 3]");
  if (!(o.patches_per_measurement >= 1)) return reject("patches_per_measurement >= 1");
  if (o.threads < 1 || o.threads > 64) return reject("1 to 64 threads");
  if (!(o.max_cost > 0 && o.max_cost <= 1)) return reject("max_cost in (0, 1]");
  if (o.evidence_images < 1 || o.evidence_images > 10000) {
    return reject("1 to 10000 evidence_images");
  }
  if (!(o.min_distinctness >= 0 && o.min_distinctness < 1)) {
    return reject("min_distinctness in [0, 1)");
  }
  if (o.lost_after < 1) return reject("lost_after >= 1");
  if (!positive(o.drift_mm) || !positive(o.drift_s)) return reject("drift_mm and drift_s > 0");
  if (!(o.jump_mm > o.drift_mm)) return reject("jump_mm > drift_mm");
  if (!(o.elsewhere_mm > 0 && o.elsewhere_mm < o.jump_mm)) {
    return reject("elsewhere_mm in (0, jump_mm)");
  }
  return validate(o.mask);
}

Result<LiveRegistration> LiveRegistration::create(std::shared_ptr<const CtChannels> ct,
                                                  const Pose& accepted,
                                                  const LiveOptions& options) {
  NAV_CHECK(ct != nullptr);
  if (const auto ok = validate(options); !ok) return ok.error();
  LiveOptions own = options;
  own.level.frame_step_mm = 1e-6;  // One image at a time, so there is nothing to thin.
  return LiveRegistration(std::move(ct), accepted, own);
}

LiveRegistration::LiveRegistration(std::shared_ptr<const CtChannels> ct, const Pose& accepted,
                                   const LiveOptions& options)
    : ct_(std::move(ct)), accepted_(accepted), options_(options), pose_(accepted) {
  accept(accepted);
}

void LiveRegistration::replace_ct(std::shared_ptr<const CtChannels> ct) {
  NAV_CHECK(ct != nullptr);
  ct_ = std::move(ct);
}

void LiveRegistration::accept(const Pose& pose) {
  accepted_ = pose;
  pose_ = pose;
  covariance_ = Matrix6d::Identity();  // An accepted registration is accurate to a millimetre.
  mean_twist_.setZero();
  mean_centre_ct_.reset();
  unusable_ = 0;
  distinctness_.clear();
  unweighed_ = 0;
  withdrawn_.reset();
  mean_distinctness_ = std::numeric_limits<double>::quiet_NaN();
}

/// Patches of one image. Its mask needs other images to know the brightness of an unshadowed echo.
Result<PatchSet> LiveRegistration::patches_of(const TrackedImage& image) const {
  std::vector<TrackedImage> frames;
  const std::size_t others =
      std::min(window_.size(), static_cast<std::size_t>(options_.mask_images - 1));
  for (std::size_t i = window_.size() - others; i < window_.size(); ++i) {
    // Images of another depth do not tell the brightness of echoes here.
    if (!same_geometry(window_[i].tracked.frame, image.frame)) continue;
    frames.push_back(window_[i].tracked);
  }
  frames.push_back(image);
  const auto all = Sweep::create(std::move(frames), "live");
  if (!all) return all.error();
  auto masks = shadow_masks(*all, options_.mask);
  if (!masks) return masks.error();
  const auto one = Sweep::create({image}, "live");
  if (!one) return one.error();
  PatchSet patches = make_patches(*one, {std::move(masks->back())}, options_.level,
                                  sigma_of(options_.level.sample_step_mm));
  for (Patch& patch : patches.patches) {
    patch.weight = std::pow(patch.weight, options_.contrast_power / kPatchWeightPower);
  }
  return patches;
}

PatchSet LiveRegistration::window_patches() const {
  PatchSet all;
  all.side = options_.level.patch_side;
  double total = 0;
  const auto window = static_cast<std::size_t>(options_.window);
  const std::size_t first = window_.size() > window ? window_.size() - window : 0;
  for (std::size_t i = first; i < window_.size(); ++i) {
    const PatchSet& own = window_[i].patches;
    all.patches.insert(all.patches.end(), own.patches.begin(), own.patches.end());
    all.samples.insert(all.samples.end(), own.samples.begin(), own.samples.end());
    ++all.frames;
  }
  for (const Patch& patch : all.patches) total += patch.weight;
  for (Patch& patch : all.patches) patch.weight /= total;
  return all;
}

/// Prediction step: since the last image the tissue has wandered and partly returned.
void LiveRegistration::predict(Timestamp now, const Vec& centre) {
  if (newest_) {
    const Matrix6d shift = recentred(centre_ct_, centre);
    const double kept = std::exp(-to_seconds(now - *newest_) / options_.return_s);
    covariance_ = kept * kept * (shift * covariance_ * shift.transpose()).eval();
    const double turn_mm = kRotationScaleMm * options_.wander_rad;
    covariance_.diagonal().head<3>().array() += (1 - kept * kept) * turn_mm * turn_mm;
    covariance_.diagonal().tail<3>().array() +=
        (1 - kept * kept) * options_.wander_mm * options_.wander_mm;
    const Vector6d away = scaled_twist(accepted_, pose_, centre);
    pose_ = moved(accepted_, centre, twist_from_scaled() * (kept * away));
  }
  centre_ct_ = centre;
}

/// Levenberg–Marquardt on ½ κ E + ½ ξᵀ P⁻¹ ξ. κ turns the mean of the patches' squared residuals
/// into a sum over independent measurements, scaled by their own variance.
LiveRegistration::Solution LiveRegistration::solve(const PatchSet& patches, const Vec& centre,
                                                   const Matrix6d& prior) const {
  const SimilarityCost cost(*ct_, patches, options_.ridge, options_.threads);
  const Matrix6d scale = twist_from_scaled();
  const auto terms_at = [&](const Pose& pose) { return cost.terms(pose, centre); };
  Solution best{.pose = pose_, .cost = 1, .information = prior, .iterations = 0, .finite = false};
  CostTerms terms = terms_at(pose_);
  if (terms.non_finite > 0 || !std::isfinite(terms.cost)) return best;
  const double measurements =
      std::max(1.0, static_cast<double>(patches.patches.size()) / options_.patches_per_measurement);
  const double kappa = measurements / std::max(terms.cost, 1e-3);
  Vector6d twist = Vector6d::Zero();
  double value = kappa * terms.cost;
  double damping = 1e-3;
  best = {.pose = pose_, .cost = terms.cost, .information = prior, .iterations = 0, .finite = true};
  while (best.iterations < options_.max_iterations) {
    ++best.iterations;
    const Matrix6d h = kappa * scale * terms.hessian * scale;
    best.information = h + prior;
    Matrix6d damped = best.information;
    damped.diagonal() *= 1 + damping;
    const Vector6d g = kappa * (scale * terms.gradient) + prior * twist;
    const Vector6d step = -symmetric_solve(damped, g);
    if (!step.allFinite()) break;
    const Pose next = moved(best.pose, centre, scale * step);
    const CostTerms there = terms_at(next);
    const Vector6d next_twist = scaled_twist(pose_, next, centre);
    const double next_value = kappa * there.cost + next_twist.dot(prior * next_twist);
    if (there.non_finite > 0 || !(next_value < value)) {
      damping *= 10;
      if (damping > 1e3) break;
      continue;
    }
    best.pose = next;
    best.cost = there.cost;
    terms = there;
    twist = next_twist;
    value = next_value;
    damping = std::max(damping / 10, 1e-6);
    if (step.norm() < kTinyStepMm) break;
  }
  return best;
}

/// A single image says little about whose CT it is; the mean over many images does.
void LiveRegistration::weigh(const PatchSet& patches, const Solution& found) {
  if (++unweighed_ < kWeighEvery) return;
  unweighed_ = 0;
  const SimilarityCost cost(*ct_, patches, options_.ridge, options_.threads);
  double least = 1;
  for (int axis = 3; axis < 6; ++axis) {
    for (const double way : {-options_.elsewhere_mm, options_.elsewhere_mm}) {
      const Pose there = moved(found.pose, centre_ct_, way * Vector6d::Unit(axis));
      least = std::min(least, cost.cost(there).cost);
    }
  }
  distinctness_.push_back(least > 0 ? 1 - found.cost / least : 0);
  const auto count =
      static_cast<std::size_t>((options_.evidence_images + kWeighEvery - 1) / kWeighEvery);
  if (distinctness_.size() > count) distinctness_.pop_front();
  if (distinctness_.size() < count) return;
  mean_distinctness_ =
      std::accumulate(distinctness_.begin(), distinctness_.end(), 0.0) / static_cast<double>(count);
  if (mean_distinctness_ < options_.min_distinctness) withdrawn_ = mean_distinctness_;
}

void LiveRegistration::judge(LiveUpdate& update, const TrackedImage& image) {
  update.displacement_mm = image_distance_mm(image, accepted_, update.ct_from_reference);
  const Pose mean =
      moved(accepted_, mean_centre_ct_.value_or(centre_ct_), twist_from_scaled() * mean_twist_);
  update.mean_displacement_mm = image_distance_mm(image, accepted_, mean);
  std::ostringstream text;
  text.precision(3);
  if (withdrawn_) {
    update.state = LiveState::kLost;
    text << "the CT may be of another patient, register again: expected "
         << options_.evidence_images << " images to match at least "
         << 100 * options_.min_distinctness << " % better at the registered pose than "
         << options_.elsewhere_mm << " mm away, found " << 100 * *withdrawn_ << " %";
  } else if (unusable_ >= options_.lost_after) {
    update.state = LiveState::kLost;
    text << "no image matches the CT: expected a usable one in the last " << options_.lost_after
         << ", found none";
  } else if (update.displacement_mm > options_.jump_mm) {
    update.state = LiveState::kDrifted;
    text << "expected the tissue within " << options_.jump_mm
         << " mm of its accepted position, found " << update.displacement_mm << " mm";
  } else if (update.mean_displacement_mm > options_.drift_mm) {
    update.state = LiveState::kDrifted;
    text << "expected the mean position of the tissue over " << options_.drift_s << " s within "
         << options_.drift_mm << " mm of the accepted one, found " << update.mean_displacement_mm
         << " mm";
  } else if (unusable_ > 0) {
    update.state = LiveState::kHolding;
    text << "expected an image that matches the CT, found " << update.patches
         << " patches with a cost of " << update.cost;
  }
  update.cause = text.str();
}

Result<LiveUpdate> LiveRegistration::update(const TrackedImage& image) {
  const Timestamp now = image.frame.acquired;
  if (newest_ && now <= *newest_) {
    return Error{ErrorCode::kUsage, "live registration: expected an image after " +
                                        std::to_string(to_seconds(*newest_)) + " s, found " +
                                        std::to_string(to_seconds(now)) + " s"};
  }
  auto patches = patches_of(image);
  if (!patches) return patches.error();
  const auto own = static_cast<int>(patches->patches.size());
  const bool enough = patches->patches.size() >= kMinImagePatches;
  predict(now, image_points(image, pose_)[4]);
  LiveUpdate out{
      .ct_from_reference = pose_, .state = LiveState::kFollowing, .cost = 1, .patches = own};
  bool usable = false;
  if (enough) {
    window_.push_back({image, std::move(*patches)});
    const auto keep = static_cast<std::size_t>(std::max(options_.window, options_.mask_images));
    while (window_.size() > keep) window_.pop_front();
    const Matrix6d prior = symmetric_inverse(covariance_);
    const PatchSet patches_now = window_patches();
    const Solution found = solve(patches_now, centre_ct_, prior);
    out.cost = found.cost;
    out.iterations = found.iterations;
    if (found.finite) weigh(patches_now, found);
    usable = found.finite && found.cost <= options_.max_cost;
    if (usable) {
      pose_ = found.pose;
      // The images of the window were measured before; this makes each count once.
      const Matrix6d gained = (found.information - prior) / std::max<double>(1, options_.window);
      covariance_ = symmetric_inverse(prior + gained);
    } else {
      window_.pop_back();
    }
  }
  unusable_ = usable ? 0 : unusable_ + 1;
  if (usable) {
    const double seconds = newest_ ? to_seconds(now - *newest_) : 0;
    const double share = 1 - std::exp(-seconds / options_.drift_s);
    if (!mean_centre_ct_) mean_centre_ct_ = centre_ct_;
    mean_twist_ += share * (scaled_twist(accepted_, pose_, *mean_centre_ct_) - mean_twist_);
  }
  newest_ = now;
  out.ct_from_reference = pose_;
  out.distinctness = mean_distinctness_;
  out.predicted_rms_mm = std::sqrt(covariance_.bottomRightCorner<3, 3>().trace());
  judge(out, image);
  return out;
}

}  // namespace nav::registration
