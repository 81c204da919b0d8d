// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "nav/result.hpp"
#include "render/features/service.hpp"
#include "render/predicates/kind.hpp"
#include "render/predicates/predicate_scene.hpp"

namespace nav::render {

/// Options for deriving the features that predicates read from the volume.
struct DerivedFeatureOptions {
  features::SnrOptions snr;
  features::VesselnessOptions vesselness;
  features::ConfidenceOptions confidence;
  features::GradientOptions gradient;
  std::optional<std::int16_t> unknown;  ///< Stored value of voxels that no ultrasound image
                                        ///< reached.
};

/// Limit of the signal-to-noise ratios that predicates read, on either side of 0. It exceeds 883,
/// the greatest ratio that 8 bits can give. Saturated voxels with more bits give 10^5, and in such
/// a range one step of the codes would be larger than the ratios of tissue.
inline constexpr double kMostSnr = 1000;

/// Source of a channel that predicates read.
struct ChannelSource {
  bool derived = false;     ///< Computed by add_derived_features().
  bool gradient = false;    ///< Smoothed as the options of the gradient say.
  bool scan_lines = false;  ///< Depends on the directions of the scan lines too.
};
/// The source of a channel. All false: the volume itself, or a channel that only the user can
/// provide.
[[nodiscard]] ChannelSource source_of_channel(const std::string& channel);

/// True when a predicate needs scan lines, for itself or for its channels.
[[nodiscard]] bool reads_scan_lines(const PredicateNeeds& needs);

/// Adds gradients, signal-to-noise ratio, vesselness and confidence if a predicate of the model
/// reads them (PredicateNeeds::channels) and they are missing; computes nothing else. Requests all
/// of them at once and waits for them. Gradients are those of the shares of white
/// (PredicateScene::intensity), per mm. The gradient angle needs two features, along and across the
/// scan line, because angles cannot be interpolated. The signal counts from the black of
/// PredicateScene::intensity. Rejects angles and confidence without scan lines, confidence with a
/// direction per voxel but no feature depth, and all that the features reject.
Result<void> add_derived_features(const std::shared_ptr<const StoredVolume>& volume,
                                  const DerivedFeatureOptions& options,
                                  features::DerivedVolumes& service, PredicateScene& predicates);

/// Computes one feature with a name, or finds it in a cache.
using MakeFeature = std::function<Result<features::DerivedVolume>(const std::string& name,
                                                                  const features::DerivedRequest&)>;
/// Adds the same features, one after the other, with \p make.
Result<void> add_derived_features(const std::shared_ptr<const StoredVolume>& volume,
                                  const DerivedFeatureOptions& options, const MakeFeature& make,
                                  PredicateScene& predicates);

}  // namespace nav::render
