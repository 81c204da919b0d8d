// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_registration.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "nav/positions.hpp"
#include "registration/search/starts.hpp"
#include "registration/shape/shape_discrepancy.hpp"
#include "registration/shape/shape_rivals.hpp"
#include "registration/shape/shape_solver.hpp"
#include "registration/shape/shape_strain.hpp"

namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;

constexpr std::size_t kMinPoints = 20;
constexpr double kMinSpreadMm = 1;
constexpr std::size_t kScreenPoints = 120;  // Enough to rank poses that are centimetres apart.
constexpr std::size_t kCoarsePoints = 300;
constexpr std::size_t kSolvedShapeStarts = 24;
constexpr std::size_t kFinishedShapes = 4;
constexpr int kCoarseRounds = 6;
constexpr double kSameShapeMm = 2;
constexpr double kOtherMinimumMm = 5;
constexpr double kClearlyWorse = 1.2;
constexpr std::size_t kComparedPoints = 80;

Error reject(ErrorCode code, const std::string& expected, const std::string& found) {
  return {code, "shape registration: expected " + expected + ", found " + found};
}

Error cancelled() { return {ErrorCode::kCancelled, "shape registration: cancelled by the caller"}; }

Point<frames::Reference> centroid_of(const ReferencePoints& points) {
  Point<frames::Reference> centroid{Eigen::Vector3d::Zero()};
  for (const auto& p : points) centroid.mm += p.mm / static_cast<double>(points.size());
  return centroid;
}

DistanceSummary summary_of(const ReferencePoints& points, const ShapeField& shape,
                           const Pose& pose) {
  std::vector<double> d;
  for (const auto& p : points) d.push_back(shape.distance_mm((pose * p).mm));
  std::sort(d.begin(), d.end());
  DistanceSummary out{0, d[d.size() / 2], 0, d[d.size() * 95 / 100]};
  for (const double x : d) {
    out.mean_mm += x / static_cast<double>(d.size());
    out.rms_mm += x * x / static_cast<double>(d.size());
  }
  out.rms_mm = std::sqrt(out.rms_mm);
  return out;
}

class ShapeRegistrar {
 public:
  ShapeRegistrar(std::span<const Point<frames::Reference>> points, const ShapeField& shape,
                 const Pose& initial, const ShapeRegistrationOptions& options,
                 const std::function<bool()>& keep_going)
      : points_(some_points_of(points, static_cast<std::size_t>(options.max_points))),
        coarse_(some_points_of(points_, kCoarsePoints)),
        shape_(shape),
        initial_(initial),
        options_(options),
        keep_going_(keep_going) {}

  Result<ShapeRegistration> run() {
    std::vector<ShapeSolution> found = coarse_solutions();
    if (!stopped_) hold_what_slides(found);
    if (stopped_) return cancelled();
    found.erase(
        found.begin() + static_cast<std::ptrdiff_t>(std::min(found.size(), kFinishedShapes)),
        found.end());
    for (ShapeSolution& one : found) {
      if (stopped()) return cancelled();
      const int before = one.iterations;
      one = descend(points_, shape_, one.pose, options_, options_.max_rounds);
      one.iterations += before;
    }
    sort(found);
    ShapeRegistration result = report(found);
    if (stopped()) return cancelled();
    return result;
  }

