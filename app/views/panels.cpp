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
constexpr Rgba8 kFaint = rgb8(0x9aa5b0);
/// Height of the status bar below 3D views of up to 600 pixels.
constexpr int kBarHeight = 60;

/// Letters at the edges of the Image plane: x is right, y is down.
render::SliceLabels letters_of_image(const Transform<frames::Ct, frames::Image>& ct_from_image) {
  return render::labels_of({ct_from_image * Point<frames::Image>{{0, 0, 0}},
                            ct_from_image * Direction<frames::Image>{{1, 0, 0}},
                            ct_from_image * Direction<frames::Image>{{0, 1, 0}}});
}

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
                int size) {
  const std::string shown = shorten(canvas, size, words, width - 16);
  // With its own background: the image below may be as bright as the text.
  canvas.fill(x + 1, y - size - 2, canvas.text_width(size, shown) + 14, size + 9, kBackground);
  canvas.text(x + 8, y, size, shown, colour);
}

/// Draws a whole text, wrapped into lines, and returns the base line after it. Nothing is
/// shortened, so the text may have numbers. y: first base line.
int draw_note(Canvas& canvas, int y, int width, const std::string& words, int size) {
  const int line_height = size * 24 / 13;
  for (const std::string& line : render::wrapped(size, words, width - 16)) {
    draw_label(canvas, 0, y, width, line, colour_of(SafetyState::kDegraded), size);
    y += line_height;
  }
  return y;
}

/// Draws the legend of the 3D view at its lower left, over at most half of its height. A last line
/// gives the number of entries that do not fit.
void draw_legend(Canvas& canvas, int width, int height, const std::vector<LegendEntry>& legend) {
  const int size = text_size(13, height);
  const int line_height = size * 20 / 13;
  const int swatch = size - 1;
  constexpr int kLeft = 8;
  const auto room = static_cast<std::size_t>(height / 2 / line_height);
  const std::size_t shown = legend.size() <= room ? legend.size() : room - 1;
  const auto rows = static_cast<int>(std::min(legend.size(), room));
  int y = height - line_height * rows;
  const auto line = [&](const std::string& words) {
    const int x = kLeft + swatch;
    draw_label(canvas, x, y, width - x, words, kOverlayText, size);
  };
  for (std::size_t i = 0; i < shown; ++i) {
    const LegendEntry& entry = legend[i];
    const int number = canvas.text_width(size, " " + entry.importance_words());
    line(shorten(canvas, size, entry.name, width / 2 - number) + " " + entry.importance_words());
    canvas.fill(kLeft, y - swatch, swatch, swatch, entry.colour);
    y += line_height;
  }
  if (shown < legend.size()) line("and " + std::to_string(legend.size() - shown) + " more");
}

/// Draws why a panel is empty, over at most three lines.
void draw_withdrawn(Canvas& canvas, int x, int y, int width, const Safety& safety, int size) {
  for (const std::string& line : render::wrapped(size, "withdrawn: " + safety.cause, width - 16)) {
    draw_label(canvas, x, y, width, line, colour_of(safety.state), size);
    y += size * 20 / 13;
  }
}

void draw_panels(Canvas& canvas, int x, int width, int height, const PanelContext& context) {
  const session::Epoch& epoch = context.epoch;
  const int half = height / 2;
  const int title = text_size(15, height);
  const int small = text_size(13, height);
  const bool live = epoch.frame && epoch.ultrasound.state <= SafetyState::kDegraded;
  const bool placed = live && epoch.ct_from_image && epoch.plane.state <= SafetyState::kDegraded;
  const auto letters = placed ? letters_of_image(*epoch.ct_from_image) : render::SliceLabels{};
  const auto label_at = [&](int base, const std::string& words, Rgba8 colour, int size) {
    draw_label(canvas, x, base, width, words, colour, size);
  };
  if (live) {
    const PlaneView view = fit(epoch.frame->frame, x, 0, width, half);
    draw_ultrasound(canvas, view, epoch.frame->frame);
    draw_depth_marks(canvas, view, epoch.frame->frame, small);
    if (epoch.placement.state == SafetyState::kValid) draw_in_plane(canvas, view, context);
    // Without letters the directions in the patient are not known.
    draw_letters(canvas, {x, title + 12, width, half - title - 12}, letters, title);
    draw_scale_bar(canvas, {x, 0, width, half}, x + 8, half - small, view.mm_per_px, small);
  }
  label_at(title + 5, "Ultrasound", kOverlayText, title);
  if (!live) draw_withdrawn(canvas, x, half / 2, width, epoch.ultrasound, small);
  if (placed) {
    const PlaneView view = fit(epoch.frame->frame, x, half, width, height - half);
    canvas.copy(render::slice_along_image(context.ct, *epoch.ct_from_image, view.origin_mm,
                                          view.mm_per_px, view.width, view.height, context.window),
                view.x, view.y);
    draw_in_plane(canvas, view, context);
    const CanvasArea area{x, half + title + 12, width, height - half - title - 12 - 2 * small};
    draw_letters(canvas, area, letters, title);
    draw_scale_bar(canvas, {x, half, width, height - half}, x + 8, height - 3 * small,
                   view.mm_per_px, small);
    const Eigen::Vector2d middle = view.point_of(view.width / 2, view.height / 2);
    const auto centre = *epoch.ct_from_image * Point<frames::Image>{{middle.x(), middle.y(), 0}};
    const std::string window = words_of_window(context.window.level, context.window.width);
    const std::string both = window + "   " + position_words(centre.mm);
    const bool fits = canvas.text_width(small, both) + 16 <= width;
    label_at(height - 9, fits ? both : window, kOverlayText, small);
  }
  label_at(half + title + 5, context.modality + " along the ultrasound plane", kOverlayText, title);
  if (!placed) draw_withdrawn(canvas, x, half + half / 2, width, epoch.plane, small);
  canvas.fill(x, 0, 1, height, kFaint);
  canvas.fill(x, half, width, 1, kFaint);
}

