// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/search/skin_search.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <sstream>

#include "nav/stopwatch.hpp"
#include "registration/pose_solver.hpp"
#include "registration/prepared.hpp"
#include "registration/search/body_surface.hpp"
#include "registration/search/global_search.hpp"
#include "registration/similarity/image_outline.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;

// The face of the probe is pressed up to a centimetre into the skin, or floats on gel; the surface
// is about as coarse.
constexpr double kPressMm = 4;
constexpr double kPressSpreadMm = 10;
constexpr double kLeastInside = 0.85;
constexpr double kLeastOverlap = 0.6;
constexpr std::size_t kFacesLookedAt = 12;
constexpr std::size_t kPointsLookedAt = 60;
constexpr double kSamePlaceMm = 5;
constexpr double kSamePoseMm = 1;
constexpr std::size_t kKeptPlaces = 2;
constexpr double kLeastTimeLimitS = 1e-9;

/// The middle of the transducer's face, Image.
Point<frames::Image> face_of(const UltrasoundImage& frame) {
  if (frame.outline) {
    const Eigen::Vector2d p =
        frame.outline->apex_mm + Eigen::Vector2d(0, frame.outline->radius_min_mm);
    return {{p.x(), p.y(), 0}};
  }
  return frame.grid.at(0.5 * (frame.pixels.width() - 1), 0);
}

/// Evenly chosen elements, about count of them.
template <class T>
std::vector<T> some_of(const std::vector<T>& all, std::size_t count) {
  const std::size_t stride = std::max<std::size_t>(1, all.size() / count);
  std::vector<T> out;
  for (std::size_t i = stride / 2; i < all.size(); i += stride) out.push_back(all[i]);
  return out;
}

/// The positions of a sweep's transducer faces and points.
struct Held {
  std::vector<Point<frames::Reference>> faces, points;
  Point<frames::Reference> face{{0, 0, 0}};  ///< Face of the middle image.
  Eigen::Matrix3d axes;  ///< Lateral, depth and elevational axes of the middle image.
};

Held held(const Sweep& sweep, const SweepPoints& points) {
  Held out;
  for (const TrackedImage& tracked : sweep.frames()) {
    out.faces.push_back(tracked.reference_from_image * face_of(tracked.frame));
  }
  const std::size_t middle = sweep.frames().size() / 2;
  out.face = out.faces[middle];
  out.axes = sweep.frames()[middle].reference_from_image.rotation().toRotationMatrix();
  out.faces = some_of(out.faces, kFacesLookedAt);
  out.points = some_of(points.points, kPointsLookedAt);
  return out;
}

/// True if the whole sweep stands on the body and looks into it.
bool stands(const Held& held, const BodySurface& body, const VoxelGrid& grid, const Pose& pose) {
  double squares = 0;
  for (const auto& face : held.faces) {
    const double off = body.depth_mm(pose * face) - kPressMm;
    squares += off * off / static_cast<double>(held.faces.size());
  }
  if (!(squares <= kPressSpreadMm * kPressSpreadMm)) return false;
  std::size_t inside = 0, in_ct = 0;
  const Eigen::Array3d last =
      Eigen::Array3d(grid.size[0], grid.size[1], grid.size[2]) - Eigen::Array3d::Ones();
  for (const auto& point : held.points) {
    const auto p = pose * point;
    inside += body.depth_mm(p) > 0 ? 1 : 0;
    const Eigen::Array3d index = grid.index_of(p).array();
    in_ct += (index >= 0).all() && (index <= last).all() ? 1 : 0;
  }
  const auto count = static_cast<double>(held.points.size());
  return static_cast<double>(inside) >= kLeastInside * count &&
         static_cast<double>(in_ct) >= kLeastOverlap * count;
}

/// Inclinations of the probe from the skin's normal, about its two other axes.
std::vector<Eigen::Quaterniond> leans(double lean_rad) {
  std::vector<Eigen::Quaterniond> out{Eigen::Quaterniond::Identity()};
  if (lean_rad <= 0) return out;
  for (const Vec& axis : {Vec(Vec::UnitX()), Vec(Vec::UnitZ())}) {
    for (const double sign : {-1.0, 1.0}) {
      out.emplace_back(Eigen::AngleAxisd(sign * lean_rad, axis));
    }
  }
  return out;
}

/// True if a probe with these axes agrees with the known orientation, if one is given.
bool held_so(const Eigen::Matrix3d& axes_in_ct, const SkinSearchOptions& options) {
  return !options.marker_towards ||
         -axes_in_ct.col(0).dot(*options.marker_towards) >= std::cos(options.marker_within_rad);
}

