// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/derived_features.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "nav/index.hpp"
#include "render/parallel.hpp"
#include "render/predicates/registry.hpp"

namespace nav::render {
namespace {

/// Combines the direction and the depth of each voxel, which scenes store separately. \p depth:
/// null if unknown.
Result<features::ScanLines> lines_per_voxel(const VoxelScan& scan, const VoxelGrid& grid,
                                            const FeatureVolume* depth) {
  std::vector<features::PackedDirection> away(scan.into_ct->size());
  std::vector<float> depth_mm(scan.into_ct->size(), std::nanf(""));
  const std::size_t slice = as_size(grid.size[0]) * as_size(grid.size[1]);
  for_each_index(grid.size[2], 0, [&](int k) {
    for (std::size_t i = as_size(k) * slice; i < (as_size(k) + 1) * slice; ++i) {
      const Eigen::Vector3d into = (*scan.into_ct)[i].cast<double>();
      if (into.norm() > 0) away[i] = features::PackedDirection::pack(into.stableNormalized());
      const std::int16_t code = depth != nullptr ? depth->codes()->values()[i] : std::int16_t{0};
      if (depth == nullptr || code == FeatureVolume::kUndefined) continue;
      depth_mm[i] = static_cast<float>(depth->offset() + depth->scale() * code);
    }
  });
  return features::ScanLines::per_voxel(grid, std::move(away), std::move(depth_mm));
}

const FeatureVolume* depth_of(const PredicateScene& predicates) {
  const auto found = predicates.features.volumes.find(feature::kDepth);
  return found == predicates.features.volumes.end() ? nullptr : &found->second;
}

/// Checks that a feature can use the scan lines of a scene.
Result<void> check_lines(const PredicateScene& predicates, const VoxelGrid& grid,
                         const std::string& name) {
  const auto& scan = predicates.scan;
  if (!scan) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected scan lines of the volume, found no scan geometry"};
  }
  if (std::holds_alternative<VoxelScan>(*scan) && depth_of(predicates) == nullptr &&
      name == feature::kConfidence) {
    return Error{
        ErrorCode::kMalformedData,
        "confidence: expected the feature depth beside the scan-line directions, found none"};
  }
  return validate(*scan, grid);
}

Result<features::ScanLines> lines_of(const PredicateScene& predicates, const VoxelGrid& grid) {
  if (const auto* parallel = std::get_if<ParallelScan>(&*predicates.scan)) {
    return features::ScanLines::parallel({parallel->into_ct.v.stableNormalized()},
                                         parallel->face_ct);
  }
  if (const auto* fan = std::get_if<FanScan>(&*predicates.scan)) {
    return features::ScanLines::fan(fan->apex_ct, fan->face_radius_mm);
  }
  return lines_per_voxel(std::get<VoxelScan>(*predicates.scan), grid, depth_of(predicates));
}

/// Clamps signal-to-noise ratios to kMostSnr. NaN stays NaN.
void limit(std::vector<float>& snr) {
  constexpr auto kMost = static_cast<float>(kMostSnr);
  for (float& x : snr) x = std::clamp(x, -kMost, kMost);
}

struct WantedFeature {
  std::string name;
  features::DerivedRequest request;
};

/// A feature, its source, and its options.
struct Feature {
  const char* name;
  ChannelSource source;
  features::DerivedOptions how;
};

std::vector<Feature> all_features(const DerivedFeatureOptions& options, double black) {
  using features::GradientPart;
  const auto gradient = [&](GradientPart part) {
    return features::GradientPartOptions{part, options.gradient};
  };
  features::SnrOptions snr = options.snr;
  snr.black = black;
  constexpr ChannelSource kPlain{true, false, false};
  constexpr ChannelSource kOfLines{true, false, true};
  constexpr ChannelSource kGradient{true, true, false};
  constexpr ChannelSource kGradientOfLines{true, true, true};
  return {{feature::kGradientMagnitude, kGradient, gradient(GradientPart::kMagnitude)},
          {feature::kGradientAlong, kGradientOfLines, gradient(GradientPart::kAlong)},
          {feature::kGradientAcross, kGradientOfLines, gradient(GradientPart::kAcross)},
          {feature::kSnr, kPlain, snr},
          {feature::kVesselness, kPlain, options.vesselness},
          {feature::kConfidence, kOfLines, options.confidence}};
}

/// Names of the channels that the predicates of a model read.
Result<std::set<std::string>> channels_of(const PredicateScene& predicates, const VoxelGrid& grid) {
  std::set<std::string> channels;
  for (const std::string& name : kinds_of(predicates.model)) {
    const auto kind = find_predicate_kind(name);
    if (!kind) return kind.error();
    const auto needs = (*kind)->needs({grid, predicates.scan, {}, {}});
    channels.insert(needs.channels.begin(), needs.channels.end());
  }
  return channels;
}

/// Features that the model uses and the scene does not have yet.
Result<std::vector<WantedFeature>> wanted_features(
    const std::shared_ptr<const StoredVolume>& volume, const DerivedFeatureOptions& options,
    const PredicateScene& predicates) {
  const auto channels = channels_of(predicates, volume->grid());
  if (!channels) return channels.error();
  const features::ScalarVolume scalar = features::ScalarVolume::of(volume, options.unknown);
  std::vector<WantedFeature> wanted;
  std::optional<features::ScanLines> lines;  // Shared by all features that need them.
  for (const Feature& one : all_features(options, predicates.intensity.black)) {
    const bool there = predicates.features.volumes.contains(one.name);
    if (!channels->contains(one.name) || there) continue;
    wanted.push_back({one.name, {scalar, one.how, {}}});
    if (!one.source.scan_lines) continue;
    if (auto ok = check_lines(predicates, volume->grid(), one.name); !ok) return ok.error();
    if (!lines) {
      auto found = lines_of(predicates, volume->grid());
      if (!found) return found.error();
      lines = *std::move(found);
    }
    wanted.back().request.lines = lines;
  }
  return wanted;
}

Result<void> store_feature(const std::string& name, const Result<features::DerivedVolume>& made,
                           PredicateScene& predicates) {
  if (!made) return made.error();
  std::vector<float> values = *made->volume.values;
  if (name == feature::kSnr) limit(values);
  if (source_of_channel(name).gradient) {
    const auto per_white =
        static_cast<float>(1 / (predicates.intensity.white - predicates.intensity.black));
    for (float& v : values) v *= per_white;
  }
  auto stored = FeatureVolume::create(made->volume.grid, values, name);
  if (!stored) return stored.error();
  predicates.features.volumes.emplace(name, *std::move(stored));
  return {};
}

}  // namespace

