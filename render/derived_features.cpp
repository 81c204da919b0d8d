// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/derived_features.hpp"

#include <string>
#include <utility>
#include <vector>

namespace nav::render {
namespace {

Result<derived::ScanLines> lines_of(const std::optional<ScanGeometry>& scan) {
  const std::string expected = "confidence: expected parallel scan lines or a fan, found ";
  if (!scan) return Error{ErrorCode::kMalformedData, expected + "no scan geometry"};
  if (const auto* parallel = std::get_if<ParallelScan>(&*scan)) {
    return derived::ScanLines::parallel(parallel->into_ct, parallel->face_ct);
  }
  if (const auto* fan = std::get_if<FanScan>(&*scan)) {
    return derived::ScanLines::fan(fan->apex_ct, fan->face_radius_mm);
  }
  return Error{ErrorCode::kUnsupportedData, expected + "a direction per voxel"};
}

}  // namespace

Result<void> add_derived_features(const std::shared_ptr<const Volume>& volume,
                                  const DerivedFeatureOptions& options,
                                  derived::DerivedVolumes& service, PredicateScene& predicates) {
  const auto kinds = kinds_of(predicates.model);
  const derived::ScalarVolume scalar = derived::ScalarVolume::of(volume);
  std::vector<std::pair<std::string, derived::DerivedVolumes::Ticket>> tickets;
  for (const auto& [name, how] :
       {std::pair<std::string, derived::DerivedOptions>{feature::kSnr, options.snr},
        {feature::kVesselness, options.vesselness},
        {feature::kConfidence, options.confidence}}) {
    if (kinds.count(name) == 0 || predicates.features.volumes.count(name) != 0) continue;
    derived::DerivedRequest request{scalar, how, {}};
    if (name == feature::kConfidence) {
      auto lines = lines_of(predicates.scan);
      if (!lines) return lines.error();
      request.lines = *std::move(lines);
    }
    auto ticket = service.request(request);
    if (!ticket) return ticket.error();
    tickets.emplace_back(name, *std::move(ticket));
  }
  for (const auto& [name, ticket] : tickets) {
    const auto made = ticket.wait();
    if (!made) return made.error();
    auto stored = FeatureVolume::create(made->volume.grid, *made->volume.values, name);
    if (!stored) return stored.error();
    predicates.features.volumes.emplace(name, *std::move(stored));
  }
  return {};
}

}  // namespace nav::render
