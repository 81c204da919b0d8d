// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/reconstruction.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "nav/stopwatch.hpp"
#include "sim/session/simulated_session.hpp"
#include "tracking/reconstruction/reconstruction.hpp"
#include "tracking/reconstruction/sweep_grid.hpp"

namespace nav::bench {
namespace {

using tracking::Compounding;
using tracking::ImageArea;
using tracking::Reconstruction;
using tracking::ReconstructionMethod;
using tracking::ReconstructionOptions;
using ReferenceGrid = VoxelGridIn<frames::Reference>;
using ReferenceFromImage = Transform<frames::Reference, frames::Image>;

struct NamedMethod {
  const char* method;
  ReconstructionMethod value;
};
constexpr std::array<NamedMethod, 4> kMethods{{{"nearest", ReconstructionMethod::kNearest},
                                               {"trilinear", ReconstructionMethod::kTrilinear},
                                               {"gaussian", ReconstructionMethod::kGaussian},
                                               {"backward", ReconstructionMethod::kBackward}}};
struct NamedCompounding {
  const char* compound;
  Compounding value;
};
constexpr std::array<NamedCompounding, 4> kCompoundings{{{"mean", Compounding::kMean},
                                                         {"median", Compounding::kMedian},
                                                         {"max", Compounding::kMaximum},
                                                         {"latest", Compounding::kLatest}}};

using Images = std::vector<TrackedImage>;

std::shared_ptr<const ImageArea> area_of(const TrackedImage& image) {
  return std::make_shared<ImageArea>(image.frame, tracking::PlusClip{});
}

/// A freehand sweep of textured images, oblique to the axes: it moves along its normal and tilts.
Images textured_sweep(int count, int width, int height, double pixel_mm, double length_mm) {
  std::vector<std::uint8_t> pixels;
  std::uint32_t state = 1;
  for (int n = 0; n < width * height; ++n) {
    state = state * 1664525U + 1013904223U;
    pixels.push_back(static_cast<std::uint8_t>(state >> 24));
  }
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, -2, 0.7).normalized()));
  const Image2d<std::uint8_t> shared(width, height, std::move(pixels));
  Images sweep;
  for (int n = 0; n < count; ++n) {
    const double share = static_cast<double>(n) / std::max(count - 1, 1);
    const Eigen::Quaterniond tilted =
        turn * Eigen::AngleAxisd(0.3 * (share - 0.5), Eigen::Vector3d::UnitX());
    UltrasoundImage frame;
    frame.grid = {Eigen::Vector2d::Constant(pixel_mm).asDiagonal(), {0, 0}};
    frame.pixels = shared;
    sweep.push_back({frame,
                     ReferenceFromImage(tilted, turn * Eigen::Vector3d(0, 0, share * length_mm)),
                     Duration(0)});
  }
  return sweep;
}

tracking::SweepExtent extent_of(const Images& images) {
  std::vector<Point<frames::Reference>> corners;
  for (const TrackedImage& image : images) {
    for (const Eigen::Vector2d& corner : area_of(image)->corners()) {
      corners.push_back(image.reference_from_image * image.frame.grid.at(corner.x(), corner.y()));
    }
  }
  return tracking::sweep_extent(corners);
}

/// Cube of side^3 voxels around the images.
ReferenceGrid cube_around(const Images& images, int side) {
  const auto extent = extent_of(images);
  const Eigen::Vector3d box = extent.high_mm - extent.low_mm;
  ReferenceGrid grid;
  grid.size = {side, side, side};
  grid.spacing_mm = Eigen::Vector3d::Constant(box.maxCoeff() / (side - 4));
  grid.origin_mm = (extent.low_mm + extent.high_mm) / 2 - (side - 1) / 2.0 * grid.spacing_mm;
  return grid;
}

double rate_at(std::vector<double> seconds, double share) {
  std::ranges::sort(seconds);
  const auto at = static_cast<std::size_t>(std::ceil(share * static_cast<double>(seconds.size())));
  return 1 / std::max(seconds[std::clamp<std::size_t>(at, 1, seconds.size()) - 1], 1e-9);
}

