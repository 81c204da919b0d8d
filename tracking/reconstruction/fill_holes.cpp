// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/fill_holes.hpp"

#include <atomic>
#include <cmath>
#include <limits>

#include "nav/index.hpp"
#include "tracking/reconstruction/reconstruction_engine.hpp"

namespace nav::tracking {
namespace {

using Offset = std::array<int, 3>;

constexpr std::array<Offset, 13> kLines{{{1, 0, 0},
                                         {0, 1, 0},
                                         {0, 0, 1},
                                         {1, 1, 0},
                                         {1, -1, 0},
                                         {1, 0, 1},
                                         {1, 0, -1},
                                         {0, 1, 1},
                                         {0, 1, -1},
                                         {1, 1, 1},
                                         {1, 1, -1},
                                         {1, -1, 1},
                                         {1, -1, -1}}};

class Filler {
 public:
  Filler(const std::array<int, 3>& size, int most_steps, const std::vector<std::int16_t>& seen)
      : size_(size), most_steps_(most_steps), seen_(seen) {}

  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return (as_size(k) * as_size(size_[1]) + as_size(j)) * as_size(size_[0]) + as_size(i);
  }
  /// Value of an empty voxel; kUnseenVoxel: no line is short enough.
  [[nodiscard]] std::int16_t value(int i, int j, int k) const {
    double shortest = std::numeric_limits<double>::infinity();
    double sum = 0;
    int ties = 0;
    for (const Offset& line : kLines) {
      const Found ahead = first_seen({i, j, k}, line, 1, most_steps_);
      if (ahead.steps == 0) continue;
      const Found behind = first_seen({i, j, k}, line, -1, most_steps_ + 1 - ahead.steps);
      if (behind.steps == 0) continue;
      const int steps = ahead.steps + behind.steps;
      const double length =
          steps * std::sqrt(line[0] * line[0] + line[1] * line[1] + line[2] * line[2]);
      if (length > shortest) continue;
      if (length < shortest) {
        shortest = length;
        sum = ties = 0;
      }
      sum += (static_cast<double>(ahead.value) * behind.steps +
              static_cast<double>(behind.value) * ahead.steps) /
             steps;
      ++ties;
    }
    if (ties == 0) return kUnseenVoxel;
    return static_cast<std::int16_t>(std::lround(sum / ties));
  }

 private:
  struct Found {
    int steps = 0;  ///< 0: none.
    std::int16_t value = kUnseenVoxel;
  };
  [[nodiscard]] Found first_seen(Offset at, const Offset& line, int sign, int most) const {
    for (int n = 1; n <= most; ++n) {
      for (std::size_t a = 0; a < 3; ++a) {
        at[a] += sign * line[a];
        if (at[a] < 0 || at[a] >= size_[a]) return {};
      }
      const std::int16_t value = seen_[offset(at[0], at[1], at[2])];
      if (value != kUnseenVoxel) return {n, value};
    }
    return {};
  }

  std::array<int, 3> size_;
  int most_steps_;
  const std::vector<std::int16_t>& seen_;
};

}  // namespace

Result<std::vector<VoxelOrigin>> fill_holes(const std::array<int, 3>& size, int most_steps,
                                            int threads, std::vector<std::int16_t>& values,
                                            const ReconstructionRun& run) {
  std::vector<VoxelOrigin> origins(values.size(), VoxelOrigin::kEmpty);
  std::vector<std::int16_t> filled = values;
  const Filler filler(size, most_steps, values);
  std::atomic<int> done = 0;
  const Workers workers(threads);
  workers.run(size[2], [&](int k) {
    if (run.stop.stop_requested()) return;
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t at = filler.offset(i, j, k);
        if (values[at] != kUnseenVoxel) {
          origins[at] = VoxelOrigin::kSeen;
        } else if (const std::int16_t found = filler.value(i, j, k); found != kUnseenVoxel) {
          filled[at] = found;
          origins[at] = VoxelOrigin::kFilled;
        }
      }
    }
    if (run.progress) run.progress(static_cast<double>(++done) / size[2]);
  });
  if (run.stop.stop_requested()) return reconstruction_cancelled();
  values = std::move(filled);
  return origins;
}

}  // namespace nav::tracking
