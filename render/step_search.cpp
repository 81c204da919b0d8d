// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/step_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "render/ray_spec.hpp"
#include "render/sparse_rays.hpp"

namespace nav::render {
namespace {

constexpr int kRays = 64 * 48;
constexpr double kCoarsest = 4;             // Voxels.
constexpr std::size_t kSteps = 6;           // Down to 1/8 voxel.
constexpr double kReferencePart = 1.0 / 4;  // Of the step at which the halving ends.
// The rays are few, and pictures of 8 bits err by up to 0.0011 more, which adds as squares.
constexpr double kMargin = 0.86;    // What is aimed at.
constexpr double kAccepted = 0.88;  // What a step that was drawn may show.
constexpr int kTries = 3;           // Between two steps.

// Sparing rays.
constexpr int kTileColumns = 3;
constexpr int kTileRows = 2;
constexpr int kTileSide = 25;  // Pixels: whole squares of a lattice of 4 and of 2.
constexpr double kPixelErrors[] = {0.012, 0.025};  // What coarser ones err shows in few places.
constexpr double kTileSafety = 1.5;                // The tiles are few too.
constexpr double kTileCoarser = 2;  // Than the step: neither saving nor error depends much on it.
// What the CPU engine takes, in volume samples: a gradient, a ray, a pixel of a sparse picture; and
// rays that lie apart, over as many of a dense picture.
constexpr double kGradientSamples = 1.3;
constexpr double kRaySamples = 8;
constexpr double kPixelSamples = 12;
constexpr double kScattered = 1.15;
constexpr double kWorthwhile = 0.9;  // Of the dense picture's time; else every pixel has its ray.

Scene ct_alone(const Scene& scene) {
  Scene few = scene;
  few.plane.reset();
  few.needle.reset();
  few.spheres.clear();
  few.lines.clear();
  few.cutaway.reset();
  few.predicates.reset();
  few.ultrasound.reset();
  few.quality.pixel_error = 0;
  return few;
}

/// The CT alone, in few pixels.
Scene few_rays(const Scene& scene) {
  Scene few = ct_alone(scene);
  const double across = static_cast<double>(scene.width) / scene.height;
  few.width = std::clamp(static_cast<int>(std::lround(std::sqrt(kRays * across))), 1, kRays);
  few.height = std::clamp(static_cast<int>(std::lround(few.width / across)), 1, kRays);
  return few;
}

/// Where errors that follow a power of the step pass an error; fine itself where they do not.
StepChoice between(const StepChoice& coarse, const StepChoice& fine, double rms) {
  if (!(fine.rms > 0 && fine.rms < rms && rms < coarse.rms)) return fine;
  const double share = std::log(rms / fine.rms) / std::log(coarse.rms / fine.rms);
  return {fine.step_voxels * std::pow(coarse.step_voxels / fine.step_voxels, share), rms, true};
}

/// Pictures of few rays, each step half of the one before.
class Pictures {
 public:
  Pictures(Engine& engine, const Scene& scene) : engine_(engine), few_(few_rays(scene)) {}

  static double step(std::size_t i) { return kCoarsest * std::pow(0.5, static_cast<double>(i)); }

  /// Draws those up to the i-th that are not there yet.
  Result<void> draw_to(std::size_t i) {
    while (pictures_.size() <= i) {
      auto picture = drawn(step(pictures_.size()));
      if (!picture) return picture.error();
      pictures_.push_back(std::move(*picture));
    }
    return {};
  }
  Result<Image2d<RgbaF>> drawn(double step_voxels) {
    few_.quality.step_voxels = step_voxels;
    auto image = engine_.render(few_);
    if (!image) return image.error();
    return std::move(image->pixels);
  }
  [[nodiscard]] const Image2d<RgbaF>& at(std::size_t i) const { return pictures_[i]; }

