// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/filled_field.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "nav/index.hpp"
#include "render/features/kernels.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

constexpr int kBrick = 8;

/// The first known value of the volume.
double reference_of(const ScalarVolume& volume) {
  std::vector<float> row(as_size(volume.grid().size[0]));
  for (int k = 0; k < volume.grid().size[2]; ++k) {
    for (int j = 0; j < volume.grid().size[1]; ++j) {
      volume.read_row(j, k, row.data());
      for (const float v : row) {
        if (v == v) return static_cast<double>(v);
      }
    }
  }
  return 0;
}

/// Extends the known voxels into the unknown ones, breadth first.
class Extension {
 public:
  explicit Extension(FilledField& field) : field_(field) {
    state_.resize(as_size(field.size[0]) * as_size(field.size[1]) * as_size(field.size[2]));
  }
  void run(int layers) {
    collect_known();
    std::vector<std::array<int, 3>> frontier = first_layer();
    for (int layer = 0; layer < layers && !frontier.empty(); ++layer) {
      fill(frontier);
      frontier = next_layer(frontier);
    }
    for (float& v : field_.values) v = v == v ? v : 0.0F;
  }

 private:
  enum : std::uint8_t { kNothing, kQueued, kHasValue };

  std::uint8_t& state(int i, int j, int k) {
    return state_[(as_size(k) * as_size(field_.size[1]) + as_size(j)) * as_size(field_.size[0]) +
                  as_size(i)];
  }
  template <class Visit>
  void neighbours(const std::array<int, 3>& at, const Visit& visit) {
    for (int k = std::max(at[2] - 1, 0); k <= std::min(at[2] + 1, field_.size[2] - 1); ++k) {
      for (int j = std::max(at[1] - 1, 0); j <= std::min(at[1] + 1, field_.size[1] - 1); ++j) {
        for (int i = std::max(at[0] - 1, 0); i <= std::min(at[0] + 1, field_.size[0] - 1); ++i) {
          visit(i, j, k);
        }
      }
    }
  }
  template <class Visit>
  void all_voxels(const Visit& visit) {
    for (int k = 0; k < field_.size[2]; ++k) {
      for (int j = 0; j < field_.size[1]; ++j) {
        for (int i = 0; i < field_.size[0]; ++i) visit(i, j, k);
      }
    }
  }
  void collect_known() {
    all_voxels([&](int i, int j, int k) {
      const float v = field_.row(j, k)[i];
      state(i, j, k) = v == v ? kHasValue : kNothing;
    });
  }
  std::vector<std::array<int, 3>> first_layer() {
    std::vector<std::array<int, 3>> found;
    all_voxels([&](int i, int j, int k) {
      if (state(i, j, k) != kNothing) return;
      bool near = false;
      neighbours({i, j, k},
                 [&](int x, int y, int z) { near = near || state(x, y, z) == kHasValue; });
      if (!near) return;
      state(i, j, k) = kQueued;
      found.push_back({i, j, k});
    });
    return found;
  }
  void fill(const std::vector<std::array<int, 3>>& frontier) {
    for (const auto& at : frontier) {
      double sum = 0;
      int count = 0;
      neighbours(at, [&](int x, int y, int z) {
        if (state(x, y, z) != kHasValue) return;
        sum += static_cast<double>(field_.row(y, z)[x]);
        ++count;
      });
      field_.row(at[1], at[2])[at[0]] = static_cast<float>(sum / count);
    }
    for (const auto& at : frontier) state(at[0], at[1], at[2]) = kHasValue;
  }
  std::vector<std::array<int, 3>> next_layer(const std::vector<std::array<int, 3>>& frontier) {
    std::vector<std::array<int, 3>> found;
    for (const auto& at : frontier) {
      neighbours(at, [&](int x, int y, int z) {
        if (state(x, y, z) != kNothing) return;
        state(x, y, z) = kQueued;
        found.push_back({x, y, z});
      });
    }
    return found;
  }

  FilledField& field_;
  std::vector<std::uint8_t> state_;
};

struct BrickExtremes {
  std::vector<float> low, high;
};

