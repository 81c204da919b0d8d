// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_image.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "app/predicates/predicate_legend.hpp"
#include "app/views/overlay.hpp"
#include "render/canvas.hpp"
#include "render/letters.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {
namespace {

using render::features::Stroke;

/// Sizes of text and bars beside images of a height, pixels. They grow with images above 600
/// pixels.
struct Layout {
  explicit Layout(int image_height)
      : title_height(text_size(28, image_height)),
        bars_height(text_size(120, image_height)),
        margin(text_size(12, image_height)),
        text(text_size(15, image_height)),
        line(text_size(20, image_height)) {}
  int title_height;  ///< Above the panels.
  int bars_height;   ///< Below the panels.
  int margin;
  int text;
  int line;  ///< Height of a line of the legend.
};

/// Draws the predicate histogram; a bar's height is its importance relative to the greatest
/// importance of all panels.
void draw_bars(const render::PredicateModel& model, double greatest, int left, int width, int top,
               const Layout& layout, render::Canvas& canvas) {
  const int count = static_cast<int>(model.entries.size());
  const double pitch = static_cast<double>(width - 2 * layout.margin) / count;
  const int gap = std::min(layout.margin, static_cast<int>(pitch / 4));
  const int most = layout.bars_height - 2 * layout.margin;
  const int base = top + layout.bars_height - layout.margin;
  for (int j = 0; j < count; ++j) {
    const auto& bar = model.histogram.bars()[static_cast<std::size_t>(j)];
    const double share = greatest > 0 ? bar.importance / greatest : 0;
    const int height = std::max(1, static_cast<int>(std::lround(most * share)));
    const int x = left + layout.margin + static_cast<int>(j * pitch);
    const int next = left + layout.margin + static_cast<int>((j + 1) * pitch);
    canvas.fill(x, base - height, std::max(next - x - gap, 1), height, bar_colour(bar));
  }
}

/// Breaks a name into lines that fit a width. Lines may break between any two letters; a name that
/// is too long ends in an ellipsis.
std::vector<std::string> lines_of(const std::string& words, int width, const Layout& layout,
                                  const render::Canvas& canvas) {
  constexpr std::size_t kMostLines = 4;
  std::vector<std::string> lines{""};
  for (const render::Letter& letter : render::letters_of(words)) {
    if (canvas.text_width(layout.text, lines.back() + letter.bytes) <= width ||
        lines.back().empty()) {
      lines.back() += letter.bytes;
    } else if (lines.size() == kMostLines) {
      while (!lines.back().empty() &&
             canvas.text_width(layout.text, lines.back() + "...") > width) {
        render::drop_last_letter(lines.back());
      }
      lines.back() += "...";
      break;
    } else {
      lines.push_back(letter.bytes);
    }
  }
  return lines;
}

/// Lines of the legend for an entry: the name, then the importance behind it or on its own line.
std::vector<std::string> legend_lines(const LegendEntry& entry, int width, const Layout& layout,
                                      const render::Canvas& canvas) {
  auto lines = lines_of(entry.name, width, layout, canvas);
  const std::string together = lines.back() + " " + entry.importance_words();
  if (canvas.text_width(layout.text, together) <= width) {
    lines.back() = together;
  } else {
    lines.push_back(entry.importance_words());
  }
  return lines;
}

/// Draws every entry with its colour and importance, in the order of the bars, with as many side by
/// side as fit. Returns the height. canvas: null to measure without drawing.
int legend(const render::PredicateModel& model, int left, int width, int top, const Layout& layout,
           const render::Canvas& measure, render::Canvas* canvas) {
  const int swatch = layout.margin;
  const int indent = swatch + layout.margin / 2;
  const int room = width - 2 * layout.margin;
  int x = 0;
  int y = 0;
  for (const LegendEntry& entry : legend_of(model)) {
    const auto lines = legend_lines(entry, room - indent, layout, measure);
    int wide = 0;
    for (const auto& line : lines) wide = std::max(wide, measure.text_width(layout.text, line));
    if (x > 0 && x + indent + wide > room) {
      x = 0;
      y += layout.line;
    }
    if (canvas != nullptr) {
      const int from = left + layout.margin + x;
      canvas->fill(from, top + y + layout.line - layout.text - 2, swatch, swatch, entry.colour);
      for (std::size_t n = 0; n < lines.size(); ++n) {
        canvas->text(from + indent, top + y + layout.text + static_cast<int>(n) * layout.line,
                     layout.text, lines[n], render::rgb8(0xd0d0d0));
      }
    }
    x += indent + wide + layout.margin;
    if (lines.size() > 1) {
      x = 0;
      y += static_cast<int>(lines.size()) * layout.line;
    }
  }
  return y + (x > 0 ? layout.line : 0) + layout.margin;
}

/// True when a slice shows the whole stroke: all its points lie in the slice, and the stroke was
/// painted on that plane or is as thick as it is wide.
bool lies_in(const Stroke& stroke, const render::SlicePlane& plane, const VoxelGrid& grid) {
  constexpr double kRounding = 1e-3;
  const Eigen::Vector3d normal = plane.right.v.cross(plane.down.v);
  const bool parallel = normal.cross(stroke.plane_normal.v.stableNormalized()).norm() < kRounding;
  if (!parallel && stroke.half_thickness_mm < stroke.radius_mm) return false;
  const double near_mm = kRounding * grid.spacing_mm.minCoeff();
  return std::all_of(stroke.points.begin(), stroke.points.end(), [&](const auto& p) {
    return std::abs((p.mm - plane.centre_ct.mm).dot(normal)) < near_mm;
  });
}

/// Plane of a slice through a stroke. Down is as close as possible to axis j, the usual direction
/// of scan lines.
render::SlicePlane plane_of(const Stroke& stroke, const VoxelGrid& grid) {
  const Eigen::Vector3d normal = stroke.plane_normal.v.normalized();
  Eigen::Vector3d down = grid.directions.col(1);
  if (std::abs(down.dot(normal)) > 0.9) down = grid.directions.col(2);
  down = (down - down.dot(normal) * normal).normalized();
  Eigen::Vector3d right = down.cross(normal);
  if (right.dot(grid.directions.col(0) + 0.5 * grid.directions.col(2)) < 0) right = -right;
  const Eigen::Vector3d centre = grid.centre().mm;
  const double off = (stroke.points.front().mm - centre).dot(normal);
  return {{centre + off * normal}, {right}, {down}};
}

/// Planes such that each stroke is shown by one of them; strokes on the same plane share it.
std::vector<render::SlicePlane> slices_of(const std::vector<Stroke>& strokes,
                                          const VoxelGrid& grid) {
  std::vector<render::SlicePlane> slices;
  for (const Stroke& stroke : strokes) {
    const bool known = std::any_of(slices.begin(), slices.end(),
                                   [&](const auto& plane) { return lies_in(stroke, plane, grid); });
    if (!known) slices.push_back(plane_of(stroke, grid));
  }
  return slices;
}

/// Mask of the voxels that strokes mark. Precondition: strokes that ScribbleMask accepts.
render::features::ScribbleMask marked(const std::vector<Stroke>& strokes, const VoxelGrid& grid) {
  render::features::ScribbleMask mask(grid);
  for (const Stroke& stroke : strokes) {
    const auto ok = mask.add(stroke);
    NAV_CHECK(ok.has_value());
  }
  return mask;
}

/// Draws a slice with its marked voxels in colour.
Image2d<Rgba8> slice_image(const StoredVolume& volume, const render::HuWindow& window,
                           const render::SlicePlane& plane,
                           const render::features::ScribbleMask& mask, int width, int height) {
  const VoxelGrid& grid = volume.grid();
  const auto span = [&](const Direction<frames::Ct>& axis) {
    return (grid.directions.transpose() * axis.v).cwiseAbs().dot(grid.extent_mm());
  };
  render::SliceOptions options;
  options.width = width;
  options.height = height;
  constexpr double kCoarsest = 100;  // Limit of slice_values(), mm; larger volumes are cropped.
  options.mm_per_pixel =
      std::min(std::max(span(plane.right) / width, span(plane.down) / height), kCoarsest);
  const auto values = render::slice_values(volume, plane, options);
  NAV_CHECK(values.has_value());
  render::Canvas canvas(width, height, render::rgb8(0x101010));
  canvas.copy(render::to_grey(*values, window), 0, 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d index = grid.index_of(
          {plane.centre_ct.mm + options.mm_per_pixel * ((x - 0.5 * (width - 1)) * plane.right.v +
                                                        (y - 0.5 * (height - 1)) * plane.down.v)});
      const Eigen::Vector3i voxel = index.array().round().cast<int>();
      const Eigen::Vector3i size(grid.size[0], grid.size[1], grid.size[2]);
      if ((voxel.array() < 0).any() || (voxel.array() >= size.array()).any()) continue;
      const std::uint8_t bits =
          mask.bits()[render::features::offset_of(grid, voxel.x(), voxel.y(), voxel.z())];
      if (bits == 0) continue;
      const bool show = bits == render::features::ScribbleMask::kShowBit;
      canvas.blend(x, y, show ? render::rgb8(0x30e060) : render::rgb8(0xff4040), 0.8);
    }
  }
  constexpr int kLeastLettered = 128;  // Least side with letters and scale, pixels.
  if (std::min(width, height) >= kLeastLettered) {
    const int size = text_size(Layout(height).text, height);
    const CanvasArea whole{0, 0, width, height};
    draw_letters(canvas, whole, render::labels_of(plane), size);
    draw_scale_bar(canvas, whole, 6, height - 6, options.mm_per_pixel, size);
  }
  return canvas.image();
}

}  // namespace

