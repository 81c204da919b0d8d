// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/reconstruction.hpp"

#include <sstream>
#include <utility>

#include "tracking/reconstruction/reconstruction_engine.hpp"

namespace nav::tracking {
namespace {

Error out_of_range(const char* what, const char* expected, double found) {
  std::ostringstream text;
  text << "reconstruction: expected " << what << ' ' << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

}  // namespace

Result<void> validate(const ReconstructionOptions& options) {
  if (!(options.gaussian_voxels >= 0.3 && options.gaussian_voxels <= 2)) {
    return out_of_range("a Gaussian", "of 0.3 to 2 voxels", options.gaussian_voxels);
  }
  if (!(options.reach_mm > 0 && options.reach_mm <= 100)) {
    return out_of_range("a reach", "in (0, 100] mm", options.reach_mm);
  }
  const bool backward = options.method == ReconstructionMethod::kBackward;
  const bool weighs = options.compounding == Compounding::kMean ||
                      (backward && options.compounding == Compounding::kMedian);
  if (options.by_confidence && !weighs) {
    return Error{ErrorCode::kUsage,
                 "reconstruction: expected the mean, or the median of the backward method, for "
                 "weights by confidence, found another compounding, in which weights do not count"};
  }
  if (options.threads < 0) return out_of_range("threads", ">= 0", options.threads);
  return {};
}

double reconstruction_bytes(const VoxelGridIn<frames::Reference>& grid,
                            const ReconstructionOptions& options, double pixels) {
  const double voxels = 1.0 * grid.size[0] * grid.size[1] * grid.size[2];
  constexpr double kValue = 2;  // The voxels that are handed out.
  if (options.method == ReconstructionMethod::kBackward) {
    return voxels * (2 * kValue + 8) + (options.by_confidence ? 2 : 1) * pixels;
  }
  switch (options.compounding) {
    case Compounding::kMean:
      return voxels * (kValue + 8);
    case Compounding::kMaximum:
    case Compounding::kLatest:
      return voxels * 2 * kValue;
    case Compounding::kMedian:
      break;
  }
  // A list doubles when it is full. Weights of at least 1/8: eight voxels of a pixel at most by
  // trilinear weights, the voxels within two standard deviations by a Gaussian.
  const double radius = 2 * options.gaussian_voxels;
  const double copies = options.method == ReconstructionMethod::kNearest ? 1
                        : options.method == ReconstructionMethod::kTrilinear
                            ? 4
                            : 4.2 * radius * radius * radius;
  return voxels * kValue + 2 * 4 * copies * pixels;
}

Reconstruction::Reconstruction(std::unique_ptr<Engine> engine) : engine_(std::move(engine)) {}
Reconstruction::~Reconstruction() = default;
Reconstruction::Reconstruction(Reconstruction&&) noexcept = default;
Reconstruction& Reconstruction::operator=(Reconstruction&&) noexcept = default;

Result<Reconstruction> Reconstruction::create(const VoxelGridIn<frames::Reference>& grid,
                                              const ReconstructionOptions& options) {
  if (auto ok = validate(grid, "reconstruction"); !ok) return ok.error();
  if (auto ok = validate(options); !ok) return ok.error();
  return Reconstruction(options.method == ReconstructionMethod::kBackward
                            ? make_backward_engine(grid, options)
                            : make_splatting_engine(grid, options));
}

void Reconstruction::add(const TrackedImage& image, const std::shared_ptr<const ImageArea>& area,
                         const Image2d<std::uint8_t>& confidence) {
  NAV_CHECK(area->fits(image.frame), image.frame.sequence);
  const auto& pixels = image.frame.pixels;
  const bool weighs = engine_->options().by_confidence;
  NAV_CHECK(confidence.width() == (weighs ? pixels.width() : 0) &&
                confidence.height() == (weighs ? pixels.height() : 0),
            confidence.width(), confidence.height());
  if (!area->empty()) engine_->add(image, area, confidence);
}

const VoxelGridIn<frames::Reference>& Reconstruction::grid() const { return engine_->grid(); }

Result<std::vector<std::int16_t>> Reconstruction::values(const ReconstructionRun& run) {
  return engine_->values(run);
}

std::span<const ScanLineAtVoxel> Reconstruction::scan_lines() const {
  return engine_->scan_lines();
}

Error reconstruction_cancelled() {
  return {ErrorCode::kCancelled, "reconstruction: stopped before it was finished"};
}

}  // namespace nav::tracking
