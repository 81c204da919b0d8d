// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/acceptance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "nav/check.hpp"
#include "registration/error_probability.hpp"
#include "registration/uncertainty/misfit.hpp"

namespace nav::registration {
namespace {

std::string sentence(const std::string& what, const std::string& relation, double limit,
                     const std::string& unit, double found) {
  std::ostringstream text;
  text.precision(3);
  text << what << ": expected " << relation << ' ' << limit << unit << ", found ";
  if (std::isfinite(found)) {
    text << found << unit;
  } else {
    text << "no finite value";
  }
  return text.str();
}

/// NaN if any component is NaN.
double most_stretched(const ImageScale& stretch) {
  const double deep = std::abs(stretch.depth_scale - 1);
  const double strain = stretch.strain.norm();
  return std::isnan(strain) ? strain : std::max(deep, strain);
}

/// Adds one sentence for each cause that was estimated with the pose, and at most one for the
/// others.
void judge_misfits(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                   const AcceptanceLimits& warnings, Judge& judge) {
  const auto judge_one = [&](const Misfit& misfit, const std::string& how) {
    const auto cause = static_cast<std::size_t>(misfit.cause);
    const bool estimated = !misfit.deviations.empty();
    const auto of = [&](const AcceptanceLimits& from) {
      return estimated ? from.max_corrected_mm.at(cause) : from.max_misfit_mm.at(cause);
    };
    judge.at_most("misfit of images and CT, " + how + in_words(misfit), misfit.excess_mm(),
                  of(limits), of(warnings), " mm");
  };
  for (const Misfit& misfit : result.misfits) {
    if (!misfit.deviations.empty() && misfit.telling()) judge_one(misfit, "from ");
  }
  const Misfit* worst = likeliest_misfit(result, limits);
  if (worst == nullptr) worst = likeliest_misfit(result, warnings);
  if (worst != nullptr) judge_one(*worst, "probably from ");
}

/// Judges errors of the system against what was known of them before.
void judge_errors(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                  const AcceptanceLimits& warnings, Judge& judge) {
  constexpr std::array<const char*, kErrorParameters> kNames{
      "delay",       "depth scale", "width scale", "pressure",    "calibration",
      "calibration", "calibration", "calibration", "calibration", "calibration"};
  const ErrorVector values = result.errors.vector();
  std::size_t worst = 0;
  double most = 0;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (!(result.error_sigmas[k] > 0)) continue;
    const double sigmas = std::abs(values[k]) / result.error_sigmas[k];
    if (sigmas <= most) continue;
    worst = i;
    most = sigmas;
    if (std::isnan(sigmas)) break;
  }
  judge.at_most(std::string(kNames[worst]) +
                    " that makes the images fit, in standard deviations of what is known of it",
                most, limits.max_error_sigmas, warnings.max_error_sigmas, "");
}

/// Judges the disagreements of halves. A reason why halves could not be compared is given once, and
/// not at all if the uncertainty failed for the same reason.
void judge_halves(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                  const AcceptanceLimits& warnings, Judge& judge) {
  const auto judge_one = [&](const std::string& what, const std::string& fault, double found_mm,
                             double limit_mm, double warning_mm) {
    if (fault.empty()) {
      judge.at_most("disagreement of " + what, found_mm, limit_mm, warning_mm, " mm");
    } else if (result.covariance_valid || fault != result.covariance_fault) {
      judge.reject("disagreement of " + what + ": " + fault);
    }
  };
  const double limit_mm = limits.max_split_disagreement_mm;
  const double warning_mm = warnings.max_split_disagreement_mm;
  if (!result.split_fault.empty() && result.split_fault == result.halves_fault) {
    judge_one("the two halves of the images", result.split_fault, result.split_disagreement_mm,
              limit_mm, warning_mm);
    return;
  }
  judge_one("odd and even images", result.split_fault, result.split_disagreement_mm, limit_mm,
            warning_mm);
  judge_one("the first and second half", result.halves_fault, result.halves_disagreement_mm,
            limits.max_halves_disagreement_mm, warnings.max_halves_disagreement_mm);
}

}  // namespace

