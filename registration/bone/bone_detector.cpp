// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/bone/bone_detector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/bone/scan_lines.hpp"
#include "registration/similarity/grey_histogram.hpp"
#include "registration/similarity/image_outline.hpp"
#include "registration/similarity/noise_floor.hpp"
#include "registration/similarity/shadow_mask.hpp"

namespace nav::registration {
namespace {

// Half widths of the ridge, mm: a linear probe's pulse to that of a low-frequency convex one.
constexpr std::array kRidgeHalfMm = {0.25, 0.5, 0.9};
constexpr double kRidgeGapMm = 0.4;     // Between the ridge and what it is compared with.
constexpr double kRidgeBesideMm = 1.5;  // Length of that, above and below.
constexpr double kAboveMm = 6;       // Echoes above the ridge, which the shadow is compared with.
constexpr double kBelowMm = 2;       // From the ridge to where its shadow begins.
constexpr double kLaterEchoMm = 4;   // Length of a later echo in the shadow,
constexpr double kLaterHalfMm = 15;  // which counts half this far below.
constexpr double kLeastTissue = 4;   // Grey above the noise.
// An echo below darkness lies in the shadow of another: the echoes above it are weaker than this
// share of those higher up, which count half this far above.
constexpr double kLeastLitShare = 0.3;
constexpr double kLitHalfMm = 30;
// An echo that runs to and fro between bone and transducer shows again at twice the depth, weaker.
constexpr double kTwiceMm = 0.8;
constexpr float kTwiceStronger = 1.3f;
// Weight of the near shadow; the rest is that of later echoes, which alone count this much: the far
// wall of a vessel ends no shadow.
constexpr float kPerShade = 0.6f;
constexpr float kPerLater = 0.75f;
constexpr double kNoiseCellMm = 1;  // Cells of the noise floor.
constexpr std::size_t kLearntImages = 24;
// Log-odds of bone against none, by ridge (in standard deviations of the texture) and by shadow.
constexpr double kUsualRidge = 2.0;
constexpr double kPerRidge = 0.9;
constexpr double kMostRidge = 6;
constexpr double kPerShadow = 6;
constexpr double kBeginCost = 5;      // A surface that begins or ends within an image.
constexpr double kPerJumpMm = 1.0;    // A step in depth from one line to the next.
constexpr double kRefineMm = 0.6;     // The peak lies this close to the best path.
constexpr double kPeakHalfMm = 0.15;  // Half width of the mean whose peak is sought.
// The echo lies at the centre of what exceeds this share of the way from the tissue to its peak.
constexpr double kEchoShare = 0.5;
constexpr double kEchoReachMm = 1.2;
constexpr double kConfidentOdds = 2.5;

using Greys = std::vector<float>;  // Depth-major: depth * lines + line.

/// Sums down the lines: row d holds the sum of the samples above d.
class LineSums {
 public:
  LineSums(const Greys& values, int lines, int depths)
      : lines_(as_size(lines)), depths_(depths), sums_(values.size() + as_size(lines), 0) {
    for (std::size_t i = 0; i < values.size(); ++i) sums_[i + lines_] = sums_[i] + values[i];
  }
  /// Row of sums above a depth, limited to the image.
  [[nodiscard]] const float* row(int depth) const {
    return &sums_[as_size(std::clamp(depth, 0, depths_)) * lines_];
  }