ChannelSource source_of_channel(const std::string& channel) {
  for (const Feature& one : all_features({}, 0)) {
    if (one.name == channel) return one.source;
  }
  return {};
}

bool reads_scan_lines(const PredicateNeeds& needs) {
  return needs.scan || std::ranges::any_of(needs.channels, [](const std::string& channel) {
           return source_of_channel(channel).scan_lines;
         });
}

Result<void> add_derived_features(const std::shared_ptr<const StoredVolume>& volume,
                                  const DerivedFeatureOptions& options,
                                  features::DerivedVolumes& service, PredicateScene& predicates) {
  const auto wanted = wanted_features(volume, options, predicates);
  if (!wanted) return wanted.error();
  std::vector<features::DerivedVolumes::Ticket> tickets;
  for (const WantedFeature& one : *wanted) {
    auto ticket = service.request(one.request);
    if (!ticket) return ticket.error();
    tickets.push_back(*std::move(ticket));
  }
  for (std::size_t n = 0; n < tickets.size(); ++n) {
    if (auto ok = store_feature((*wanted)[n].name, tickets[n].wait(), predicates); !ok) return ok;
  }
  return {};
}

Result<void> add_derived_features(const std::shared_ptr<const StoredVolume>& volume,
                                  const DerivedFeatureOptions& options, const MakeFeature& make,
                                  PredicateScene& predicates) {
  const auto wanted = wanted_features(volume, options, predicates);
  if (!wanted) return wanted.error();
  for (const auto& [name, request] : *wanted) {
    if (auto ok = store_feature(name, make(name, request), predicates); !ok) return ok;
  }
  return {};
}

}  // namespace nav::render