/// Time limit and cancellation of a search without a start.
class Patience {
 public:
  Patience(double limit_s, const std::function<bool(double fraction)>& progress)
      : limit_s_(limit_s), progress_(progress) {}

  bool keep_going() {
    cancelled_ = cancelled_ || (progress_ && !progress_(0));
    return !cancelled_ && !late();
  }
  [[nodiscard]] bool late() const { return left_s() <= 0; }
  [[nodiscard]] double left_s() const { return limit_s_ - seconds_since(start_); }
  /// Reason for a missing pose, if the search ended early.
  [[nodiscard]] std::optional<Error> error() const {
    const std::string what = "registration without a start pose: ";
    if (cancelled_) return Error{ErrorCode::kCancelled, what + "cancelled by the caller"};
    if (!late()) return {};
    std::ostringstream text;
    text << what << "expected a position within the time limit of " << limit_s_ << " s, found none";
    return Error{ErrorCode::kTimeout, text.str()};
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  double limit_s_;
  const std::function<bool(double fraction)>& progress_;
  bool cancelled_ = false;
};

std::vector<Pose> standing_poses(const Held& held, const BodySurface& body, const VoxelGrid& grid,
                                 const SkinSearchOptions& options, Patience& patience) {
  std::vector<Pose> poses;
  const auto tilts = leans(options.lean_rad);
  for (const SkinPoint& skin : body.points(options.spacing_mm)) {
    if (!patience.keep_going()) break;
    Eigen::Matrix3d upright;  // x, y (into the body) and z axes of an ultrasound image.
    upright.col(1) = skin.inward;
    upright.col(0) = skin.inward.unitOrthogonal();
    upright.col(2) = upright.col(0).cross(upright.col(1));
    for (int turn = 0; turn < options.turns; ++turn) {
      const Eigen::AngleAxisd about(2 * std::numbers::pi * turn / options.turns, Vec::UnitY());
      for (const auto& tilt : tilts) {
        const Eigen::Matrix3d axes = upright * (about * tilt).toRotationMatrix();
        if (!held_so(axes, options)) continue;
        const Eigen::Quaterniond q(Eigen::Matrix3d(axes * held.axes.transpose()));
        const Vec face = skin.place.mm + kPressMm * skin.inward;
        const Pose pose(q.normalized(), face - q.normalized() * held.face.mm);
        if (stands(held, body, grid, pose)) poses.push_back(pose);
      }
    }
  }
  return poses;
}

/// Positions that are registered to the end, and the margin to the best of the others.
struct RivalPlaces {
  std::vector<PoseSolution> places;
  std::optional<double> margin;
};

/// Solves each position on the second level, if it is not the finest. A position that costs much
/// more there has lost.
RivalPlaces rivals_of(const Volume& ct, const PreparedSweep& sweep, const std::vector<Found>& found,
                      const ImageRegistrationOptions& options, const SkinSearchOptions& search,
                      Patience& patience) {
  std::vector<PoseSolution> all;
  for (const Found& one : found) {
    if (all.size() == static_cast<std::size_t>(search.followed)) break;
    all.push_back(one.solution);
  }
  if (sweep.levels().size() < 3) return {std::move(all), {}};
  const PreparedLevel& level = sweep.levels()[1];
  ImageRegistrationOptions plain = options;
  plain.starts = 0;
  for (PoseSolution& place : all) {
    if (!patience.keep_going()) break;
    const auto channels = make_ct_channels(ct, reachable_box(sweep, place.pose, plain),
                                           sigma_of(level.options.sample_step_mm));
    if (!channels) continue;
    const SimilarityCost cost(*channels, level.patches, options.ridge, options.threads,
                              measure_of(options.similarity));
    place =
        solve_pose(cost, place.pose, sweep.points().centroid,
                   {options.max_iterations, kCoarseTolerance, [&] { return patience.late(); }}, {});
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.final_cost < b.final_cost; });
  RivalPlaces out;
  for (const PoseSolution& place : all) {
    const bool known = std::any_of(out.places.begin(), out.places.end(), [&](const auto& kept) {
      return distance_mm(sweep.points(), kept.pose, place.pose) < kSamePoseMm;
    });
    if (known) continue;
    const double ratio = place.final_cost / std::max(all.front().final_cost, 1e-12);
    if (ratio < kLostRatio && out.places.size() < kKeptPlaces) {
      out.places.push_back(place);
    } else if (distance_mm(sweep.points(), all.front().pose, place.pose) > kSamePlaceMm) {
      out.margin = std::min(out.margin.value_or(ratio - 1), ratio - 1);
    }
  }
  return out;
}

