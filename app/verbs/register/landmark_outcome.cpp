// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/landmark_outcome.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "app/verbs/register/landmark_file.hpp"
#include "io/markups.hpp"
#include "registration/landmarks/robust_landmarks.hpp"
#include "registration/landmarks/tre_map.hpp"
#include "session/registration_file.hpp"

namespace nav::app {
namespace {

constexpr double kLandmarkMapStepMm = 20;

/// Fits the pairs that were not rejected, with the axes of their errors.
Result<registration::LandmarkRegistration> refine(const LandmarkList& list,
                                                  const std::vector<std::string>& rejected) {
  std::vector<registration::AnisotropicLandmark> kept;
  for (const auto& one : list.shaped) {
    if (std::find(rejected.begin(), rejected.end(), one.name) == rejected.end())
      kept.push_back(one);
  }
  return registration::register_anisotropic_landmarks(kept);
}

/// Finds pairs whose CT points can be swapped while the residual stays within its limit.
std::vector<SwappedLandmarks> swapped(std::vector<registration::LandmarkPair> pairs) {
  std::vector<SwappedLandmarks> out;
  if (pairs.size() > kMostSwapped) return out;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      std::swap(pairs[i].ct, pairs[j].ct);
      const auto fit = registration::register_landmarks(pairs);
      std::swap(pairs[i].ct, pairs[j].ct);
      if (!fit || fit->fre_rms_mm > registration::LandmarkLimits{}.max_fre_rms_mm) continue;
      out.push_back({pairs[j].name, pairs[i].name, fit->fre_rms_mm, fit->ct_from_reference});
    }
  }
  return out;
}

/// Computes LandmarkOutcome::mirrored_fre_rms_mm.
std::optional<double> mirrored(std::vector<registration::LandmarkPair> pairs) {
  for (auto& pair : pairs) pair.reference.mm.x() = -pair.reference.mm.x();
  const auto fit = registration::register_landmarks(pairs);
  if (!fit || fit->fre_rms_mm > registration::LandmarkLimits{}.max_fre_rms_mm) return {};
  return fit->fre_rms_mm;
}

/// True for a point that lies outside the CT by no more than a marker does.
bool is_near_ct(const VoxelGrid& grid, const Eigen::Vector3d& mm) {
  constexpr double kMarkerMm = 5;
  const Eigen::Vector3d from_centre = grid.directions.transpose() * (mm - grid.centre().mm);
  const Eigen::Vector3d half = 0.5 * grid.extent_mm();
  return (from_centre.cwiseAbs().array() <= half.array() + kMarkerMm).all();
}

