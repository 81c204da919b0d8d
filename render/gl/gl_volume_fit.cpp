// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_volume_fit.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "nav/index.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

int parts(int n, int factor) { return (n + factor - 1) / factor; }

/// Mean of the existing voxels of a box.
std::int16_t box_mean(const StoredVolume& full, const std::array<int, 3>& first,
                      const std::array<int, 3>& factors) {
  const auto& size = full.grid().size;
  double sum = 0;
  int count = 0;
  for (int k = first[2]; k < std::min(first[2] + factors[2], size[2]); ++k) {
    for (int j = first[1]; j < std::min(first[1] + factors[1], size[1]); ++j) {
      const std::size_t row = (as_size(k) * as_size(size[1]) + as_size(j)) * as_size(size[0]);
      for (int i = first[0]; i < std::min(first[0] + factors[0], size[0]); ++i, ++count) {
        sum += full.values()[row + as_size(i)];
      }
    }
  }
  return static_cast<std::int16_t>(std::lround(sum / count));
}

/// The two voxels of an axis around a position, and the weight of the second.
struct Between {
  std::size_t low, high;
  double w;
};
Between between(double index, int count) {
  const double x = std::clamp(index, 0.0, count - 1.0);
  const int low = std::min(static_cast<int>(x), std::max(count - 2, 0));
  return {as_size(low), as_size(std::min(low + 1, count - 1)), x - low};
}

struct ErrorSum {
  double max = 0;
  double squares = 0;
};

/// Error over one slice of the full volume.
ErrorSum slice_error(const StoredVolume& full, const StoredVolume& small,
                     const std::array<int, 3>& f, int k) {
  const auto& n = full.grid().size;
  const auto& m = small.grid().size;
  const auto place = [&](int i, std::size_t axis) {
    return between((i + 0.5) / f[axis] - 0.5, m[axis]);
  };
  const auto mx = as_size(m[0]);
  const auto my = as_size(m[1]);
  const Between z = place(k, 2);
  ErrorSum sum;
  for (int j = 0; j < n[1]; ++j) {
    const Between y = place(j, 1);
    const std::size_t row = (as_size(k) * as_size(n[1]) + as_size(j)) * as_size(n[0]);
    for (int i = 0; i < n[0]; ++i) {
      const Between x = place(i, 0);
      const auto line = [&](std::size_t b, std::size_t c) {
        const std::size_t start = (c * my + b) * mx;
        return (1 - x.w) * small.values()[start + x.low] + x.w * small.values()[start + x.high];
      };
      const auto sheet = [&](std::size_t c) {
        return (1 - y.w) * line(y.low, c) + y.w * line(y.high, c);
      };
      const double found = (1 - z.w) * sheet(z.low) + z.w * sheet(z.high);
      const double error = std::abs(found - full.values()[row + as_size(i)]);
      sum.max = std::max(sum.max, error);
      sum.squares += error * error;
    }
  }
  return sum;
}

VoxelGrid reduced_grid(const VoxelGrid& full, const std::array<int, 3>& factors) {
  VoxelGrid grid = full;
  Eigen::Vector3d first;  // Centre of the first box, in voxels of the full volume.
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    grid.size[axis] = parts(full.size[axis], factors[axis]);
    grid.spacing_mm[a] = full.spacing_mm[a] * factors[axis];
    first[a] = 0.5 * (factors[axis] - 1);
  }
  grid.origin_mm = full.at(first).mm;
  return grid;
}

}  // namespace

ReducedVolume reduced(const StoredVolume& full, const std::array<int, 3>& factors) {
  const VoxelGrid grid = reduced_grid(full.grid(), factors);
  std::vector<std::int16_t> hu(grid.voxel_count());
  for_each_index(grid.size[2], 0, [&](int k) {
    std::size_t at = as_size(k) * as_size(grid.size[1]) * as_size(grid.size[0]);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i, ++at) {
        hu[at] = box_mean(full, {i * factors[0], j * factors[1], k * factors[2]}, factors);
      }
    }
  });
  auto volume = StoredVolume::create(grid, std::move(hu), full.name());
  NAV_CHECK(volume.has_value(), full.name());
  ReducedVolume out{std::make_shared<const StoredVolume>(std::move(volume).value()), factors, 0, 0};
  std::vector<ErrorSum> errors(as_size(full.grid().size[2]));
  for_each_index(full.grid().size[2], 0,
                 [&](int k) { errors[as_size(k)] = slice_error(full, *out.volume, factors, k); });
  double squares = 0;
  for (const ErrorSum& error : errors) {
    out.max_error_hu = std::max(out.max_error_hu, error.max);
    squares += error.squares;
  }
  out.rms_error_hu = std::sqrt(squares / static_cast<double>(full.grid().voxel_count()));
  return out;
}

std::array<int, 3> factors_to_fit(const std::array<int, 3>& size, int largest_edge,
                                  std::size_t most_voxels) {
  std::array<int, 3> factors{};
  for (std::size_t axis = 0; axis < 3; ++axis) factors[axis] = parts(size[axis], largest_edge);
  const auto edge = [&](std::size_t axis) { return parts(size[axis], factors[axis]); };
  while (as_size(edge(0)) * as_size(edge(1)) * as_size(edge(2)) > most_voxels) {
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis) {
      if (edge(axis) > edge(longest)) longest = axis;
    }
    if (edge(longest) == 1) break;
    factors[longest] *= 2;
  }
  return factors;
}

std::string note_of(const ReducedVolume& reduced, const StoredVolume& full) {
  std::ostringstream text;
  const auto size = [&](const std::array<int, 3>& n) {
    text << n[0] << " x " << n[1] << " x " << n[2];
  };
  text << full.name() << ": ";
  size(full.grid().size);
  text << " voxels do not fit into this OpenGL device, drawn from means of ";
  size(reduced.factors);
  text << " voxels; values differ by at most " << reduced.max_error_hu << " HU, rms "
       << reduced.rms_error_hu << " HU";
  return text.str();
}

}  // namespace nav::render
