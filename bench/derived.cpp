// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/derived.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <malloc.h>
#include <numbers>
#include <optional>

#include "bench/derived_itk.hpp"
#include "render/features/definition.hpp"
#include "render/features/service.hpp"

namespace nav::bench {
namespace {

using namespace render::features;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kVoxelMm = 0.4;

/// Number in [0, 1) from a position: without state, independent of the order.
double hash01(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1.0p-53;
}

/// Mean brightness at a position, in fractions of the side.
double tissue(double x, double y, double z) {
  const double layers = 90 + 30 * std::sin(14 * y + 2 * std::sin(5 * x)) + 10 * std::sin(9 * z);
  const double vessels[3][3] = {{0.3, 0.45, 0.05}, {0.62, 0.6, 0.03}, {0.5, 0.25, 0.018}};
  for (const auto& v : vessels) {
    const double wander = 0.08 * std::sin(6 * z + 9 * v[0]);
    if (std::hypot(x - v[0] - wander, y - v[1]) < v[2]) return 14;
  }
  if (std::hypot(x - 0.8, y - 0.35) < 0.08 && y < 0.35) return 230;
  if (std::abs(x - 0.8) < 0.08 && y >= 0.35) return 6;
  return layers;
}

ItkVoxels itk_voxels(const ScalarVolume& volume) {
  const VoxelGrid& grid = volume.grid();
  ItkVoxels voxels{grid.size,
                   {grid.spacing_mm.x(), grid.spacing_mm.y(), grid.spacing_mm.z()},
                   std::vector<float>(ItkPeer::built() ? grid.voxel_count() : 0)};
  if (!ItkPeer::built()) return voxels;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      volume.read_row(j, k, voxels.values.data() + offset_of(grid, 0, j, k));
    }
  }
  return voxels;
}

ScanLines down(const ScalarVolume& volume) {
  return *ScanLines::parallel({{0, 1, 0}}, volume.grid().at({0, 0, 0}));
}

/// Scan lines from an apex half a side above the middle of the first face.
ScanLines fan(const ScalarVolume& volume) {
  const auto& size = volume.grid().size;
  return *ScanLines::fan(volume.grid().at({size[0] / 2.0, -size[1] / 2.0, size[2] / 2.0}), 0);
}

GradientPartOptions smooth(GradientPart part, double truncate = GradientOptions{}.truncate) {
  return {part, {.smoothing_mm = kUsualSmoothingMm, .truncate = truncate}};
}

/// A feature with the ITK filter that computes the same quantity.
struct Subject {
  std::string name;
  DerivedOptions options;
  double goal_s;
  std::string peer;
  std::function<void(ItkPeer&)> run_peer{};
  std::optional<ScanLines> lines{};  ///< None: scan lines run straight down.
};

std::vector<Subject> subjects(const ScalarVolume& volume, int threads) {
  const VesselnessOptions vessels;
  const auto sigmas = sigmas_mm(vessels);
  const ItkTubes tubes{
      .bright = vessels.polarity == Polarity::kBright,
      .alpha = vessels.alpha,
      .beta = vessels.beta,
      .c = contrast_of(vessels, volume, threads) / (std::numbers::sqrt2 * std::numbers::e),
      .first_sigma_mm = sigmas.front(),
      .last_sigma_mm = sigmas.back(),
      .scales = vessels.scales};
  return {
      {.name = "snr",
       .options = SnrOptions{},
       .goal_s = 1,
       .peer = "NoiseImageFilter + MeanImageFilter",
       .run_peer = [](ItkPeer& p) { p.signal_to_noise(); }},
      {.name = "vesselness",
       .options = vessels,
       .goal_s = 6,
       .peer = "MultiScaleHessianBasedMeasure, 4 scales",
       .run_peer = [=](ItkPeer& p) { p.vesselness(tubes); }},
      {.name = "confidence", .options = ConfidenceOptions{}, .goal_s = 10, .peer = "none"},
      {.name = "confidence_of_fan",
       .options = ConfidenceOptions{},
       .goal_s = 10,
       .peer = "none",
       .lines = fan(volume)},
      {.name = "gradient_magnitude",
       .options = GradientPartOptions{},
       .goal_s = kNaN,
       .peer = "GradientMagnitudeImageFilter",
       .run_peer = [](ItkPeer& p) { p.gradient_magnitude(0); }},
      {.name = "gradient_angle",
       .options = GradientPartOptions{GradientPart::kAngle},
       .goal_s = kNaN,
       .peer = "none"},
      {.name = "smooth_gradient_magnitude",
       .options = smooth(GradientPart::kMagnitude),
       .goal_s = kNaN,
       .peer = "GradientMagnitudeRecursiveGaussianImageFilter",
       .run_peer = [](ItkPeer& p) { p.gradient_magnitude(kUsualSmoothingMm); }},
      {.name = "smooth_gradient_along",
       .options = smooth(GradientPart::kAlong),
       .goal_s = kNaN,
       .peer = "none"},
      {.name = "smooth_gradient_across",
       .options = smooth(GradientPart::kAcross),
       .goal_s = kNaN,
       .peer = "none"},
  };
}