 private:
  Engine& engine_;
  Scene few_;
  std::vector<Image2d<RgbaF>> pictures_;
};

/// What sparing rays does to a scene.
struct Sparing {
  double pixel_error = 0;
  double rms = 0;   ///< Between the pictures with and without.
  double cost = 1;  ///< Over that of a ray for every pixel, by what was sampled.
};

/// A part of the picture about a pixel, at the picture's own resolution: turned towards it in
/// perspective, which is the same rays but for their slant.
Scene tile_of(const Scene& scene, int column, int row) {
  Scene tile = scene;
  const auto view =
      spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid());
  const auto x = (2 * column + 1) * scene.width / (2 * kTileColumns);
  const auto y = (2 * row + 1) * scene.height / (2 * kTileRows);
  const auto ray = spec::ray_of(view, x, y);
  const Eigen::Vector3d eye = ray.origin + scene.ct->grid().origin_mm;
  tile.camera.eye_ct.mm = eye;
  tile.camera.look_at_ct.mm = eye + ray.direction;
  tile.camera.up_ct.v = view.up;  // Never along the ray.
  tile.width = tile.height = kTileSide;
  const double share = static_cast<double>(kTileSide) / scene.height;
  tile.camera.orthographic_height_mm *= share;
  tile.camera.vertical_fov_rad = 2 * std::atan(share * std::tan(scene.camera.vertical_fov_rad / 2));
  return tile;
}

double cost_of(const RenderStatistics& taken) {
  return static_cast<double>(taken.volume_samples) +
         kGradientSamples * static_cast<double>(taken.gradient_samples) +
         kRaySamples * static_cast<double>(taken.rays);
}

/// Measured on tiles at a step; only those that save time. Empty: none does.
Result<std::vector<Sparing>> sparings(Engine& engine, const Scene& scene, double step_voxels) {
  std::vector<Sparing> found;
  Scene few = ct_alone(scene);
  few.quality.step_voxels = std::min(kTileCoarser * step_voxels, kCoarsest);
  few.quality.pixel_error = kPixelErrors[0];
  const bool large =
      scene.width >= kTileColumns * kTileSide && scene.height >= kTileRows * kTileSide;
  if (!large || !sparse_rays(few)) return found;
  std::array<double, std::size(kPixelErrors)> squares{};
  std::array<double, std::size(kPixelErrors)> costs{};
  double dense_cost = 0;
  for (int i = 0; i < kTileColumns * kTileRows; ++i) {
    Scene tile = tile_of(few, i % kTileColumns, i / kTileColumns);
    tile.quality.pixel_error = 0;
    const auto dense = engine.render(tile);
    if (!dense) return dense.error();
    dense_cost += cost_of(dense->statistics);
    for (std::size_t j = 0; j < std::size(kPixelErrors); ++j) {
      tile.quality.pixel_error = kPixelErrors[j];
      const auto spared = engine.render(tile);
      if (!spared) return spared.error();
      const double rms = rms_difference(spared->pixels, dense->pixels);
      squares[j] += rms * rms / (kTileColumns * kTileRows);
      costs[j] += kScattered * cost_of(spared->statistics) + kPixelSamples * kTileSide * kTileSide;
    }
  }
  for (std::size_t j = 0; j < std::size(kPixelErrors); ++j) {
    if (costs[j] > kWorthwhile * dense_cost || !(dense_cost > 0)) continue;
    found.push_back({kPixelErrors[j], kTileSafety * std::sqrt(squares[j]), costs[j] / dense_cost});
  }
  return found;
}

/// The coarsest step found whose picture errs no more than wanted, and what was known of others.
class Ladder {
 public:
  /// Errors against truth of the steps drawn, from coarse to fine.
  explicit Ladder(std::vector<StepChoice> measured) : measured_(std::move(measured)) {}

  /// By interpolation; the finest where it errs more.
  [[nodiscard]] StepChoice at(double rms) const {
    StepChoice found = measured_.back();
    for (std::size_t i = measured_.size() - 1; found.rms <= rms && i-- > 0;) {
      if (measured_[i].rms > rms) return between(measured_[i], found, rms);
      found = measured_[i];
    }
    return found;
  }
  void add(const StepChoice& one) {
    const auto coarser = [](const StepChoice& a, const StepChoice& b) {
      return a.step_voxels > b.step_voxels;
    };
    measured_.insert(std::upper_bound(measured_.begin(), measured_.end(), one, coarser), one);
  }

 private:
  std::vector<StepChoice> measured_;
};

/// The pixel error that makes the picture cheapest: samples go with 1 / step.
Sparing cheapest(const Ladder& ladder, const std::vector<Sparing>& all, double wanted) {
  const double dense_step = ladder.at(wanted).step_voxels;
  Sparing best;
  double least = kWorthwhile;
  for (const Sparing& one : all) {
    if (one.rms >= wanted) continue;
    const double left = std::sqrt(wanted * wanted - one.rms * one.rms);
    const StepChoice with = ladder.at(left);
    if (with.rms > left) continue;
    const double cost = one.cost * dense_step / with.step_voxels;
    if (cost >= least) continue;
    least = cost;
    best = one;
  }
  return best;
}

}  // namespace

Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms) {
  if (!(rms > 0 && rms <= 1)) {
    return Error{ErrorCode::kUsage,
                 "step for an error: expected an rms in (0, 1], found " + std::to_string(rms)};
  }
  Pictures pictures(engine, scene);
  // A step whose picture changes little when it is halved.
  std::size_t last = 0;
  for (;; ++last) {
    if (auto ok = pictures.draw_to(last + 1); !ok) return ok.error();
    const double change = rms_difference(pictures.at(last), pictures.at(last + 1));
    if (change == 0 && last == 0) return StepChoice{kCoarsest, 0, true};
    if (change <= rms || last + 1 == kSteps) break;
  }
  const double fine = Pictures::step(last) * kReferencePart;
  const auto truth = pictures.drawn(fine);
  if (!truth) return truth.error();
  const auto against_it = [&](double step_voxels, const Image2d<RgbaF>& picture) {
    const double error = rms_difference(picture, *truth);
    return StepChoice{step_voxels, error, error <= rms};
  };
  std::vector<StepChoice> measured;
  for (std::size_t i = 0; i <= std::min(last + 1, kSteps - 1); ++i) {
    measured.push_back(against_it(Pictures::step(i), pictures.at(i)));
  }
  Ladder ladder(std::move(measured));
  const double wanted = kMargin * rms;
  const auto all = sparings(engine, scene, ladder.at(wanted).step_voxels);
  if (!all) return all.error();
  const Sparing sparing = cheapest(ladder, *all, wanted);
  const auto left = [&](double of) {
    return std::sqrt(std::max(of * of - sparing.rms * sparing.rms, 0.0));
  };
  // Errors are no smooth function of the step: what was interpolated is drawn.
  StepChoice found = ladder.at(left(wanted));
  for (int i = 0; i < kTries && found.rms == left(wanted); ++i) {
    const auto picture = pictures.drawn(found.step_voxels);
    if (!picture) return picture.error();
    const StepChoice drawn = against_it(found.step_voxels, *picture);
    ladder.add(drawn);
    if (drawn.rms <= left(kAccepted * rms)) {
      found = drawn;
      break;
    }
    found = ladder.at(left(wanted));
  }
  found.pixel_error = sparing.pixel_error;
  found.rms = std::hypot(found.rms, sparing.rms);
  found.reached = found.rms <= rms;
  return found;
}

}  // namespace nav::render
