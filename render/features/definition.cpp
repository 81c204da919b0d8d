// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/definition.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav/index.hpp"
#include "nav/matrices.hpp"
#include "render/features/filled_field.hpp"
#include "render/features/gaussian_taps.hpp"

namespace nav::render::features::definition {
namespace {

/// Voxels in double, i fastest.
struct Field {
  std::array<int, 3> size;
  std::vector<double> values;
};

enum class Order { kSmooth, kSlope, kBend };

Field filtered(const Field& in, int axis, const GaussianTaps& taps, Order order) {
  Field out = in;
  const auto a = as_size(axis);
  const std::size_t step = axis == 0   ? 1
                           : axis == 1 ? as_size(in.size[0])
                                       : as_size(in.size[0]) * as_size(in.size[1]);
  for (std::size_t n = 0; n < in.values.size(); ++n) {
    const int at = static_cast<int>(n / step % as_size(in.size[a]));
    const double* line = in.values.data() + (n - as_size(at) * step);
    const auto value = [&](int p) {
      return line[as_size(std::clamp(p, 0, in.size[a] - 1)) * step];
    };
    double sum = order == Order::kSmooth ? taps.smooth[0] * value(at)
                 : order == Order::kBend ? taps.bend[0] * value(at)
                                         : 0;
    for (int k = 1; k <= taps.radius; ++k) {
      const double before = value(at - k);
      const double after = value(at + k);
      sum += order == Order::kSmooth  ? taps.smooth[as_size(k)] * (after + before)
             : order == Order::kSlope ? taps.slope[as_size(k)] * (after - before)
                                      : taps.bend[as_size(k)] * (after + before);
    }
    out.values[n] = sum;
  }
  return out;
}

Field field_of(const ScalarVolume& volume, int layers) {
  const FilledField filled = filled_field(volume, layers, 1);
  Field field{filled.size, {}};
  for (int k = 0; k < filled.size[2]; ++k) {
    for (int j = 0; j < filled.size[1]; ++j) {
      const float* row = filled.row(j, k);
      for (int i = 0; i < filled.size[0]; ++i) {
        field.values.push_back(static_cast<double>(row[i]));
      }
    }
  }
  return field;
}

}  // namespace

double signal_to_noise(const ScalarVolume& volume, const SnrOptions& options, int i, int j, int k) {
  const auto& size = volume.grid().size;
  const auto weights = window_weights(options);
  const int r = options.window_voxels / 2;
  const auto over_window = [&](const auto& visit) {
    for (int z = std::max(k - r, 0); z <= std::min(k + r, size[2] - 1); ++z) {
      for (int y = std::max(j - r, 0); y <= std::min(j + r, size[1] - 1); ++y) {
        for (int x = std::max(i - r, 0); x <= std::min(i + r, size[0] - 1); ++x) {
          const auto value = static_cast<double>(volume.at(x, y, z));
          if (std::isnan(value)) continue;
          visit(value, weights[as_size(x - i + r)] * weights[as_size(y - j + r)] *
                           weights[as_size(z - k + r)]);
        }
      }
    }
  };
  double total = 0, sum = 0, spread = 0;
  over_window([&](double value, double weight) {
    total += weight;
    sum += weight * value;
  });
  const double mean = sum / total;
  over_window(
      [&](double value, double weight) { spread += weight * (value - mean) * (value - mean); });
  const double floor = volume.quantum() / std::sqrt(12.0);
  if (std::isnan(volume.at(i, j, k))) return std::nan("");
  return (mean - options.black) / std::max(std::sqrt(spread / total), floor);
}

std::vector<Eigen::Vector3d> gradients(const ScalarVolume& volume, double smoothing_mm) {
  const VoxelGrid& grid = volume.grid();
  std::vector<double> slopes[3];
  if (smoothing_mm > 0) {
    constexpr double kTruncate = 8;
    const Eigen::Vector3d sigma = grid.spacing_mm.cwiseInverse() * smoothing_mm;
    const GaussianTaps taps[3] = {gaussian_taps(sigma.x(), kTruncate),
                                  gaussian_taps(sigma.y(), kTruncate),
                                  gaussian_taps(sigma.z(), kTruncate)};
    const Field field =
        field_of(volume, std::max({taps[0].radius, taps[1].radius, taps[2].radius}));
    for (int axis = 0; axis < 3; ++axis) {
      Field one = field;
      for (int a = 0; a < 3; ++a) {
        one = filtered(one, a, taps[a], a == axis ? Order::kSlope : Order::kSmooth);
      }
      slopes[axis] = std::move(one.values);
    }
  }
  std::vector<Eigen::Vector3d> out;
  out.reserve(grid.voxel_count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!(smoothing_mm > 0)) {
          out.push_back(gradient_at(volume, i, j, k));
          continue;
        }
        const std::size_t n = out.size();
        const Eigen::Vector3d slope(slopes[0][n], slopes[1][n], slopes[2][n]);
        out.emplace_back(grid.directions * slope.cwiseQuotient(grid.spacing_mm));
        if (std::isnan(volume.at(i, j, k))) out.back().setConstant(std::nan(""));
      }
    }
  }
  return out;
}