Result<DerivedTiming> time_subject(const Subject& subject, const ScalarVolume& volume,
                                   const DerivedBenchOptions& options, ItkPeer& peer) {
  DerivedTiming timing{.feature = subject.name,
                       .goal_s = subject.goal_s,
                       .peer = subject.peer,
                       .peer_taken = {kNaN, kNaN}};
  const DerivedRequest request{volume, subject.options,
                               subject.lines ? *subject.lines : down(volume)};
  std::size_t before = 0;
  std::atomic<std::size_t> most = 0;
  RunOptions run;
  run.threads = options.threads;
  run.memory_limit = std::numeric_limits<std::size_t>::max();
  run.progress = [&](double) {
    const std::size_t now = resident_bytes();
    std::size_t seen = most;
    while (now > seen && !most.compare_exchange_weak(seen, now)) {
    }
  };
  std::vector<Task> tasks{[&]() -> Result<void> {
    malloc_trim(0);  // Memory left by earlier runs would hide the memory of this one.
    before = resident_bytes();
    most = before;
    auto found = compute(request, run);
    if (!found) return found.error();
    most = std::max(most.load(), resident_bytes());
    timing.note = found->note;
    return {};
  }};
  if (subject.run_peer && ItkPeer::built()) {
    tasks.emplace_back([&]() -> Result<void> {
      subject.run_peer(peer);
      return {};
    });
  } else if (subject.run_peer) {
    timing.peer = "not built";
  }
  auto taken = time_in_turn(tasks, options.repeats);
  if (!taken) return taken.error();
  timing.taken = taken->front();
  if (taken->size() > 1) timing.peer_taken = taken->back();
  timing.bytes_per_voxel =
      static_cast<double>(most.load() - before) / static_cast<double>(volume.grid().voxel_count());
  return timing;
}

struct Difference {
  double rms = 0, max = 0, median_value = 0;
};
Difference difference(const FeatureVolume& found, const std::vector<double>& truth) {
  Difference d;
  std::vector<double> sizes;
  for (std::size_t n = 0; n < truth.size(); ++n) {
    if (!std::isfinite(truth[n])) continue;
    const double error = std::abs(truth[n] - static_cast<double>((*found.values)[n]));
    d.rms += error * error;
    d.max = std::max(d.max, error);
    sizes.push_back(std::abs(truth[n]));
  }
  d.rms = std::sqrt(d.rms / static_cast<double>(std::max<std::size_t>(sizes.size(), 1)));
  d.median_value = median(std::move(sizes));
  return d;
}

/// Times a setting and compares its result with the truth.
Result<void> add_point(const std::string& feature, const std::string& setting,
                       const ScalarVolume& volume, const DerivedOptions& options,
                       const std::vector<double>& truth, DerivedBenchReport& report) {
  std::optional<DerivedVolume> found;
  const DerivedRequest request{volume, options, down(volume)};
  const Task task = [&]() -> Result<void> {
    auto one = compute(request, {});
    if (!one) return one.error();
    found = *one;
    return {};
  };
  auto taken = time_in_turn({task}, {3, 5});
  if (!taken) return taken.error();
  const Difference d = difference(found->volume, truth);
  report.errors.push_back({.feature = feature,
                           .setting = setting,
                           .cpu_s = taken->front().cpu_s,
                           .rms = d.rms,
                           .max = d.max,
                           .median_value = d.median_value});
  return {};
}

