// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/acceptance.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "nav/check.hpp"

namespace nav::registration {
namespace {

std::string sentence(const std::string& what, const std::string& relation, double limit,
                     const std::string& unit, double found) {
  std::ostringstream text;
  text.precision(3);
  text << what << ": expected " << relation << ' ' << limit << unit << ", found " << found << unit;
  return text.str();
}

}  // namespace

Result<void> validate(const AcceptanceLimits& limits) {
  const auto refuse = [](const std::string& what, const std::string& expected, double found) {
    std::ostringstream text;
    text << "acceptance: " << what << ": expected " << expected << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  if (!(limits.min_overlap >= 0 && limits.min_overlap <= 1)) {
    return refuse("min_overlap", "0 to 1", limits.min_overlap);
  }
  if (!std::isfinite(limits.min_z_score)) {
    return refuse("min_z_score", "a finite number", limits.min_z_score);
  }
  if (!(limits.max_cost > 0 && limits.max_cost <= 1)) {
    return refuse("max_cost", "a value in (0, 1]", limits.max_cost);
  }
  if (!std::isfinite(limits.min_margin)) {
    return refuse("min_margin", "a finite number", limits.min_margin);
  }
  if (!(limits.max_tre_rms_mm > 0)) {
    return refuse("max_tre_rms_mm", "a positive number", limits.max_tre_rms_mm);
  }
  if (!(limits.max_split_disagreement_mm > 0)) {
    return refuse("max_split_disagreement_mm", "a positive number",
                  limits.max_split_disagreement_mm);
  }
  if (!(limits.max_halves_disagreement_mm > 0)) {
    return refuse("max_halves_disagreement_mm", "a positive number",
                  limits.max_halves_disagreement_mm);
  }
  if (!(limits.max_stretch > 0)) {
    return refuse("max_stretch", "a positive number", limits.max_stretch);
  }
  return {};
}

void require_at_most(std::vector<std::string>& reasons, const std::string& what, double found,
                     double limit, const std::string& unit) {
  if (std::isfinite(found) && found <= limit) return;
  reasons.push_back(sentence(what, "at most", limit, unit, found));
}

Result<void> validate(const WarningLimits& warnings, const AcceptanceLimits& limits) {
  struct Pair {
    const char* name;
    double warning, limit;
    bool at_least;
  };
  const Pair pairs[] = {{"min_overlap", warnings.min_overlap, limits.min_overlap, true},
                        {"min_z_score", warnings.min_z_score, limits.min_z_score, true},
                        {"max_cost", warnings.max_cost, limits.max_cost, false},
                        {"min_margin", warnings.min_margin, limits.min_margin, true},
                        {"max_tre_rms_mm", warnings.max_tre_rms_mm, limits.max_tre_rms_mm, false},
                        {"max_split_disagreement_mm", warnings.max_split_disagreement_mm,
                         limits.max_split_disagreement_mm, false},
                        {"max_halves_disagreement_mm", warnings.max_halves_disagreement_mm,
                         limits.max_halves_disagreement_mm, false},
                        {"max_stretch", warnings.max_stretch, limits.max_stretch, false}};
  for (const Pair& pair : pairs) {
    if (pair.at_least ? pair.warning >= pair.limit : pair.warning <= pair.limit) continue;
    std::ostringstream text;
    text << "warnings: " << pair.name << ": expected " << (pair.at_least ? "at least" : "at most")
         << " its limit of acceptance, " << pair.limit << ", found " << pair.warning;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return {};
}

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccept:
      return "accept";
    case Verdict::kWarn:
      return "warn";
    case Verdict::kRefuse:
      return "refuse";
  }
  return "refuse";
}

namespace {

/// Collects what misses its limit and what only comes near it. Comparisons are written so that NaN
/// fails them.
struct Judge {
  std::vector<std::string> reasons, warnings;

  void at_least(const std::string& what, double found, double limit, double warning) {
    if (!(found >= limit)) {
      reasons.push_back(sentence(what, "at least", limit, "", found));
    } else if (!(found >= warning)) {
      warn(what, found, "below", limit, warning, "");
    }
  }
  void at_most(const std::string& what, double found, double limit, double warning,
               const std::string& unit) {
    const std::size_t before = reasons.size();
    require_at_most(reasons, what, found, limit, unit);
    if (reasons.size() == before && !(found <= warning)) {
      warn(what, found, "above", limit, warning, unit);
    }
  }
  void warn(const std::string& what, double found, const std::string& beyond, double limit,
            double warning, const std::string& unit) {
    std::ostringstream text;
    text.precision(3);
    text << what << ": " << found << unit << "; refused " << beyond << ' ' << limit << unit
         << ", warned of " << beyond << ' ' << warning << unit;
    warnings.push_back(text.str());
  }
};

}  // namespace

Decision decide(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target, const WarningLimits& warnings) {
  auto ok = validate(limits);
  if (ok) ok = validate(warnings, limits);
  NAV_CHECK(ok.has_value(), ok ? std::string() : ok.error().message);
  Judge judge;
  if (result.termination == Termination::kFailed) {
    judge.reasons.push_back("solver: expected it to converge, found: " + result.message);
  }
  judge.at_least("overlap of the sweep with the CT", result.overlap, limits.min_overlap,
                 warnings.min_overlap);
  judge.at_least("score against random poses", result.z_score, limits.min_z_score,
                 warnings.min_z_score);
  judge.at_most("cost of the match", result.final_cost, limits.max_cost, warnings.max_cost, "");
  if (result.margin) {
    judge.at_least("margin to the next best pose", *result.margin, limits.min_margin,
                   warnings.min_margin);
  }
  if (result.covariance_valid) {
    judge.at_most("predicted error at the target", result.tre_rms_mm(target), limits.max_tre_rms_mm,
                  warnings.max_tre_rms_mm, " mm");
  } else {
    judge.reasons.push_back("uncertainty: " + result.covariance_fault);
  }
  judge.at_most("disagreement of odd and even pictures", result.split_disagreement_mm,
                limits.max_split_disagreement_mm, warnings.max_split_disagreement_mm, " mm");
  judge.at_most("disagreement of first and second half", result.halves_disagreement_mm,
                limits.max_halves_disagreement_mm, warnings.max_halves_disagreement_mm, " mm");
  judge.at_most("stretch of the pictures, which are shown without it",
                std::max(std::abs(result.stretch.depth_scale - 1), result.stretch.strain.norm()),
                limits.max_stretch, warnings.max_stretch, "");
  const bool accepted = judge.reasons.empty();
  if (!accepted) judge.warnings.clear();
  return {accepted, std::move(judge.reasons), std::move(judge.warnings)};
}

double predicted_tre_rms_mm(const LandmarkRegistration& fit, const Point<frames::Ct>& target) {
  return std::max(fit.sigma_scale, 1.0) * fit.tre_rms_mm(target);
}

Decision decide(const LandmarkRegistration& fit, const LandmarkLimits& limits,
                const Point<frames::Ct>& target) {
  std::vector<std::string> reasons;
  require_at_most(reasons, "residual of the landmarks, RMS", fit.fre_rms_mm, limits.max_fre_rms_mm,
                  " mm");
  require_at_most(reasons, "predicted error at the target", predicted_tre_rms_mm(fit, target),
                  limits.max_tre_rms_mm, " mm");
  const bool accepted = reasons.empty();
  return {accepted, std::move(reasons), {}};
}

}  // namespace nav::registration