Result<void> validate(const AcceptanceLimits& limits) {
  const auto reject = [](const std::string& what, const std::string& expected, double found) {
    std::ostringstream text;
    text << "acceptance: " << what << ": expected " << expected << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  if (!(limits.min_overlap >= 0 && limits.min_overlap <= 1)) {
    return reject("min_overlap", "0 to 1", limits.min_overlap);
  }
  if (!(limits.max_error_probability > 0 && limits.max_error_probability <= 1)) {
    return reject("max_error_probability", "a value in (0, 1]", limits.max_error_probability);
  }
  if (!std::isfinite(limits.min_z_score)) {
    return reject("min_z_score", "a finite number", limits.min_z_score);
  }
  if (limits.min_places < 0) return reject("min_places", "0 or more", limits.min_places);
  if (!(limits.max_cost > 0 && limits.max_cost <= 1)) {
    return reject("max_cost", "a value in (0, 1]", limits.max_cost);
  }
  if (!std::isfinite(limits.min_margin)) {
    return reject("min_margin", "a finite number", limits.min_margin);
  }
  if (!(limits.max_tre_rms_mm > 0)) {
    return reject("max_tre_rms_mm", "a positive number", limits.max_tre_rms_mm);
  }
  if (!(limits.max_split_disagreement_mm > 0)) {
    return reject("max_split_disagreement_mm", "a positive number",
                  limits.max_split_disagreement_mm);
  }
  if (!(limits.max_halves_disagreement_mm > 0)) {
    return reject("max_halves_disagreement_mm", "a positive number",
                  limits.max_halves_disagreement_mm);
  }
  if (!(limits.max_basin_shift_mm > 0)) {
    return reject("max_basin_shift_mm", "a positive number", limits.max_basin_shift_mm);
  }
  if (!(limits.max_scale > 0)) {
    return reject("max_stretch", "a positive number", limits.max_scale);
  }
  for (const double limit : limits.max_misfit_mm) {
    if (!(limit > 0)) return reject("max_misfit_mm", "positive numbers", limit);
  }
  if (!(limits.max_error_sigmas > 0)) {
    return reject("max_error_sigmas", "a positive number", limits.max_error_sigmas);
  }
  for (const double limit : limits.max_corrected_mm) {
    if (!(limit > 0)) return reject("max_corrected_mm", "positive numbers", limit);
  }
  return {};
}

AcceptanceLimits limits_for(Effort effort) {
  AcceptanceLimits limits;
  if (effort == Effort::kQuick) {
    // The probability was not fitted to quick registrations.
    limits.max_error_probability = 1;
    limits.min_z_score = 4.5;
    limits.min_margin = 0.15;
    limits.max_cost = 0.25;
    limits.max_misfit_mm[static_cast<std::size_t>(MisfitCause::kDelay)] = 0.75;
    limits.max_misfit_mm[static_cast<std::size_t>(MisfitCause::kCalibration)] = 0.9;
  }
  return limits;
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccept:
      return "accept";
    case Verdict::kWarn:
      return "warn";
    case Verdict::kReject:
      return "refuse";
  }
  return "refuse";
}

const char* in_words(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccept:
      return "accepted";
    case Verdict::kWarn:
      return "accepted with warnings";
    case Verdict::kReject:
      return "refused";
  }
  return "refused";
}

void Decision::reject(std::string reason) {
  accepted = false;
  reasons.push_back(std::move(reason));
  warnings.clear();
}

void Judge::at_least(const std::string& what, double found, double limit, double warning) {
  if (!(found >= limit)) {
    reasons_.push_back(sentence(what, "at least", limit, "", found));
  } else if (!(found >= warning)) {
    warn(what, found, "below", limit, warning, "");
  }
}

void Judge::at_most(const std::string& what, double found, double limit, double warning,
                    const std::string& unit) {
  if (!(std::isfinite(found) && found <= limit)) {
    reasons_.push_back(sentence(what, "at most", limit, unit, found));
  } else if (!(found <= warning)) {
    warn(what, found, "above", limit, warning, unit);
  }
}

void Judge::warn(const std::string& what, double found, const std::string& beyond, double limit,
                 double warning, const std::string& unit) {
  std::ostringstream text;
  text.precision(3);
  text << what << ": " << found << unit << "; warning " << beyond << ' ' << warning << unit
       << ", refused " << beyond << ' ' << limit << unit;
  warnings_.push_back(text.str());
}