template <class At>
std::vector<double> everywhere(const VoxelGrid& grid, const At& at) {
  std::vector<double> values;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) values.push_back(at(i, j, k));
    }
  }
  return values;
}

Result<void> vesselness_curve(DerivedBenchReport& report) {
  const ScalarVolume volume = derived_phantom(48);
  VesselnessOptions options;
  const auto truth = definition::vesselness(volume, options);
  for (const double truncate : {2.5, 3.0, 4.0, 5.0, 6.0}) {
    options.truncate = truncate;
    char setting[32];
    std::snprintf(setting, sizeof setting, "truncate=%.1f", truncate);
    if (auto ok = add_point("vesselness", setting, volume, options, truth, report); !ok) return ok;
  }
  return {};
}

Result<void> confidence_curve(int side, DerivedBenchReport& report) {
  const ScalarVolume volume = derived_phantom(side);
  ConfidenceOptions options;
  const auto truth = definition::confidence(volume, down(volume), options);
  if (!truth) return truth.error();
  for (const double error : {1e-2, 1e-3, 1e-4, 1e-5, 1e-7}) {
    options.solve.error = error;
    options.solve.max_iterations = 1000;
    char setting[32];
    std::snprintf(setting, sizeof setting, "error=%.0e", error);
    if (auto ok = add_point("confidence", setting, volume, options, *truth, report); !ok) return ok;
  }
  return {};
}

/// Varies the radius of the filters and compares with the definition.
Result<void> smooth_gradient_curve(const std::string& feature, DerivedBenchReport& report) {
  const ScalarVolume volume = derived_phantom(48);
  GradientPart part = GradientPart::kMagnitude;
  if (feature == "smooth_gradient_along") part = GradientPart::kAlong;
  if (feature == "smooth_gradient_across") part = GradientPart::kAcross;
  std::vector<double> truth;
  for (const Eigen::Vector3d& g : definition::gradients(volume, kUsualSmoothingMm)) {
    truth.push_back(part == GradientPart::kMagnitude ? g.norm()
                    : part == GradientPart::kAlong   ? g.y()
                                                     : std::hypot(g.x(), g.z()));
  }
  for (const double truncate : {2.0, 3.0, 4.0, 5.0, 6.0}) {
    char setting[32];
    std::snprintf(setting, sizeof setting, "truncate=%.1f", truncate);
    if (auto ok = add_point(feature, setting, volume, smooth(part, truncate), truth, report); !ok) {
      return ok;
    }
  }
  return {};
}

/// Varies the size for features with a single method: sums of a window in double precision,
/// differences of neighbours, distances.
Result<void> size_curve(const std::string& feature, DerivedBenchReport& report) {
  for (const int side : {16, 24, 32, 48}) {
    const ScalarVolume volume = derived_phantom(side);
    const ScanLines lines = down(volume);
    DerivedOptions options = ScanDepthOptions{};
    std::function<double(int, int, int)> truth = [&](int i, int j, int k) {
      return lines.depth_mm(volume.grid(), i, j, k);
    };
    if (feature == "snr") {
      options = SnrOptions{};
      truth = [&](int i, int j, int k) {
        return definition::signal_to_noise(volume, SnrOptions{}, i, j, k);
      };
    } else if (feature == "gradient_magnitude") {
      options = GradientPartOptions{};
      truth = [&](int i, int j, int k) { return gradient_at(volume, i, j, k).norm(); };
    } else if (feature == "gradient_angle") {
      options = GradientPartOptions{GradientPart::kAngle};
      truth = [&](int i, int j, int k) {
        return gradient_angle(gradient_at(volume, i, j, k), {0, 1, 0}, 1e-3);
      };
    }
    const auto values = everywhere(volume.grid(), truth);
    const std::string setting = "side=" + std::to_string(side);
    if (auto ok = add_point(feature, setting, volume, options, values, report); !ok) return ok;
  }
  return {};
}