 private:
  bool stopped() {
    stopped_ = stopped_ || (keep_going_ && !keep_going_());
    return stopped_;
  }
  static void sort(std::vector<ShapeSolution>& found) {
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.mean_mm < b.mean_mm; });
  }

  /// If the shape leaves directions free, starts that differ only in them are equally good: the
  /// descent from the initial pose is preferred over others that are not clearly better.
  void hold_what_slides(std::vector<ShapeSolution>& found) {
    const ShapeCurvature at = curvature_at(coarse_, shape_, found.front().pose, options_);
    const Observability seen = observability(at.curvature, at.lever_mm, options_.least_strength);
    if (seen.unseen == 0) return;
    const ShapeSolution plain = descend(coarse_, shape_, initial_, options_, options_.max_rounds);
    if (plain.mean_mm > kClearlyWorse * found.front().mean_mm + options_.noise_mm) return;
    found.assign(1, plain);
  }

  /// The initial pose and the starts with the smallest distances.
  std::vector<Pose> ranked_starts() {
    const ReferencePoints screen = some_points_of(points_, kScreenPoints);
    const Eigen::Vector3d centre = (initial_ * centroid_of(points_)).mm;
    // The distance of a point is capped at the largest offset of a start, so that outliers do not
    // decide the ranking.
    const double cap = options_.start_range_mm;
    std::vector<std::pair<double, Pose>> ranked;
    for (const Vector6d& twist : spread_twists(options_.starts, options_.start_range_rad,
                                               options_.start_range_mm, options_.seed)) {
      const Pose pose = moved(initial_, centre, twist);
      double sum = 0;
      for (const auto& p : screen) sum += std::min(shape_.distance_mm((pose * p).mm), cap);
      ranked.emplace_back(sum, pose);
    }
    std::stable_sort(ranked.begin(), ranked.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<Pose> out{initial_};
    for (std::size_t i = 0; i < std::min(ranked.size(), kSolvedShapeStarts); ++i) {
      out.push_back(ranked[i].second);
    }
    return out;
  }

  /// Distinct results from a subset of the points, best first.
  std::vector<ShapeSolution> coarse_solutions() {
    std::vector<ShapeSolution> all;
    for (const Pose& start : ranked_starts()) {
      if (stopped()) return all;
      all.push_back(descend(coarse_, shape_, start, options_, kCoarseRounds));
    }
    sort(all);
    std::vector<ShapeSolution> kept;
    for (const ShapeSolution& one : all) {
      const bool known = std::any_of(kept.begin(), kept.end(), [&](const ShapeSolution& k) {
        return points_apart_mm(coarse_, k.pose, one.pose) < kSameShapeMm;
      });
      if (!known) kept.push_back(one);
    }
    return kept;
  }

  [[nodiscard]] std::optional<double> margin(const std::vector<ShapeSolution>& found) const {
    std::optional<double> least;
    for (const ShapeSolution& other : found) {
      if (points_apart_mm(coarse_, other.pose, found.front().pose) <= kOtherMinimumMm) continue;
      const double own = std::max(found.front().mean_mm, 1e-12);
      least = std::min(least.value_or(1e300), (other.mean_mm - own) / own);
    }
    return least;
  }

  [[nodiscard]] ShapeRegistration report(const std::vector<ShapeSolution>& found) const;
  [[nodiscard]] static PoseUncertainty uncertainty(const ShapeCurvature& at,
                                                   const Observability& seen);

  ReferencePoints points_, coarse_;
  const ShapeField& shape_;
  const Pose& initial_;
  const ShapeRegistrationOptions& options_;
  const std::function<bool()>& keep_going_;
  bool stopped_ = false;
};

/// Sandwich covariance with one score per cube, in the directions that are seen.
PoseUncertainty ShapeRegistrar::uncertainty(const ShapeCurvature& at, const Observability& seen) {
  const auto count = static_cast<double>(at.counted.size());
  Matrix6d inverse = Matrix6d::Zero();
  for (Eigen::Index i = seen.unseen; i < 6; ++i) {
    const Vector6d v = seen.twist(i);
    inverse += v * v.transpose() / (count * seen.strengths[i]);
  }
  const Matrix6d scatter =
      widest_block_scatter(at.places_ct_mm, at.gradients, at.centre_ct_mm, inverse, at.lever_mm);
  return {{at.centre_ct_mm}, inverse * scatter * inverse};
}

