// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "nav/index.hpp"
#include "nav/zeroed_array.hpp"
#include "tracking/reconstruction/image_path.hpp"
#include "tracking/reconstruction/reconstruction_engine.hpp"

namespace nav::tracking {
namespace {

constexpr std::int64_t kOneVoxel = std::int64_t{1} << kPositionBits;
constexpr std::uint32_t kFraction = 0xffffffffU;
/// Least weight with which a pixel counts for maximum, median and latest, as in PLUS.
constexpr float kLeastWeight = 0.125F;

int whole(std::int64_t position) { return static_cast<int>(position >> kPositionBits); }

// Stores: what is kept of the values that reached each voxel. add() may run for different slices of
// voxels at once.

/// Mean of equal weights, exact.
class MeanOfPixels {
 public:
  static constexpr bool kWeighted = false;
  static constexpr bool kNeedsSlices = false;
  explicit MeanOfPixels(const std::array<int, 3>& size)
      : cells_(as_size(size[0]) * as_size(size[1]) * as_size(size[2])) {}
  void add(std::size_t voxel, std::uint8_t value) {
    cells_[voxel].sum += value;
    ++cells_[voxel].count;
  }
  [[nodiscard]] std::int16_t value(std::size_t voxel) const {
    const auto [sum, count] = cells_[voxel];
    if (count == 0) return kUnseenVoxel;
    return static_cast<std::int16_t>((sum + count / 2) / count);
  }

 private:
  struct Cell {
    std::uint32_t sum, count;
  };
  ZeroedArray<Cell> cells_;
};

/// Weighted mean in single precision.
class MeanByWeight {
 public:
  static constexpr bool kWeighted = true;
  static constexpr bool kNeedsSlices = false;
  explicit MeanByWeight(const std::array<int, 3>& size)
      : cells_(as_size(size[0]) * as_size(size[1]) * as_size(size[2])) {}
  void add(std::size_t voxel, std::uint8_t value, float weight) {
    Cell& cell = cells_[voxel];
    cell.sum += weight * static_cast<float>(value);
    cell.weight += weight;
  }
  [[nodiscard]] std::int16_t value(std::size_t voxel) const {
    const auto [sum, weight] = cells_[voxel];
    if (!(weight > 0)) return kUnseenVoxel;
    return static_cast<std::int16_t>(std::lround(sum / weight));
  }

 private:
  struct Cell {
    float sum, weight;
  };
  ZeroedArray<Cell> cells_;
};

/// Largest value, or the last one.
template <bool kLargest>
class OneValue {
 public:
  static constexpr bool kWeighted = false;
  static constexpr bool kNeedsSlices = false;
  explicit OneValue(const std::array<int, 3>& size)
      : one_more_(as_size(size[0]) * as_size(size[1]) * as_size(size[2])) {}
  void add(std::size_t voxel, std::uint8_t value) {
    const auto more = static_cast<std::int16_t>(value + 1);
    one_more_[voxel] = kLargest ? std::max(one_more_[voxel], more) : more;
  }
  [[nodiscard]] std::int16_t value(std::size_t voxel) const {
    return static_cast<std::int16_t>(one_more_[voxel] - 1);
  }

 private:
  ZeroedArray<std::int16_t> one_more_;  ///< 0: unseen.
};

/// Median. Values are kept in lists, one for each 4096 voxels of a slice k.
class MedianOfPixels {
 public:
  static constexpr bool kWeighted = false;
  static constexpr bool kNeedsSlices = true;
  explicit MedianOfPixels(const std::array<int, 3>& size)
      : per_slice_(as_size(size[0]) * as_size(size[1])),
        lists_per_slice_((per_slice_ + kPerList - 1) / kPerList),
        lists_(lists_per_slice_ * as_size(size[2])) {}
  void add(std::size_t voxel, std::uint8_t value) {
    const std::size_t slice = voxel / per_slice_;
    const std::size_t in_slice = voxel - slice * per_slice_;
    lists_[slice * lists_per_slice_ + in_slice / kPerList].push_back(
        static_cast<std::uint32_t>(in_slice % kPerList) << 8 | value);
  }
  /// Medians of one slice; the lower of the middle two.
  void slice(int k, std::int16_t* values) const {
    for (std::size_t n = 0; n < lists_per_slice_; ++n) {
      const auto& kept = lists_[as_size(k) * lists_per_slice_ + n];
      std::vector<std::uint32_t> sorted(kept);
      std::sort(sorted.begin(), sorted.end());
      const std::size_t past = std::min(kPerList, per_slice_ - n * kPerList);
      std::fill_n(values + n * kPerList, past, kUnseenVoxel);
      for (std::size_t i = 0; i < sorted.size();) {
        std::size_t end = i;
        while (end < sorted.size() && sorted[end] >> 8 == sorted[i] >> 8) ++end;
        values[n * kPerList + (sorted[i] >> 8)] =
            static_cast<std::int16_t>(sorted[i + (end - i - 1) / 2] & 0xffU);
        i = end;
      }
    }
  }