Decision Judge::decision() && {
  const bool accepted = reasons_.empty();
  if (!accepted) warnings_.clear();
  return {accepted, std::move(reasons_), std::move(warnings_)};
}

Decision decide(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target, const AcceptanceLimits& warnings) {
  const auto ok = validate(limits);
  NAV_CHECK(ok.has_value(), ok ? std::string() : ok.error().message);
  Judge judge;
  if (result.termination == Termination::kIterationLimit) {
    judge.warn("the solver stopped at the iteration limit before it converged");
  }
  if (result.termination == Termination::kTimeLimit) {
    judge.reject("the solver stopped at the time limit before it converged");
  }
  if (result.termination == Termination::kFailed) {
    judge.reject("the solver failed: " + result.message);
  }
  judge.at_least("overlap of the sweep with the CT", result.overlap, limits.min_overlap,
                 warnings.min_overlap);
  judge.at_least("score against random poses", result.z_score, limits.min_z_score,
                 warnings.min_z_score);
  if (result.bootstrap.places > 0) {
    judge.at_least("positions at which images were acquired", result.bootstrap.places,
                   limits.min_places, warnings.min_places);
  }
  judge.at_most("cost of the match", result.final_cost, limits.max_cost, warnings.max_cost, "");
  if (result.margin) {
    judge.at_least("margin to the next best pose", *result.margin, limits.min_margin,
                   warnings.min_margin);
  }
  if (result.covariance_valid) {
    judge.at_most("predicted error at the target", result.tre_rms_mm(target), limits.max_tre_rms_mm,
                  warnings.max_tre_rms_mm, " mm");
    const bool enough = result.bootstrap.places >= limits.min_places;
    if (enough && !result.bootstrap.fault.empty()) {
      judge.warn("predicted error: estimated from patches alone, not from images: " +
                 result.bootstrap.fault);
    }
  } else {
    judge.reject("uncertainty: " + result.covariance_fault);
  }
  judge_halves(result, limits, warnings, judge);
  judge.at_most("distance to a lower cost nearby (the pose is not a local minimum)",
                result.basin.shift_mm, limits.max_basin_shift_mm, warnings.max_basin_shift_mm,
                " mm");
  judge.at_most("scale of the images (they are drawn unscaled)", most_stretched(result.stretch),
                limits.max_scale, warnings.max_scale, "");
  judge_misfits(result, limits, warnings, judge);
  judge_errors(result, limits, warnings, judge);
  // Whatever missed a limit of its own says more than the probability.
  if (result.covariance_valid && !judge.rejected()) {
    const double most = limits.max_error_probability;
    judge.at_most("probability that the error at the target exceeds 3 mm",
                  error_probability(result, target), most,
                  judge.warned() ? most : warnings.max_error_probability, "");
  }
  if (result.without_delay && !judge.rejected()) {
    const Decision before = decide(*result.without_delay, limits, target, warnings);
    for (const std::string& reason : before.reasons) {
      judge.reject("before a delay of the images was estimated: " + reason);
    }
  }
  return std::move(judge).decision();
}

const Misfit* likeliest_misfit(const ImageRegistrationResult& result,
                               const AcceptanceLimits& limits) {
  return likeliest_of(result.misfits, limits.max_misfit_mm);
}

double predicted_tre_rms_mm(const LandmarkRegistration& fit, const Point<frames::Ct>& target) {
  return std::max(fit.sigma_scale, 1.0) * fit.tre_rms_mm(target);
}

Decision decide(const LandmarkRegistration& fit, const LandmarkLimits& limits,
                const Point<frames::Ct>& target, const LandmarkLimits& warnings) {
  Judge judge;
  judge.at_most("residual of the landmarks, RMS", fit.fre_rms_mm, limits.max_fre_rms_mm,
                warnings.max_fre_rms_mm, " mm");
  judge.at_most("predicted error at the target", predicted_tre_rms_mm(fit, target),
                limits.max_tre_rms_mm, warnings.max_tre_rms_mm, " mm");
  return std::move(judge).decision();
}

}  // namespace nav::registration