/// An error for the first point that lies outside the CT by more than a marker does.
Result<void> check_inside(const LandmarkList& list, const Volume& ct) {
  const VoxelGrid& grid = ct.grid();
  const Eigen::Vector3d half = 0.5 * grid.extent_mm();
  const bool inside_as_ras = std::ranges::all_of(list.pairs, [&](const auto& pair) {
    return is_near_ct(grid, {-pair.ct.mm.x(), -pair.ct.mm.y(), pair.ct.mm.z()});
  });
  for (const auto& pair : list.pairs) {
    if (is_near_ct(grid, pair.ct.mm)) continue;
    const Eigen::Vector3d reach = grid.directions.cwiseAbs() * half;
    std::ostringstream text;
    text << "landmark '" << pair.name << "': expected its Ct point inside the CT, "
         << (grid.centre().mm - reach).transpose() << " to "
         << (grid.centre().mm + reach).transpose() << " mm, found " << pair.ct.mm.transpose();
    if (inside_as_ras) text << " (all are inside with x and y negated: RAS instead of LPS?)";
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  return {};
}

/// Rejects points of another unit.
Result<void> check_units(const LandmarkList& list) {
  std::vector<Eigen::Vector3d> reference, ct;
  for (const auto& pair : list.pairs) {
    reference.push_back(pair.reference.mm);
    ct.push_back(pair.ct.mm);
  }
  if (auto ok = check_unit(reference, "Reference points"); !ok) return ok;
  return check_unit(ct, "Ct points");
}

/// A wrong scale, if all pairs agree with it and not without it.
std::optional<registration::LandmarkScale> wrong_scale(
    const LandmarkList& list, const registration::RobustLandmarkOptions& options) {
  registration::LandmarkScaleOptions scale;
  double sigma2 = 0;
  for (const auto& pair : list.pairs) {
    sigma2 += pair.sigma_mm * pair.sigma_mm / static_cast<double>(list.pairs.size());
  }
  scale.max_fre_rms_mm = std::min(registration::LandmarkLimits{}.max_fre_rms_mm,
                                  options.inlier_sigmas * std::sqrt(sigma2));
  return registration::landmark_scale(list.pairs, scale);
}

Result<LandmarkOutcome> fit_list(const LandmarkList& list) {
  registration::RobustLandmarkOptions options;
  if (!list.sigmas_given) options.inlier_sigmas = registration::LandmarkLimits{}.max_fre_rms_mm;
  const auto robust = registration::register_landmarks_robustly(list.pairs, options);
  if (!robust && robust.error().code != ErrorCode::kRefused) return robust.error();
  if (const auto scale = wrong_scale(list, options)) {
    auto all = registration::register_landmarks(list.pairs);
    if (!all) return all.error();
    return LandmarkOutcome{.fit = std::move(*all),
                           .gate_sigmas = options.inlier_sigmas,
                           .shaped = false,
                           .no_majority = "",
                           .scale = scale};
  }
  const std::vector<std::string> rejected = robust ? robust->rejected : std::vector<std::string>{};
  auto fit = !list.shaped.empty() ? refine(list, rejected)
             : robust             ? Result(robust->fit)
                                  : registration::register_landmarks(list.pairs);
  if (!fit) return fit.error();
  LandmarkOutcome outcome{.fit = std::move(*fit),
                          .gate_sigmas = options.inlier_sigmas,
                          .shaped = !list.shaped.empty(),
                          .no_majority = robust ? "" : robust.error().message};
  std::vector<registration::LandmarkPair> kept;
  for (const auto& pair : list.pairs) {
    if (std::find(rejected.begin(), rejected.end(), pair.name) == rejected.end()) {
      kept.push_back(pair);
      continue;
    }
    const double off = (outcome.fit.ct_from_reference * pair.reference - pair.ct).v.norm();
    outcome.rejected.push_back({pair.name, off});
  }
  if (!robust) return outcome;  // Refused in any case.
  outcome.mirrored_fre_rms_mm = mirrored(kept);
  outcome.swapped = swapped(std::move(kept));
  return outcome;
}

}  // namespace

Result<LandmarkOutcome> register_landmark_file(const std::filesystem::path& path,
                                               const std::filesystem::path& ct_points,
                                               const Volume* ct, Diagnostics& diagnostics) {
  if (io::is_markups_file(path) == ct_points.empty()) {
    return Error{
        ErrorCode::kUsage,
        ct_points.empty()
            ? "--landmarks with a Markups file requires --ct-landmarks, its points in the CT"
            : "--ct-landmarks requires --landmarks with a Markups file (.fcsv, .mrk.json)"};
  }
  const auto list = ct_points.empty() ? read_landmarks(path)
                                      : read_landmark_markups(path, ct_points, diagnostics);
  if (!list) return list.error();
  if (ct != nullptr) {
    if (const auto ok = check_inside(*list, *ct); !ok) {
      const auto& named = ct_points.empty() ? path : ct_points;
      return Error{ok.error().code, named.string() + ": " + ok.error().message};
    }
  }
  if (const auto ok = check_units(*list); !ok) {
    return Error{ok.error().code, path.string() + ": " + ok.error().message};
  }
  auto outcome = fit_list(*list);
  if (!outcome) {
    return Error{outcome.error().code, path.string() + ": " + outcome.error().message};
  }
  for (const RejectedLandmark& one : outcome->rejected) {
    diagnostics.report(Severity::kWarning, "landmarks",
                       path.string() + ": landmark '" + one.name + "' is not used: expected it " +
                           "within " + quantity(outcome->gate_sigmas, 2, "sigmas") +
                           " of the fit of the others, found it " +
                           quantity(one.distance_mm, 1, "mm") + " away");
  }
  if (!outcome->no_majority.empty()) {
    diagnostics.report(Severity::kWarning, "landmarks",
                       path.string() + ": " + outcome->no_majority + "; all pairs are used");
  }
  return outcome;
}