Image2d<Rgba8> predicate_image(const std::vector<PredicatePanel>& panels) {
  constexpr int kTitle = 16;
  constexpr int kSmallestTitle = 9;
  NAV_CHECK(!panels.empty());
  const int width = panels.front().image.width();
  const int height = panels.front().image.height();
  const Layout layout(height);
  const int indent = text_size(8, height);
  const render::Canvas measure(1, 1, render::rgb8(0));
  double greatest = 0;
  int below = 0;
  for (const PredicatePanel& panel : panels) {
    if (!panel.model) continue;
    for (const auto& bar : panel.model->histogram.bars()) {
      greatest = std::max(greatest, bar.importance);
    }
    below = std::max(
        below, layout.bars_height + legend(*panel.model, 0, width, 0, layout, measure, nullptr));
  }
  render::Canvas canvas(static_cast<int>(panels.size()) * width,
                        layout.title_height + height + below, render::rgb8(0x202020));
  int left = 0;
  const int base = layout.title_height + height;
  for (const PredicatePanel& panel : panels) {
    canvas.copy(panel.image, left, layout.title_height);
    draw_letters(canvas, {left, layout.title_height, width, height}, panel.letters,
                 text_size(kTitle, height));
    int size = text_size(kTitle, height);
    while (size > kSmallestTitle && canvas.text_width(size, panel.title) > width - 2 * indent)
      --size;
    canvas.text(left + indent, layout.title_height - indent, size, panel.title,
                render::rgb8(0xffd24a));
    if (panel.model) {
      draw_bars(*panel.model, greatest, left, width, base, layout, canvas);
      legend(*panel.model, left, width, base + layout.bars_height, layout, measure, &canvas);
    }
    left += width;
  }
  return canvas.image();
}

