// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/step_search.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "render/quality/ray_sparing.hpp"
#include "render/spec/ray_spec_cutaway.hpp"

namespace nav::render {
namespace {

constexpr double kRays = 4096;
constexpr double kCoarsest = 4;  // In voxels.
constexpr double kFinest = 1.0 / 16;
constexpr double kReferencePart = 1.0 / 4;  // Reference step, as a share of the measured step.
constexpr double kMostFalls = 0.5;          // The value for first order.
// Errors usually lie at few edges. So rays are added until the estimated rms has the relative
// standard deviation kScatter, up to kMostRays or the share kMostOfImage of the image's pixels.
constexpr double kScatter = 0.04;
constexpr double kEnough = 1.4;  // Times kScatter: more rays would not change much.
constexpr double kMoreRays = 4;  // Largest factor at once: few rays estimate their scatter badly.
constexpr double kMostRays = 128 * 128;
constexpr double kMostOfImage = 1.0 / 8;
constexpr double kRoomDeviations = 3;  // Safety margin, in standard deviations of an estimate:
                                       // edges scatter more than rays show.
constexpr int kTries = 2;              // Number of tries between two steps.
constexpr double kNear = 0.05;         // Within this share of the goal no other step is tried.
// Least share of the requested rms that the step may use. If rounding to 8 bits leaves less, no
// step reaches the request.
constexpr double kLeastShare = 0.5;

/// The CT of a scene with the objects that stand in it and its cutaway, unchanged.
Scene ct_cut_open(const Scene& scene) {
  Scene cut = scene;
  cut.predicates.reset();
  cut.ultrasound.reset();
  cut.quality.pixel_error = 0;
  return cut;
}

/// True if the CT has other errors when objects stand in it: at edges of a cutaway, and in means
/// and extremes of rays that end at an ultrasound image.
bool errs_as_it_stands(const Scene& scene) {
  if (scene.projection != Projection::kComposite) return scene.plane.has_value();
  return scene.cutaway &&
         !(scene.cutaway->meshes.empty() && spec::make_cutaway(scene, false).empty());
}

/// The scene with fewer pixels.
Scene few_rays(const Scene& scene, double rays) {
  Scene few = scene;
  const double across = static_cast<double>(scene.width) / scene.height;
  const auto pixels = [&](double n) {
    return std::clamp(static_cast<int>(std::lround(n)), 1, static_cast<int>(rays));
  };
  few.width = pixels(std::sqrt(rays * across));
  few.height = pixels(few.width / across);
  return few;
}

/// A step, and the error of images that are drawn with it.
struct Measured {
  double step_voxels = 0;
  double rms = 0;      ///< Before rounding to 8 bits.
  double scatter = 0;  ///< Relative standard deviation of rms.
};

/// Measures the error of an image against another image of the same size.
Measured measured(double step_voxels, const Image2d<RgbaF>& image, const Image2d<RgbaF>& truth) {
  std::vector<double> squares(truth.pixels().size());
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const RgbaF& p = image.pixels()[i];
    const RgbaF& q = truth.pixels()[i];
    squares[i] = (std::pow(p.r - q.r, 2) + std::pow(p.g - q.g, 2) + std::pow(p.b - q.b, 2)) / 3.0;
  }
  const Estimate found = Estimate::of(squares);
  if (!(found.mean > 0)) return {step_voxels, 0, 0};
  return {step_voxels, std::sqrt(found.mean), found.deviation / (2 * found.mean)};
}

/// Error of rounding an image to 8 bits; 0 if it holds only background that 8 bits represent
/// exactly.
double rounding_rms(const Image2d<RgbaF>& image) {
  std::vector<RgbaF> rounded;
  const Image2d<Rgba8> bytes = to_8bit(image);
  for (const Rgba8& p : bytes.pixels()) {
    rounded.push_back({static_cast<float>(p.r) / 255, static_cast<float>(p.g) / 255,
                       static_cast<float>(p.b) / 255, 1});
  }
  return rms_difference({image.width(), image.height(), std::move(rounded)}, image);
}

/// The step at which the error reaches rms, if errors follow a power of the step between two steps.
/// Returns fine if the errors of the two do not enclose rms.
Measured between(const Measured& coarse, const Measured& fine, double rms) {
  if (!(fine.rms > 0 && fine.rms < rms && rms < coarse.rms)) return fine;
  const double share = std::log(rms / fine.rms) / std::log(coarse.rms / fine.rms);
  return {fine.step_voxels * std::pow(coarse.step_voxels / fine.step_voxels, share), rms,
          fine.scatter};
}

/// Draws images with a given number of rays.
class Images {
 public:
  Images(Engine& engine, const Scene& scene, double rays)
      : engine_(&engine), few_(few_rays(scene, rays)) {}

