// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/phase_registration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "nav/check.hpp"
#include "registration/motion/phase_fit.hpp"
#include "registration/shape/paired_gain.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;

// Relative cost change worth about 0.2 mm.
constexpr double kNearTolerance = 1e-3;

std::vector<PhaseImage> images_of(const PatchSet& all, std::span<const double> phases,
                                  const std::vector<int>& parts) {
  std::vector<double> weights(phases.size(), 0);
  for (const Patch& p : all.patches) weights[static_cast<std::size_t>(p.frame)] += p.weight;
  std::vector<PhaseImage> out;
  double total = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    if (std::isnan(phases[i]) || !(weights[i] > 0)) continue;
    total += weights[i];
    const int frame = static_cast<int>(i);
    out.push_back({subset(all, [&](const Patch& p) { return p.frame == frame; }), weights[i],
                   phases[i], parts[i]});
  }
  for (PhaseImage& image : out) image.weight /= total;
  return out;
}

/// Assigns each image to a part: breaths are dealt out in turn. A breath ends where the phase falls
/// back by more than the noise of a belt.
std::vector<int> parts_by_breath(std::span<const double> phases) {
  constexpr double kFallsBack = 0.3;
  constexpr int kMostParts = 4;
  std::vector<int> breaths;
  int breath = 0;
  double before = 0;
  for (const double phase : phases) {
    if (!std::isnan(phase)) {
      if (phase < before - kFallsBack) ++breath;
      before = phase;
    }
    breaths.push_back(breath);
  }
  const int parts = std::clamp(breath + 1, 2, kMostParts);
  for (int& b : breaths) b %= parts;
  return breaths;
}

/// Longest part of the cycle between neighbouring phases; 1 without images.
double longest_gap(const ChosenImages& images) {
  if (images.empty()) return 1;
  std::vector<double> phases;
  for (const PhaseImage* p : images) phases.push_back(p->phase);
  std::sort(phases.begin(), phases.end());
  double gap = phases.front() + 1 - phases.back();
  for (std::size_t i = 1; i < phases.size(); ++i) gap = std::max(gap, phases[i] - phases[i - 1]);
  return gap;
}

/// A common pose and a motion, fitted to the same images.
struct Rivals {
  PhaseFit still, moving;

  [[nodiscard]] bool finite() const { return still.finite && moving.finite; }
};

/// Fits to all images, coarse to fine. The first harmonic is fitted before the others: far from the
/// solution the others would follow the noise.
Rivals fit_whole(const std::vector<PhaseImages>& levels, const PhaseFit& start,
                 const PhaseOptions& options) {
  constexpr Eigen::Index kFirstHarmonic = 3;
  PhaseOptions near = options;  // Only close enough for the finest level to converge.
  near.cost_tolerance = std::max(options.cost_tolerance, kNearTolerance);
  Rivals out{start, start};
  for (const PhaseImages& level : levels) {
    const ChosenImages images = level.all();
    const PhaseOptions& here = &level == &levels.back() ? options : near;
    out.still = fit_phases(level.ct, images, out.still, 1, here);
    if (&level == &levels.front()) {
      out.moving = fit_phases(level.ct, images, out.still, kFirstHarmonic, near);
    }
    out.moving = fit_phases(level.ct, images, out.moving, 1 + 2 * options.harmonics, here);
  }
  return out;
}

/// Fits to all breaths except one part, on the finest level, starting from the fits to all.
Rivals fit_without(const PhaseImages& finest, int part, const Rivals& whole,
                   const PhaseOptions& options) {
  const ChosenImages seen = finest.without(part);
  return {fit_phases(finest.ct, seen, whole.still, 1, options),
          fit_phases(finest.ct, seen, whole.moving, whole.moving.series.cols(), options)};
}

/// Cross-validation: images judge fits that did not use them.
struct CrossCheck {
  double rigid = 0, moving = 0;
  PairedGain gain;

  void judge(const CtChannels& ct, const ChosenImages& judges, const Rivals& rivals,
             const PhaseOptions& options) {
    const auto a = costs_at(ct, judges, rivals.still.motion(), options);
    const auto b = costs_at(ct, judges, rivals.moving.motion(), options);
    for (std::size_t i = 0; i < judges.size(); ++i) {
      rigid += a[i];
      moving += b[i];
      gain.add(a[i] - b[i]);
    }
  }
  [[nodiscard]] bool finite() const { return std::isfinite(rigid) && std::isfinite(moving); }
};

/// Decides if the images that were left out support the motion.
void choose(const CrossCheck& check, const PhaseOptions& options, PhaseResult& result) {
  result.held_out_rigid = check.rigid / check.gain.count;
  result.held_out_moving = check.moving / check.gain.count;
  result.gain_sigmas = check.gain.sigmas();
  const double share = check.gain.sum / std::max(check.rigid, 1e-12);
  result.supported =
      result.gain_sigmas >= options.min_gain_sigmas && share >= options.min_gain_share;
  std::ostringstream text;
  text.precision(3);
  text << (result.supported ? "moves with the breath" : "rigid")
       << ": in breaths left out of the fit, motion with the breath reduced the cost by "
       << 100 * share << " % (" << result.gain_sigmas << " standard errors)";
  if (!result.supported) {
    text << ", expected at least " << 100 * options.min_gain_share << " % ("
         << options.min_gain_sigmas << ')';
  }
  result.reason = text.str();
}