/// Computes the least and the greatest value of each brick.
BrickExtremes brick_extremes(const FilledField& field, const std::array<int, 3>& count,
                             int threads) {
  const std::size_t total = as_size(count[0]) * as_size(count[1]) * as_size(count[2]);
  BrickExtremes out{std::vector<float>(total, INFINITY), std::vector<float>(total, -INFINITY)};
  for_each_index(count[2], threads, [&](int bz) {
    for (int k = bz * kBrick; k < std::min((bz + 1) * kBrick, field.size[2]); ++k) {
      for (int j = 0; j < field.size[1]; ++j) {
        const float* row = field.row(j, k);
        const std::size_t first =
            (as_size(bz) * as_size(count[1]) + as_size(j / kBrick)) * as_size(count[0]);
        for (int i = 0; i < field.size[0]; ++i) {
          float& low = out.low[first + as_size(i / kBrick)];
          float& high = out.high[first + as_size(i / kBrick)];
          low = row[i] < low ? row[i] : low;
          high = row[i] > high ? row[i] : high;
        }
      }
    }
  });
  return out;
}

/// Extends BrickExtremes over `reach` bricks on either side along one axis.
void widen(BrickExtremes& e, const std::array<int, 3>& count, int axis, int reach) {
  const auto a = as_size(axis);
  const std::size_t step = axis == 0   ? 1
                           : axis == 1 ? as_size(count[0])
                                       : as_size(count[0]) * as_size(count[1]);
  const BrickExtremes in = e;
  for (std::size_t b = 0; b < in.low.size(); ++b) {
    const int at = static_cast<int>(b / step % as_size(count[a]));
    for (int s = -reach; s <= reach; ++s) {
      if (at + s < 0 || at + s >= count[a]) continue;
      const std::size_t other = b + static_cast<std::size_t>(s) * step;
      e.low[b] = std::min(e.low[b], in.low[other]);
      e.high[b] = std::max(e.high[b], in.high[other]);
    }
  }
}

}  // namespace

FilledField filled_field(const ScalarVolume& volume, int layers, int threads) {
  FilledField field;
  field.size = volume.grid().size;
  field.stride = padded(field.size[0]);
  field.reference = reference_of(volume);
  field.values.resize(as_size(field.stride) * as_size(field.size[1]) * as_size(field.size[2]));
  std::vector<std::uint8_t> complete(as_size(field.size[2]), 1);
  for_each_index(field.size[2], threads, [&](int k) {
    for (int j = 0; j < field.size[1]; ++j) {
      float* row = field.row(j, k);
      volume.read_row(j, k, row);
      bool known = true;
      for (int i = 0; i < field.size[0]; ++i) {
        known = known && row[i] == row[i];
        row[i] = static_cast<float>(static_cast<double>(row[i]) - field.reference);
      }
      if (!known) complete[as_size(k)] = 0;
    }
  });
  field.all_known = std::all_of(complete.begin(), complete.end(), [](auto c) { return c != 0; });
  if (!field.all_known) Extension(field).run(layers);
  return field;
}

ActiveBricks::ActiveBricks(const FilledField& field, const std::array<int, 3>& support,
                           double least_range, int threads)
    : size_(field.size) {
  for (std::size_t a = 0; a < 3; ++a) count_[a] = (size_[a] - 1) / kBrick + 1;
  BrickExtremes e = brick_extremes(field, count_, threads);
  for (int axis = 0; axis < 3; ++axis) {
    widen(e, count_, axis, (support[as_size(axis)] + kBrick - 1) / kBrick);
  }
  active_.resize(e.low.size());
  for (std::size_t b = 0; b < active_.size(); ++b) {
    active_[b] = static_cast<double>(e.high[b]) - static_cast<double>(e.low[b]) > least_range;
  }
  rows_.resize(as_size(count_[1]) * as_size(count_[2]));
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto first = active_.begin() + static_cast<std::ptrdiff_t>(r * as_size(count_[0]));
    rows_[r] = std::find(first, first + count_[0], 1) != first + count_[0];
  }
}

bool ActiveBricks::row(int j, int k) const {
  return rows_[as_size(k / kBrick) * as_size(count_[1]) + as_size(j / kBrick)] != 0;
}

double ActiveBricks::share() const {
  return static_cast<double>(std::accumulate(active_.begin(), active_.end(), std::size_t{0})) /
         static_cast<double>(active_.size());
}

}  // namespace nav::render::features
