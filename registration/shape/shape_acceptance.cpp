// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_acceptance.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "registration/shape/shape_solver.hpp"

namespace nav::registration {
namespace {

// Without neighbouring points the noise of a careful pointer on bone is assumed.
constexpr double kUsualNoiseMm = 0.7;
constexpr double kLeastNoiseMm = 0.4;
// Rougher points are no reason to believe a shape that fits them loosely.
constexpr double kGreatestNoiseMm = 1.5;
constexpr double kSharedSigmas = 3;

std::string rounded(double value, int digits) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(digits);
  text << value;
  return text.str();
}

void judge_turned(const ShapeRegistration& result, double least, const KnownPose* known,
                  Judge& judge) {
  for (const ShapeRival& rival : result.evidence->rivals.turned) {
    if (rival.evidence >= least) continue;
    if (known != nullptr && points_apart_mm(result.some_points, rival.pose,
                                            known->ct_from_reference) > known->within_mm) {
      continue;
    }
    judge.reject("the points fit the shape " +
                 std::string(rival.evidence < -least ? "better" : "as well") + " when turned by " +
                 rounded(rival.turned_deg, 0) + " degrees, " + rounded(rival.apart_mm, 0) +
                 " mm away (" + rounded(rival.mean_mm, 2) + " mm against " +
                 rounded(result.after.mean_mm, 2) +
                 " mm): give landmarks, or touch what tells the ends and sides apart");
    return;
  }
}

void judge_mirrored(const ShapeRegistration& result, double least, const KnownPose* known,
                    Judge& judge) {
  const auto& rivals = result.evidence->rivals;
  if (!rivals.mirrored || rivals.mirrored->evidence >= least) return;
  const std::string found = rounded(rivals.mirrored->mean_mm, 2) + " mm against " +
                            rounded(result.after.mean_mm, 2) + " mm";
  const bool better = rivals.mirrored->evidence < -least;
  if (!better && rivals.own_mirror_image) {
    judge.warn(
        "the surface is its own mirror image within the noise: the points cannot tell left "
        "from right (" +
        found + ")");
  } else if (!better && known != nullptr && known->tells_sides) {
    judge.warn("the points fit the mirrored surface as well (" + found +
               "); only the landmarks tell the side");
  } else {
    judge.reject("the points fit the mirrored surface " +
                 std::string(better ? "better" : "as well or better") + " (" + found +
                 "): check the side");
  }
}

void judge_strain(const ShapeStrain& strain, const ShapeLimits& limits, bool known, Judge& judge) {
  const double most = strain.stretches.cwiseAbs().maxCoeff();
  if (std::abs(strain.scale) >
      std::max(limits.max_stretch, limits.max_scale_sigmas * strain.scale_sigma)) {
    judge.reject("size: the points fit a shape better that is " +
                 rounded(100 * std::abs(strain.scale), 1) + " % " +
                 (strain.scale > 0 ? "smaller" : "larger") +
                 ": check the patient, the level and the units");
  } else if (strain.evidence > limits.max_strain_evidence && most > limits.max_stretch) {
    Eigen::Index at = 0;
    strain.stretches.cwiseAbs().maxCoeff(&at);
    const Eigen::Vector3d& d = strain.longest_ct;
    judge.reject("form: the points fit a shape better that is " + rounded(100 * most, 1) + " % " +
                 (strain.stretches[at] > 0 ? "shorter" : "longer") + " along Ct (" +
                 rounded(d.x(), 2) + ", " + rounded(d.y(), 2) + ", " + rounded(d.z(), 2) +
                 "): check the patient and the level");
  }
  if (strain.scale_sigma > limits.max_scale_sigma &&
      strain.moved_sigma_mm > limits.max_moved_sigma_mm) {
    const std::string text =
        "size: the points show the size of the shape only within " +
        rounded(100 * std::min(2 * strain.scale_sigma, 1.0), 0) +
        " %: another level or patient would fit as well; touch more of the bone";
    if (known) {
      judge.warn(text);
    } else {
      judge.reject(text + " or give landmarks");
    }
  }
  const double least =
      std::max(limits.max_shared_distance_mm, kSharedSigmas * strain.shared_sigma_mm);
  if (std::isfinite(strain.shared_sigma_mm) && std::abs(strain.shared_mm) > least) {
    judge.reject("distance of all points from the surface: expected at most " +
                 rounded(limits.max_shared_distance_mm, 1) + " mm, found " +
                 rounded(std::abs(strain.shared_mm), 1) +
                 " mm: check the pointer's tip and the tissue on the bone");
  }
}

/// Warns where an offset that all points share would go into the pose without being noticed.
void judge_shared_distance(const ShapeStrain& strain, double limit_mm, Judge& judge) {
  const double unnoticed_mm = kSharedSigmas * strain.shared_sigma_mm;
  if (unnoticed_mm <= limit_mm) return;
  const std::string size =
      std::isfinite(unnoticed_mm) ? "of up to " + rounded(unnoticed_mm, 1) + " mm" : "of any size";
  judge.warn("points: they lie on one side of the shape, so a distance " + size +
             " that all have from it goes into the pose unnoticed; --landmarks would show it");
}

}  // namespace