  Result<Image2d<RgbaF>> drawn(double step_voxels) {
    few_.quality.step_voxels = step_voxels;
    auto image = engine_->render(few_);
    if (!image) return image.error();
    return std::move(image->pixels);
  }
  /// Draws the image that others are measured against: no ray ends early.
  Result<void> draw_truth(double step_voxels) {
    const Quality quality = few_.quality;
    few_.quality.opaque_at = 1;
    auto image = drawn(step_voxels);
    few_.quality = quality;
    if (!image) return image.error();
    truth_ = std::move(*image);
    truth_voxels_ = step_voxels;
    return {};
  }
  [[nodiscard]] double rounding() const { return rounding_rms(truth_); }
  /// Measures an image that was drawn with step_voxels, which must be greater than the truth's
  /// step. falls: see StepSearch::falls_.
  [[nodiscard]] Measured against_truth(double step_voxels, const Image2d<RgbaF>& image,
                                       double falls) const {
    Measured found = measured(step_voxels, image, truth_);
    found.rms /= 1 - std::pow(falls, std::log2(step_voxels / truth_voxels_));
    return found;
  }
  Result<Measured> measure(double step_voxels, double falls) {
    const auto image = drawn(step_voxels);
    if (!image) return image.error();
    return against_truth(step_voxels, *image, falls);
  }

 private:
  Engine* engine_;
  Scene few_;
  Image2d<RgbaF> truth_;
  double truth_voxels_ = 0;
};

/// The measured steps, from which the coarsest step for an error is found.
class Ladder {
 public:
  [[nodiscard]] bool empty() const { return measured_.empty(); }
  /// The step for an error, by interpolation. If all steps err more, it is finer than all of them,
  /// down to kFinest. If errors rise and fall with the step, it lies next to the finest step that
  /// errs too much: if several steps reach the error, few rays often underestimate the coarsest of
  /// them.
  [[nodiscard]] Measured at(double rms) const {
    const auto too_coarse = std::find_if(measured_.rbegin(), measured_.rend(),
                                         [&](const Measured& one) { return one.rms > rms; });
    if (too_coarse == measured_.rend()) return measured_.front();
    if (too_coarse == measured_.rbegin()) {
      Measured finer = measured_.back();
      finer.step_voxels = std::max(kFinest, finer.step_voxels * rms / finer.rms);
      return finer;
    }
    return between(*too_coarse, *std::prev(too_coarse), rms);
  }
  void add(const Measured& one) {
    const auto coarser = [](const Measured& a, const Measured& b) {
      return a.step_voxels > b.step_voxels;
    };
    const auto at = std::lower_bound(measured_.begin(), measured_.end(), one, coarser);
    if (at != measured_.end() && at->step_voxels == one.step_voxels) {
      *at = one;
    } else {
      measured_.insert(at, one);
    }
  }
  /// The greatest scatter of all steps: it is chance at which step the few rays meet an edge with a
  /// large error.
  [[nodiscard]] double scatter() const {
    double greatest = 0;
    for (const Measured& one : measured_) greatest = std::max(greatest, one.scatter);
    return greatest;
  }
  void scale(double factor) {
    for (Measured& one : measured_) one.rms *= factor;
  }

