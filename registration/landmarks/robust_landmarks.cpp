// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/robust_landmarks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace nav::registration {
namespace {

using Pairs = std::vector<LandmarkPair>;
using Pose = Transform<frames::Ct, frames::Reference>;

constexpr std::size_t kMinAgreeing = 4;
constexpr int kMaxRefits = 20;

double sigmas_off(const Pose& pose, const LandmarkPair& pair) {
  return ((pose * pair.reference).mm - pair.ct.mm).norm() / pair.sigma_mm;
}

/// Σ min(d²/σ², limit²).
double truncated_sum(const Pose& pose, const Pairs& pairs, double limit) {
  double sum = 0;
  for (const LandmarkPair& pair : pairs) {
    sum += std::pow(std::min(sigmas_off(pose, pair), limit), 2);
  }
  return sum;
}

Pairs agreeing(const Pose& pose, const Pairs& pairs, double limit) {
  Pairs out;
  std::copy_if(pairs.begin(), pairs.end(), std::back_inserter(out),
               [&](const LandmarkPair& pair) { return sigmas_off(pose, pair) <= limit; });
  return out;
}

/// All triples, or an even choice of them.
std::vector<std::array<std::size_t, 3>> triples_of(std::size_t n, int most) {
  const std::size_t all = n * (n - 1) * (n - 2) / 6;
  const std::size_t stride =
      (all + static_cast<std::size_t>(most) - 1) / static_cast<std::size_t>(most);
  std::vector<std::array<std::size_t, 3>> out;
  std::size_t index = 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      for (std::size_t k = j + 1; k < n; ++k) {
        if (index++ % stride == 0) out.push_back({i, j, k});
      }
    }
  }
  return out;
}

/// Pose of the best triple; absent if no triple determines one.
std::optional<Pose> best_start(const Pairs& pairs, const RobustLandmarkOptions& options) {
  std::optional<Pose> best;
  double least = 0;
  for (const auto& triple : triples_of(pairs.size(), options.max_triples)) {
    const Pairs three{pairs[triple[0]], pairs[triple[1]], pairs[triple[2]]};
    const auto fit = register_landmarks(three);
    if (!fit) continue;
    const double sum = truncated_sum(fit->ct_from_reference, pairs, options.inlier_sigmas);
    if (best && sum >= least) continue;
    best = fit->ct_from_reference;
    least = sum;
  }
  return best;
}

std::vector<std::string> names_missing(const Pairs& all, const Pairs& kept) {
  std::vector<std::string> names;
  for (const LandmarkPair& pair : all) {
    const bool there = std::any_of(kept.begin(), kept.end(),
                                   [&](const LandmarkPair& k) { return k.name == pair.name; });
    if (!there) names.push_back(pair.name);
  }
  return names;
}

/// Finds the pairs that agree with each other: first with the best triple, then with the fit of the
/// agreeing pairs.
Pairs agreeing_most(const Pairs& all, const RobustLandmarkOptions& options) {
  const auto pose = best_start(all, options);
  if (!pose) return {};
  Pairs kept = agreeing(*pose, all, options.inlier_sigmas);
  for (int i = 0; i < kMaxRefits; ++i) {
    const auto fit = register_landmarks(kept);
    if (!fit) break;
    Pairs next = agreeing(fit->ct_from_reference, all, options.inlier_sigmas);
    const bool same = names_missing(kept, next).empty() && next.size() == kept.size();
    kept = std::move(next);
    if (same) break;
  }
  return kept;
}

bool is_majority(const Pairs& kept, const Pairs& all) {
  return kept.size() >= kMinAgreeing && 2 * kept.size() > all.size();
}

/// True if a majority agrees once an axis is flipped, and at least as many pairs as without the
/// flip.
bool is_flipped(const Pairs& all, const Pairs& kept, const RobustLandmarkOptions& options) {
  Pairs flipped = all;
  for (LandmarkPair& pair : flipped) pair.reference.mm.x() = -pair.reference.mm.x();
  const Pairs agree = agreeing_most(flipped, options);
  return is_majority(agree, all) && agree.size() >= kept.size();
}

Error no_agreement(const Pairs& all, const Pairs& kept) {
  std::string text = "landmarks: expected more than half of the " + std::to_string(all.size()) +
                     " pairs to agree, and at least " + std::to_string(kMinAgreeing) + ", found " +
                     std::to_string(kept.size());
  const auto rejected = names_missing(all, kept);
  for (std::size_t i = 0; i < rejected.size(); ++i) {
    text += (i == 0 ? "; not among them: '" : "', '") + rejected[i];
  }
  return {ErrorCode::kRefused, text + (rejected.empty() ? "" : "'")};
}

}  // namespace

Result<RobustLandmarkRegistration> register_landmarks_robustly(
    std::span<const LandmarkPair> pairs, const RobustLandmarkOptions& options) {
  if (!(options.inlier_sigmas > 0 && std::isfinite(options.inlier_sigmas)) ||
      options.max_triples < 1) {
    return Error{ErrorCode::kUsage,
                 "landmarks: expected inlier_sigmas > 0 and max_triples >= 1, found " +
                     std::to_string(options.inlier_sigmas) + " and " +
                     std::to_string(options.max_triples)};
  }
  // Bad values and degenerate layouts are errors, not outliers.
  if (const auto ok = check_landmarks(pairs); !ok) return ok.error();
  const Pairs all(pairs.begin(), pairs.end());
  const auto all_together = register_landmarks(pairs);
  if (all_together &&
      agreeing(all_together->ct_from_reference, all, options.inlier_sigmas).size() == all.size()) {
    return RobustLandmarkRegistration{*all_together, {}};
  }
  const Pairs kept = agreeing_most(all, options);
  // Two swapped names may look like a flipped axis.
  if (!all_together && is_flipped(all, kept, options)) return all_together.error();
  if (!is_majority(kept, all)) return no_agreement(all, kept);
  auto fit = register_landmarks(kept);
  if (!fit) return fit.error();
  return RobustLandmarkRegistration{std::move(*fit), names_missing(all, kept)};
}

}  // namespace nav::registration