/// Draws a lamp with the name and the state of an input. Returns the x where it ends.
int draw_lamp(Canvas& canvas, int x, int y, const std::string& input, const Safety& safety,
              int size) {
  const Rgba8 colour = colour_of(safety.state);
  canvas.fill(x, y - size + 3, size - 1, size - 1, colour);
  x = canvas.text(x + size + 7, y, size, input, kFaint) + size / 3;
  return canvas.text(x, y, size, to_string(safety.state), colour) + size;
}

/// Draws numbers of guidance as large as they fit, at most twice the size of other text.
void draw_numbers(Canvas& canvas, int base, const NeedleGuidance& guidance,
                  const session::GuidanceError& error, int size) {
  constexpr int kLeft = 10;
  // Numbers are drawn whole or not at all; in a narrow image without their intervals.
  for (const std::string& numbers : {guidance_words(guidance, error), guidance_words(guidance)}) {
    for (int one = 2 * size + 4; one >= size - 2; --one) {
      if (canvas.text_width(one, numbers) > canvas.width() - 2 * kLeft) continue;
      canvas.text(kLeft, base, one, numbers, kOverlayText);
      return;
    }
  }
}

/// Draws a cause over at most two lines.
void draw_cause(Canvas& canvas, int base, const std::string& cause, int size) {
  constexpr int kLeft = 10;
  const int width = canvas.width() - 2 * kLeft;
  auto lines = render::wrapped(size, cause, width);
  for (std::size_t i = 2; i < lines.size(); ++i) lines[1] += " " + lines[i];
  for (std::size_t i = 0; i < std::min<std::size_t>(lines.size(), 2); ++i) {
    canvas.text(kLeft, base, size, shorten(canvas, size, lines[i], width), kOverlayText);
    base += size + 3;
  }
}

/// Draws states and banner in the first line, numbers or their cause below. A banner without space
/// is left out.
void draw_status(Canvas& canvas, int y, int height, const PanelContext& context) {
  const session::Epoch& epoch = context.epoch;
  canvas.fill(0, y, canvas.width(), height, rgb8(0x1b2229));
  const int size = height * 15 / kBarHeight;
  const int base = y + size + 4;
  int x = draw_lamp(canvas, 10, base, "ultrasound", epoch.ultrasound, size);
  x = draw_lamp(canvas, x, base, context.modality, epoch.placement, size);
  const bool has_needle = context.plan || context.needle_expected;
  if (has_needle) x = draw_lamp(canvas, x, base, "needle", epoch.needle, size);
  if (epoch.guidance) {
    draw_numbers(canvas, y + height - size / 2, *epoch.guidance, context.guidance_error, size);
  } else {
    const std::string& cause =
        has_needle && epoch.plane.cause.empty() ? epoch.needle.cause : epoch.plane.cause;
    draw_cause(canvas, base + size + 4, cause, size);
  }
  if (context.banner.empty()) return;
  const int end = canvas.width() - 16 - canvas.text_width(size, context.banner);
  if (end > x) canvas.text(end, base, size, context.banner, kFaint);
}

/// True when the status bar has space for its lamps and the banner.
bool has_status(const Canvas& canvas, const PanelContext& context) {
  const int size = 15;
  const bool has_needle = context.plan || context.needle_expected;
  const std::string words = "ultrasound degraded " + context.modality + " degraded " +
                            (has_needle ? "needle degraded " : "") + context.banner;
  const int lamps = has_needle ? 3 : 2;
  return canvas.text_width(size, words) + lamps * 3 * size + 30 <= canvas.width();
}

