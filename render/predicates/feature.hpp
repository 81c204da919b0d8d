// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::render {
namespace features {
class LayerModel;
}  // namespace features

/// A derived quantity of an ultrasound volume, one number per voxel, for predicates: SNR,
/// vesselness, confidence, gradients. Kept in 16 bits between the least and the greatest value,
/// which is its definition for every engine. Immutable; copying copies a pointer.
class FeatureVolume {
 public:
  /// Code of a voxel without a value.
  static constexpr std::int16_t kUndefined = -32768;

  /// values: i fastest; NaN and infinities are undefined voxels, where no predicate is true.
  /// Refuses a bad grid or a count that does not match it.
  static Result<FeatureVolume> create(const VoxelGrid& grid, std::span<const float> values,
                                      std::string name);

  [[nodiscard]] const std::string& name() const { return codes_->name(); }
  [[nodiscard]] const VoxelGrid& grid() const { return codes_->grid(); }
  /// value = offset + scale · code, but for kUndefined.
  [[nodiscard]] const std::shared_ptr<const Volume>& codes() const { return codes_; }
  [[nodiscard]] double offset() const { return offset_; }
  /// > 0.
  [[nodiscard]] double scale() const { return scale_; }
  /// A stored value is within half of it: a step of the codes, or of single precision where that
  /// is more, as for constants.
  [[nodiscard]] double quantum() const { return quantum_; }
  [[nodiscard]] bool has_undefined() const { return has_undefined_; }
  /// What other voxels of the same codes are; has_undefined() stays.
  [[nodiscard]] FeatureVolume with_codes(std::shared_ptr<const Volume> codes) const {
    FeatureVolume other = *this;
    other.codes_ = std::move(codes);
    return other;
  }

 private:
  FeatureVolume() = default;
  std::shared_ptr<const Volume> codes_;
  double offset_ = 0;
  double scale_ = 1;
  double quantum_ = 1;
  bool has_undefined_ = false;
};

/// Label layers, one bit each, per voxel. Immutable; copying copies a pointer.
class LabelVolume {
 public:
  /// Refuses a bad grid or a count that does not match it.
  static Result<LabelVolume> create(const VoxelGrid& grid, std::vector<std::uint32_t> bits,
                                    std::string name);
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  /// i fastest.
  [[nodiscard]] std::span<const std::uint32_t> bits() const { return *bits_; }
  /// The same labels as what they are rastered from: surfaces of the same grid. Bit n is layer n.
  [[nodiscard]] LabelVolume with_layers(std::shared_ptr<const features::LayerModel> layers) const {
    LabelVolume other = *this;
    other.layers_ = std::move(layers);
    return other;
  }
  /// Null: there is nothing but the voxels.
  [[nodiscard]] const std::shared_ptr<const features::LayerModel>& layers() const {
    return layers_;
  }

 private:
  LabelVolume() = default;
  std::shared_ptr<const features::LayerModel> layers_;
  VoxelGrid grid_;
  std::shared_ptr<const std::vector<std::uint32_t>> bits_;
  std::string name_;
};

/// What predicates may ask for besides the ultrasound volume itself, on its grid.
struct Features {
  std::map<std::string, FeatureVolume> volumes;  ///< By the name that predicates know.
  std::optional<LabelVolume> labels;
};

/// Names of what the built-in predicates read.
namespace feature {
/// The volume itself, as a share of white (PredicateScene::intensity).
inline constexpr const char* kIntensity = "intensity";
inline constexpr const char* kGradientMagnitude = "gradient_magnitude";  ///< 1/mm.
/// Derivative along the scan line, 1/mm, signed: > 0 where it gets brighter with depth.
inline constexpr const char* kGradientAlong = "gradient_along";
inline constexpr const char* kGradientAcross = "gradient_across";  ///< Rest of the gradient, >= 0.
inline constexpr const char* kSnr = "snr";
inline constexpr const char* kVesselness = "vesselness";
inline constexpr const char* kConfidence = "confidence";
inline constexpr const char* kDepth = "depth";  ///< mm; only where no scan geometry says it.
}  // namespace feature

}  // namespace nav::render