 private:
  static constexpr std::size_t kPerList = 4096;
  std::size_t per_slice_, lists_per_slice_;
  std::vector<std::vector<std::uint32_t>> lists_;  ///< Voxel in the list << 8 | value.
};

template <class Store>
void give(Store& store, std::size_t voxel, std::uint8_t value, float weight) {
  if constexpr (Store::kWeighted) {
    store.add(voxel, value, weight);
  } else if (weight >= kLeastWeight) {
    store.add(voxel, value);
  }
}

/// Share with which a pixel counts: 1 for stores without weights and images without confidence.
template <class Store>
float share_of(const std::uint8_t* confidence, std::ptrdiff_t pixel) {
  if constexpr (Store::kWeighted) {
    constexpr float kStep = 1.0F / 256;
    return confidence == nullptr ? 1.0F : kStep * static_cast<float>(confidence[pixel] + 1);
  }
  return 1.0F;
}

// Kernels: the voxels that a pixel reaches. A position is that of its cell: the cell and those up
// to reach_below() before and reach_above() after it are written.

class NearestKernel {
 public:
  explicit NearestKernel(const ReconstructionOptions& /*options*/) {}
  static double shift() { return 0.5; }
  static int reach_below() { return 0; }
  static int reach_above() { return 0; }
  template <class Store>
  void row(FixedPosition p, const FixedPosition& step, std::size_t row, std::size_t slice,
           std::span<const std::uint8_t> pixels, const std::uint8_t* confidence,
           Store& store) const {
    for (const std::uint8_t& pixel : pixels) {
      const float counts = share_of<Store>(confidence, &pixel - pixels.data());
      give(store,
           static_cast<std::size_t>(p[0] >> kPositionBits) +
               static_cast<std::size_t>(p[1] >> kPositionBits) * row +
               static_cast<std::size_t>(p[2] >> kPositionBits) * slice,
           pixel, counts);
      for (std::size_t a = 0; a < 3; ++a) p[a] += step[a];
    }
  }
};

class TrilinearKernel {
 public:
  explicit TrilinearKernel(const ReconstructionOptions& /*options*/) {}
  static double shift() { return 0; }
  static int reach_below() { return 0; }
  static int reach_above() { return 1; }
  template <class Store>
  void row(FixedPosition p, const FixedPosition& step, std::size_t row, std::size_t slice,
           std::span<const std::uint8_t> pixels, const std::uint8_t* confidence,
           Store& store) const {
    for (const std::uint8_t& pixel : pixels) {
      const float counts = share_of<Store>(confidence, &pixel - pixels.data());
      std::array<float, 3> w{};
      for (std::size_t a = 0; a < 3; ++a) {
        constexpr float kUnit = 1.0F / 16777216;  // 24 bits are exact.
        w[a] = kUnit * static_cast<float>(static_cast<std::int32_t>((p[a] & kFraction) >> 8));
      }
      const std::size_t voxel = static_cast<std::size_t>(p[0] >> kPositionBits) +
                                static_cast<std::size_t>(p[1] >> kPositionBits) * row +
                                static_cast<std::size_t>(p[2] >> kPositionBits) * slice;
      const float low = 1 - w[0];
      const auto pair = [&](std::size_t at, float weight) {
        give(store, at, pixel, counts * weight * low);
        give(store, at + 1, pixel, counts * weight * w[0]);
      };
      pair(voxel, (1 - w[1]) * (1 - w[2]));
      pair(voxel + row, w[1] * (1 - w[2]));
      pair(voxel + slice, (1 - w[1]) * w[2]);
      pair(voxel + slice + row, w[1] * w[2]);
      for (std::size_t a = 0; a < 3; ++a) p[a] += step[a];
    }
  }
};

class GaussianKernel {
 public:
  explicit GaussianKernel(const ReconstructionOptions& options)
      : reach_(static_cast<int>(std::ceil(2 * options.gaussian_voxels))) {
    const double sigma = options.gaussian_voxels;
    for (int bin = 0; bin < kBins; ++bin) {
      const double at = (bin + 0.5) / kBins - 0.5;
      for (int n = -reach_; n <= reach_; ++n) {
        const double d = n - at;
        weights_.push_back(std::abs(d) <= 2 * sigma
                               ? static_cast<float>(std::exp(-d * d / (2 * sigma * sigma)))
                               : 0.0F);
      }
    }
  }
  static double shift() { return 0.5; }
  [[nodiscard]] int reach_below() const { return reach_; }
  [[nodiscard]] int reach_above() const { return reach_; }
  template <class Store>
  void row(FixedPosition p, const FixedPosition& step, std::size_t row, std::size_t slice,
           std::span<const std::uint8_t> pixels, const std::uint8_t* confidence,
           Store& store) const {
    const auto taps = static_cast<std::size_t>(2 * reach_ + 1);
    for (const std::uint8_t& pixel : pixels) {
      const float counts = share_of<Store>(confidence, &pixel - pixels.data());
      std::array<const float*, 3> w{};
      std::array<std::size_t, 3> first{};
      for (std::size_t a = 0; a < 3; ++a) {
        w[a] = &weights_[((p[a] & kFraction) >> (kPositionBits - kBinBits)) * taps];
        first[a] = static_cast<std::size_t>(whole(p[a]) - reach_);
      }
      for (std::size_t k = 0; k < taps; ++k) {
        for (std::size_t j = 0; j < taps; ++j) {
          const float weight = w[2][k] * w[1][j];
          if (!(weight > 0)) continue;
          const std::size_t voxel = first[0] + (first[1] + j) * row + (first[2] + k) * slice;
          for (std::size_t i = 0; i < taps; ++i) {
            if (w[0][i] > 0) give(store, voxel + i, pixel, counts * weight * w[0][i]);
          }
        }
      }
      for (std::size_t a = 0; a < 3; ++a) p[a] += step[a];
    }
  }

