// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/prepared.hpp"

#include <algorithm>
#include <chrono>
#include <span>
#include <sstream>

#include "nav/stopwatch.hpp"
#include "registration/assessment.hpp"
#include "registration/similarity/coarse_images.hpp"
#include "registration/similarity/image_outline.hpp"

namespace nav::registration {
namespace {

constexpr const char* kSource = "registration";
// Fewer patches rank poses badly; smaller patches than this show no structure.
constexpr std::size_t kRankingPatches = 60;
constexpr int kLeastSide = 5;

std::vector<double> steps_of(const ImageRegistrationOptions& options) {
  std::vector<double> steps;
  for (const LevelOptions& level : options.levels) steps.push_back(level.sample_step_mm);
  return steps;
}

std::string too_few(std::size_t level, double step_mm, std::size_t found) {
  std::ostringstream text;
  text << "level " << level << " (" << step_mm << " mm): expected at least " << kMinPatches
       << " patches outside shadows, found " << found;
  return text.str();
}

/// A clause that says why a sweep has no patches.
std::string seen_in(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks,
                    const LevelOptions& level, double near_field_mm) {
  const auto any = [](std::span<const std::uint8_t> pixels) {
    return std::ranges::any_of(pixels, [](std::uint8_t pixel) { return pixel != 0; });
  };
  const auto one_grey = [](const TrackedImage& tracked) {
    const auto pixels = tracked.frame.pixels.pixels();
    return std::ranges::all_of(pixels, [&](std::uint8_t grey) { return grey == pixels.front(); });
  };
  const auto usable =
      std::ranges::count_if(masks, [&](const auto& mask) { return any(mask.pixels()); });
  const UltrasoundImage& first = sweep.frames().front().frame;
  const double patch_mm = (level.patch_side - 1) * level.sample_step_mm;
  std::ostringstream text;
  text.precision(3);
  text << usable << " of " << masks.size() << " images have usable pixels, "
       << std::ranges::count_if(sweep.frames(), one_grey)
       << " are of one grey throughout; an image is "
       << first.pixels.width() * first.grid.mm_per_pixel.col(0).norm() << " x "
       << first.pixels.height() * first.grid.mm_per_pixel.col(1).norm() << " mm, a patch "
       << patch_mm << " x " << patch_mm << " mm, and the first " << near_field_mm
       << " mm of depth are not used";
  return text.str();
}

}  // namespace

Result<PreparedCt> PreparedCt::create(const Volume& ct, const ImageRegistrationOptions& options) {
  if (const auto ok = validate(options); !ok) return ok.error();
  PreparedCt prepared;
  prepared.grid_ = ct.grid();
  prepared.name_ = ct.name();
  prepared.steps_ = steps_of(options);
  const CtBox box = box_of(ct.grid());
  for (const LevelOptions& level : options.levels) {
    auto channels = make_ct_channels(ct, box, sigma_of(level.sample_step_mm), level.texel_sigmas);
    if (!channels) return channels.error();
    prepared.levels_.push_back(std::make_shared<const CtChannels>(std::move(*channels)));
  }
  return prepared;
}

Result<PreparedSweep> PreparedSweep::create(const Sweep& as_recorded,
                                            const ImageRegistrationOptions& options,
                                            Diagnostics& diagnostics,
                                            const std::function<bool()>& keep_going) {
  if (const auto ok = validate(options); !ok) return ok.error();
  Sweep sweep = with_outline(as_recorded);
  if (options.most_images > 0 || options.average_pixels) {
    const int all = static_cast<int>(sweep.frames().size());
    sweep = coarse_images(
        sweep, options.most_images > 0 ? options.most_images : all,
        options.average_pixels ? sigma_of(options.levels.back().sample_step_mm) : 0.0);
  }
  const auto masks = shadow_masks(sweep, options.mask);
  if (!masks) return masks.error();
  PreparedSweep prepared;
  prepared.points_ = sweep_points(sweep, *masks);
  prepared.motions_ = image_motions(sweep, as_recorded);
  prepared.path_ = image_motions(as_recorded, as_recorded);
  prepared.steps_ = steps_of(options);
  for (std::size_t i = 0; i < options.levels.size(); ++i) {
    if (keep_going && !keep_going()) {
      return Error{ErrorCode::kCancelled, "image registration: cancelled by the caller"};
    }
    const auto start = std::chrono::steady_clock::now();
    LevelOptions level = options.levels[i];
    PatchSet patches = make_patches(sweep, *masks, level, sigma_of(level.sample_step_mm));
    while (patches.patches.size() < kRankingPatches && level.patch_side > kLeastSide) {
      level.patch_side -= 2;
      patches = make_patches(sweep, *masks, level, sigma_of(level.sample_step_mm));
    }
    const std::size_t found = patches.patches.size();
    if (found >= kMinPatches && !prepared.points_.points.empty()) {
      prepared.levels_.push_back({i, level, std::move(patches), seconds_since(start)});
      continue;
    }
    const std::string text = too_few(i, level.sample_step_mm, found);
    if (i + 1 == options.levels.size()) {
      return Error{ErrorCode::kRefused,
                   "image registration: " + text + ": " +
                       seen_in(sweep, *masks, level, options.mask.near_field_mm)};
    }
    diagnostics.report(Severity::kInfo, kSource, text + "; the level is left out");
  }
  return prepared;
}

CtBox reachable_box(const PreparedSweep& sweep,
                    const Transform<frames::Ct, frames::Reference>& initial,
                    const ImageRegistrationOptions& options) {
  const double search = options.starts > 0 ? options.start_range_mm +
                                                 options.start_range_rad * sweep.points().radius_mm
                                           : 0.0;
  // The random poses that the result is judged by reach farther than a solve without starts.
  return box_around(sweep.points(), {initial}, std::max(search + kNearTravelMm, kRandomPoseMm));
}

}  // namespace nav::registration
