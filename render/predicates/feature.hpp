// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::render {
namespace features {
class LayerModel;
}  // namespace features

/// A derived quantity of an ultrasound volume, one number per voxel, for predicates: SNR,
/// vesselness, confidence, gradients. Values are stored in 16 bits between the least and the
/// greatest value. These stored values define the feature for every engine. Immutable; copying
/// copies a pointer.
class FeatureVolume {
 public:
  /// Code of a voxel without a value.
  static constexpr std::int16_t kUndefined = -32768;

  /// Encodes values, i fastest. NaN and infinities mark undefined voxels, where no predicate is
  /// true. Rejects an invalid grid or a count that does not match the grid.
  static Result<FeatureVolume> create(const VoxelGrid& grid, std::span<const float> values,
                                      std::string name);

  [[nodiscard]] const std::string& name() const { return codes_->name(); }
  [[nodiscard]] const VoxelGrid& grid() const { return codes_->grid(); }
  /// Codes: value = offset + scale · code, except for kUndefined.
  [[nodiscard]] const std::shared_ptr<const StoredVolume>& codes() const { return codes_; }
  [[nodiscard]] double offset() const { return offset_; }
  /// Value step per code, > 0.
  [[nodiscard]] double scale() const { return scale_; }
  /// Resolution: a stored value is exact to half of this. It is the step of the codes, or that of
  /// single precision if greater, as for constants.
  [[nodiscard]] double quantum() const { return quantum_; }
  [[nodiscard]] bool has_undefined() const { return has_undefined_; }
  /// Returns this feature with other codes; offset, scale, quantum and has_undefined() stay.
  [[nodiscard]] FeatureVolume with_codes(std::shared_ptr<const StoredVolume> codes) const {
    FeatureVolume other = *this;
    other.codes_ = std::move(codes);
    return other;
  }

 private:
  FeatureVolume() = default;
  std::shared_ptr<const StoredVolume> codes_;
  double offset_ = 0;
  double scale_ = 1;
  double quantum_ = 1;
  bool has_undefined_ = false;
};

/// Label layers per voxel, one bit for each layer. Immutable; copying copies a pointer.
class LabelVolume {
 public:
  /// Rejects an invalid grid or a count that does not match the grid.
  static Result<LabelVolume> create(const VoxelGrid& grid, std::vector<std::uint32_t> bits,
                                    std::string name);
  [[nodiscard]] const std::string& name() const { return voxels_.name(); }
  [[nodiscard]] const VoxelGrid& grid() const { return voxels_.grid(); }
  /// Bit masks of the voxels, i fastest.
  [[nodiscard]] std::span<const std::uint32_t> bits() const { return voxels_.values(); }
  /// Returns these labels together with the surfaces, on the same grid, from which they were
  /// rasterised. Bit n is layer n.
  [[nodiscard]] LabelVolume with_layers(std::shared_ptr<const features::LayerModel> layers) const {
    LabelVolume other = *this;
    other.layers_ = std::move(layers);
    return other;
  }
  /// The surfaces, or null when there are only voxels.
  [[nodiscard]] const std::shared_ptr<const features::LayerModel>& layers() const {
    return layers_;
  }

 private:
  using Voxels = VolumeOf<frames::Ct, std::uint32_t>;
  explicit LabelVolume(Voxels voxels) : voxels_(std::move(voxels)) {}
  std::shared_ptr<const features::LayerModel> layers_;
  Voxels voxels_;
};

/// Additional data that predicates may read, on the grid of the ultrasound volume.
struct Features {
  std::map<std::string, FeatureVolume> volumes;  ///< Keyed by the names that predicates use.
  std::optional<LabelVolume> labels;
};

/// Names of the channels that the built-in predicates read.
namespace feature {
/// The volume itself, as a share of white (PredicateScene::intensity). A feature of this name takes
/// its place for predicates, and the volume then only says how bright and opaque samples are.
inline constexpr const char* kIntensity = "intensity";
inline constexpr const char* kGradientMagnitude = "gradient_magnitude";  ///< 1/mm.
/// Signed derivative along the scan line, 1/mm: > 0 when brightness increases with depth.
inline constexpr const char* kGradientAlong = "gradient_along";
inline constexpr const char* kGradientAcross = "gradient_across";  ///< Rest of the gradient, >= 0.
inline constexpr const char* kSnr = "snr";
inline constexpr const char* kVesselness = "vesselness";
inline constexpr const char* kConfidence = "confidence";
inline constexpr const char* kDepth = "depth";  ///< mm; used only when no scan geometry gives the
                                                ///< depth.
}  // namespace feature

}  // namespace nav::render