 private:
  static constexpr int kBinBits = 7;
  static constexpr int kBins = 1 << kBinBits;
  int reach_;
  std::vector<float> weights_;  ///< Bin of the fraction, then tap.
};

template <class Kernel, class Store>
class SplattingEngine final : public Reconstruction::Engine {
 public:
  SplattingEngine(const VoxelGridIn<frames::Reference>& grid, const ReconstructionOptions& options)
      : Engine(grid, options), kernel_(options), store_(grid.size) {}

  void add(const TrackedImage& image, const std::shared_ptr<const ImageArea>& area,
           const Image2d<std::uint8_t>& confidence) override {
    const auto path = ImagePath::of(image, grid_, kernel_.shift());
    if (!path) return;
    // Each thread owns slabs of voxels, so that every voxel takes its pixels in one order. A slab
    // across the rows of the image meets few of them.
    std::size_t axis = 2;
    if (!Store::kNeedsSlices) {
      Eigen::Index steepest = 0;
      path->per_row().cwiseAbs().maxCoeff(&steepest);
      axis = static_cast<std::size_t>(steepest);
    }
    const Range cells = cells_of(*path, *area, axis);
    if (cells.low >= cells.high) return;
    constexpr int kSlabs = 16;
    const int reach = kernel_.reach_below() + kernel_.reach_above();
    const int thickness = std::max({1, reach, (cells.high - cells.low + kSlabs - 1) / kSlabs});
    const int slabs = (cells.high - cells.low + thickness - 1) / thickness;
    const auto work = [&](int slab) {
      const int low = cells.low + slab * thickness;
      add_slab(image, *area, confidence, *path, axis, {low, std::min(low + thickness, cells.high)});
    };
    if (reach == 0) return workers_.run(slabs, work);
    // Kernels write into the neighbouring slab too, so neighbours never run at once.
    workers_.run((slabs + 1) / 2, [&](int n) { work(2 * n); });
    if (slabs > 1) workers_.run(slabs / 2, [&](int n) { work(2 * n + 1); });
  }

  Result<std::vector<std::int16_t>> values(const ReconstructionRun& run) override {
    const std::size_t slice = as_size(grid_.size[0]) * as_size(grid_.size[1]);
    std::vector<std::int16_t> values(grid_.voxel_count());
    workers_.run(grid_.size[2], [&](int k) {
      if (run.stop.stop_requested()) return;
      std::int16_t* const out = values.data() + as_size(k) * slice;
      if constexpr (Store::kNeedsSlices) {
        store_.slice(k, out);
      } else {
        for (std::size_t n = 0; n < slice; ++n) out[n] = store_.value(as_size(k) * slice + n);
      }
    });
    if (run.stop.stop_requested()) return reconstruction_cancelled();
    if (run.progress) run.progress(1);
    return values;
  }