Result<ReconstructionRate> measure_rate(const Images& images, const ReferenceGrid& grid,
                                        const NamedMethod& method,
                                        const NamedCompounding& compounding, int threads) {
  ReconstructionOptions options;
  options.method = method.value;
  options.compounding = compounding.value;
  options.threads = threads;
  auto volume = Reconstruction::create(grid, options);
  if (!volume) return volume.error();
  const auto area = area_of(images.front());
  ReconstructionRate rate{method.method, compounding.compound, static_cast<int>(images.size())};
  std::vector<double> seconds;
  const double begun = process_time_s();
  for (const TrackedImage& image : images) {
    const auto start = std::chrono::steady_clock::now();
    volume->add(image, area);
    seconds.push_back(seconds_since(start));
  }
  rate.cpu_ms = 1e3 * (process_time_s() - begun) / static_cast<double>(images.size());
  rate.fps_p50 = rate_at(seconds, 0.5);
  rate.fps_p95 = rate_at(seconds, 0.95);
  return rate;
}

Result<BackwardTime> measure_backward(const ReconstructionBenchOptions& options) {
  BackwardTime time;
  time.images = options.quick ? 12 : 140;
  time.width = options.quick ? 185 : 739;
  time.height = options.quick ? 148 : 593;
  time.spacing_mm = 0.5;
  const double pixel_mm = options.quick ? 0.32 : 0.08;
  const Images images = textured_sweep(time.images, time.width, time.height, pixel_mm, 60);
  const auto grid = tracking::sweep_grid(extent_of(images), time.spacing_mm, 0);
  if (!grid) return grid.error();
  ReconstructionOptions how;
  how.method = ReconstructionMethod::kBackward;
  how.reach_mm = time.spacing_mm;
  how.threads = options.threads;
  auto volume = Reconstruction::create(*grid, how);
  if (!volume) return volume.error();
  const auto area = area_of(images.front());
  const auto start = std::chrono::steady_clock::now();
  const double begun = process_time_s();
  for (const TrackedImage& image : images) volume->add(image, area);
  const auto values = volume->values();
  if (!values) return values.error();
  time.taken.cpu_s = process_time_s() - begun;
  time.taken.wall_s = seconds_since(start);
  time.voxels = values->size();
  time.seen = values->size() -
              static_cast<std::size_t>(std::ranges::count(*values, tracking::kUnseenVoxel));
  return time;
}

/// Images of a simulated sweep with their true poses: every second one is reconstructed, the others
/// are the truth.
struct SimulatedImages {
  Images used, left_out;
  double distance_mm = 0;
};

Result<SimulatedImages> simulated_images(bool quick) {
  sim::SimulatedSessionOptions session_options;
  session_options.probe = sim::linear_l14();
  session_options.frame_rate_hz = 60;
  session_options.breathing.amplitude_mm = Eigen::Vector3d::Zero();
  const auto session = sim::SimulatedSession::create(session_options);
  if (!session) return session.error();
  const sim::UltrasoundSimulator simulator(sim::AbdomenPhantom(), session_options.probe, 1);
  SimulatedImages images;
  const int count = std::min(quick ? 12 : 80, session->frame_count());
  std::vector<double> distances;
  for (int n = 0; n < count; ++n) {
    const auto pose = session->truth(n).rest.ct_from_image;
    TrackedImage image{simulator.simulate(pose, Timestamp(), static_cast<std::uint64_t>(n)),
                       ReferenceFromImage(pose.rotation(), pose.translation_mm()), Duration(0)};
    Images& part = n % 2 == 0 ? images.used : images.left_out;
    if (n % 2 == 0 && !part.empty()) {
      distances.push_back((part.back().reference_from_image.translation_mm() -
                           image.reference_from_image.translation_mm())
                              .norm());
    }
    part.push_back(std::move(image));
  }
  images.distance_mm = median(distances);
  return images;
}

