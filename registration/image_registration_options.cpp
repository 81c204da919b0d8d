// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <sstream>

#include "registration/image_registration.hpp"
#include "registration/similarity/lc2_kernel.hpp"
#include "registration/similarity/similarity_measure.hpp"

namespace nav::registration {
namespace {

Error reject(const std::string& what, const std::string& expected, double found) {
  std::ostringstream text;
  text << "image registration: " << what << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

Result<void> validate_level(const LevelOptions& level, std::size_t index) {
  const std::string name = "levels[" + std::to_string(index) + "].";
  if (!(level.sample_step_mm > 0.05 && level.sample_step_mm <= 20)) {
    return reject(name + "sample_step_mm", "a value in (0.05, 20]", level.sample_step_mm);
  }
  if (level.patch_side < 5 || level.patch_side > kMaxPatchSide || level.patch_side % 2 == 0) {
    return reject(name + "patch_side", "an odd number of 5 to 21", level.patch_side);
  }
  if (level.patches < 50 || level.patches > 1000000) {
    return reject(name + "patches", "50 to 1000000", level.patches);
  }
  if (!(level.texel_sigmas > 0 && level.texel_sigmas <= 2)) {
    return reject(name + "texel_sigmas", "a value in (0, 2]", level.texel_sigmas);
  }
  if (!(level.frame_step_mm > 0 && level.frame_step_mm <= 100)) {
    return reject(name + "frame_step_mm", "a value in (0, 100]", level.frame_step_mm);
  }
  return {};
}

}  // namespace

const char* to_string(Effort effort) { return effort == Effort::kQuick ? "quick" : "usual"; }

ImageRegistrationOptions with_effort(Effort effort) {
  ImageRegistrationOptions options;
  if (effort == Effort::kUsual) return options;
  options.levels = {{.sample_step_mm = 5.0,
                     .patch_side = 7,
                     .patches = 60,
                     .frame_step_mm = 9.0,
                     .choice = PatchChoice::kContrast,
                     .texel_sigmas = 1.5},
                    {.sample_step_mm = 2.0,
                     .patch_side = 7,
                     .patches = 250,
                     .frame_step_mm = 1.0,
                     .choice = PatchChoice::kEven}};
  options.least_judging = 40;
  options.most_images = 8;
  options.average_pixels = true;
  // With this value, 95 % intervals cover 0.95 of the targets on the development seeds.
  options.bias_floor_mm = 0.1;
  // Twice as many poses change no decision.
  options.z_score_poses = 30;
  options.bootstrap.replicates = 200;
  return options;
}

Result<void> validate(const ImageRegistrationOptions& options) {
  if (options.levels.empty()) return reject("levels", "at least 1", 0);
  for (std::size_t i = 0; i < options.levels.size(); ++i) {
    if (const auto ok = validate_level(options.levels[i], i); !ok) return ok.error();
    if (i > 0 && options.levels[i].sample_step_mm > options.levels[i - 1].sample_step_mm) {
      return reject("levels[" + std::to_string(i) + "].sample_step_mm", "coarse to fine",
                    options.levels[i].sample_step_mm);
    }
  }
  if (const auto ok = validate(options.mask); !ok) return ok.error();
  if (options.stretch != ScaleModel::kNone &&
      measure_of(options.similarity).by_patch() == nullptr) {
    return Error{ErrorCode::kUsage,
                 "image registration: a scale cannot be estimated without terms of single patches"};
  }
  if (!(options.loss.scale >= 1e-3 && options.loss.scale <= 1000)) {
    return reject("loss.scale", "0.001 to 1000", options.loss.scale);
  }
  if (!(options.ridge >= 1e-4 && options.ridge <= 10)) {
    return reject("ridge", "1e-4 to 10", options.ridge);
  }
  if (!(options.min_ct_contrast_hu >= 0 && options.min_ct_contrast_hu <= 200)) {
    return reject("min_ct_contrast_hu", "0 to 200", options.min_ct_contrast_hu);
  }
  if (options.least_judging < 20 || options.least_judging > 1000000) {
    return reject("least_judging", "20 to 1000000", options.least_judging);
  }
  if (options.most_images < 0 || options.most_images > 1000000) {
    return reject("most_images", "0 to 1000000", options.most_images);
  }
  if (options.max_iterations < 1 || options.max_iterations > 1000) {
    return reject("max_iterations", "1 to 1000", options.max_iterations);
  }
  if (options.starts < 0 || options.starts > 1000000) {
    return reject("starts", "0 to 1000000", options.starts);
  }
  if (!(options.start_range_mm >= 0 && options.start_range_mm <= 200)) {
    return reject("start_range_mm", "0 to 200", options.start_range_mm);
  }
  if (!(options.start_range_rad >= 0 && options.start_range_rad <= M_PI)) {
    return reject("start_range_rad", "0 to pi", options.start_range_rad);
  }
  if (options.z_score_poses < 10 || options.z_score_poses > 100000) {
    return reject("z_score_poses", "10 to 100000", options.z_score_poses);
  }
  if (!(options.bias_floor_mm >= 0 && options.bias_floor_mm <= 100)) {
    return reject("bias_floor_mm", "0 to 100", options.bias_floor_mm);
  }
  if (!(options.calibration_sigma_mm >= 0 && options.calibration_sigma_mm <= 10)) {
    return reject("calibration_sigma_mm", "0 to 10", options.calibration_sigma_mm);
  }
  if (!(options.delay_sigma_s >= 0 && options.delay_sigma_s <= 1)) {
    return reject("delay_sigma_s", "0 to 1", options.delay_sigma_s);
  }
  if (!(options.scale_sigma >= 0 && options.scale_sigma <= 0.1)) {
    return reject("scale_sigma", "0 to 0.1", options.scale_sigma);
  }
  if (!(options.pressed_sigma_mm >= 0 && options.pressed_sigma_mm <= 20)) {
    return reject("pressed_sigma_mm", "0 to 20", options.pressed_sigma_mm);
  }
  if (const auto ok = validate(options.bootstrap); !ok) return ok.error();
  if (!(options.time_limit_s > 0)) {
    return reject("time_limit_s", "a positive number", options.time_limit_s);
  }
  if (options.threads < 1 || options.threads > 64) {
    return reject("threads", "1 to 64", options.threads);
  }
  return {};
}

const char* to_string(ScaleModel model) {
  switch (model) {
    case ScaleModel::kNone:
      return "none";
    case ScaleModel::kSoundSpeed:
      return "sound-speed";
    case ScaleModel::kAffine:
      return "affine";
  }
  return "none";
}

const char* to_string(Termination termination) {
  switch (termination) {
    case Termination::kConverged:
      return "converged";
    case Termination::kIterationLimit:
      return "iteration_limit";
    case Termination::kTimeLimit:
      return "time_limit";
    case Termination::kFailed:
      return "failed";
  }
  return "failed";
}

double ImageRegistrationResult::tre_rms_mm(const Point<frames::Ct>& target) const {
  if (!covariance_valid) return std::numeric_limits<double>::infinity();
  return uncertainty.tre_rms_mm(target);
}

}  // namespace nav::registration
