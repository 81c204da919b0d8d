// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Options of derive.
#include <algorithm>

#include "app/options/option_rows.hpp"

namespace nav::app {
namespace {

const std::vector<std::string_view> kDerive{"derive"};

/// None asked for: all of them are derived.
bool derives_any_of(const Settings& s, std::initializer_list<std::string_view> names) {
  const auto& asked = s.derive.features;
  return asked.empty() || std::ranges::any_of(asked, [&](const std::string& feature) {
           return std::ranges::count(names, feature) > 0;
         });
}

Requirement vesselness() {
  return {.met = [](const Settings& s) { return derives_any_of(s, {"vesselness"}); },
          .text = "--feature vesselness"};
}
Requirement scan_lines() {
  return {.met =
              [](const Settings& s) {
                return derives_any_of(s, {"confidence", "gradient-angle", "gradient-along",
                                          "gradient-across", "depth"});
              },
          .text = "--feature confidence, gradient-angle, gradient-along, gradient-across or depth"};
}
Requirement gradients() {
  return {.met =
              [](const Settings& s) {
                return derives_any_of(s, {"gradient-magnitude", "gradient-angle", "gradient-along",
                                          "gradient-across"});
              },
          .text =
              "--feature gradient-magnitude, gradient-angle, gradient-along or "
              "gradient-across"};
}
Requirement snr_or_gradients() {
  return {.met =
              [](const Settings& s) {
                return derives_any_of(s, {"snr", "gradient-magnitude", "gradient-angle",
                                          "gradient-along", "gradient-across"});
              },
          .text =
              "--feature snr, gradient-magnitude, gradient-angle, gradient-along or "
              "gradient-across"};
}
Requirement snr() {
  return {.met = [](const Settings& s) { return derives_any_of(s, {"snr"}); },
          .text = "--feature snr"};
}
Requirement confidence() {
  return {.met = [](const Settings& s) { return derives_any_of(s, {"confidence"}); },
          .text = "--feature confidence"};
}
Requirement values() {
  return {.met =
              [](const Settings& s) {
                return derives_any_of(s, {"snr", "vesselness", "confidence", "gradient-magnitude",
                                          "gradient-angle", "gradient-along", "gradient-across"});
              },
          .text = "a --feature of the values of the voxels",
          .found = [](const Settings&) -> std::string { return "depth"; }};
}

}  // namespace

void add_derive_rows(std::vector<Option>& rows) {
  using render::features::WindowWeights;
  const std::vector<Option> lines{
      {.name = "--into",
       .type = "X",
       .text = "direction of parallel scan lines, away from the probe, LPS",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.into),
       .unbounded = "any direction; 0 0 0 has none",
       .absent = "none",
       .usual = true,
       .needs = {scan_lines()},
       .excludes = {"--apex", "--scan-lines"}},
      {.name = "--face",
       .type = "MM",
       .unit = "mm",
       .text = "point of the plane where parallel scan lines have depth 0, LPS",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.face_mm),
       .range = of_point(),
       .absent = "the known voxel nearest to the probe",
       .needs = {scan_lines(), {.any_of = {{"--into"}}}}},
      {.name = "--apex",
       .type = "MM",
       .unit = "mm",
       .text = "apex of a fan of scan lines, LPS",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.apex_mm),
       .range = of_point(),
       .absent = "none",
       .usual = true,
       .needs = {scan_lines()},
       .excludes = {"--scan-lines"}},
      {.name = "--face-radius-mm",
       .type = "MM",
       .unit = "mm",
       .text = "radius of the probe face of a fan",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.face_radius_mm),
       .range = within(0, 1e4),
       .needs = {scan_lines(), {.any_of = {{"--apex"}}}}},
      {.name = "--scan-lines",
       .type = "FILE",
       .text = "file of the planes of the sweep that the volume was made from",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.scan_lines),
       .absent = "none",
       .needs = {scan_lines()}},
      {.name = "--black",
       .type = "X",
       .unit = "stored values",
       .text = "stored value of no intensity",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.black),
       .range = within(-2147483648.0, 2147483647),
       .needs = {snr_or_gradients()}},
      {.name = "--white",
       .type = "X",
       .unit = "stored values",
       .text = "stored value of full intensity; volumes of more than 8 bits need their own",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.white),
       .range = within(-2147483648.0, 2147483647),
       .usual = true,
       .needs = {gradients()}},
      {.name = "--unknown",
       .type = "N",
       .unit = "stored values",
       .text = "stored value of voxels that no image reached",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.unknown),
       .range = within(-32768, 32767),
       .absent = "none",
       .needs = {values()}},
      {.name = "--cache",
       .type = "DIR",
       .text = "folder that stores derived features for the next run",
       .group = group::kGroupScanLines,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.cache),
       .absent = "none"}};
  const std::vector<Option> features{
      {.name = "--feature",
       .type = "NAME",
       .text = "feature to derive; may be repeated",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.features),
       .choices = {"snr", "vesselness", "confidence", "gradient-magnitude", "gradient-angle",
                   "gradient-along", "gradient-across", "depth"},
       .absent = "all that can be derived",
       .usual = true,
       .repeats = true},
      {.name = "--smoothing-mm",
       .type = "MM",
       .unit = "mm",
       .text = "smoothing of gradients, as predicates read them",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.smoothing_mm),
       .range = within(0, 20),
       .needs = {gradients()}},
      {.name = "--snr-window",
       .type = "N",
       .unit = "voxels",
       .text = "side of the neighbourhood of the signal-to-noise ratio, odd",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.snr.window_voxels),
       .range = within(3, 31),
       .needs = {snr()}},
      {.name = "--snr-gaussian",
       .text = "Gaussian weights instead of equal ones in that neighbourhood",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .needs = {snr()},
       .take = [](Settings& s, const std::vector<std::string>&) -> Result<void> {
         s.derive.snr.weights = WindowWeights::kGaussian;
         return {};
       }},
      {.name = "--confidence-alpha",
       .type = "X",
       .text = "attenuation of the confidence",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.confidence.alpha),
       .range = within(0, 20),
       .needs = {confidence()}},
      {.name = "--confidence-beta",
       .type = "X",
       .text = "steepness of the confidence: how strongly differences of intensity separate",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.confidence.beta),
       .range = within(0, 1000),
       .needs = {confidence()}},
      {.name = "--confidence-gamma",
       .type = "X",
       .text = "penalty of the confidence across scan lines",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.confidence.gamma),
       .range = within(0, 1),
       .needs = {confidence()}},
      {.name = "--smallest-radius",
       .type = "MM",
       .unit = "mm",
       .text = "smallest radius of vessels",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.smallest_radius_mm),
       .range = within(1e-3, 100),
       .needs = {vesselness()}},
      {.name = "--largest-radius",
       .type = "MM",
       .unit = "mm",
       .text = "largest radius of vessels, at least the smallest",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.largest_radius_mm),
       .range = within(1e-3, 100),
       .needs = {vesselness()}},
      {.name = "--bright",
       .text = "vessels are brighter than their surroundings",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.bright_vessels),
       .needs = {vesselness()}},
      {.name = "--size",
       .type = "N",
       .unit = "pixels",
       .text = "longer side of each image",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.size_px),
       .range = within(64, 8192)},
      {.name = "--threads",
       .type = "N",
       .text = "threads of the derivation; 0: all cores",
       .group = group::kGroupFeatures,
       .verbs = kDerive,
       .slot = NAV_SLOT(derive.threads),
       .range = within(0, 1024)}};
  rows.insert(rows.end(), features.begin(), features.end());
  rows.insert(rows.end(), lines.begin(), lines.end());
}

}  // namespace nav::app