ShapeRegistration ShapeRegistrar::report(const std::vector<ShapeSolution>& found) const {
  const ShapeSolution& best = found.front();
  const ShapeCurvature at = curvature_at(points_, shape_, best.pose, options_);
  const Observability seen = observability(at.curvature, at.lever_mm, options_.least_strength);
  const double discrepancy_mm = shape_discrepancy_mm(at.places_ct_mm, at.offsets_mm, shape_.kind());
  ShapeRegistration out{.ct_from_reference = best.pose,
                        .before = summary_of(points_, shape_, initial_),
                        .after = summary_of(points_, shape_, best.pose),
                        .points = static_cast<int>(points_.size()),
                        .trimmed = static_cast<int>(points_.size() - at.counted.size()),
                        .scale_mm = at.scale_mm,
                        .iterations = best.iterations,
                        .converged = best.converged,
                        .sliding = sliding_directions(seen, at.centre_ct_mm),
                        .margin = margin(found),
                        .uncertainty = uncertainty(at, seen),
                        .discrepancy_mm = discrepancy_mm,
                        .some_points = some_points_of(points_, kComparedPoints)};
  if (!out.sliding.empty()) return out;
  std::vector<Pose> others;
  for (const ShapeSolution& one : found) others.push_back(one.pose);
  const ShapeNoise noise = shape_noise(at, discrepancy_mm, options_.least_sigma_mm);
  out.evidence = ShapeEvidence{.noise = noise,
                               .strain = shape_strain(points_, shape_, best.pose, at, noise),
                               .rivals = shape_rivals(points_, shape_, initial_, best.pose, others,
                                                      noise, options_, keep_going_)};
  return out;
}

}  // namespace

Result<void> validate(const ShapeRegistrationOptions& o) {
  const auto check = [](bool ok, const char* what, const char* expected, double found) {
    if (ok) return Result<void>();
    return Result<void>(
        reject(ErrorCode::kUsage, std::string(what) + " of " + expected, std::to_string(found)));
  };
  const std::array checks = {
      check(o.keep_fraction > 0.3 && o.keep_fraction <= 1, "keep_fraction", "0.3 to 1",
            o.keep_fraction),
      check(o.noise_mm > 0 && o.noise_mm <= 100, "noise_mm", "0 to 100", o.noise_mm),
      check(o.max_points >= 20 && o.max_points <= 10000000, "max_points", "20 to 1e7",
            o.max_points),
      check(o.max_rounds >= 1 && o.max_rounds <= 1000, "max_rounds", "1 to 1000", o.max_rounds),
      check(o.starts >= 0 && o.starts <= 1000000, "starts", "0 to 1000000", o.starts),
      check(o.start_range_mm >= 0 && o.start_range_mm <= 200, "start_range_mm", "0 to 200",
            o.start_range_mm),
      check(o.start_range_rad >= 0 && o.start_range_rad <= M_PI, "start_range_rad", "0 to pi",
            o.start_range_rad),
      check(o.least_sigma_mm > 0 && o.least_sigma_mm <= 100, "least_sigma_mm", "0 to 100",
            o.least_sigma_mm),
      check(o.least_strength > 0 && o.least_strength < 1, "least_strength", "0 to 1",
            o.least_strength)};
  for (const auto& ok : checks) {
    if (!ok) return ok;
  }
  return {};
}

Result<ShapeRegistration> register_points(std::span<const Point<frames::Reference>> points,
                                          const ShapeField& shape, const Pose& initial,
                                          const ShapeRegistrationOptions& options,
                                          const std::function<bool()>& keep_going) {
  if (const auto ok = validate(options); !ok) return ok.error();
  if (points.size() < kMinPoints) {
    return reject(ErrorCode::kMalformedData, "at least 20 points", std::to_string(points.size()));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_place(points[i].mm)) continue;
    const std::string point = "point " + std::to_string(i) + " to be ";
    if (!points[i].mm.allFinite()) {
      return reject(ErrorCode::kMalformedData, point + "finite", "NaN or Inf");
    }
    std::ostringstream found;
    found << points[i].mm.transpose();
    return reject(ErrorCode::kMalformedData, point + "within 1e7 mm", found.str());
  }
  const bool spread = std::any_of(points.begin(), points.end(), [&](const auto& p) {
    return (p.mm - points.front().mm).norm() > kMinSpreadMm;
  });
  if (!spread) return reject(ErrorCode::kRefused, "points over 1 mm apart", "one position");
  return ShapeRegistrar(points, shape, initial, options, keep_going).run();
}

}  // namespace nav::registration
