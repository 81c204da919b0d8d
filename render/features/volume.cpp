// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "render/features/digest.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

constexpr int kBins = 4096;
using Histogram = std::array<std::uint64_t, kBins>;

struct Extremes {
  float least = std::numeric_limits<float>::infinity();
  float greatest = -std::numeric_limits<float>::infinity();
  std::size_t known = 0;
};

/// Extremes of the known voxels whose values are counted.
template <class Counts>
Extremes extremes_of(const ScalarVolume& volume, int threads, const Counts& counts) {
  const auto& size = volume.grid().size;
  std::vector<Extremes> planes(static_cast<std::size_t>(size[2]));
  for_each_index(size[2], threads, [&](int k) {
    std::vector<float> row(static_cast<std::size_t>(size[0]));
    Extremes plane;
    for (int j = 0; j < size[1]; ++j) {
      volume.read_row(j, k, row.data());
      for (const float v : row) {
        if (!(v == v) || !counts(v)) continue;
        plane.least = std::min(plane.least, v);
        plane.greatest = std::max(plane.greatest, v);
        ++plane.known;
      }
    }
    planes[static_cast<std::size_t>(k)] = plane;
  });
  Extremes all;
  for (const Extremes& plane : planes) {
    all.least = std::min(all.least, plane.least);
    all.greatest = std::max(all.greatest, plane.greatest);
    all.known += plane.known;
  }
  return all;
}

/// Bins of equal width over a range that is not empty.
class Bins {
 public:
  explicit Bins(const Extremes& range)
      : least_(range.least), width_((range.greatest - least_) / kBins), scale_(1 / width_) {}
  /// Bin of a value within the range.
  [[nodiscard]] std::size_t of(float value) const {
    const auto bin = static_cast<int>((static_cast<double>(value) - least_) * scale_);
    return static_cast<std::size_t>(std::clamp(bin, 0, kBins - 1));
  }
  [[nodiscard]] double middle(std::size_t bin) const {
    return least_ + (static_cast<double>(bin) + 0.5) * width_;
  }

 private:
  double least_, width_, scale_;
};

/// Counts in slabs of planes, each with its own histogram, so that memory does not grow with the
/// volume.
Histogram histogram_of(const ScalarVolume& volume, const Extremes& range, int threads) {
  const auto& size = volume.grid().size;
  constexpr int kSlabs = 16;
  std::vector<Histogram> slabs(kSlabs, Histogram{});
  const Bins bins(range);
  for_each_index(kSlabs, threads, [&](int slab) {
    std::vector<float> row(static_cast<std::size_t>(size[0]));
    Histogram& counts = slabs[static_cast<std::size_t>(slab)];
    for (int k = slab * size[2] / kSlabs; k < (slab + 1) * size[2] / kSlabs; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        volume.read_row(j, k, row.data());
        for (const float v : row) {
          if (v >= range.least && v <= range.greatest) ++counts[bins.of(v)];
        }
      }
    }
  });
  Histogram all{};
  for (const Histogram& one : slabs) {
    for (std::size_t bin = 0; bin < all.size(); ++bin) all[bin] += one[bin];
  }
  return all;
}

/// The bin of the value with a rank, and the number of values in the bins before.
struct RankedBin {
  std::size_t bin = 0, before = 0;
};
RankedBin bin_of_rank(const Histogram& counts, double rank) {
  RankedBin at;
  while (at.bin + 1 < counts.size() && static_cast<double>(at.before + counts[at.bin]) < rank) {
    at.before += counts[at.bin++];
  }
  return at;
}

