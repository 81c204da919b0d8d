// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/slices.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <sstream>

#include "app/output_folder.hpp"
#include "app/verbs/slice_planes.hpp"
#include "app/views/ct_window.hpp"
#include "app/views/overlay.hpp"
#include "app/views/panels.hpp"
#include "app/views/placed_image.hpp"
#include "io/ct.hpp"
#include "render/canvas.hpp"
#include "render/slices/slice.hpp"
#include "session/outside_ct.hpp"
#include "session/placement.hpp"

namespace nav::app {
namespace {

Result<render::SlabMode> slab_mode(const std::string& name) {
  if (name == "maximum") return render::SlabMode::kMaximum;
  if (name == "minimum") return render::SlabMode::kMinimum;
  if (name == "mean") return render::SlabMode::kMean;
  return Error{ErrorCode::kUsage, "--mode: expected maximum, minimum or mean, found " + name};
}

/// Least sizes of an image that has space for the letters, and for the letters and the warning,
/// pixels.
constexpr int kLeastPx = 64;
constexpr int kLeastWarnedPx = 192;
/// Least size of an image that has space for scale, position and grey window, pixels.
constexpr int kLeastDescribedPx = 400;

/// Adds to the image of a slice the letters of its edges, its needle or path, the warning, and
/// where there is space its name, scale, position and grey window.
Image2d<Rgba8> labelled(const Image2d<Rgba8>& image, const NamedPlane& slice,
                        const std::string& warning, const render::HuWindow& window) {
  render::Canvas canvas(image.width(), image.height(), render::rgb8(0));
  canvas.copy(image, 0, 0);
  const Rgba8 colour = render::rgb8(0xffd24a);
  const int size = text_size(16, image.height());
  const int small = text_size(13, image.height());
  constexpr int kWordsMargin = 6;
  const int words_line = size + 4;
  if (slice.line_ct) {
    const auto pixel = [&](const Point<frames::Ct>& p) -> Eigen::Vector2d {
      const Eigen::Vector3d from = (p.mm - slice.plane.centre_ct.mm) / slice.mm_per_pixel;
      return {from.dot(slice.plane.right.v) + 0.5 * (image.width() - 1),
              from.dot(slice.plane.down.v) + 0.5 * (image.height() - 1)};
    };
    canvas.line(pixel((*slice.line_ct)[0]), pixel((*slice.line_ct)[1]), 1, render::rgb8(0x6fd3ff));
  }
  const render::SliceLabels labels = render::labels_of(slice.plane);
  const int middle = image.height() / 2 + size / 3;
  const int top_letter = (image.width() - canvas.text_width(size, labels.top)) / 2;
  // The name stands beside the top letter, or below it if it is too long; never over a letter.
  int base = kWordsMargin + size;
  const int end = 2 * kWordsMargin + canvas.text_width(size, slice.name);
  if (end > top_letter) base += words_line;
  if (end <= image.width() && base + kWordsMargin <= middle - size) {
    canvas.outlined_text(kWordsMargin, base, size, slice.name, colour);
  }
  if (!warning.empty()) {
    canvas.outlined_text(kWordsMargin, base + words_line, size, warning, colour);
  }
  const CanvasArea whole{0, 0, image.width(), image.height()};
  draw_letters(canvas, whole, labels, size, colour);
  if (image.width() < kLeastDescribedPx) return canvas.image();
  const int low = image.height() - kWordsMargin;
  draw_scale_bar(canvas, whole, kWordsMargin, low, slice.mm_per_pixel, small, colour);
  const auto right_aligned = [&](int line, const std::string& words) {
    const int x = image.width() - kWordsMargin - canvas.text_width(small, words);
    if (x > image.width() / 2 + size) canvas.outlined_text(x, line, small, words, colour);
  };
  right_aligned(low, words_of_window(window.level, window.width));
  right_aligned(low - small - 5, position_words(slice.plane.centre_ct.mm));
  return canvas.image();
}

/// Checks the size. recorded: the session has a recording, so a warning may need space.
Result<void> validate(const SlicesOptions& options, bool recorded) {
  const int least_px = recorded ? kLeastWarnedPx : kLeastPx;
  if (options.size_px < least_px || options.size_px > 8192) {
    return Error{ErrorCode::kUsage, "--size: expected " + std::to_string(least_px) +
                                        " to 8192 pixels, found " +
                                        std::to_string(options.size_px)};
  }
  return {};
}

render::Fusion fusion_of(const SlicesOptions& options) {
  render::Fusion fusion;
  fusion.mode = options.fusion == "checkerboard" ? render::FusionMode::kCheckerboard
                : options.fusion == "wipe"       ? render::FusionMode::kWipe
                                                 : render::FusionMode::kBlend;
  fusion.share = options.share;
  fusion.square_mm = options.square_mm;
  fusion.wipe = options.wipe;
  return fusion;
}

/// Data that are fused with the CT.
struct Overlay {
  std::optional<PlacedImage> image;
  std::optional<Volume> second;
  render::HuWindow window{};  ///< Grey window of the second volume; set after the planes are known.
};

Result<Overlay> read_overlay(const SessionConfig& config, const SlicesOptions& options,
                             const Volume& ct, Console& console) {
  Overlay overlay;
  if (!config.source.recording.empty()) {
    auto image = placed_image(config, ct, options.frame, console);
    if (!image) return image.error();
    overlay.image = std::move(*image);
  }
  if (!options.second.empty()) {
    io::CtOptions reading;
    reading.accept_unknown_orientation = config.ct.accept_unknown_orientation;
    reading.expect_hounsfield_units = false;  // It may be an MR.
    auto second = io::read_ct(options.second, console, reading);
    if (!second) return second.error();
    overlay.second = std::move(*second);
  }
  return overlay;
}

Result<Image2d<Rgba8>> fused_slice(const Volume& ct, const NamedPlane& slice,
                                   const render::SliceOptions& how, const SlicesOptions& options,
                                   const render::HuWindow& window, const Overlay& overlay,
                                   Console& console) {
  const auto values = render::slice_values(ct, slice.plane, how);
  if (!values) return values.error();
  const auto outside = [](float v) { return std::isnan(v); };
  const bool empty = std::ranges::all_of(values->pixels(), outside);
  if (empty) console.report(Severity::kWarning, slice.name, "the slice lies outside the CT");
  auto grey = render::to_grey(*values, window);
  if (overlay.second) {
    const auto second = render::slice_values(*overlay.second, slice.plane, how);
    if (!second) return second.error();
    if (std::ranges::all_of(second->pixels(), outside)) {
      console.report(Severity::kWarning, slice.name,
                     "the second volume does not reach the slice: is it in the CT's frame?");
    }
    return render::fuse(grey, render::to_grey(*second, overlay.window), how, fusion_of(options));
  }
  if (!overlay.image) return grey;
  return render::fuse(grey, slice.plane, how, overlay.image->plane, fusion_of(options));
}

/// Values of a volume in the slices, on a coarse grid for each; along the ultrasound image instead
/// if there is one.
Result<std::vector<float>> values_shown(const Volume& volume, const std::vector<NamedPlane>& planes,
                                        const SlicesOptions& options, render::SlabMode mode,
                                        const Overlay& overlay) {
  if (overlay.image) {
    return values_along(volume, overlay.image->plane.ct_from_image, overlay.image->plane.frame);
  }
  constexpr int kCoarsePx = 64;
  constexpr double kMostMmPerPixel = 100;
  std::vector<float> shown;
  for (const NamedPlane& slice : planes) {
    render::SliceOptions how;
    how.width = how.height = kCoarsePx;
    how.mm_per_pixel = std::min(slice.mm_per_pixel * options.size_px / kCoarsePx, kMostMmPerPixel);
    how.slab_mm = options.slab_mm;
    how.slab = mode;
    const auto values = render::slice_values(volume, slice.plane, how);
    if (!values) return values.error();
    std::ranges::copy_if(values->pixels(), std::back_inserter(shown),
                         [](float v) { return !std::isnan(v); });
  }
  return shown;
}

/// Grey window of the second volume: from the options, else chosen for the shown values.
Result<render::HuWindow> window_of_second(const std::vector<NamedPlane>& planes,
                                          const SlicesOptions& options, render::SlabMode mode,
                                          const Overlay& overlay) {
  const auto shown = values_shown(*overlay.second, planes, options, mode, overlay);
  if (!shown) return shown.error();
  SessionConfig::View said;
  said.window_level = options.second_level;
  said.window_width = options.second_width;
  return ct_window(said, *overlay.second, *shown);
}

std::string level_and_width(const render::HuWindow& window) {
  std::ostringstream text;
  text << "level " << window.level << ", width " << window.width;
  return text.str();
}

}  // namespace

Result<void> run_slices(const SessionConfig& config, const SlicesOptions& options,
                        Console& console) {
  if (config.source.kind == SessionConfig::SourceKind::kSimulated) {
    return Error{ErrorCode::kUsage,
                 "source.kind: expected \"recording\", because its CT has a file, found "
                 "\"simulated\""};
  }
  if (auto ok = require_path(config.ct.path, "ct", "a CT"); !ok) return ok;
  if (auto ok = require_path(config.output.folder, "--out", "a folder"); !ok) return ok;
  const auto mode = slab_mode(options.slab);
  if (!mode) return mode.error();
  const bool recorded = !config.source.recording.empty();
  if (const auto ok = validate(options, recorded); !ok) return ok;
  const auto ct = session::read_session_ct(config.ct, console);
  if (!ct) return ct.error();
  auto overlay = read_overlay(config, options, **ct, console);
  if (!overlay) return overlay.error();
  const auto planes = slice_planes(options, config.plan, **ct, overlay->image);
  if (!planes) return planes.error();
  if (config.plan) session::warn_outside(*config.plan, **ct, console);
  const auto shown = values_shown(**ct, *planes, options, *mode, *overlay);
  if (!shown) return shown.error();
  const render::HuWindow window = ct_window(config.view, **ct, *shown);
  if (overlay->second) {
    const auto second = window_of_second(*planes, options, *mode, *overlay);
    if (!second) return second.error();
    overlay->window = *second;
  }
  auto out = OutputFolder::create(config.output.folder);
  if (!out) return out.error();
  // Remove slices of an earlier run, so that its needle or plan does not seem to be of this run.
  RunFiles earlier;
  for (const std::string& name : slice_names()) earlier.files.insert(name + ".png");
  if (const auto ok = out->forget_earlier_run(earlier); !ok) return ok;
  const std::string warning = overlay->image && !overlay->image->registered ? "NOT REGISTERED" : "";
  for (const NamedPlane& slice : *planes) {
    render::SliceOptions how;
    how.width = how.height = options.size_px;
    how.mm_per_pixel = slice.mm_per_pixel;
    how.slab_mm = options.slab_mm;
    how.slab = *mode;
    const auto image = fused_slice(**ct, slice, how, options, window, *overlay, console);
    if (!image) return image.error();
    const auto ok = out->write_image(slice.name + ".png", labelled(*image, slice, warning, window));
    if (!ok) return ok;
  }
  std::ostringstream where;
  where << planes->size() << " slices through (" << planes->front().plane.centre_ct.mm.transpose()
        << ") mm in " << config.output.folder.string() << ", window: " << level_and_width(window);
  if (overlay->second)
    where << "; window of the second volume: " << level_and_width(overlay->window);
  console.say(where.str());
  return {};
}

}  // namespace nav::app