 private:
  std::vector<Measured> measured_;  ///< In order from coarse to fine.
};

/// The error that is left for the step if the total error must not exceed rms. The mean squares of
/// the step, of rounding and of sparing add up.
double left_for_step(double rms, double rounding, const Sparing& sparing, double scatter) {
  const double shown = std::max(rms * rms - rounding * rounding, std::pow(kLeastShare * rms, 2));
  const double spared = sparing.error.mean + kRoomDeviations * sparing.error.deviation;
  return std::sqrt(std::max(shown - spared, 0.0)) / (1 + kRoomDeviations * scatter);
}

/// A search for one scene.
class StepSearch {
 public:
  StepSearch(Engine& engine, const Scene& scene, double rms)
      : engine_(engine), scene_(scene), rms_(rms), images_(engine, scene, kRays) {}

  Result<StepChoice> run() {
    if (auto ok = look_over(); !ok) return ok.error();
    if (ladder_.empty()) return chosen({kCoarsest, 0, 0});
    auto rough = images_.measure(ladder_.at(left()).step_voxels, falls_);
    if (!rough) return rough.error();
    ladder_.add(*rough);
    scatter_ = ladder_.scatter();
    if (auto ok = choose_sparing(rough->step_voxels); !ok) return ok.error();
    if (auto ok = take_enough_rays(*rough); !ok) return ok.error();
    const auto found = narrow_down(*rough);
    if (!found) return found.error();
    return chosen(*found);
  }

 private:
  /// The truth's step for an image with a step.
  static double truth_voxels(double step_voxels) { return kReferencePart * step_voxels; }
  [[nodiscard]] double left() const { return left_for_step(rms_, rounding_, sparing_, scatter_); }
  [[nodiscard]] StepChoice chosen(const Measured& found) const {
    const double rms =
        std::sqrt(found.rms * found.rms + rounding_ * rounding_ + sparing_.error.mean);
    return {found.step_voxels, rms, rms <= rms_, sparing_.pixel_error};
  }

  /// Halves the step until the image changes little. Leaves the ladder empty if the first two
  /// images are equal.
  Result<void> look_over() {
    std::vector<Image2d<RgbaF>> drawn;
    double step = kCoarsest;
    double change = 0;
    for (;; step /= 2) {
      auto image = images_.drawn(step);
      if (!image) return image.error();
      drawn.push_back(std::move(*image));
      if (drawn.size() < 2) continue;
      change = rms_difference(*std::prev(drawn.end(), 2), drawn.back());
      rounding_ = rounding_rms(drawn.back());
      if (change == 0 && drawn.size() == 2) return {};
      if (change <= left() || step <= kFinest) break;
    }
    if (auto ok = images_.draw_truth(truth_voxels(2 * step)); !ok) return ok.error();
    rounding_ = images_.rounding();
    // seen / change = (1 - falls^2) / (1 - falls) = 1 + falls, because the truth has a quarter of
    // the step.
    const double seen = images_.against_truth(2 * step, *std::prev(drawn.end(), 2), 0).rms;
    if (change > 0) falls_ = std::clamp(seen / change - 1, 0.0, kMostFalls);
    step = kCoarsest;
    for (const auto& image : drawn) {
      ladder_.add(images_.against_truth(step, image, falls_));
      step /= 2;
    }
    return {};
  }

  /// Chooses the pixel error that makes the image cheapest.
  Result<void> choose_sparing(double step_voxels) {
    if (scene_.projection != Projection::kComposite)
      return {};  // Hardly any ray equals its
                  // neighbour.
    const auto all = ray_sparings(engine_, scene_, step_voxels);
    if (!all) return all.error();
    double least = 0;
    for (const Sparing& one : *all) {
      const double left = left_for_step(rms_, rounding_, one, scatter_);
      const double cost = one.cost.at(ladder_.at(left).step_voxels);
      if (one.pixel_error > 0 && (ladder_.at(left).rms > left || cost >= least)) continue;
      least = one.pixel_error > 0 ? cost : kSparingWorthwhile * cost;
      sparing_ = one;
    }
    return {};
  }

