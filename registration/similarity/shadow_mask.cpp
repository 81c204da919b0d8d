// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/shadow_mask.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <span>
#include <sstream>
#include <string>

#include "nav/index.hpp"
#include "registration/similarity/grey_histogram.hpp"
#include "registration/similarity/image_outline.hpp"
#include "registration/similarity/noise_floor.hpp"

namespace nav::registration {
namespace {

constexpr int kOutside = -1;
// An echo outweighs as many cells without one.
constexpr int kDarkPerEcho = 3;
// No ultrasound image is wider; a larger size has wrong units, and its mask would take minutes.
constexpr double kWidestImageMm = 1000;
// Arc length at mid depth; the widest probes have a third of a metre.
constexpr double kWidestArcMm = 3000;

Error reject_mask(const std::string& what, const std::string& expected, double found) {
  std::ostringstream text;
  text << what << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

/// Pixels [from, to) of an ultrasound image, by their index in it.
struct PixelRun {
  std::size_t from = 0, to = 0;
};

/// Scan line and depth bin of each pixel, the same for all images with one grid and outline.
struct ScanGeometry {
  int lines = 0;
  int depths = 0;
  double bin_mm = 1;
  /// One value for each pixel, row-major: depth * lines + line, because pixels of a row lie at
  /// similar depths; lines * depths outside the outline.
  std::vector<int> cell_of;
  /// One run for each row: from the first pixel with a cell to the last.
  std::vector<PixelRun> inside;
  std::vector<float> pixels;  ///< Pixels of each cell, at least 1.
  std::vector<float> empty;   ///< 1 for a cell without a pixel, else 0.
  [[nodiscard]] std::size_t cells() const {
    return static_cast<std::size_t>(lines) * static_cast<std::size_t>(depths);
  }
};

/// Line and depth bin of a pixel; kOutside: outside the outline.
struct BeamCell {
  int line = kOutside, depth = kOutside;
};

/// Look-up of bins by ascending edges. Consecutive pixels are neighbours, so that the bin of one is
/// hardly ever far from that of the last.
class Bins {
 public:
  /// Edges f(first + k size), k = 0, 1, ... until beyond the end. Values before the first edge or
  /// after the last belong to the end bins.
  template <class Function>
  Bins(double first, double end, double size, const Function& f) {
    for (int k = 0; first + k * size <= end; ++k) edges_.push_back(f(first + k * size));
    edges_.front() = -std::numeric_limits<double>::infinity();
    edges_.push_back(std::numeric_limits<double>::infinity());
  }
  /// Bin of value / unit, unit > 0.
  int of(double value, double unit = 1) {
    while (value >= edges_[last_ + 1] * unit) ++last_;
    while (value < edges_[last_] * unit) --last_;
    return static_cast<int>(last_);
  }

 private:
  std::vector<double> edges_;
  std::size_t last_ = 0;
};

/// Calls visit(p, i) with the position p of each pixel i in the image, mm, row by row.
template <class Visit>
void for_each_pixel(const UltrasoundImage& frame, const Visit& visit) {
  const auto& [mm_per_pixel, origin_mm] = frame.grid;
  std::size_t i = 0;
  for (int row = 0; row < frame.pixels.height(); ++row) {
    for (int column = 0; column < frame.pixels.width(); ++column) {
      // Equals PixelGrid::at(), without a call for each pixel.
      visit(Eigen::Vector2d(origin_mm + mm_per_pixel * Eigen::Vector2d(column, row)), i++);
    }
  }
}

/// Cells of a sector: beams rotate about an apex; lines are line_mm apart at mid depth.
std::vector<BeamCell> sector_cells(const UltrasoundImage& frame, const SectorOutline& outline,
                                   double line_mm, double bin_mm) {
  const double widest = outline.half_angle_rad;
  const double line_rad = 2 * line_mm / (outline.radius_min_mm + outline.radius_max_mm);
  Bins lines(-widest, widest, line_rad, [](double rad) { return std::tan(rad); });
  Bins depths(outline.radius_min_mm, outline.radius_max_mm, bin_mm, [](double r) { return r * r; });
  const double steepest = std::tan(widest);
  const double nearest = outline.radius_min_mm * outline.radius_min_mm;
  const double farthest = outline.radius_max_mm * outline.radius_max_mm;
  std::vector<BeamCell> cells(frame.pixels.pixels().size());
  for_each_pixel(frame, [&](const Eigen::Vector2d& p, std::size_t i) {
    // Equals SectorOutline::contains(), using tangents and squares.
    const Eigen::Vector2d d = p - outline.apex_mm;
    const double square = d.squaredNorm();
    const bool inside =
        d.y() > 0 && std::abs(d.x()) <= steepest * d.y() && square >= nearest && square <= farthest;
    if (inside) cells[i] = {lines.of(d.x(), d.y()), depths.of(square)};
  });
  return cells;
}

/// Cells of parallel beams, which run down the image.
std::vector<BeamCell> parallel_cells(const UltrasoundImage& frame, double line_mm, double bin_mm) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  for_each_pixel(frame, [&](const Eigen::Vector2d& p, std::size_t) { low = low.cwiseMin(p); });
  std::vector<BeamCell> cells(frame.pixels.pixels().size());
  for_each_pixel(frame, [&](const Eigen::Vector2d& p, std::size_t i) {
    cells[i] = {static_cast<int>((p.x() - low.x()) / line_mm),
                static_cast<int>((p.y() - low.y()) / bin_mm)};
  });
  return cells;
}

ScanGeometry scan_geometry(const UltrasoundImage& frame, double line_spacing_mm) {
  ScanGeometry geometry;
  // Bins no finer than a pixel, so that none stays empty along a line.
  geometry.bin_mm =
      std::max({1.0, frame.grid.mm_per_pixel.col(0).norm(), frame.grid.mm_per_pixel.col(1).norm()});
  const double line_mm = std::max(line_spacing_mm, frame.grid.mm_per_pixel.col(0).norm());
  const std::vector<BeamCell> cells =
      frame.outline ? sector_cells(frame, *frame.outline, line_mm, geometry.bin_mm)
                    : parallel_cells(frame, line_mm, geometry.bin_mm);
  int first = std::numeric_limits<int>::max();  // Lines beside the image do not count.
  int last = kOutside;
  for (const BeamCell& cell : cells) {
    if (cell.line == kOutside) continue;
    first = std::min(first, cell.line);
    last = std::max(last, cell.line);
    geometry.depths = std::max(geometry.depths, cell.depth + 1);
  }
  geometry.cell_of.assign(cells.size(), 0);
  if (last == kOutside) return geometry;
  geometry.lines = last - first + 1;
  std::vector<int> pixels(geometry.cells(), 0);
  const std::size_t width = as_size(frame.pixels.width());
  for (std::size_t begin = 0; begin < cells.size(); begin += width) {
    PixelRun run{begin + width, begin};
    for (std::size_t i = begin; i < begin + width; ++i) {
      geometry.cell_of[i] = geometry.lines * geometry.depths;
      if (cells[i].line == kOutside) continue;
      geometry.cell_of[i] = cells[i].depth * geometry.lines + cells[i].line - first;
      ++pixels[as_size(geometry.cell_of[i])];
      run.from = std::min(run.from, i);
      run.to = i + 1;
    }
    if (run.from < run.to) geometry.inside.push_back(run);
  }
  for (const int count : pixels) {
    geometry.pixels.push_back(static_cast<float>(std::max(count, 1)));
    geometry.empty.push_back(count > 0 ? 0.0f : 1.0f);
  }
  return geometry;
}

}  // namespace

bool same_geometry(const UltrasoundImage& a, const UltrasoundImage& b) {
  if (a.pixels.width() != b.pixels.width() || a.pixels.height() != b.pixels.height() ||
      a.grid.mm_per_pixel != b.grid.mm_per_pixel || a.grid.origin_mm != b.grid.origin_mm ||
      a.outline.has_value() != b.outline.has_value()) {
    return false;
  }
  return !a.outline || (a.outline->apex_mm == b.outline->apex_mm &&
                        a.outline->radius_min_mm == b.outline->radius_min_mm &&
                        a.outline->radius_max_mm == b.outline->radius_max_mm &&
                        a.outline->half_angle_rad == b.outline->half_angle_rad);
}

namespace {

/// Mean grey of each (line, depth) cell; kOutside, which is −1, if the image has no pixel there.
/// Averaging over the cell reduces speckle and the noise floor, whose single pixels can be bright.
std::vector<float> cell_means(const UltrasoundImage& frame, const ScanGeometry& geometry) {
  // Two sums for each cell: neighbouring pixels, mostly of one cell, need not wait for each other.
  const std::size_t cells = geometry.cells();
  std::vector<int> sums(2 * (cells + 1), 0);
  int* even = sums.data();
  int* odd = even + cells + 1;
  const std::uint8_t* grey = frame.pixels.pixels().data();
  const int* cell_of = geometry.cell_of.data();
  for (const PixelRun& run : geometry.inside) {
    std::size_t i = run.from;
    for (; i + 1 < run.to; i += 2) {
      even[cell_of[i]] += grey[i];
      odd[cell_of[i + 1]] += grey[i + 1];
    }
    if (i < run.to) even[cell_of[i]] += grey[i];
  }
  std::vector<float> means(cells);
  const float* pixels = geometry.pixels.data();
  const float* empty = geometry.empty.data();
  for (std::size_t cell = 0; cell < cells; ++cell) {
    means[cell] = static_cast<float>(even[cell] + odd[cell]) / pixels[cell] - empty[cell];
  }
  return means;
}

/// 75th percentile over all lines and images, for each depth; 0 where no image has a pixel.
std::vector<int> usual_grey(const std::vector<CellGreys>& means, CellCount count) {
  std::vector<int> usual;
  for (std::size_t depth = 0; depth < as_size(count.depths); ++depth) {
    usual.push_back(greys_at(means, depth, as_size(count.lines)).quantile(0.75).value_or(0));
  }
  return usual;
}

/// First depth bin of each line that is no longer usable: the depth with the most echoes above it
/// less a third of the cells without an echo. Dark tissue or a vessel does not end a line, and a
/// bright cell of noise far below does not prolong one.
std::vector<int> line_ends(const CellGreys& means, const CellGreys& calmed,
                           const std::vector<int>& usual, const NoiseFloor& noise, CellCount count,
                           const ShadowMaskOptions& options) {
  const auto lines = as_size(count.lines);
  std::vector<int> own(lines, 0), balance(lines, 0), best(lines, 0);
  for (int depth = 0; depth < std::min(count.depths, noise.noise_from); ++depth) {
    // The limit is at least 1, so that black is never an echo.
    const auto limit = static_cast<float>(std::max(usual[as_size(depth)] - options.drop_grey, 1));
    const float least = noise.least_echo[as_size(depth)];
    const std::size_t first = as_size(depth) * lines;
    for (std::size_t line = 0; line < lines; ++line) {
      if (means[first + line] < 0) continue;
      const bool echo = means[first + line] >= limit && calmed[first + line] >= least;
      balance[line] += echo ? kDarkPerEcho : -1;
      if (balance[line] <= best[line]) continue;
      best[line] = balance[line];
      own[line] = depth + 1;
    }
  }
  std::vector<int> ends(lines);
  for (int line = 0; line < count.lines; ++line) {
    const int from = std::max(line - options.neighbour_lines, 0);
    const int to = std::min(line + options.neighbour_lines, count.lines - 1);
    ends[as_size(line)] = *std::min_element(own.begin() + from, own.begin() + to + 1);
  }
  return ends;
}

/// Pixels outside the beams of a sweep without an outline, dilated by one pixel, because the pixels
/// at the edge are half lit.
std::vector<std::uint8_t> outside_of(const Sweep& sweep) {
  const Image2d<std::uint8_t>& first = sweep.frames().front().frame.pixels;
  std::vector<std::uint8_t> dark = never_lit(sweep);
  const cv::Mat narrow(first.height(), first.width(), CV_8U, dark.data());
  cv::Mat wider;
  cv::dilate(narrow, wider, cv::Mat::ones(3, 3, CV_8U));
  return {wider.datastart, wider.dataend};
}

Result<void> check_outline(const SectorOutline& outline, const std::string& name) {
  const bool good = outline.apex_mm.allFinite() && outline.radius_min_mm >= 0 &&
                    outline.radius_max_mm > outline.radius_min_mm &&
                    std::isfinite(outline.radius_max_mm) && outline.half_angle_rad > 0 &&
                    outline.half_angle_rad < M_PI_2;
  if (!good) {
    std::ostringstream text;
    text << name << "expected an outline with 0 <= radius_min < radius_max and a half angle in "
         << "(0, pi/2), found radii " << outline.radius_min_mm << " and " << outline.radius_max_mm
         << " mm, half angle " << outline.half_angle_rad << " rad";
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  const double deep_mm = outline.radius_max_mm - outline.radius_min_mm;
  const double wide_mm = outline.half_angle_rad * (outline.radius_min_mm + outline.radius_max_mm);
  if (deep_mm <= kWidestImageMm && wide_mm <= kWidestArcMm) return {};
  std::ostringstream text;
  text << name << "expected an outline at most " << kWidestImageMm << " mm deep and "
       << kWidestArcMm << " mm wide half way down, found " << deep_mm << " and " << wide_mm
       << " mm: are its radii in mm?";
  return Error{ErrorCode::kMalformedData, text.str()};
}

}  // namespace

Result<void> check_geometry(const Sweep& sweep) {
  for (std::size_t i = 0; i < sweep.frames().size(); ++i) {
    const UltrasoundImage& frame = sweep.frames()[i].frame;
    const std::string name = "sweep image " + std::to_string(i) + ": ";
    if (const auto ok = nav::validate(frame.grid); !ok) {
      return Error{ok.error().code, name + ok.error().message};
    }
    const double width_mm = frame.pixels.width() * frame.grid.mm_per_pixel.col(0).norm();
    const double height_mm = frame.pixels.height() * frame.grid.mm_per_pixel.col(1).norm();
    if (!(std::max(width_mm, height_mm) <= kWidestImageMm)) {
      std::ostringstream text;
      text << name << "expected an image of at most " << kWidestImageMm
           << " mm along either side, found one of " << width_mm << " x " << height_mm
           << " mm: is the size of its pixels in mm?";
      return Error{ErrorCode::kMalformedData, text.str()};
    }
    if (!frame.outline) continue;
    if (auto ok = check_outline(*frame.outline, name); !ok) return ok;
  }
  for (std::size_t i = 1; i < sweep.frames().size(); ++i) {
    if (same_geometry(sweep.frames().front().frame, sweep.frames()[i].frame)) continue;
    return Error{ErrorCode::kMalformedData,
                 "sweep image " + std::to_string(i) +
                     ": expected the pixel grid and outline of image 0, found others"};
  }
  return {};
}

Result<void> validate(const ShadowMaskOptions& options) {
  if (!(options.near_field_mm >= 0 && options.near_field_mm < 1e3)) {
    return reject_mask("near_field_mm", "0 to 1000", options.near_field_mm);
  }
  if (options.drop_grey < 1 || options.drop_grey > 254) {
    return reject_mask("drop_grey", "1 to 254", options.drop_grey);
  }
  if (options.neighbour_lines < 0 || options.neighbour_lines > 1000) {
    return reject_mask("neighbour_lines", "0 to 1000", options.neighbour_lines);
  }
  if (!(options.line_spacing_mm > 0 && options.line_spacing_mm < 100)) {
    return reject_mask("line_spacing_mm", "a value in (0, 100)", options.line_spacing_mm);
  }
  return {};
}

Result<std::vector<Image2d<std::uint8_t>>> shadow_masks(const Sweep& sweep,
                                                        const ShadowMaskOptions& options) {
  if (const auto ok = validate(options); !ok) return ok.error();
  if (const auto ok = check_geometry(sweep); !ok) return ok.error();
  const auto& frames = sweep.frames();
  const UltrasoundImage& first = frames.front().frame;
  const ScanGeometry geometry = scan_geometry(first, options.line_spacing_mm);
  std::vector<CellGreys> means;
  means.reserve(frames.size());
  for (const auto& tracked : frames) means.push_back(cell_means(tracked.frame, geometry));
  const CellCount count{geometry.lines, geometry.depths};
  std::vector<CellGreys> calmed;
  calmed.reserve(frames.size());
  for (const CellGreys& image : means) calmed.push_back(calm(image, count));
  const std::vector<int> usual = usual_grey(means, count);
  const NoiseFloor noise = noise_floor(means, calmed, count);
  const int near = static_cast<int>(std::ceil(options.near_field_mm / geometry.bin_mm));

  const std::vector<std::uint8_t> outside =
      first.outline ? std::vector<std::uint8_t>() : outside_of(sweep);
  std::vector<Image2d<std::uint8_t>> masks;
  masks.reserve(frames.size());
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::vector<int> ends = line_ends(means[f], calmed[f], usual, noise, count, options);
    std::vector<std::uint8_t> usable(geometry.cells() + 1, 0);
    for (int depth = near; depth < geometry.depths; ++depth) {
      std::uint8_t* row = &usable[as_size(depth) * ends.size()];
      for (std::size_t line = 0; line < ends.size(); ++line) row[line] = depth < ends[line] ? 1 : 0;
    }
    std::vector<std::uint8_t> mask(geometry.cell_of.size(), 0);
    for (const PixelRun& run : geometry.inside) {
      for (std::size_t i = run.from; i < run.to; ++i) {
        mask[i] = usable[as_size(geometry.cell_of[i])];
      }
    }
    for (std::size_t i = 0; i < outside.size(); ++i) {
      if (outside[i] != 0) mask[i] = 0;
    }
    masks.emplace_back(first.pixels.width(), first.pixels.height(), std::move(mask));
  }
  return masks;
}

}  // namespace nav::registration