/// The result with the lowest cost, and its margin to the others.
ImageRegistrationResult best_of(std::vector<ImageRegistrationResult> ends,
                                const SweepPoints& points, const std::optional<double>& margin) {
  std::stable_sort(ends.begin(), ends.end(),
                   [](const auto& a, const auto& b) { return a.final_cost < b.final_cost; });
  ImageRegistrationResult best = std::move(ends.front());
  if (margin) best.margin = std::min(best.margin.value_or(*margin), *margin);
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const auto& pose = ends[i].ct_from_reference;
    if (distance_mm(points, best.ct_from_reference, pose) <= kSamePlaceMm) continue;
    const double one = ends[i].final_cost / std::max(best.final_cost, 1e-12) - 1;
    best.margin = std::min(best.margin.value_or(one), one);
  }
  return best;
}

}  // namespace

Result<void> validate(const SkinSearchOptions& options) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("skin search: expected ") + what};
  };
  if (!(options.spacing_mm > 0 && options.spacing_mm <= 200)) {
    return reject("spacing_mm in (0, 200]");
  }
  if (options.turns < 1 || options.turns > 360) return reject("turns of 1 to 360");
  if (!(options.lean_rad >= 0 && options.lean_rad <= 1)) return reject("lean_rad in [0, 1]");
  if (options.tried < 1 || options.tried > 1000000) return reject("tried of 1 to 1000000");
  if (options.followed < 1 || options.followed > 100) return reject("followed of 1 to 100");
  constexpr double kUnit = 1e-6;
  if (options.marker_towards && !(std::abs(options.marker_towards->norm() - 1) <= kUnit)) {
    return reject("marker_towards of length 1");
  }
  if (!(options.marker_within_rad > 0 && options.marker_within_rad <= std::numbers::pi)) {
    return reject("marker_within_rad in (0, pi]");
  }
  return {};
}

Result<ImageRegistrationResult> register_on_skin(
    const Volume& ct, const Sweep& as_recorded, const ImageRegistrationOptions& options,
    const SkinSearchOptions& search_options, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress) {
  if (const auto ok = validate(search_options); !ok) return ok.error();
  const auto begin = std::chrono::steady_clock::now();
  Patience patience(options.time_limit_s, progress);
  const auto keep_going = [&] { return patience.keep_going(); };
  const Sweep sweep = with_outline(as_recorded);
  const auto prepared = PreparedSweep::create(sweep, options, diagnostics, keep_going);
  if (!prepared) return patience.error().value_or(prepared.error());
  const BodySurface body(ct);
  const auto poses =
      standing_poses(held(sweep, prepared->points()), body, ct.grid(), search_options, patience);
  if (const auto error = patience.error()) return *error;
  if (poses.empty()) {
    return Error{ErrorCode::kRefused,
                 "registration without a start pose: expected skin in " + ct.name() +
                     " on which the sweep fits" +
                     (search_options.marker_towards ? " with its marker as declared" : "") +
                     ", found none"};
  }
  const PreparedLevel& level = prepared->levels().front();
  const auto channels =
      make_ct_channels(ct, box_of(ct.grid()), sigma_of(level.options.sample_step_mm));
  if (!channels) return channels.error();
  const SimilarityCost cost(*channels, level.patches, options.ridge, options.threads,
                            measure_of(options.similarity));
  int non_finite = 0;
  const SearchOptions about{
      .max_iterations = options.max_iterations, .seed = options.seed, .threads = options.threads};
  const Places places{poses, search_options.spacing_mm,
                      static_cast<std::size_t>(search_options.tried)};
  const auto found = search_among(cost, places, prepared->points(), about, keep_going, non_finite);
  const RivalPlaces rivals = rivals_of(ct, *prepared, found, options, search_options, patience);
  ImageRegistrationOptions plain = options;
  plain.starts = 0;
  std::vector<ImageRegistrationResult> ends;
  for (const PoseSolution& place : rivals.places) {
    // After the time limit the best result so far is returned, and it will be rejected.
    if (!patience.keep_going() && !ends.empty()) break;
    plain.time_limit_s = std::max(patience.left_s(), kLeastTimeLimitS);
    auto end = register_prepared(ct, *prepared, place.pose, plain, progress);
    if (!end && end.error().code == ErrorCode::kRefused) continue;  // Position outside the CT.
    if (!end) return end.error();
    ends.push_back(std::move(*end));
  }
  if (ends.empty()) {
    return patience.error().value_or(
        Error{ErrorCode::kRefused, "registration without a start pose: expected a position in " +
                                       ct.name() + " that the sweep matches, found none"});
  }
  auto best = best_of(std::move(ends), prepared->points(), rivals.margin);
  // Positions that were not reached in time might have been better.
  if (patience.late()) best.termination = Termination::kTimeLimit;
  best.total_s = seconds_since(begin);
  return best;
}

}  // namespace nav::registration