std::vector<std::array<double, 3>> eigenvalues(const ScalarVolume& volume, double sigma_mm,
                                               double truncate) {
  const Eigen::Vector3d sigma = volume.grid().spacing_mm.cwiseInverse() * sigma_mm;
  const GaussianTaps taps[3] = {gaussian_taps(sigma.x(), truncate),
                                gaussian_taps(sigma.y(), truncate),
                                gaussian_taps(sigma.z(), truncate)};
  const Field field = field_of(volume, std::max({taps[0].radius, taps[1].radius, taps[2].radius}));
  const auto derivative = [&](Order x, Order y, Order z) {
    return filtered(filtered(filtered(field, 0, taps[0], x), 1, taps[1], y), 2, taps[2], z).values;
  };
  using enum Order;
  const auto xx = derivative(kBend, kSmooth, kSmooth), yy = derivative(kSmooth, kBend, kSmooth);
  const auto zz = derivative(kSmooth, kSmooth, kBend), xy = derivative(kSlope, kSlope, kSmooth);
  const auto xz = derivative(kSlope, kSmooth, kSlope), yz = derivative(kSmooth, kSlope, kSlope);
  std::vector<std::array<double, 3>> out(xx.size());
  for (std::size_t n = 0; n < out.size(); ++n) {
    Eigen::Matrix3d h;
    h << xx[n], xy[n], xz[n], xy[n], yy[n], yz[n], xz[n], yz[n], zz[n];
    const Eigen::Matrix3d scaled = sigma.asDiagonal() * h * sigma.asDiagonal();
    const Eigen::Vector3d values = eigenpairs<3>(scaled).values;
    out[n] = {values[0], values[1], values[2]};
  }
  return out;
}

double tube_response(std::array<double, 3> l, const VesselnessOptions& options, double contrast) {
  for (double& value : l) value = options.polarity == Polarity::kBright ? -value : value;
  std::sort(l.begin(), l.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  if (!(l[1] > 0 && l[2] > 0)) return 0;
  const double c = contrast / (std::numbers::sqrt2 * std::numbers::e);
  const double plate = l[1] / l[2];
  const double blob = std::abs(l[0]) / std::sqrt(l[1] * l[2]);
  const double size = std::hypot(l[0], l[1], l[2]);
  return -std::expm1(-plate * plate / (2 * options.alpha * options.alpha)) *
         std::exp(-blob * blob / (2 * options.beta * options.beta)) *
         -std::expm1(-size * size / (2 * c * c));
}

std::vector<double> vesselness(const ScalarVolume& volume, const VesselnessOptions& options) {
  const double contrast = contrast_of(options, volume, 1);
  std::vector<double> best(volume.grid().voxel_count(), 0.0);
  for (const double sigma : sigmas_mm(options)) {
    constexpr double kTruncate = 8;
    const auto values = eigenvalues(volume, sigma, kTruncate);
    for (std::size_t n = 0; n < best.size(); ++n) {
      best[n] = std::max(best[n], tube_response(values[n], options, contrast));
    }
  }
  const auto& size = volume.grid().size;
  for (std::size_t n = 0; n < best.size(); ++n) {
    const auto i = static_cast<int>(n % as_size(size[0]));
    const auto j = static_cast<int>(n / as_size(size[0]) % as_size(size[1]));
    const auto k = static_cast<int>(n / as_size(size[0]) / as_size(size[1]));
    if (std::isnan(volume.at(i, j, k))) best[n] = std::nan("");
  }
  return best;
}

}  // namespace nav::render::features::definition