Image2d<Rgba8> stroke_image(const StoredVolume& volume,
                            const render::PredicateScene::IntensityWindow& intensity,
                            const std::vector<Stroke>& strokes, int width, int height) {
  constexpr int kSmallest = 64;  // Least size of a slice, pixels.
  const auto slices = slices_of(strokes, volume.grid());
  NAV_CHECK(!slices.empty());
  const int count = static_cast<int>(slices.size());
  const int most_columns = std::max(width / kSmallest, 1);
  const int most_rows = std::max(height / kSmallest, 1);
  // Few slices are stacked; more would be too small, so they go into a grid.
  constexpr int kStacked = 3;
  const int columns =
      count <= kStacked
          ? 1
          : std::min(most_columns,
                     static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count)))));
  const int rows = std::min(most_rows, (count + columns - 1) / columns);
  const int shown = std::min(count, rows * columns);
  const render::HuWindow window{0.5 * (intensity.black + intensity.white),
                                intensity.white - intensity.black};
  const auto mask = marked(strokes, volume.grid());
  render::Canvas canvas(width, height, render::rgb8(0x101010));
  for (int n = 0; n < shown; ++n) {
    canvas.copy(slice_image(volume, window, slices[static_cast<std::size_t>(n)], mask,
                            width / columns, height / rows),
                n % columns * (width / columns), n / columns * (height / rows));
  }
  if (shown < count) {
    const Layout layout(height);
    const std::string words = std::to_string(count - shown) + " more slices not shown";
    canvas.fill(0, height - layout.line, canvas.text_width(layout.text, words) + 2 * layout.margin,
                layout.line, render::rgb8(0x202020));
    canvas.text(layout.margin, height - 5, layout.text, words, render::rgb8(0xffd24a));
  }
  return canvas.image();
}

}  // namespace nav::app
