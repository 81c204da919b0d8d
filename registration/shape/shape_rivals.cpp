// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_rivals.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "registration/search/starts.hpp"

namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kRankedPoints = 80;
constexpr std::size_t kSolvedPoints = 250;
constexpr std::size_t kSolvedRivals = 12;
constexpr std::size_t kFinishedRivals = 2;
constexpr int kRivalRounds = 6;
constexpr int kVariations = 5;
constexpr double kVariationRad = 0.2;
constexpr double kVariationMm = 12;
constexpr double kRankedCapMm = 15;
constexpr double kSameRivalMm = 2;
constexpr double kOtherPoseMm = 3;
// A residual beyond this many sigmas says no more than that the point is a stray.
constexpr double kStraySigmas = 3.5;
constexpr std::size_t kMirroredPieces = 300;
// A shape that differs from its mirror image by no more than this has no side for navigation.
constexpr double kSymmetricSigmas = 1.5;
constexpr double kSymmetricMm = 1;
// Around half turns the search is as wide as that for the registration itself.
constexpr int kWideVariations = 30;

ReferencePoints mirrored(ReferencePoints points) {
  for (auto& p : points) p.mm.x() = -p.mm.x();
  return points;
}

struct Axes {
  Eigen::Vector3d centre;
  Eigen::Matrix3d axes;     ///< Columns, longest first, right-handed.
  Eigen::Vector3d lengths;  ///< Standard deviations.
};

