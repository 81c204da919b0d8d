// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/gradient_features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "nav/index.hpp"
#include "render/parallel.hpp"
#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

/// A field of floats on a grid, with its borders repeated.
struct Field {
  const VoxelGrid& grid;
  std::vector<float> values;

  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return (as_size(k) * as_size(grid.size[1]) + as_size(j)) * as_size(grid.size[0]) + as_size(i);
  }
  [[nodiscard]] float at(std::array<int, 3> p) const { return values[offset(p[0], p[1], p[2])]; }
};

/// Half of a Gaussian kernel, of sum 1 with its mirror image; three sigmas wide.
std::vector<float> gaussian(double sigma_voxels) {
  const int reach = static_cast<int>(std::ceil(3 * sigma_voxels));
  std::vector<float> half(as_size(reach) + 1);
  double sum = 0;
  for (int i = 0; i <= reach; ++i) {
    const double w = std::exp(-0.5 * i * i / (sigma_voxels * sigma_voxels));
    half[as_size(i)] = static_cast<float>(w);
    sum += i == 0 ? w : 2 * w;
  }
  for (float& w : half) w = static_cast<float>(w / sum);
  return half;
}

/// One value of a line, of whose kernel only what is known counts. Unknown (NaN) stays unknown.
float smoothed_where_known(const std::vector<float>& line, int i, const std::vector<float>& half) {
  const int n = static_cast<int>(line.size());
  float sum = half[0] * line[as_size(i)];
  float weight = half[0];
  if (std::isnan(sum)) return sum;
  for (int d = 1; d < static_cast<int>(half.size()); ++d) {
    for (const int at : {std::max(i - d, 0), std::min(i + d, n - 1)}) {
      const float value = line[as_size(at)];
      if (std::isnan(value)) continue;
      sum += half[as_size(d)] * value;
      weight += half[as_size(d)];
    }
  }
  return sum / weight;
}

void smooth_along(int axis, double sigma_mm, int threads, bool all_known, Field& field) {
  const auto& size = field.grid.size;
  const int n = size[as_size(axis)];
  const double sigma = sigma_mm / field.grid.spacing_mm[axis];
  if (n == 1 || sigma < 0.05) return;
  const std::vector<float> half = gaussian(sigma);
  const int u = axis == 0 ? 1 : 0;
  const int v = axis == 2 ? 1 : 2;
  for_each_index(size[as_size(v)], threads, [&](int b) {
    std::vector<float> line(as_size(n));
    for (int a = 0; a < size[as_size(u)]; ++a) {
      std::array<int, 3> p{};
      p[as_size(u)] = a;
      p[as_size(v)] = b;
      const std::size_t start = field.offset(p[0], p[1], p[2]);
      p[as_size(axis)] = 1;
      const std::size_t stride = field.offset(p[0], p[1], p[2]) - start;
      for (int i = 0; i < n; ++i) line[as_size(i)] = field.values[start + as_size(i) * stride];
      for (int i = 0; i < n && !all_known; ++i) {
        field.values[start + as_size(i) * stride] = smoothed_where_known(line, i, half);
      }
      for (int i = 0; i < n && all_known; ++i) {
        float sum = half[0] * line[as_size(i)];
        for (int d = 1; d < static_cast<int>(half.size()); ++d) {
          sum += half[as_size(d)] *
                 (line[as_size(std::max(i - d, 0))] + line[as_size(std::min(i + d, n - 1))]);
        }
        field.values[start + as_size(i) * stride] = sum;
      }
    }
  });
}

Field intensities(const Volume& volume, const PredicateScene::IntensityWindow& window,
                  std::optional<std::int16_t> unknown) {
  Field field{volume.grid(), std::vector<float>(volume.hu().size())};
  const double scale = 1 / (window.white - window.black);
  std::transform(volume.hu().begin(), volume.hu().end(), field.values.begin(), [&](std::int16_t v) {
    return v == unknown ? std::numeric_limits<float>::quiet_NaN()
                        : static_cast<float>((v - window.black) * scale);
  });
  return field;
}

