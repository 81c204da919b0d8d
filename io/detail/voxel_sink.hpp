// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <utility>

#include "io/pixel_type.hpp"

namespace nav::io::detail {

/// Conversion of stored numbers to values: value = slope * stored + intercept.
struct Rescale {
  double slope = 1;
  double intercept = 0;
  std::optional<std::pair<double, double>> padding;  ///< Stored values in [first, second] are air.
};

/// Receiver of the voxels of a file, in the order i, j, k.
class VoxelSink {
 public:
  VoxelSink() = default;
  VoxelSink(const VoxelSink&) = delete;
  VoxelSink& operator=(const VoxelSink&) = delete;
  VoxelSink(VoxelSink&&) = default;
  VoxelSink& operator=(VoxelSink&&) = default;
  virtual ~VoxelSink() = default;
  /// Reserves memory for \p voxel_count voxels, of which those so far are a part; the caller has
  /// checked that the file can hold them.
  virtual void reserve(std::size_t voxel_count) = 0;
  /// Appends samples in native byte order.
  virtual void append(std::span<const std::byte> samples, PixelType type,
                      const Rescale& rescale) = 0;
};

/// Calls \p each with every complete sample as a number.
template <class T, class Each>
void for_each_sample(std::span<const std::byte> samples, const Each& each) {
  for (std::size_t i = 0; i + sizeof(T) <= samples.size(); i += sizeof(T)) {
    T stored;
    std::memcpy(&stored, samples.data() + i, sizeof(T));
    each(stored);
  }
}

/// Overload for a sample type that is known at run time.
template <class Each>
void for_each_sample(std::span<const std::byte> samples, PixelType type, const Each& each) {
  switch (type) {
    case PixelType::kUint8:
      return for_each_sample<std::uint8_t>(samples, each);
    case PixelType::kInt8:
      return for_each_sample<std::int8_t>(samples, each);
    case PixelType::kUint16:
      return for_each_sample<std::uint16_t>(samples, each);
    case PixelType::kInt16:
      return for_each_sample<std::int16_t>(samples, each);
    case PixelType::kUint32:
      return for_each_sample<std::uint32_t>(samples, each);
    case PixelType::kInt32:
      return for_each_sample<std::int32_t>(samples, each);
    case PixelType::kFloat32:
      return for_each_sample<float>(samples, each);
    case PixelType::kFloat64:
      return for_each_sample<double>(samples, each);
  }
}

}  // namespace nav::io::detail
