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

/// How the features that predicates read are derived from the volume.
struct DerivedFeatureOptions {
  features::SnrOptions snr;
  features::VesselnessOptions vesselness;
  features::ConfidenceOptions confidence;
  features::GradientOptions gradient;
  std::optional<std::int16_t> unknown;  ///< Stored value of voxels that no picture reached.
};

/// Signal-to-noise ratios as predicates read them lie within this on either side: more than the 883
/// that 8 bits can give. Saturated voxels of more bits give 10^5, beside which the steps of the
/// codes would be larger than the ratios of tissue.
inline constexpr double kMostSnr = 1000;

/// What a channel that predicates read is made from.
struct ChannelSource {
  bool derived = false;     ///< By add_derived_features().
  bool gradient = false;    ///< Smoothed as the set-up says.
  bool scan_lines = false;  ///< By the direction of scan lines, too.
};
/// All false: the volume itself, or something that only the user can give.
[[nodiscard]] ChannelSource source_of_channel(const std::string& channel);

/// Whether a predicate asks for scan lines, for itself or for what it reads.
[[nodiscard]] bool reads_scan_lines(const PredicateNeeds& needs);

/// Adds gradients, signal-to-noise ratio, vesselness and confidence where a predicate of the model
/// reads them (PredicateNeeds::channels) and they are not there yet; computes nothing else. They
/// are asked for all at once; waits for them. Gradients are those of the shares of white
/// (PredicateScene::intensity), per mm; the angle's are two features, along and across the scan
/// line, since angles cannot be interpolated. Signal is counted from PredicateScene::intensity's
/// black. Refuses angles and confidence without scan lines, confidence with a direction per voxel
/// but no feature depth, and whatever the features themselves do.
Result<void> add_derived_features(const std::shared_ptr<const Volume>& volume,
                                  const DerivedFeatureOptions& options,
                                  features::DerivedVolumes& service, PredicateScene& predicates);

/// Computes or finds one feature of that name.
using MakeFeature = std::function<Result<features::DerivedVolume>(const std::string& name,
                                                                  const features::DerivedRequest&)>;
/// The same, one after the other, by whoever knows how.
Result<void> add_derived_features(const std::shared_ptr<const Volume>& volume,
                                  const DerivedFeatureOptions& options, const MakeFeature& make,
                                  PredicateScene& predicates);

}  // namespace nav::render