Result<void> check_phases(const PatchSet& patches, std::span<const double> phases) {
  for (std::size_t i = 0; i < phases.size(); ++i) {
    if (std::isnan(phases[i]) || (phases[i] >= 0 && phases[i] < 1)) continue;
    return Error{ErrorCode::kUsage, "phase of image " + std::to_string(i) +
                                        ": expected [0, 1) or NaN, found " +
                                        std::to_string(phases[i])};
  }
  for (const Patch& p : patches.patches) {
    if (static_cast<std::size_t>(p.frame) < phases.size()) continue;
    return Error{ErrorCode::kUsage, "phases: expected one for each image, found " +
                                        std::to_string(phases.size()) + " and a patch of image " +
                                        std::to_string(p.frame)};
  }
  return {};
}

Result<void> check_images(const PhaseImages& level, int parts, const PhaseOptions& options) {
  if (static_cast<int>(level.images.size()) < options.min_images) {
    return Error{ErrorCode::kRefused, "registration by phase: expected at least " +
                                          std::to_string(options.min_images) +
                                          " images with patches and a phase, found " +
                                          std::to_string(level.images.size())};
  }
  const auto reject = [](const std::string& expected, double gap) {
    return Error{ErrorCode::kRefused,
                 "registration by phase: expected " + expected + ", found none in " +
                     std::to_string(std::lround(100 * gap)) + " % of a breath"};
  };
  if (const double gap = longest_gap(level.all()); gap > options.max_gap) {
    return reject("images of the whole breath", gap);
  }
  for (int part = 0; part < parts; ++part) {
    if (const double gap = longest_gap(level.without(part)); gap > options.max_gap) {
      return reject("images of two whole breaths (each checks the other)", gap);
    }
  }
  return {};
}

Vec centre_of(const std::vector<PhaseImage>& images, const Pose& pose) {
  Vec sum = Vec::Zero();
  for (const PhaseImage& image : images) {
    for (const Patch& p : image.patches.patches) {
      sum += image.weight * p.weight * (pose * Point<frames::Reference>{p.centre_mm}).mm;
    }
  }
  return sum;
}

int count_of(const std::vector<int>& parts) {
  return parts.empty() ? 0 : *std::ranges::max_element(parts) + 1;
}

Result<PhaseResult> refine(const std::vector<PhaseImages>& levels, const Pose& common,
                           std::vector<int> parts, const PhaseOptions& options) {
  const PhaseImages& finest = levels.back();
  const PhaseFit start{common, centre_of(finest.images, common), Eigen::MatrixXd::Zero(6, 1)};
  const Rivals whole = fit_whole(levels, start, options);
  const Error not_finite{ErrorCode::kNumerical,
                         "registration by phase: expected a finite similarity of every image"};
  if (!whole.finite()) return not_finite;
  CrossCheck check;
  std::vector<PhaseMotion> unseen;
  for (int part = 0; part < count_of(parts); ++part) {
    const Rivals others = fit_without(finest, part, whole, options);
    if (!others.finite()) return not_finite;
    check.judge(finest.ct, finest.of(part), others, options);
    unseen.push_back(others.moving.motion());
  }
  if (!check.finite()) return not_finite;
  PhaseResult result{.motion = whole.still.motion(),
                     .rigid_cost = whole.still.cost,
                     .final_cost = whole.still.cost,
                     .images = static_cast<int>(finest.images.size()),
                     .iterations = whole.still.iterations,
                     .unseen = std::move(unseen),
                     .part = std::move(parts)};
  choose(check, options, result);
  if (!result.supported) return result;
  result.motion = whole.moving.motion();
  result.final_cost = whole.moving.cost;
  result.iterations = whole.moving.iterations;
  return result;
}

}  // namespace

Result<void> validate(const PhaseOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("registration by phase: expected ") + what};
  };
  if (o.harmonics < 1 || o.harmonics > 4) return reject("1 to 4 harmonics");
  if (!(o.stiffness > 0 && std::isfinite(o.stiffness))) return reject("stiffness > 0");
  if (!(o.usual_mm.minCoeff() > 0 && o.usual_mm.allFinite())) return reject("usual_mm > 0");
  if (o.max_iterations < 1 || o.max_iterations > 200) return reject("1 to 200 iterations");
  if (!(o.cost_tolerance > 0 && o.cost_tolerance < 1)) return reject("cost_tolerance in (0, 1)");
  if (!(o.ridge > 0 && std::isfinite(o.ridge))) return reject("ridge > 0");
  if (o.threads < 1 || o.threads > 64) return reject("1 to 64 threads");
  if (o.min_images < 8) return reject("min_images >= 8");
  if (!(o.max_gap > 0 && o.max_gap < 1)) return reject("max_gap in (0, 1)");
  if (!(o.min_gain_sigmas > 0)) return reject("min_gain_sigmas > 0");
  if (!(o.min_gain_share >= 0 && o.min_gain_share < 1)) return reject("min_gain_share in [0, 1)");
  return {};
}

Result<PhaseResult> refine_by_phase(const CtChannels& ct, const PatchSet& patches,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options) {
  const std::array<PhaseLevel, 1> level = {PhaseLevel{ct, patches}};
  return refine_by_phase(level, phases, ct_from_reference, options);
}

Result<PhaseResult> refine_by_phase(std::span<const PhaseLevel> given,
                                    std::span<const double> phases, const Pose& ct_from_reference,
                                    const PhaseOptions& options) {
  NAV_CHECK(!given.empty(), given.size());
  if (const auto ok = validate(options); !ok) return ok.error();
  std::vector<int> parts = parts_by_breath(phases);
  std::vector<PhaseImages> levels;
  for (const PhaseLevel& one : given) {
    if (const auto ok = check_phases(one.patches, phases); !ok) return ok.error();
    levels.push_back({one.ct, images_of(one.patches, phases, parts)});
    if (const auto ok = check_images(levels.back(), count_of(parts), options); !ok)
      return ok.error();
  }
  return refine(levels, ct_from_reference, std::move(parts), options);
}

}  // namespace nav::registration