/// Width of the flat panels beside a 3D view.
constexpr int side_of(int height) { return height * 2 / 3; }
/// Height of the status bar below a 3D view.
int bar_of(int height) { return text_size(kBarHeight, height); }
/// Least size with panels: height of the 3D view, width of the whole image.
constexpr int kSmallestHeight = 300;
constexpr int kSmallestWidth = 400;

/// Draws the letters of the patient's directions at the edges of the 3D view.
void draw_orientation(Canvas& canvas, int width, int height, const render::Camera& camera) {
  const ViewLetters of = view_letters(camera);
  draw_letters(canvas, {0, 0, width, height}, {of.left, of.right, of.up, of.down},
               text_size(16, height));
}

/// Draws SIMULATED and NOT REGISTERED, where they hold, at the upper right of the 3D view.
/// below: rows at the top that other text takes.
void draw_warnings_in_words(Canvas& canvas, int width, int height, const PanelContext& context,
                            int below = 0) {
  const int size = text_size(16, height);
  int base = below + size + 6;
  const auto line = [&](const std::string& words) {
    const int x = std::max(2, width - 8 - canvas.text_width(size, words));
    canvas.outlined_text(x, base, size, words, colour_of(SafetyState::kDegraded));
    base += size + 6;
  };
  if (context.simulated) line("SIMULATED");
  if (context.epoch.placement.state != SafetyState::kValid) line("NOT REGISTERED");
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

std::string guidance_words(const NeedleGuidance& guidance, const session::GuidanceError& error) {
  bool known = false;
  const auto number = [&](double value, const std::optional<double>& half_width, const char* unit) {
    std::array<char, 64> text{};
    if (half_width) {
      std::snprintf(text.data(), text.size(), "%.1f +/- %.1f %s", value, *half_width, unit);
      known = true;
    } else {
      std::snprintf(text.data(), text.size(), "%.1f %s", value, unit);
    }
    return std::string(text.data());
  };
  constexpr double kDegrees = 180 / M_PI;
  std::optional<double> angle_deg = error.angle_to_plan_rad;
  if (angle_deg) *angle_deg *= kDegrees;
  const std::string tip = number(guidance.tip_to_target_mm, error.tip_to_target_mm, "mm");
  const std::string lateral = number(guidance.lateral_mm, error.lateral_mm, "mm");
  const std::string angle = number(guidance.angle_to_plan_rad * kDegrees, angle_deg, "deg");
  return "tip to target " + tip + "    lateral " + lateral + "    angle to plan " + angle +
         (known ? "    (+/-: 95 %)" : "");
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

bool has_panels(int width, int height) {
  return height >= kSmallestHeight && width + side_of(height) >= kSmallestWidth;
}

Image2d<Rgba8> compose_panels(const Image2d<Rgba8>& view_3d, const PanelContext& context) {
  const int view_width = view_3d.width();
  const int view_height = view_3d.height();
  const PixelSize size{view_width + side_of(view_height), view_height + bar_of(view_height)};
  Canvas canvas(size.width, size.height, kBackground);
  canvas.copy(view_3d, 0, 0);
  const int small = text_size(13, view_height);
  if (has_panels(view_width, view_height)) {
    draw_orientation(canvas, view_width, view_height, context.camera);
    draw_warnings_in_words(canvas, view_width, view_height, context);
    const int line_height = small * 24 / 13;
    int next = small + 7;
    const auto line = [&](const std::string& words) {
      if (words.empty()) return;
      for (const auto& part : render::wrapped(small, words, view_width * 9 / 20)) {
        draw_label(canvas, 0, next, view_width, part, kOverlayText, small);
        next += line_height;
      }
    };
    line(context.appearance);
    if (context.grey) line(words_of_window(context.grey->level_hu, context.grey->width_hu));
    // Each has its own place, so that one does not move the next.
    next = std::max(next, small + 7 + line_height);
    for (const std::string& words : {context.note, context.warning}) {
      const int after = next + line_height;
      next = std::max(draw_note(canvas, next, view_width, words, small), after);
    }
    draw_legend(canvas, view_width, view_height, context.legend);
    draw_panels(canvas, view_width, size.width - view_width, view_height, context);
    draw_status(canvas, view_height, bar_of(view_height), context);
  } else {
    // Even the smallest view says whose image it is, what it leaves out, its states with their
    // cause, and whether it is not registered.
    int next = draw_note(canvas, 16, canvas.width(), context.note, small);
    next = draw_note(canvas, next, canvas.width(), context.warning, small);
    if (has_status(canvas, context)) {
      draw_status(canvas, view_height, bar_of(view_height), context);
    } else {
      draw_note(canvas, view_height + 16, canvas.width(), context.banner, small);
    }
    draw_warnings_in_words(canvas, canvas.width(), view_height, context, next - 16);
  }
  return canvas.image();
}

}  // namespace nav::app
