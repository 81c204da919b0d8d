// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tracking/reconstruction/reconstruction.hpp"
#include "tracking/reconstruction/workers.hpp"

namespace nav::tracking {

class Reconstruction::Engine {
 public:
  Engine(const VoxelGridIn<frames::Reference>& grid, const ReconstructionOptions& options)
      : grid_(grid), options_(options), workers_(options.threads) {}
  virtual ~Engine() = default;
  virtual void add(const TrackedImage& image, const std::shared_ptr<const ImageArea>& area,
                   const Image2d<std::uint8_t>& confidence) = 0;
  virtual Result<std::vector<std::int16_t>> values(const ReconstructionRun& run) = 0;
  [[nodiscard]] virtual std::span<const ScanLineAtVoxel> scan_lines() const { return {}; }
  [[nodiscard]] const VoxelGridIn<frames::Reference>& grid() const { return grid_; }
  [[nodiscard]] const ReconstructionOptions& options() const { return options_; }

 protected:
  VoxelGridIn<frames::Reference> grid_;
  ReconstructionOptions options_;
  Workers workers_;
};

/// Nearest, trilinear, Gaussian.
std::unique_ptr<Reconstruction::Engine> make_splatting_engine(
    const VoxelGridIn<frames::Reference>& grid, const ReconstructionOptions& options);
std::unique_ptr<Reconstruction::Engine> make_backward_engine(
    const VoxelGridIn<frames::Reference>& grid, const ReconstructionOptions& options);

/// The error kCancelled.
Error reconstruction_cancelled();

}  // namespace nav::tracking