registration::Decision decide(const LandmarkOutcome& outcome, const Point<frames::Ct>& target) {
  auto decision = registration::decide(outcome.fit, registration::LandmarkLimits{}, target);
  if (!outcome.no_majority.empty()) {
    decision.reject(outcome.no_majority);
  }
  if (outcome.scale) {
    // The scale is the reason of every other one.
    decision.reasons.clear();
    decision.reject("landmarks: " + registration::in_words(*outcome.scale) +
                    "; with this corrected all fit within " +
                    quantity(outcome.scale->fre_rms_mm, 2, "mm") + " RMS, without it within " +
                    quantity(outcome.scale->rigid_fre_rms_mm, 2, "mm"));
  }
  if (!decision.accepted) return decision;
  constexpr std::size_t kNoneToSpare = 3;
  if (outcome.fit.residuals.size() <= kNoneToSpare) {
    decision.warnings.push_back(
        "landmarks used: expected at least 4, so that a wrong one can be detected, found 3");
  } else if (outcome.mirrored_fre_rms_mm) {
    decision.warnings.push_back(
        "landmarks: all lie so near one plane that they also fit mirrored, within " +
        quantity(*outcome.mirrored_fre_rms_mm, 2, "mm") + ": they cannot tell left from right");
  }
  constexpr double kSameTurnDeg = 5;
  constexpr double kDegrees = 180 / std::numbers::pi;
  const auto here = outcome.fit.ct_from_reference;
  for (const SwappedLandmarks& pair : outcome.swapped) {
    const auto& there = pair.ct_from_reference;
    const double moved_mm = (there * (here.inverse() * target) - target).v.norm();
    const double turned_deg = kDegrees * there.rotation().angularDistance(here.rotation());
    if (moved_mm <= registration::LandmarkLimits{}.max_tre_rms_mm && turned_deg <= kSameTurnDeg) {
      continue;
    }
    decision.warnings.push_back("landmarks '" + pair.one + "' and '" + pair.other +
                                "' may be swapped: after a swap all fit within " +
                                quantity(pair.fre_rms_mm, 2, "mm") + ", the pose is turned by " +
                                quantity(turned_deg, 0, "degrees") + " and the target moves by " +
                                quantity(moved_mm, 1, "mm"));
  }
  return decision;
}

io::Json json_of(const LandmarkOutcome& outcome, const registration::Decision& decision,
                 const Point<frames::Ct>& target, const Volume* ct) {
  const auto& fit = outcome.fit;
  io::Json json = json_of(decision);
  json["fre_rms_mm"] = fit.fre_rms_mm;
  json["fle_rms_mm"] = json_number(fit.fle_rms_mm);
  json["sigma_scale"] = json_number(fit.sigma_scale);
  json["anisotropic"] = outcome.shaped;
  json["target_error_rms_mm"] = json_number(registration::predicted_tre_rms_mm(fit, target));
  json["landmarks"] = io::Json::array();
  for (const auto& residual : fit.residuals) {
    json["landmarks"].push_back({{"name", residual.name},
                                 {"residual_mm", residual.distance_mm},
                                 {"leave_one_out_mm", json_number(residual.leave_one_out_mm)}});
  }
  json["gate_sigmas"] = outcome.gate_sigmas;
  json["rejected"] = io::Json::array();
  for (const auto& one : outcome.rejected) {
    json["rejected"].push_back({{"name", one.name}, {"distance_mm", one.distance_mm}});
  }
  json["scale"] = nullptr;
  if (outcome.scale) {
    constexpr std::array kAxes = {"all", "ct", "reference"};
    const Eigen::Vector3d& f = outcome.scale->factors;
    json["scale"] = {{"axes", kAxes[static_cast<std::size_t>(outcome.scale->axes)]},
                     {"factors", {f.x(), f.y(), f.z()}},
                     {"fre_rms_mm", outcome.scale->fre_rms_mm}};
  }
  if (ct != nullptr) {
    const double limit = registration::LandmarkLimits{}.max_tre_rms_mm;
    const auto map = registration::tre_map(fit.uncertainty, ct->grid(), kLandmarkMapStepMm);
    json["error_map"] = {{"step_mm", map.step_mm},
                         {"worst_rms_mm", map.worst_mm()},
                         {"limit_mm", limit},
                         {"fraction_within_limit", map.fraction_within(limit)}};
  }
  json[pose_key(decision)] = app::json_of(fit.ct_from_reference.matrix());
  return json;
}

io::Json landmark_report(const LandmarkOutcome& outcome, const registration::Decision& decision,
                         const Point<frames::Ct>& target, const ReportedCt& ct,
                         const std::string& reference_frame) {
  io::Json json;
  json["verb"] = "register";
  json["version"] = SONDE_VERSION;
  json["method"] = "landmarks";
  json["ct"] = ct.name;
  json["ct_sha256"] = ct.ct != nullptr ? io::Json(session::ct_digest(*ct.ct)) : io::Json(nullptr);
  json["target_ct_mm"] = {target.mm.x(), target.mm.y(), target.mm.z()};
  json["reference_frame"] = reference_frame.empty() ? io::Json(nullptr) : io::Json(reference_frame);
  json["registration"] = json_of(outcome, decision, target, ct.ct);
  return json;
}

}  // namespace nav::app