Decision decide(const ShapeRegistration& result, const ShapeLimits& limits,
                const Point<frames::Ct>& target, const ShapeLimits& warnings,
                const std::optional<KnownPose>& known,
                const std::optional<double>& given_sigma_mm) {
  Judge judge;
  for (const SlidingDirection& one : result.sliding) {
    judge.reject("the shape does not determine the " + one.description);
  }
  judge.at_most("mean distance of the points", result.after.mean_mm, limits.max_mean_mm,
                warnings.max_mean_mm, " mm");
  if (result.sliding.empty()) {
    judge.at_most("predicted error at the target", result.tre_rms_mm(target), limits.max_tre_rms_mm,
                  warnings.max_tre_rms_mm, " mm RMS");
  }
  if (!result.converged) judge.reject("the solver did not converge");
  if (!result.evidence) return std::move(judge).decision();
  const ShapeNoise& noise = result.evidence->noise;
  const double expected_mm = given_sigma_mm.value_or(
      std::clamp(noise.rough_mm.value_or(kUsualNoiseMm), kLeastNoiseMm, kGreatestNoiseMm));
  const double shared_mm =
      std::sqrt(std::max(noise.sigma_mm * noise.sigma_mm - expected_mm * expected_mm, 0.0));
  const double limit_mm = limits.max_shared * expected_mm;
  if (!(std::max(shared_mm, result.discrepancy_mm) <= limit_mm)) {
    judge.reject("residuals of the points: expected at most " + rounded(limit_mm, 2) +
                 " mm beyond their noise of " + rounded(expected_mm, 2) + " mm, found " +
                 rounded(std::max(shared_mm, result.discrepancy_mm), 2) +
                 " mm: check for the right bone, level and patient");
  }
  const KnownPose* vouched = known ? &*known : nullptr;
  if (known) {
    const double from_known_mm =
        points_apart_mm(result.some_points, result.ct_from_reference, known->ct_from_reference);
    if (!(from_known_mm <= known->within_mm)) {
      judge.reject("points: expected within " + rounded(known->within_mm, 1) +
                   " mm of where the landmarks or the start put them, found " +
                   rounded(from_known_mm, 1) + " mm");
    }
  }
  judge_turned(result, limits.min_evidence, vouched, judge);
  judge_mirrored(result, limits.min_evidence, vouched, judge);
  judge_strain(result.evidence->strain, limits, known.has_value(), judge);
  if (!known) {
    judge_shared_distance(result.evidence->strain, limits.max_shared_distance_mm, judge);
  }
  return std::move(judge).decision();
}

}  // namespace nav::registration