/// Values of a volume at some pixels of the images that were left out; NaN where it has none.
std::vector<double> resliced(const std::vector<std::int16_t>& values, const ReferenceGrid& grid,
                             const Images& left_out) {
  constexpr int kStride = 3;
  std::vector<double> found;
  const auto row = static_cast<std::size_t>(grid.size[0]);
  const auto slice = row * static_cast<std::size_t>(grid.size[1]);
  const auto at = [&](const Eigen::Vector3d& index) {
    const Eigen::Vector3d low = index.array().floor();
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d up(corner & 1, corner >> 1 & 1, corner >> 2);
      const Eigen::Vector3d voxel = low + up;
      for (std::size_t a = 0; a < 3; ++a) {
        const double v = voxel[static_cast<Eigen::Index>(a)];
        if (!(v >= 0 && v < grid.size[a])) return std::nan("");
      }
      const std::int16_t value =
          values[static_cast<std::size_t>(voxel.x()) + static_cast<std::size_t>(voxel.y()) * row +
                 static_cast<std::size_t>(voxel.z()) * slice];
      if (value == tracking::kUnseenVoxel) return std::nan("");
      const Eigen::Vector3d near = (1 - (index - voxel).array().abs()).matrix();
      sum += near.prod() * value;
    }
    return sum;
  };
  for (const TrackedImage& image : left_out) {
    for (int y = 0; y < image.frame.pixels.height(); y += kStride) {
      for (int x = 0; x < image.frame.pixels.width(); x += kStride) {
        found.push_back(at(grid.index_of(image.reference_from_image * image.frame.grid.at(x, y))));
      }
    }
  }
  return found;
}

std::vector<double> pixels_of(const Images& images) {
  constexpr int kStride = 3;
  std::vector<double> found;
  for (const TrackedImage& image : images) {
    for (int y = 0; y < image.frame.pixels.height(); y += kStride) {
      for (int x = 0; x < image.frame.pixels.width(); x += kStride) {
        found.push_back(image.frame.pixels.at(x, y));
      }
    }
  }
  return found;
}

double rms_of(const std::vector<double>& values, const std::vector<double>& truth,
              const std::vector<char>& counted) {
  double sum = 0;
  double count = 0;
  for (std::size_t n = 0; n < truth.size(); ++n) {
    if (counted[n] == 0) continue;
    sum += (values[n] - truth[n]) * (values[n] - truth[n]);
    ++count;
  }
  return count > 0 ? std::sqrt(sum / count) : std::nan("");
}

/// All methods and compoundings at one spacing.
Result<std::vector<ReconstructionErrorPoint>> errors_at(const SimulatedImages& images,
                                                        double spacing_mm, int threads) {
  const auto grid = tracking::sweep_grid(extent_of(images.used), spacing_mm, 2);
  if (!grid) return grid.error();
  const std::vector<double> truth = pixels_of(images.left_out);
  std::vector<ReconstructionErrorPoint> points;
  std::vector<std::vector<double>> all;
  std::vector<char> everywhere(truth.size(), 1);
  for (const NamedMethod& method : kMethods) {
    for (const NamedCompounding& compounding : kCompoundings) {
      ReconstructionOptions options;
      options.method = method.value;
      options.compounding = compounding.value;
      // Reaches the middle between two images, where there are coarser ones than voxels.
      options.reach_mm = std::max(spacing_mm, images.distance_mm);
      options.threads = threads;
      const auto start = std::chrono::steady_clock::now();
      auto volume = Reconstruction::create(*grid, options);
      if (!volume) return volume.error();
      const auto area = area_of(images.used.front());
      for (const TrackedImage& image : images.used) volume->add(image, area);
      const auto values = volume->values();
      if (!values) return values.error();
      ReconstructionErrorPoint point{method.method, compounding.compound, spacing_mm};
      point.seconds = seconds_since(start);
      all.push_back(resliced(*values, *grid, images.left_out));
      std::vector<char> covered;
      double sum = 0;
      double count = 0;
      for (std::size_t n = 0; n < truth.size(); ++n) {
        covered.push_back(std::isnan(all.back()[n]) ? 0 : 1);
        everywhere[n] = static_cast<char>(everywhere[n] & covered[n]);
        if (covered[n] == 0) continue;
        sum += all.back()[n] - truth[n];
        ++count;
      }
      point.covered = count / static_cast<double>(truth.size());
      point.mean = sum / count;
      point.rms = rms_of(all.back(), truth, covered);
      points.push_back(point);
    }
  }
  for (std::size_t n = 0; n < points.size(); ++n) {
    points[n].rms_everywhere = rms_of(all[n], truth, everywhere);
  }
  return points;
}