 private:
  std::size_t lines_;
  int depths_;
  Greys sums_;
};

/// Ranges of samples that the features of one ridge width compare.
struct RidgeSpan {
  int half, gap, beside;
};

Error reject_bone(const std::string& what, const std::string& expected, double found) {
  std::ostringstream text;
  text << what << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

/// Averages neighbouring lines with the weights 1, 2 and 1, which calms speckle.
Greys across_lines(const Greys& greys, int lines) {
  const std::size_t n = as_size(lines);
  Greys out(greys.size());
  for (std::size_t row = 0; row < greys.size(); row += n) {
    const float* g = &greys[row];
    float* o = &out[row];
    if (n < 2) {
      o[0] = g[0];
      continue;
    }
    o[0] = 0.75f * g[0] + 0.25f * g[1];
    for (std::size_t i = 1; i + 1 < n; ++i) o[i] = 0.5f * g[i] + 0.25f * (g[i - 1] + g[i + 1]);
    o[n - 1] = 0.75f * g[n - 1] + 0.25f * g[n - 2];
  }
  return out;
}

/// Ridge of one width at a depth for all lines: how far the mean exceeds those above and below.
void ridge_row(const LineSums& sums, const RidgeSpan& span, int depth, int lines, float* out) {
  const float* a0 = sums.row(depth - span.half - span.gap - span.beside);
  const float* a1 = sums.row(depth - span.half - span.gap);
  const float* c0 = sums.row(depth - span.half);
  const float* c1 = sums.row(depth + span.half + 1);
  const float* b0 = sums.row(depth + span.half + 1 + span.gap);
  const float* b1 = sums.row(depth + span.half + 1 + span.gap + span.beside);
  const float per_centre = 1.0f / static_cast<float>(2 * span.half + 1);
  const float per_beside = 1.0f / static_cast<float>(span.beside);
  for (int i = 0; i < lines; ++i) {
    const float above = (a1[i] - a0[i]) * per_beside;
    const float below = (b1[i] - b0[i]) * per_beside;
    out[i] = (c1[i] - c0[i]) * per_centre - std::max(above, below);
  }
}

float median_of(std::vector<float>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

struct BoneDetector::Data {
  BoneDetectorOptions options;
  UltrasoundImage like;  ///< Geometry of the images.
  ScanLines scan;
  std::vector<RidgeSpan> spans{};
  std::vector<float> texture{};  ///< Standard deviation of the ridge in tissue, by width, > 0.
  Greys noise_sums{};            ///< Least echo by depth, summed from the top; depths + 1 values.
  int deepest = 0;               ///< Depth from which on all images show noise alone.

  Data(const Sweep& sweep, const BoneDetectorOptions& of)
      : options(of), like(sweep.frames().front().frame), scan(sweep, of.line_mm) {
    for (const double half_mm : kRidgeHalfMm) {
      spans.push_back({std::max(steps(half_mm), 1), steps(kRidgeGapMm), steps(kRidgeBesideMm)});
    }
    learn_noise(sweep);
    learn_texture(sweep);
  }

  [[nodiscard]] int steps(double mm) const {
    return static_cast<int>(std::lround(mm / scan.step_mm()));
  }
  [[nodiscard]] Greys lines_of(const UltrasoundImage& frame) const {
    return across_lines(scan.sample(frame.pixels), scan.lines());
  }
  [[nodiscard]] float noise_between(int from, int to) const {
    const int a = std::clamp(from, 0, scan.depths());
    const int b = std::clamp(to, a, scan.depths());
    return b > a ? (noise_sums[as_size(b)] - noise_sums[as_size(a)]) / static_cast<float>(b - a)
                 : 0;
  }
  void learn_noise(const Sweep& sweep);
  void learn_texture(const Sweep& sweep);
  /// Log-odds of bone at each sample, line-major; negative where there is none.
  [[nodiscard]] Greys odds(const Greys& greys) const;
  /// True if a stronger ridge lies half as deep.
  [[nodiscard]] bool is_second_echo(const Greys& ridges, int depth, std::size_t line) const {
    const int reach = steps(kTwiceMm);
    const auto n = as_size(scan.lines());
    const float own = kTwiceStronger * ridges[as_size(depth) * n + line];
    for (int d = std::max(depth / 2 - reach, 0); d <= depth / 2 + reach && d < depth; ++d) {
      if (ridges[as_size(d) * n + line] > own) return true;
    }
    return false;
  }
  /// Depth of the bone on each line; negative: none.
  [[nodiscard]] std::vector<int> best_path(const Greys& odds) const;
  /// Depth of an echo's centre, by its peak.
  [[nodiscard]] double centre_of_echo(const LineSums& sums, const Greys& greys, int peak,
                                      std::size_t line) const;
  [[nodiscard]] BoneSurface surface(const std::vector<int>& path, const Greys& odds,
                                    const Greys& greys) const;
};

void BoneDetector::Data::learn_noise(const Sweep& sweep) {
  const int across = std::max(1, static_cast<int>(std::lround(kNoiseCellMm / scan.line_mm())));
  const int down = std::max(1, steps(kNoiseCellMm));
  const CellCount count{(scan.lines() + across - 1) / across, (scan.depths() + down - 1) / down};
  const auto lines = as_size(count.lines);
  std::vector<CellGreys> cells, calmed;
  const auto& frames = sweep.frames();
  const std::size_t stride = (frames.size() + kLearntImages - 1) / kLearntImages;
  for (std::size_t f = 0; f < frames.size(); f += stride) {
    const Greys greys = scan.sample(frames[f].frame.pixels);
    CellGreys sums(lines * as_size(count.depths), 0), pixels(sums.size(), 0);
    for (int line = 0; line < scan.lines(); ++line) {
      for (int depth = scan.first(line); depth < scan.depths(); ++depth) {
        const std::size_t cell = as_size(depth / down) * lines + as_size(line / across);
        sums[cell] += greys[as_size(depth) * as_size(scan.lines()) + as_size(line)];
        pixels[cell] += 1;
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
      sums[i] = pixels[i] > 0 ? sums[i] / pixels[i] : -1;
    calmed.push_back(calm(sums, count));
    cells.push_back(std::move(sums));
  }
  const NoiseFloor floor = noise_floor(cells, calmed, count);
  deepest = std::min(floor.noise_from * down, scan.depths());
  noise_sums.assign(as_size(scan.depths()) + 1, 0);
  for (int depth = 0; depth < scan.depths(); ++depth) {
    noise_sums[as_size(depth) + 1] =
        noise_sums[as_size(depth)] + floor.least_echo[as_size(depth / down)];
  }
}

void BoneDetector::Data::learn_texture(const Sweep& sweep) {
  const auto& frames = sweep.frames();
  const std::size_t stride = (frames.size() + kLearntImages - 1) / kLearntImages;
  std::vector<std::vector<float>> ridges(spans.size());
  Greys row(as_size(scan.lines()));
  for (std::size_t f = 0; f < frames.size(); f += stride) {
    const Greys greys = lines_of(frames[f].frame);
    const LineSums sums(greys, scan.lines(), scan.depths());
    for (int depth = 0; depth < deepest; depth += 5) {
      const float least = noise_between(depth, depth + 1);
      for (std::size_t s = 0; s < spans.size(); ++s) {
        ridge_row(sums, spans[s], depth, scan.lines(), row.data());
        for (std::size_t i = 0; i < row.size(); i += 3) {
          if (greys[as_size(depth) * row.size() + i] > std::max(least, 1.0f)) {
            ridges[s].push_back(row[i]);
          }
        }
      }
    }
  }
  for (auto& values : ridges) {
    const float middle = median_of(values);
    for (float& value : values) value = std::abs(value - middle);
    texture.push_back(std::max(1.4826f * median_of(values), 2.0f));
  }
}

Greys BoneDetector::Data::odds(const Greys& greys) const {
  const int lines = scan.lines();
  const int depths = scan.depths();
  const auto n = as_size(lines);
  const LineSums sums(greys, lines, depths);
  Greys out(greys.size(), -1);
  // Ridges, in standard deviations of the texture; echoes above each sample, and the strongest of
  // them so far, from the top downwards.
  const int above_steps = std::max(steps(kAboveMm), 1);
  const int ridge_steps = std::max(steps(kRidgeHalfMm[0]), 1);
  Greys tissue(greys.size()), lit(greys.size()), ridges(greys.size(), 0), one(n);
  const auto dim = static_cast<float>(std::pow(0.5, scan.step_mm() / kLitHalfMm));
  for (int depth = 0; depth < depths; ++depth) {
    const int from = std::max(depth - above_steps, 0);
    const int to = std::max(depth - ridge_steps, from);
    const float* a0 = sums.row(from);
    const float* a1 = sums.row(to);
    const float noise = noise_between(from, to);
    const float per_above = 1.0f / static_cast<float>(std::max(to - from, 1));
    float* t = &tissue[as_size(depth) * n];
    float* l = &lit[as_size(depth) * n];
    for (std::size_t i = 0; i < n; ++i) {
      t[i] = (a1[i] - a0[i]) * per_above - noise;
      l[i] = depth > 0 ? std::max(t[i], dim * (l - n)[i]) : t[i];
    }
    float* ridge = &ridges[as_size(depth) * n];
    for (std::size_t s = 0; s < spans.size(); ++s) {
      ridge_row(sums, spans[s], depth, lines, one.data());
      const float per_texture = 1 / texture[s];
      for (std::size_t i = 0; i < n; ++i) ridge[i] = std::max(ridge[i], one[i] * per_texture);
    }
  }
  // The strongest later echo, from the bottom upwards, less the farther down it lies.
  Greys later(n, 0);
  const int later_steps = std::max(steps(kLaterEchoMm), 1);
  const auto fade = static_cast<float>(std::pow(0.5, scan.step_mm() / kLaterHalfMm));
  const int near = steps(options.near_field_mm);
  const int shadow_steps = std::max(steps(options.shadow_mm), 1);
  const int least_steps = std::max(steps(options.least_shadow_mm), 1);
  const int below = steps(kBelowMm);
  const auto most = static_cast<float>(options.most_shadow_echo);
  for (int depth = deepest - below - least_steps; depth >= 0; --depth) {
    const int from = depth + below;
    const int to = std::min(from + shadow_steps, deepest);
    const int later_to = std::min(from + later_steps, deepest);
    const float noise = noise_between(from, to);
    const float later_noise = noise_between(from, later_to);
    const float* s0 = sums.row(from);
    const float* s1 = sums.row(to);
    const float* l1 = sums.row(later_to);
    const float per_shadow = 1.0f / static_cast<float>(to - from);
    const float per_later = 1.0f / static_cast<float>(later_to - from);
    const float* ridge = &ridges[as_size(depth) * n];
    const float* t = &tissue[as_size(depth) * n];
    const float* l = &lit[as_size(depth) * n];
    for (std::size_t i = 0; i < n; ++i) {
      later[i] = std::max(fade * later[i], (l1[i] - s0[i]) * per_later - later_noise);
      const float shade = std::max((s1[i] - s0[i]) * per_shadow - noise, 0.0f);
      const float after = std::max(later[i], 0.0f);
      const float echo = std::max(kPerShade * shade + (1 - kPerShade) * after, kPerLater * after);
      const float least =
          std::max(static_cast<float>(kLeastTissue), static_cast<float>(kLeastLitShare) * l[i]);
      const float share = t[i] > least ? echo / t[i] : 2.0f;
      const bool may =
          depth >= near + scan.first(static_cast<int>(i)) && share < most && ridge[i] > 1;
      if (!may || is_second_echo(ridges, depth, i)) continue;
      out[i * as_size(depths) + as_size(depth)] =
          static_cast<float>(kPerRidge) * (std::min(ridge[i], static_cast<float>(kMostRidge)) -
                                           static_cast<float>(kUsualRidge)) +
          static_cast<float>(kPerShadow) * (0.5f * most - share);
    }
  }
  return out;
}

std::vector<int> BoneDetector::Data::best_path(const Greys& odds) const {
  const auto depths = as_size(scan.depths());
  const auto lines = as_size(scan.lines());
  constexpr int kNone = -1;
  const auto per_step = static_cast<float>(kPerJumpMm * scan.step_mm());
  // Best sum of a path that ends at a depth, or without bone, and where it came from.
  std::vector<float> best(depths, -1e9f), moved(depths);
  std::vector<int> from(depths);
  float none = 0;
  std::vector<int> came(lines * depths, kNone), none_came(lines, kNone);
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t d = 0; d < depths; ++d) {
      moved[d] = best[d];
      from[d] = static_cast<int>(d);
      if (d > 0 && moved[d - 1] - per_step > moved[d]) {
        moved[d] = moved[d - 1] - per_step;
        from[d] = from[d - 1];
      }
    }
    std::size_t strongest = 0;
    for (std::size_t d = depths; d-- > 0;) {
      if (d + 1 < depths && moved[d + 1] - per_step > moved[d]) {
        moved[d] = moved[d + 1] - per_step;
        from[d] = from[d + 1];
      }
      if (best[d] > best[strongest]) strongest = d;
    }
    const float ended = best[strongest] - static_cast<float>(kBeginCost);
    const float begun = none - static_cast<float>(kBeginCost);
    for (std::size_t d = 0; d < depths; ++d) {
      const bool begins = begun >= moved[d];
      best[d] = (begins ? begun : moved[d]) + odds[line * depths + d];
      came[line * depths + d] = begins ? kNone : from[d];
    }
    none_came[line] = ended > none ? static_cast<int>(strongest) : kNone;
    none = std::max(none, ended);
  }
  std::vector<int> path(lines, kNone);
  int at = kNone;
  const auto strongest = std::max_element(best.begin(), best.end());
  if (*strongest > none) at = static_cast<int>(strongest - best.begin());
  for (std::size_t line = lines; line-- > 0;) {
    path[line] = at;
    at = at == kNone ? none_came[line] : came[line * depths + as_size(at)];
  }
  return path;
}

double BoneDetector::Data::centre_of_echo(const LineSums& sums, const Greys& greys, int peak,
                                          std::size_t line) const {
  const auto grey = [&](int depth) {
    const bool inside = depth >= 0 && depth < scan.depths();
    return inside ? static_cast<double>(greys[as_size(depth) * as_size(scan.lines()) + line]) : 0.0;
  };
  const int above_to = peak - steps(kRidgeHalfMm[1] + kRidgeGapMm);
  const int above_from = above_to - std::max(steps(kRidgeBesideMm), 1);
  const double above = above_from < 0 ? 0
                                      : (sums.row(above_to)[line] - sums.row(above_from)[line]) /
                                            static_cast<double>(above_to - above_from);
  const double least = above + kEchoShare * (grey(peak) - above);
  double weights = 0;
  double moment = 0;
  const int reach = std::max(steps(kEchoReachMm), 1);
  for (const int step : {-1, 1}) {
    for (int k = step < 0 ? 0 : 1; k <= reach; ++k) {
      const double excess = grey(peak + step * k) - least;
      if (excess <= 0) break;
      weights += excess;
      moment += excess * (step * k);
    }
  }
  return peak + (weights > 0 ? moment / weights : 0);
}

BoneSurface BoneDetector::Data::surface(const std::vector<int>& path, const Greys& odds,
                                        const Greys& greys) const {
  const LineSums sums(greys, scan.lines(), scan.depths());
  const int half = steps(kPeakHalfMm);
  const int reach = std::max(steps(kRefineMm), 1);
  BoneSurface out;
  for (std::size_t begin = 0; begin < path.size();) {
    if (path[begin] < 0) {
      ++begin;
      continue;
    }
    std::size_t end = begin + 1;
    while (end < path.size() && path[end] >= 0) ++end;
    const double wide_mm = (scan.at_mm(static_cast<int>(begin), path[begin]) -
                            scan.at_mm(static_cast<int>(end - 1), path[end - 1]))
                               .norm();
    for (std::size_t line = begin; wide_mm >= options.least_width_mm && line < end; ++line) {
      const int depth = path[line];
      const float own = odds[line * as_size(scan.depths()) + as_size(depth)];
      const double confidence = 1 / (1 + std::exp(-static_cast<double>(own) / kConfidentOdds));
      if (own < 0 || confidence < options.least_confidence) continue;
      const auto mean = [&](int d) {
        return sums.row(d + half + 1)[line] - sums.row(d - half)[line];
      };
      int peak = depth;
      for (int d = depth - reach; d <= depth + reach; ++d) {
        if (mean(d) > mean(peak)) peak = d;
      }
      const double shift = centre_of_echo(sums, greys, peak, line) - peak;
      const int number = static_cast<int>(line);
      out.push_back({number, scan.at_mm(number, peak + shift), scan.along(number), confidence});
    }
    begin = end;
  }
  return out;
}

Result<void> validate(const BoneDetectorOptions& o) {
  if (!(o.line_mm > 0 && o.line_mm <= 10)) return reject_bone("line_mm", "0 to 10", o.line_mm);
  if (!(o.near_field_mm >= 0 && o.near_field_mm <= 1e3)) {
    return reject_bone("near_field_mm", "0 to 1000", o.near_field_mm);
  }
  if (!(o.shadow_mm > 1 && o.shadow_mm <= 50)) {
    return reject_bone("shadow_mm", "1 to 50", o.shadow_mm);
  }
  if (!(o.least_shadow_mm > 1 && o.least_shadow_mm <= o.shadow_mm)) {
    return reject_bone("least_shadow_mm", "1 to shadow_mm", o.least_shadow_mm);
  }
  if (!(o.most_shadow_echo > 0 && o.most_shadow_echo < 1)) {
    return reject_bone("most_shadow_echo", "0 to 1", o.most_shadow_echo);
  }
  if (!(o.least_width_mm >= 0 && o.least_width_mm <= 1e3)) {
    return reject_bone("least_width_mm", "0 to 1000", o.least_width_mm);
  }
  if (!(o.least_confidence >= 0 && o.least_confidence <= 1)) {
    return reject_bone("least_confidence", "0 to 1", o.least_confidence);
  }
  return {};
}

Result<BoneDetector> BoneDetector::create(const Sweep& sweep, const BoneDetectorOptions& options) {
  if (const auto ok = validate(options); !ok) return ok.error();
  if (const auto ok = check_geometry(sweep); !ok) return ok.error();
  return BoneDetector(std::make_shared<const Data>(sweep, options));
}

int BoneDetector::lines() const { return data_->scan.lines(); }

BoneSurface BoneDetector::detect(const UltrasoundImage& frame) const {
  NAV_CHECK(same_geometry(data_->like, frame), frame.pixels.width(), frame.pixels.height());
  const Greys greys = data_->lines_of(frame);
  const Greys odds = data_->odds(greys);
  return data_->surface(data_->best_path(odds), odds, greys);
}

double BoneOfSweep::share() const {
  std::size_t found = 0;
  for (const BoneSurface& one : images) found += one.size();
  return static_cast<double>(found) / (static_cast<double>(images.size()) * std::max(lines, 1));
}

Result<BoneOfSweep> bone_of_sweep(const Sweep& sweep, const BoneDetectorOptions& options,
                                  int threads) {
  const Sweep outlined = with_outline(sweep);
  const auto detector = BoneDetector::create(outlined, options);
  if (!detector) return detector.error();
  BoneOfSweep out{std::vector<BoneSurface>(sweep.frames().size()), detector->lines()};
  const auto one = [&](std::size_t i) {
    out.images[i] = detector->detect(outlined.frames()[i].frame);
  };
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, out.images.size(), one); });
  return out;
}

}  // namespace nav::registration
