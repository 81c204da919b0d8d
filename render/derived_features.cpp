// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/derived_features.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace nav::render {
namespace {

/// A direction and a depth for each voxel, which scenes keep apart.
Result<derived::ScanLines> lines_per_voxel(const VoxelScan& scan, const VoxelGrid& grid,
                                           const Features& features) {
  const auto found = features.volumes.find(feature::kDepth);
  if (found == features.volumes.end()) {
    return Error{ErrorCode::kMalformedData,
                 "confidence: expected the depth of every voxel beside the direction of its scan "
                 "line, found no feature depth"};
  }
  const FeatureVolume& depth = found->second;
  std::vector<derived::PackedDirection> away(scan.into_ct->size());
  std::vector<float> depth_mm(depth.codes()->hu().size(), std::nanf(""));
  for (std::size_t i = 0; i < away.size(); ++i) {
    const Eigen::Vector3d into = (*scan.into_ct)[i].cast<double>();
    if (into.norm() > 0) away[i] = derived::PackedDirection::pack(into.normalized());
  }
  for (std::size_t i = 0; i < depth_mm.size(); ++i) {
    const std::int16_t code = depth.codes()->hu()[i];
    if (code == FeatureVolume::kUndefined) continue;
    depth_mm[i] = static_cast<float>(depth.offset() + depth.scale() * code);
  }
  return derived::ScanLines::per_voxel(grid, std::move(away), std::move(depth_mm));
}

Result<derived::ScanLines> lines_of(const PredicateScene& predicates, const VoxelGrid& grid) {
  const auto& scan = predicates.scan;
  if (!scan) {
    return Error{ErrorCode::kMalformedData,
                 "confidence: expected scan lines of the volume, found no scan geometry"};
  }
  if (const auto* parallel = std::get_if<ParallelScan>(&*scan)) {
    return derived::ScanLines::parallel(parallel->into_ct, parallel->face_ct);
  }
  if (const auto* fan = std::get_if<FanScan>(&*scan)) {
    return derived::ScanLines::fan(fan->apex_ct, fan->face_radius_mm);
  }
  return lines_per_voxel(std::get<VoxelScan>(*scan), grid, predicates.features);
}

/// NaN stays.
void limit(std::vector<float>& snr) {
  constexpr auto kMost = static_cast<float>(kMostSnr);
  for (float& x : snr) x = std::clamp(x, -kMost, kMost);
}

struct WantedFeature {
  std::string name;
  derived::DerivedRequest request;
};

/// What the model asks for and is not there.
Result<std::vector<WantedFeature>> wanted_features(const std::shared_ptr<const Volume>& volume,
                                                   const DerivedFeatureOptions& options,
                                                   const PredicateScene& predicates) {
  const auto kinds = kinds_of(predicates.model);
  const derived::ScalarVolume scalar = derived::ScalarVolume::of(volume, options.unknown);
  std::vector<WantedFeature> wanted;
  for (const auto& [name, how] :
       {std::pair<std::string, derived::DerivedOptions>{feature::kSnr, options.snr},
        {feature::kVesselness, options.vesselness},
        {feature::kConfidence, options.confidence}}) {
    if (kinds.count(name) == 0 || predicates.features.volumes.count(name) != 0) continue;
    WantedFeature one{name, {scalar, how, {}}};
    if (name == feature::kConfidence) {
      auto lines = lines_of(predicates, volume->grid());
      if (!lines) return lines.error();
      one.request.lines = *std::move(lines);
    }
    wanted.push_back(std::move(one));
  }
  return wanted;
}

Result<void> store_feature(const std::string& name, const Result<derived::DerivedVolume>& made,
                           PredicateScene& predicates) {
  if (!made) return made.error();
  std::vector<float> values = *made->volume.values;
  if (name == feature::kSnr) limit(values);
  auto stored = FeatureVolume::create(made->volume.grid, values, name);
  if (!stored) return stored.error();
  predicates.features.volumes.emplace(name, *std::move(stored));
  return {};
}

}  // namespace

Result<void> add_derived_features(const std::shared_ptr<const Volume>& volume,
                                  const DerivedFeatureOptions& options,
                                  derived::DerivedVolumes& service, PredicateScene& predicates) {
  const auto wanted = wanted_features(volume, options, predicates);
  if (!wanted) return wanted.error();
  std::vector<derived::DerivedVolumes::Ticket> tickets;
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

Result<void> add_derived_features(const std::shared_ptr<const Volume>& volume,
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