 private:
  struct Range {
    int low, high;  ///< Cells [low, high).
  };
  /// Cells that a pixel may have along an axis, so that its whole kernel lies in the grid.
  [[nodiscard]] Range allowed(std::size_t axis) const {
    return {kernel_.reach_below(), grid_.size[axis] - kernel_.reach_above()};
  }
  [[nodiscard]] Range cells_of(const ImagePath& path, const ImageArea& area,
                               std::size_t axis) const {
    double least = INFINITY;
    double most = -INFINITY;
    for (const Eigen::Vector2d& corner : area.corners()) {
      const double at = path.at(corner.x(), corner.y())[static_cast<Eigen::Index>(axis)];
      least = std::min(least, at);
      most = std::max(most, at);
    }
    const Range all = allowed(axis);
    // One more at each end: rounding.
    return {std::max(all.low, static_cast<int>(std::floor(least)) - 1),
            std::min(all.high, static_cast<int>(std::floor(most)) + 2)};
  }
  void add_slab(const TrackedImage& image, const ImageArea& area,
                const Image2d<std::uint8_t>& confidence, const ImagePath& path, std::size_t axis,
                Range slab) {
    std::array<Range, 3> cells{allowed(0), allowed(1), allowed(2)};
    cells[axis] = slab;
    const auto row = as_size(grid_.size[0]);
    const auto slice = row * as_size(grid_.size[1]);
    const auto pixels = image.frame.pixels.pixels();
    const std::uint8_t* const weights =
        confidence.pixels().empty() ? nullptr : confidence.pixels().data();
    const auto width = as_size(image.frame.pixels.width());
    const FixedPosition& step = path.step();
    for (const ImageArea::Run& run : area.runs()) {
      FixedPosition at = path.row_start(run.row);
      ColumnSpan columns{run.first, run.past};
      // The slab comes first: most rows miss it.
      for (std::size_t n = 0; n < 3 && columns.first < columns.past; ++n) {
        const std::size_t a = (axis + n) % 3;
        columns = columns_within(columns, at[a], step[a], cells[a].low * kOneVoxel,
                                 cells[a].high * kOneVoxel);
      }
      if (columns.first >= columns.past) continue;
      for (std::size_t a = 0; a < 3; ++a) at[a] += columns.first * step[a];
      const std::size_t first = as_size(run.row) * width + as_size(columns.first);
      kernel_.row(at, step, row, slice,
                  pixels.subspan(first, as_size(columns.past - columns.first)),
                  weights == nullptr ? nullptr : weights + first, store_);
    }
  }

  Kernel kernel_;
  Store store_;
};

template <class Kernel>
std::unique_ptr<Reconstruction::Engine> splatting_by(const VoxelGridIn<frames::Reference>& grid,
                                                     const ReconstructionOptions& options) {
  using Mean =
      std::conditional_t<std::is_same_v<Kernel, NearestKernel>, MeanOfPixels, MeanByWeight>;
  switch (options.compounding) {
    case Compounding::kMean:
      if (options.by_confidence) {
        return std::make_unique<SplattingEngine<Kernel, MeanByWeight>>(grid, options);
      }
      return std::make_unique<SplattingEngine<Kernel, Mean>>(grid, options);
    case Compounding::kMedian:
      return std::make_unique<SplattingEngine<Kernel, MedianOfPixels>>(grid, options);
    case Compounding::kMaximum:
      return std::make_unique<SplattingEngine<Kernel, OneValue<true>>>(grid, options);
    case Compounding::kLatest:
      break;
  }
  return std::make_unique<SplattingEngine<Kernel, OneValue<false>>>(grid, options);
}

}  // namespace

std::unique_ptr<Reconstruction::Engine> make_splatting_engine(
    const VoxelGridIn<frames::Reference>& grid, const ReconstructionOptions& options) {
  switch (options.method) {
    case ReconstructionMethod::kTrilinear:
      return splatting_by<TrilinearKernel>(grid, options);
    case ReconstructionMethod::kGaussian:
      return splatting_by<GaussianKernel>(grid, options);
    default:
      return splatting_by<NearestKernel>(grid, options);
  }
}

}  // namespace nav::tracking