  /// Casts more rays as long as their error for the step scatters too much.
  Result<void> take_enough_rays(Measured& rough) {
    const double pixels = static_cast<double>(scene_.width) * scene_.height;
    const double most = std::min(pixels, std::max(kMostRays, kMostOfImage * pixels));
    for (double rays = kRays; 2 * rays < most && scatter_ > kEnough * kScatter;) {
      rays = std::min({rays * std::pow(scatter_ / kScatter, 2.0), kMoreRays * rays, most});
      images_ = Images(engine_, scene_, rays);
      if (auto ok = images_.draw_truth(truth_voxels(rough.step_voxels)); !ok) return ok.error();
      const auto again = images_.measure(rough.step_voxels, falls_);
      if (!again) return again.error();
      if (!(again->rms > 0 && rough.rms > 0)) return {};
      ladder_.scale(again->rms / rough.rms);
      ladder_.add(*again);
      rounding_ = images_.rounding();
      scatter_ = again->scatter;
      rough = *again;
    }
    return {};
  }

  /// Draws and measures interpolated steps, because errors are not a smooth function of the step.
  Result<Measured> narrow_down(Measured found) {
    for (int i = 0; i < kTries; ++i) {
      scatter_ = std::max(scatter_, found.scatter);
      if (found.rms <= left() && found.rms >= (1 - kNear) * left()) return found;
      const Measured next = ladder_.at((1 - kNear / 2) * left());
      if (next.step_voxels == found.step_voxels) return found;
      const auto drawn = images_.measure(next.step_voxels, falls_);
      if (!drawn) return drawn.error();
      found = *drawn;
      ladder_.add(found);
    }
    return found.rms <= left() ? found : ladder_.at((1 - kNear / 2) * left());
  }

  Engine& engine_;
  const Scene& scene_;
  double rms_;
  Images images_;
  Ladder ladder_;
  double rounding_ = 0;
  double scatter_ = 0;
  /// Error of half a step divided by the error of the step, as far as the two errors are alike: 1/4
  /// for cells that are integrated to second order, 0 for unrelated errors. The truth has an error
  /// too, and an image differs less from it by this share of its own error.
  double falls_ = 0;
  Sparing sparing_;
};

Result<void> check_rms(double rms) {
  if (rms > 0 && rms <= 1) return {};
  return Error{ErrorCode::kUsage,
               "step for an error: expected an rms in (0, 1], found " + std::to_string(rms)};
}

}  // namespace

Scene ct_alone(const Scene& scene) {
  Scene alone = ct_cut_open(scene);
  alone.plane.reset();
  alone.needle.reset();
  alone.spheres.clear();
  alone.lines.clear();
  alone.cutaway.reset();
  return alone;
}

Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms) {
  if (const auto ok = check_rms(rms); !ok) return ok.error();
  const Scene alone = ct_alone(scene);
  const auto found = StepSearch(engine, alone, rms).run();
  if (!found) return found;
  return step_for_error(engine, scene, rms, *found);
}

Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms,
                                  const StepChoice& of_ct_alone) {
  if (const auto ok = check_rms(rms); !ok) return ok.error();
  if (!errs_as_it_stands(scene)) return of_ct_alone;
  const Scene cut_open = ct_cut_open(scene);
  const auto cut = StepSearch(engine, cut_open, rms).run();
  if (!cut) return cut;
  return StepChoice{std::min(of_ct_alone.step_voxels, cut->step_voxels),
                    std::max(of_ct_alone.rms, cut->rms), of_ct_alone.reached && cut->reached,
                    std::min(of_ct_alone.pixel_error, cut->pixel_error)};
}

}  // namespace nav::render