/// Two quantiles by their ranks. While both lie in one bin, that bin is divided further.
std::array<double, 2> quantiles(const ScalarVolume& volume, Extremes range,
                                std::array<double, 2> ranks, int threads) {
  while (range.greatest > range.least) {
    const Histogram counts = histogram_of(volume, range, threads);
    const RankedBin low = bin_of_rank(counts, ranks[0]);
    const RankedBin high = bin_of_rank(counts, ranks[1]);
    const Bins bins(range);
    if (low.bin != high.bin) return {bins.middle(low.bin), bins.middle(high.bin)};
    for (double& rank : ranks) rank -= static_cast<double>(low.before);
    range = extremes_of(volume, threads, [&, from = range.least, to = range.greatest](float v) {
      return v >= from && v <= to && bins.of(v) == low.bin;
    });
  }
  return {range.least, range.least};
}

}  // namespace

Result<ScalarVolume> ScalarVolume::create(const VoxelGrid& grid, std::vector<float> values,
                                          std::string name) {
  auto floats = VolumeOf<frames::Ct, float>::create(grid, std::move(values), std::move(name));
  if (!floats) return floats.error();
  const auto infinite =
      std::ranges::find_if(floats->values(), [](float v) { return std::isinf(v); });
  if (infinite != floats->values().end()) {
    return Error{ErrorCode::kMalformedData,
                 floats->name() + ": expected finite values or NaN, found infinity at voxel " +
                     std::to_string(infinite - floats->values().begin())};
  }
  ScalarVolume volume;
  volume.grid_ = grid;
  volume.name_ = floats->name();
  volume.floats_ = *std::move(floats);
  return volume;
}

ScalarVolume ScalarVolume::of(std::shared_ptr<const StoredVolume> volume,
                              std::optional<std::int16_t> unknown) {
  NAV_CHECK(volume != nullptr);
  ScalarVolume scalar;
  scalar.grid_ = volume->grid();
  scalar.name_ = volume->name();
  scalar.volume_ = std::move(volume);
  scalar.unknown_ = unknown;
  return scalar;
}

void ScalarVolume::read_row(int j, int k, float* out) const {
  const std::size_t first = offset_of(grid_, 0, j, k);
  const auto count = static_cast<std::size_t>(grid_.size[0]);
  if (floats_) {
    std::copy_n(floats_->values().data() + first, count, out);
    return;
  }
  const std::int16_t* in = volume_->values().data() + first;
  for (std::size_t i = 0; i < count; ++i) out[i] = in[i];
  if (!unknown_) return;
  for (std::size_t i = 0; i < count; ++i) out[i] = in[i] == *unknown_ ? kUnknown : out[i];
}

float ScalarVolume::at(int i, int j, int k) const {
  const std::size_t at = offset_of(grid_, i, j, k);
  if (floats_) return floats_->values()[at];
  const std::int16_t value = volume_->values()[at];
  return unknown_ && value == *unknown_ ? kUnknown : static_cast<float>(value);
}

struct ScalarVolume::KnownDigest {
  std::once_flag once;
  std::string hex;
};

ScalarVolume::ScalarVolume() : digest_(std::make_shared<KnownDigest>()) {}

std::string ScalarVolume::digest() const {
  std::call_once(digest_->once, [this] {
    Digest digest;
    digest.add(grid_);
    digest.add(unknown_ ? static_cast<double>(*unknown_) : std::nan(""));
    if (floats_) digest.add(std::as_bytes(floats_->values()));
    if (volume_) digest.add(std::as_bytes(volume_->values()));
    digest_->hex = digest.hex();
  });
  return digest_->hex;
}

ValueRange value_range(const ScalarVolume& volume, double low_share, double high_share,
                       int threads) {
  const Extremes range = extremes_of(volume, threads, [](float) { return true; });
  const double nan = std::nan("");
  if (range.known == 0) return {.least = nan, .greatest = nan, .low = nan, .high = nan};
  const auto known = static_cast<double>(range.known);
  const auto [low, high] =
      quantiles(volume, range, {low_share * known, high_share * known}, threads);
  return {.least = range.least,
          .greatest = range.greatest,
          .low = low,
          .high = high,
          .known = range.known};
}

}  // namespace nav::render::features