/// Along the axes of the grid, per mm.
Eigen::Vector3d gradient_at(const Field& field, const std::array<int, 3>& p) {
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  if (std::isnan(field.at(p))) g.setConstant(std::nan(""));
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = as_size(axis);
    std::array<int, 3> low = p;
    std::array<int, 3> high = p;
    low[a] = std::max(p[a] - 1, 0);
    high[a] = std::min(p[a] + 1, field.grid.size[a] - 1);
    if (high[a] == low[a]) continue;
    g[axis] += (static_cast<double>(field.at(high)) - static_cast<double>(field.at(low))) /
               ((high[a] - low[a]) * field.grid.spacing_mm[axis]);
  }
  return g;
}

/// Of a gradient along and across a scan line, and its size.
struct Parts {
  std::vector<float> magnitude;
  std::vector<float> along;
  std::vector<float> across;

  void set(std::size_t at, const Eigen::Vector3d& gradient, const Eigen::Vector3d& line) {
    magnitude[at] = static_cast<float>(gradient.norm());
    if (along.empty()) return;
    if (line.isZero(0)) {
      along[at] = across[at] = std::numeric_limits<float>::quiet_NaN();
      return;
    }
    const double part = gradient.dot(line);
    along[at] = static_cast<float>(part);
    across[at] = static_cast<float>((gradient - part * line).norm());
  }
};

}  // namespace

Result<GradientFeatures> make_gradient_features(const Volume& volume,
                                                const PredicateScene::IntensityWindow& intensity,
                                                const std::optional<ScanGeometry>& scan,
                                                double smoothing_mm, int threads,
                                                std::optional<std::int16_t> unknown) {
  const VoxelGrid& grid = volume.grid();
  if (!(smoothing_mm >= 0 && smoothing_mm <= 100)) {
    std::ostringstream text;
    text << "smoothing_mm: expected a number in [0, 100], found " << smoothing_mm;
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  if (scan) {
    if (const auto ok = validate(*scan, grid); !ok) return ok.error();
  }
  Field field = intensities(volume, intensity, unknown);
  if (smoothing_mm > 0) {
    for (int axis = 0; axis < 3; ++axis) smooth_along(axis, smoothing_mm, threads, !unknown, field);
  }
  const std::size_t count = grid.voxel_count();
  Parts parts{std::vector<float>(count), std::vector<float>(scan ? count : 0),
              std::vector<float>(scan ? count : 0)};
  for_each_index(grid.size[2], threads, [&](int k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d line = scan ? Eigen::Vector3d(grid.directions.transpose() *
                                                            scan_direction(*scan, grid, i, j, k))
                                          : Eigen::Vector3d::Zero();
        parts.set(field.offset(i, j, k), gradient_at(field, {i, j, k}), line);
      }
    }
  });
  auto magnitude = FeatureVolume::create(grid, parts.magnitude, feature::kGradientMagnitude);
  if (!magnitude) return magnitude.error();
  GradientFeatures out{*std::move(magnitude), {}, {}};
  if (scan) {
    out.along = *FeatureVolume::create(grid, parts.along, feature::kGradientAlong);
    out.across = *FeatureVolume::create(grid, parts.across, feature::kGradientAcross);
  }
  return out;
}

Result<void> add_gradient_features(const Volume& volume, double smoothing_mm,
                                   PredicateScene& predicates, int threads,
                                   std::optional<std::int16_t> unknown) {
  const std::set<std::string> kinds = kinds_of(predicates.model);
  auto& volumes = predicates.features.volumes;
  const bool magnitude =
      kinds.count("gradient_magnitude") != 0 && !volumes.count(feature::kGradientMagnitude);
  const bool angle = kinds.count("gradient_angle") != 0 && !volumes.count(feature::kGradientAlong);
  if (!magnitude && !angle) return {};
  auto made =
      make_gradient_features(volume, predicates.intensity, angle ? predicates.scan : std::nullopt,
                             smoothing_mm, threads, unknown);
  if (!made) return made.error();
  if (magnitude) volumes.emplace(feature::kGradientMagnitude, made->magnitude);
  if (made->along) volumes.emplace(feature::kGradientAlong, *made->along);
  if (made->across) volumes.emplace(feature::kGradientAcross, *made->across);
  return {};
}

}  // namespace nav::render