Result<void> curve_of(const std::string& feature, const DerivedBenchOptions& options,
                      DerivedBenchReport& report) {
  if (feature == "vesselness") return vesselness_curve(report);
  if (feature == "confidence") return confidence_curve(options.confidence_side, report);
  if (feature.starts_with("smooth_gradient")) return smooth_gradient_curve(feature, report);
  return size_curve(feature, report);
}

bool wanted(const DerivedBenchOptions& options, const std::string& feature) {
  return options.features.empty() || std::find(options.features.begin(), options.features.end(),
                                               feature) != options.features.end();
}

}  // namespace

ScalarVolume derived_phantom(int side) {
  VoxelGrid grid;
  grid.size = {side, side, side};
  grid.spacing_mm = {kVoxelMm, kVoxelMm, kVoxelMm};
  std::vector<std::int16_t> voxels;
  voxels.reserve(grid.voxel_count());
  std::uint64_t cell = 0;
  double kept = 1;
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i, ++cell) {
        // Exponentially distributed power, correlated along the row.
        kept = 0.6 * kept - 0.4 * std::log(1 - hash01(cell));
        const double mean = tissue((i + 0.5) / side, (j + 0.5) / side, (k + 0.5) / side);
        voxels.push_back(static_cast<std::int16_t>(std::min(255.0, mean * std::sqrt(kept))));
      }
    }
  }
  return ScalarVolume::of(std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::move(voxels), "speckle phantom")));
}

Result<DerivedBenchReport> measure_derived(const DerivedBenchOptions& options,
                                           const std::function<void(double)>& progress) {
  DerivedBenchReport report;
  report.side = options.side;
  const ScalarVolume volume = derived_phantom(options.side);
  ItkPeer peer(itk_voxels(volume), options.threads);
  auto all = subjects(volume, options.threads);
  std::erase_if(all, [&](const Subject& subject) { return !wanted(options, subject.name); });
  std::vector<std::string> curves;
  for (const char* feature :
       {"snr", "gradient_magnitude", "gradient_angle", "smooth_gradient_magnitude",
        "smooth_gradient_along", "smooth_gradient_across", "depth", "vesselness", "confidence"}) {
    if (wanted(options, feature)) curves.emplace_back(feature);
  }
  const double steps = static_cast<double>(all.size() + curves.size());
  double done = 0;
  for (const Subject& subject : all) {
    auto timing = time_subject(subject, volume, options, peer);
    if (!timing) return timing.error();
    report.timings.push_back(std::move(*timing));
    progress(++done / steps);
  }
  for (const std::string& feature : curves) {
    if (auto ok = curve_of(feature, options, report); !ok) return ok.error();
    progress(++done / steps);
  }
  return report;
}

std::string to_text(const DerivedBenchReport& report) {
  std::string text;
  char line[256];
  std::snprintf(line, sizeof line, "\n%d^3 voxels\n%-20s %9s %9s %7s %8s %9s %7s  %s\n",
                report.side, "feature", "cpu s", "wall s", "goal s", "B/voxel", "ITK cpu s",
                "ratio", "beside");
  text += line;
  for (const auto& t : report.timings) {
    std::snprintf(line, sizeof line, "%-20s %9.3f %9.3f %7.1f %8.1f %9.3f %7.2f  %s %s\n",
                  t.feature.c_str(), t.taken.cpu_s, t.taken.wall_s, t.goal_s, t.bytes_per_voxel,
                  t.peer_taken.cpu_s, t.ratio(), t.peer.c_str(), t.note.c_str());
    text += line;
  }
  std::snprintf(line, sizeof line, "\n%-20s %-16s %10s %10s %10s %10s\n", "feature", "setting",
                "cpu s", "rms", "max", "median");
  text += line;
  for (const auto& e : report.errors) {
    std::snprintf(line, sizeof line, "%-20s %-16s %10.4f %10.2e %10.2e %10.3g\n", e.feature.c_str(),
                  e.setting.c_str(), e.cpu_s, e.rms, e.max, e.median_value);
    text += line;
  }
  return text;
}

}  // namespace nav::bench