Result<void> measure_rates(const ReconstructionBenchOptions& options,
                           const std::function<void(double)>& progress,
                           ReconstructionBenchReport& report) {
  report.width = options.quick ? 160 : 640;
  report.height = options.quick ? 120 : 480;
  report.side = options.quick ? 64 : 256;
  const Images images = textured_sweep(options.quick ? 10 : 200, report.width, report.height,
                                       64.0 / report.width, 48);
  const ReferenceGrid grid = cube_around(images, report.side);
  for (const NamedMethod& method : kMethods) {
    if (method.value == ReconstructionMethod::kBackward) continue;
    for (const NamedCompounding& compounding : kCompoundings) {
      auto rate = measure_rate(images, grid, method, compounding, options.threads);
      if (!rate) return rate.error();
      report.rates.push_back(*rate);
      progress(0.4 * static_cast<double>(report.rates.size()) / 12);
    }
  }
  return {};
}

Result<void> measure_errors(const ReconstructionBenchOptions& options,
                            const std::function<void(double)>& progress,
                            ReconstructionBenchReport& report) {
  const auto simulated = simulated_images(options.quick);
  if (!simulated) return simulated.error();
  report.image_distance_mm = simulated->distance_mm;
  const auto truth = pixels_of(simulated->left_out);
  const Images before(
      simulated->used.begin(),
      simulated->used.begin() + static_cast<std::ptrdiff_t>(simulated->left_out.size()));
  report.neighbour_rms = rms_of(pixels_of(before), truth, std::vector<char>(truth.size(), 1));
  const std::vector<double> spacings = options.quick
                                           ? std::vector<double>{0.4, 0.8}
                                           : std::vector<double>{0.2, 0.3, 0.4, 0.6, 0.9, 1.4, 2};
  for (const double spacing_mm : spacings) {
    auto points = errors_at(*simulated, spacing_mm, options.threads);
    if (!points) return points.error();
    report.errors.insert(report.errors.end(), points->begin(), points->end());
    progress(0.5 + 0.5 * static_cast<double>(report.errors.size()) /
                       (16 * static_cast<double>(spacings.size())));
  }
  return {};
}

}  // namespace

Result<ReconstructionBenchReport> measure_reconstruction(
    const ReconstructionBenchOptions& options, const std::function<void(double)>& progress) {
  ReconstructionBenchReport report;
  if (options.rates) {
    if (auto ok = measure_rates(options, progress, report); !ok) return ok.error();
  }
  if (options.backward) {
    auto backward = measure_backward(options);
    if (!backward) return backward.error();
    report.backward = *backward;
    progress(0.5);
  }
  if (options.errors) {
    if (auto ok = measure_errors(options, progress, report); !ok) return ok.error();
  }
  return report;
}

std::string to_text(const ReconstructionBenchReport& report) {
  std::string text;
  char line[200];
  if (!report.rates.empty()) {
    std::snprintf(line, sizeof line, "\n%d x %d pixels into %d^3 voxels\n%-10s %-8s %9s %9s %9s\n",
                  report.width, report.height, report.side, "method", "compound", "fps p50",
                  "fps p95", "cpu ms");
    text += line;
  }
  for (const auto& r : report.rates) {
    std::snprintf(line, sizeof line, "%-10s %-8s %9.0f %9.0f %9.2f\n", r.method.c_str(),
                  r.compound.c_str(), r.fps_p50, r.fps_p95, r.cpu_ms);
    text += line;
  }
  if (const auto& b = report.backward) {
    std::snprintf(line, sizeof line,
                  "\nbackward: %d images of %d x %d into %zu voxels of %.1f mm (%zu seen): %.2f s, "
                  "%.2f s of processors\n",
                  b->images, b->width, b->height, b->voxels, b->spacing_mm, b->seen,
                  b->taken.wall_s, b->taken.cpu_s);
    text += line;
  }
  if (!report.errors.empty()) {
    std::snprintf(line, sizeof line,
                  "\nsimulated images that were left out, between images %.2f mm apart; beside the "
                  "image before: %.1f grey levels rms\n%-10s %-8s %7s %8s %7s %7s %8s %7s\n",
                  report.image_distance_mm, report.neighbour_rms, "method", "compound", "mm",
                  "covered", "rms", "mean", "rms all", "s");
    text += line;
  }
  for (const auto& e : report.errors) {
    std::snprintf(line, sizeof line, "%-10s %-8s %7.2f %7.1f%% %7.2f %7.2f %8.2f %7.2f\n",
                  e.method.c_str(), e.compound.c_str(), e.spacing_mm, 100 * e.covered, e.rms,
                  e.mean, e.rms_everywhere, e.seconds);
    text += line;
  }
  return text;
}

}  // namespace nav::bench
