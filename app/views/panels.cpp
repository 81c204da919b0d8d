// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/panels.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <utility>
#include <vector>

#include "app/views/plane_overlays.hpp"
#include "app/views/plane_view.hpp"
#include "render/letters.hpp"

namespace nav::app {
namespace {

using render::Canvas;
using render::rgb8;

constexpr Rgba8 kBackground = rgb8(0x101418);
constexpr Rgba8 kFaint = rgb8(0x7a8590);

/// Shortens a text with an ellipsis so that it fits a width. Not for numbers, which must be shown
/// whole.
std::string shorten(const Canvas& canvas, int size, std::string words, int width) {
  if (canvas.text_width(size, words) <= width) return words;
  while (!words.empty() && canvas.text_width(size, words + "...") > width) {
    render::drop_last_letter(words);
  }
  return words + "...";
}

/// Draws a line of text at the left of a panel, shortened to the panel's width.
void draw_label(Canvas& canvas, int x, int y, int width, const std::string& words, Rgba8 colour,
                int size = 15) {
  const std::string shown = shorten(canvas, size, words, width - 16);
  // With its own background: the image below may be as bright as the text.
  canvas.fill(x + 1, y - size - 2, canvas.text_width(size, shown) + 14, size + 9, kBackground);
  canvas.text(x + 8, y, size, shown, colour);
}

/// Draws a whole text, wrapped into lines, and returns the base line after it. Nothing is
/// shortened, so the text may have numbers. y: first base line.
int draw_note(Canvas& canvas, int y, int width, const std::string& words) {
  constexpr int kSize = 13;
  constexpr int kLineHeight = 24;
  for (const std::string& line : render::wrapped(kSize, words, width - 16)) {
    draw_label(canvas, 0, y, width, line, colour_of(SafetyState::kDegraded), kSize);
    y += kLineHeight;
  }
  return y;
}

/// Draws the legend of predicates at the lower left of the 3D view, over at most half of its
/// height. A last line gives the number of entries that do not fit.
void draw_legend(Canvas& canvas, int width, int height, const std::vector<LegendEntry>& legend) {
  constexpr int kSize = 13;
  constexpr int kLineHeight = 20;
  constexpr int kSwatch = 12;
  constexpr int kLeft = 8;
  const auto room = static_cast<std::size_t>(height / 2 / kLineHeight);
  const std::size_t shown = legend.size() <= room ? legend.size() : room - 1;
  const auto rows = static_cast<int>(std::min(legend.size(), room));
  int y = height - kLineHeight * rows;
  const auto line = [&](const std::string& words) {
    const int x = kLeft + kSwatch;
    draw_label(canvas, x, y, width - x, words, kOverlayText, kSize);
  };
  for (std::size_t i = 0; i < shown; ++i) {
    const LegendEntry& entry = legend[i];
    const int number = canvas.text_width(kSize, " " + entry.importance_words());
    line(shorten(canvas, kSize, entry.name, width / 2 - number) + " " + entry.importance_words());
    canvas.fill(kLeft, y - kSwatch, kSwatch, kSwatch, entry.colour);
    y += kLineHeight;
  }
  if (shown < legend.size()) line("and " + std::to_string(legend.size() - shown) + " more");
}

void draw_panels(Canvas& canvas, int x, int width, int height, const PanelContext& context) {
  const session::Epoch& epoch = context.epoch;
  const int half = height / 2;
  const bool live = epoch.frame && epoch.ultrasound.state <= SafetyState::kDegraded;
  if (live) {
    const PlaneView view = fit(epoch.frame->frame, x, 0, width, half);
    draw_ultrasound(canvas, view, epoch.frame->frame);
    draw_depth_marks(canvas, view, epoch.frame->frame);
    if (epoch.placement.state == SafetyState::kValid) draw_in_plane(canvas, view, context);
  }
  draw_label(canvas, x, 20, width, "Ultrasound", kOverlayText);
  if (!live) {
    draw_label(canvas, x, half / 2, width, "withdrawn: " + epoch.ultrasound.cause,
               colour_of(epoch.ultrasound.state), 13);
  }
  const bool placed = live && epoch.ct_from_image && epoch.plane.state <= SafetyState::kDegraded;
  if (placed) {
    const PlaneView view = fit(epoch.frame->frame, x, half, width, height - half);
    canvas.copy(render::slice_along_image(context.ct, *epoch.ct_from_image, view.origin_mm,
                                          view.mm_per_px, view.width, view.height, context.window),
                view.x, view.y);
    draw_in_plane(canvas, view, context);
    draw_label(canvas, x, height - 9, width,
               words_of_window(context.window.level, context.window.width), kFaint, 13);
  }
  draw_label(canvas, x, half + 20, width, "CT along the ultrasound plane", kOverlayText);
  if (!placed) {
    draw_label(canvas, x, half + half / 2, width, "withdrawn: " + epoch.plane.cause,
               colour_of(epoch.plane.state), 13);
  }
  canvas.fill(x, 0, 1, height, kFaint);
  canvas.fill(x, half, width, 1, kFaint);
}

/// Draws a lamp with the name and the state of an input. Returns the x where it ends.
int draw_lamp(Canvas& canvas, int x, int y, const std::string& input, const Safety& safety) {
  const Rgba8 colour = colour_of(safety.state);
  canvas.fill(x, y - 12, 14, 14, colour);
  x = canvas.text(x + 22, y, 15, input, kFaint) + 6;
  return canvas.text(x, y, 15, to_string(safety.state), colour) + 18;
}

/// Returns whether there was space for the banner.
bool draw_status(Canvas& canvas, int y, int height, const PanelContext& context) {
  const session::Epoch& epoch = context.epoch;
  canvas.fill(0, y, canvas.width(), height, rgb8(0x1b2229));
  const int base = y + height / 2 + 6;
  int x = draw_lamp(canvas, 10, base, "ultrasound", epoch.ultrasound);
  x = draw_lamp(canvas, x, base, "CT", epoch.placement);
  const bool has_needle = context.plan || context.needle_expected;
  if (has_needle) x = draw_lamp(canvas, x, base, "needle", epoch.needle);
  const int end = canvas.width() - 16 - canvas.text_width(15, context.banner);
  if (epoch.guidance) {
    const std::string numbers = guidance_words(*epoch.guidance);
    // Numbers are drawn whole or not at all.
    if (x + canvas.text_width(17, numbers) <= end) canvas.text(x, base, 17, numbers, kOverlayText);
  } else {
    const std::string& cause =
        has_needle && epoch.plane.cause.empty() ? epoch.needle.cause : epoch.plane.cause;
    if (end - x > 40) canvas.text(x, base, 15, shorten(canvas, 15, cause, end - x), kOverlayText);
  }
  if (context.banner.empty()) return true;
  if (end > x) canvas.text(end, base, 15, context.banner, kFaint);
  return end > x;
}

/// Width of the flat panels beside a 3D view.
constexpr int side_of(int height) { return height * 2 / 3; }
/// Height of the status bar.
constexpr int kBar = 40;
/// Least size with panels: height of the 3D view, width of the whole image.
constexpr int kSmallestHeight = 300;
constexpr int kSmallestWidth = 400;

constexpr const char* kEndedWords = "the recording has ended: last image, not live";

/// Draws the letters of the patient's directions at the edges of the 3D view.
void draw_orientation(Canvas& canvas, int width, int height, const render::Camera& camera) {
  const ViewLetters letters_of = view_letters(camera);
  constexpr int kSize = 16;
  const auto centred = [&](int x, int y, const std::string& letters) {
    canvas.text(x - canvas.text_width(kSize, letters) / 2, y, kSize, letters, kOverlayText);
  };
  centred(20, height / 2, letters_of.left);
  centred(width - 20, height / 2, letters_of.right);
  centred(width / 2, 20, letters_of.up);
  centred(width / 2, height - 8, letters_of.down);
}

}  // namespace

Rgba8 colour_of(SafetyState state) {
  switch (state) {
    case SafetyState::kValid:
      return rgb8(0x2fd060);
    case SafetyState::kDegraded:
      return rgb8(0xffb400);
    case SafetyState::kStale:
      return rgb8(0x9a9a9a);
    case SafetyState::kLost:
      return rgb8(0xe04040);
  }
  return rgb8(0xe04040);
}

std::string words_of_window(double level, double width) {
  std::ostringstream text;
  text << "L " << level << "  W " << width;
  return text.str();
}

std::string guidance_words(const NeedleGuidance& guidance) {
  char numbers[160];
  std::snprintf(
      numbers, sizeof numbers, "tip to target %.1f mm    lateral %.1f mm    angle to plan %.1f deg",
      guidance.tip_to_target_mm, guidance.lateral_mm, guidance.angle_to_plan_rad * 180 / M_PI);
  return numbers;
}

std::string patient_direction(const Eigen::Vector3d& direction_ct) {
  const Eigen::Vector3d d = direction_ct.normalized();
  std::array<std::pair<double, char>, 3> axes = {{{std::abs(d.x()), d.x() > 0 ? 'L' : 'R'},
                                                  {std::abs(d.y()), d.y() > 0 ? 'P' : 'A'},
                                                  {std::abs(d.z()), d.z() > 0 ? 'S' : 'I'}}};
  std::stable_sort(axes.begin(), axes.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  constexpr double kNoticeable = 1.0 / 3;
  std::string letters;
  for (const auto& [size, letter] : axes) {
    if (size > kNoticeable) letters += letter;
  }
  return letters;
}

ViewLetters view_letters(const render::Camera& camera) {
  const Eigen::Vector3d forward = (camera.look_at_ct.mm - camera.eye_ct.mm).normalized();
  const Eigen::Vector3d right = forward.cross(camera.up_ct.v).normalized();
  const Eigen::Vector3d up = right.cross(forward);
  return {patient_direction(-right), patient_direction(right), patient_direction(up),
          patient_direction(-up)};
}

PixelSize composed_size(PixelSize view_3d) {
  return {view_3d.width + side_of(view_3d.height), view_3d.height + kBar};
}

PixelSize view_size_within(PixelSize window) {
  const int width = std::max(window.width, kSmallestWidth);
  // The panels then have at most half of the width.
  const int height = std::max(std::min(window.height - kBar, width * 3 / 4), kSmallestHeight);
  return {width - side_of(height), height};
}

bool has_panels(int width, int height) {
  return height >= kSmallestHeight && width + side_of(height) >= kSmallestWidth;
}

Image2d<Rgba8> compose_panels(const Image2d<Rgba8>& view_3d, const PanelContext& context) {
  const int view_width = view_3d.width();
  const int view_height = view_3d.height();
  const PixelSize size = composed_size({view_width, view_height});
  const std::string ended = context.ended ? kEndedWords : "";
  Canvas canvas(size.width, size.height, kBackground);
  canvas.copy(view_3d, 0, 0);
  if (has_panels(view_width, view_height)) {
    draw_orientation(canvas, view_width, view_height, context.camera);
    if (context.grey) {
      draw_label(canvas, 0, 20, view_width / 3,
                 words_of_window(context.grey->level_hu, context.grey->width_hu), kFaint, 13);
    }
    int next = draw_note(canvas, 44, view_width, context.note);
    next = draw_note(canvas, std::max(next, 68), view_width, context.warning);
    next = draw_note(canvas, std::max(next, 92), view_width, ended);
    draw_legend(canvas, view_width, view_height, context.legend);
    draw_panels(canvas, view_width, size.width - view_width, view_height, context);
    const bool has_banner = draw_status(canvas, view_height, kBar, context);
    if (context.in_window && !has_banner) draw_note(canvas, next, view_width, context.banner);
  } else {
    // Even the smallest view says whose image it is, what it leaves out, and whether it is not
    // registered.
    draw_note(canvas, view_height + 16, canvas.width(), context.banner);
    int next = draw_note(canvas, 16, canvas.width(), context.note);
    next = draw_note(canvas, next, canvas.width(), context.warning);
    draw_note(canvas, next, canvas.width(), ended);
  }
  return canvas.image();
}

}  // namespace nav::app