template <class Range, class Place>
Axes axes_of(const Range& range, const Place& place) {
  Axes out{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  const auto n = static_cast<double>(range.size());
  for (const auto& one : range) out.centre += place(one) / n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const auto& one : range) {
    const Eigen::Vector3d d = place(one) - out.centre;
    covariance += d * d.transpose() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  for (Eigen::Index i = 0; i < 3; ++i) {
    out.axes.col(i) = solver.eigenvectors().col(2 - i);
    out.lengths[i] = std::sqrt(std::max(solver.eigenvalues()[2 - i], 0.0));
  }
  if (out.axes.determinant() < 0) out.axes.col(2) *= -1;
  return out;
}

/// Rotations that nearly symmetric shapes may have: turns about the long axis, with the shape as it
/// is and end to end, and turns about the other axes.
std::vector<Eigen::Matrix3d> turns_of(const Eigen::Matrix3d& axes) {
  const auto about = [&](Eigen::Index axis, double angle) {
    return Eigen::AngleAxisd(angle, axes.col(axis)).toRotationMatrix();
  };
  std::vector<Eigen::Matrix3d> out;
  for (int k = 0; k < 12; ++k) {
    out.push_back(about(0, k * kPi / 6));
    out.push_back(about(0, k * kPi / 6) * about(2, kPi));
  }
  for (const Eigen::Index axis : {1, 2}) {
    for (int k = 1; k < 8; ++k) {
      if (k != 4) out.push_back(about(axis, k * kPi / 4));
    }
  }
  return out;
}

class RivalSearch {
 public:
  RivalSearch(const ReferencePoints& points, const ShapeField& shape, const Pose& initial,
              const Pose& best, const std::vector<Pose>& others, const ShapeNoise& noise,
              const ShapeRegistrationOptions& options, const std::function<bool()>& keep_going)
      : points_(points),
        shape_(shape),
        initial_(initial),
        best_(best),
        others_(others),
        noise_(noise),
        options_(options),
        keep_going_(keep_going) {}

  ShapeRivals run() {
    const double own = likelihood(points_, best_);
    ShapeRivals out;
    out.turned = rivals(points_, own, false);
    const auto found = rivals(mirrored(points_), own, true);
    if (!found.empty()) {
      out.mirrored = found.front();
      out.own_mirror_image = is_own_mirror_image(found.front().pose);
    }
    return out;
  }

 private:
  [[nodiscard]] Axes shape_axes() const {
    return axes_of(shape_.shape().elements, [](const ShapeElement& e) { return e.point_mm; });
  }
  [[nodiscard]] double misfit(const Eigen::Vector3d& p) const {
    const double sigmas = shape_.distance_mm(p) / noise_.sigma_mm;
    return 0.5 * std::pow(std::min(sigmas, kStraySigmas), 2);
  }
  /// Log-likelihood of independent points, up to a constant.
  [[nodiscard]] double likelihood(const ReferencePoints& points, const Pose& pose) const {
    double sum = 0;
    for (const auto& p : points) sum += misfit((pose * p).mm);
    return -sum * noise_.independent_points / static_cast<double>(points.size());
  }

  /// Registers an even choice of the shape's pieces, mirrored, to the shape, from a pose of
  /// mirrored points. The points see a part of it, so their pose alone would put the rest beside
  /// it.
  [[nodiscard]] bool is_own_mirror_image(const Pose& pose) const {
    const auto& pieces = shape_.shape().elements;
    const std::size_t stride = std::max<std::size_t>(1, pieces.size() / kMirroredPieces);
    const auto reference_from_ct = best_.inverse();
    ReferencePoints all;
    for (std::size_t i = 0; i < pieces.size(); i += stride) {
      all.push_back(reference_from_ct * Point<frames::Ct>{pieces[i].point_mm});
    }
    all = mirrored(std::move(all));
    const Pose whole = descend(all, shape_, pose, options_, kRivalRounds).pose;
    if (points_apart_mm(mirrored(points_), whole, pose) > kOtherPoseMm) return false;
    double squares = 0;
    for (const auto& p : all) squares += std::pow(shape_.distance_mm((whole * p).mm), 2);
    return std::sqrt(squares / static_cast<double>(all.size())) <=
           std::max(kSymmetricSigmas * noise_.sigma_mm, kSymmetricMm);
  }

  /// The pose that puts each mirrored point where a pose puts its original, reflected in the plane
  /// across the shape's shortest axis.
  [[nodiscard]] static Pose reflected(const Pose& pose, const Axes& of) {
    const Eigen::Vector3d across = of.axes.col(2);
    const Eigen::Matrix3d reflect = Eigen::Matrix3d::Identity() - 2 * across * across.transpose();
    const Eigen::Matrix3d back = Eigen::Vector3d(-1, 1, 1).asDiagonal();
    const Eigen::Matrix3d rotation = reflect * pose.rotation().toRotationMatrix() * back;
    return {Eigen::Quaterniond(rotation).normalized(),
            of.centre + reflect * (pose.translation_mm() - of.centre)};
  }

  std::vector<Pose> ranked(const ReferencePoints& points, bool mirror) const {
    const Axes of = shape_axes();
    const ReferencePoints few = some_points_of(points, kRankedPoints);
    const auto variations = spread_twists(kVariations, kVariationRad, kVariationMm, options_.seed);
    std::vector<std::pair<double, Pose>> all;
    const auto consider = [&](const Pose& pose) {
      double sum = 0;
      for (const auto& p : few) sum += std::min(shape_.distance_mm((pose * p).mm), kRankedCapMm);
      all.emplace_back(sum, pose);
    };
    const Eigen::Vector3d along = of.axes.col(0) * of.lengths[0];
    const auto wide = spread_twists(kWideVariations, options_.start_range_rad,
                                    options_.start_range_mm, options_.seed + 1);
    for (const bool from_best : {true, false}) {
      const Pose& from = from_best ? best_ : initial_;
      const Pose centre = mirror ? reflected(from, of) : from;
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const auto& p : few) middle += (centre * p).mm / static_cast<double>(few.size());
      for (const Eigen::Matrix3d& turn : turns_of(of.axes)) {
        const bool half_turn = (turn - turn.transpose()).norm() < 1e-6;
        if (!from_best && !half_turn) continue;
        const Eigen::Quaterniond r = (Eigen::Quaterniond(turn) * centre.rotation()).normalized();
        for (const Eigen::Vector3d& about : {of.centre, middle}) {
          for (const double shift : {0.0, -0.4, 0.4}) {
            const Pose pose{r, about + turn * (centre.translation_mm() - about) + shift * along};
            consider(pose);
            const Eigen::Vector3d at = about + turn * (middle - about) + shift * along;
            const auto& around = half_turn && shift == 0.0 ? wide : variations;
            for (const Vector6d& twist : around) consider(moved(pose, at, twist));
          }
        }
      }
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    // Starts that a solve would bring together count once.
    std::vector<Pose> out;
    for (const auto& [sum, pose] : all) {
      const bool known = std::any_of(out.begin(), out.end(), [&](const Pose& k) {
        return points_apart_mm(few, k, pose) < kVariationMm;
      });
      if (!known) out.push_back(pose);
      if (out.size() >= kSolvedRivals) break;
    }
    return out;
  }

  /// Distinct minima other than the registration, strongest first.
  std::vector<ShapeRival> rivals(const ReferencePoints& points, double own, bool mirror) const {
    const ReferencePoints some = some_points_of(points, kSolvedPoints);
    std::vector<std::pair<double, Pose>> found;
    for (const Pose& start : ranked(points, mirror)) {
      if (keep_going_ && !keep_going_()) return {};
      const Pose pose = descend(some, shape_, start, options_, kRivalRounds).pose;
      if (!mirror && points_apart_mm(some, pose, best_) < kOtherPoseMm) continue;
      found.emplace_back(likelihood(some, pose), pose);
    }
    for (const Pose& pose : others_) {
      if (!mirror && points_apart_mm(some, pose, best_) >= kOtherPoseMm) {
        found.emplace_back(likelihood(some, pose), pose);
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<ShapeRival> out;
    std::vector<Pose> taken;
    for (const auto& [value, pose] : found) {
      const bool known = std::any_of(taken.begin(), taken.end(), [&](const Pose& k) {
        return points_apart_mm(some, k, pose) < kSameRivalMm;
      });
      if (known) continue;
      taken.push_back(pose);
      const ShapeSolution solved = descend(points, shape_, pose, options_, options_.max_rounds);
      const double apart_mm = mirror ? apart_from_best(points, solved.pose)
                                     : points_apart_mm(points, solved.pose, best_);
      if (mirror || apart_mm >= kOtherPoseMm) {
        out.push_back(
            {.pose = solved.pose,
             .mirrored = mirror,
             .mean_mm = solved.mean_mm,
             .evidence = own - likelihood(points, solved.pose),
             .apart_mm = apart_mm,
             .turned_deg =
                 mirror ? 0
                        : solved.pose.rotation().angularDistance(best_.rotation()) * 180 / kPi});
      }
      if (taken.size() >= kFinishedRivals) break;
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const auto& a, const auto& b) { return a.evidence < b.evidence; });
    return out;
  }

  [[nodiscard]] double apart_from_best(const ReferencePoints& flipped, const Pose& pose) const {
    double sum = 0;
    for (std::size_t i = 0; i < flipped.size(); ++i) {
      sum += ((pose * flipped[i]).mm - (best_ * points_[i]).mm).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(flipped.size()));
  }

  const ReferencePoints& points_;
  const ShapeField& shape_;
  const Pose& initial_;
  const Pose& best_;
  const std::vector<Pose>& others_;
  const ShapeNoise& noise_;
  const ShapeRegistrationOptions& options_;
  const std::function<bool()>& keep_going_;
};

}  // namespace

ShapeRivals shape_rivals(const ReferencePoints& points, const ShapeField& shape,
                         const Pose& initial, const Pose& best, const std::vector<Pose>& others,
                         const ShapeNoise& noise, const ShapeRegistrationOptions& options,
                         const std::function<bool()>& keep_going) {
  return RivalSearch(points, shape, initial, best, others, noise, options, keep_going).run();
}

}  // namespace nav::registration
