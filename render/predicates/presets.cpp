// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <map>

#include "render/predicates/model.hpp"

namespace nav::render {
namespace {

struct PresetEntry {
  PredicateEntry entry;
  PredicateHistogram::Bar bar;
};
using PresetEntries = std::vector<PresetEntry>;
using E = PredicateExpression;

constexpr double kAll = 1e6;

E bright(double low, double high = kAll) { return E::kind("intensity", {low, high}); }
E deep(double low_mm, double high_mm = 1e4) { return E::kind("depth", {low_mm, high_mm}); }
E textured(double low, double high) { return E::kind("snr", {low, high}); }
E steep(double low_per_mm) { return E::kind("gradient_magnitude", {low_per_mm, kAll}); }
E facing(double high_rad, double least_per_mm) {
  return E::kind("gradient_angle", {0, high_rad, least_per_mm});
}
E label(double mask) { return E::kind("label", {mask}); }

/// Figures 1 and 7 of the paper: (b) the surroundings of the vessel, (c) the vessel visible through
/// them.
PresetEntries carotid_context() {
  return {{{"interfaces", E::all({steep(0.12), bright(0.3), deep(7)})}, {0.6, 45, 0.55}},
          {{"tissue", E::all({bright(0.3), deep(7)})}, {0.4, 20, 0.35}},
          {{"skin", deep(-1e4, 7)}, {0, 20, 0.2}}};
}
PresetEntries carotid_vessel() {
  return {{{"vessel", E::all({E::kind("vesselness", {0.3, 1}), deep(5)})}, {0.7, 0, 0.85}},
          {{"tissue", E::all({bright(0.3), deep(6)})}, {0.25, 35, 0.25}},
          {{"skin", deep(-1e4, 6)}, {0.05, 20, 0.2}}};
}
/// Figure 6: (b) fibrous muscle, (c) the bone surface below it.
PresetEntries shoulder_muscle() {
  return {{{"fibres", E::all({textured(2, 6), bright(0.2), deep(6)})}, {0.6, 5, 0.6}},
          {{"tissue", E::all({bright(0.15), deep(6)})}, {0.4, 30, 0.15}},
          {{"skin", deep(-1e4, 6)}, {0, 20, 0.2}}};
}
PresetEntries shoulder_bone() {
  constexpr double kSixtyDeg = 1.0471975511965976;
  return {
      {{"bone surface", E::all({bright(0.65), facing(kSixtyDeg, 0.05), deep(14)})}, {0.7, 50, 0.6}},
      {{"muscle", E::all({textured(2, 6), deep(6)})}, {0.25, 5, 0.6}},
      {{"skin", deep(-1e4, 6)}, {0.05, 20, 0.2}}};
}
PresetEntries tendon() {
  return {{{"along the scan", facing(0.6, 0.03)}, {0.55, 45, 0.7}},
          {{"fibres", E::all({textured(1.5, 4), bright(0.25)})}, {0.3, 200, 0.4}},
          {{"tissue", bright(0.15)}, {0.15, 30, 0.1}}};
}
/// Figure 8: (b) the tendon by gradient angle and label, (c) the tendon with surrounding fibrous
/// muscle.
PresetEntries tendon_fibres() {
  constexpr double kFortyFiveDeg = 0.7853981633974483;
  return {{{"tendon", E::all({label(4), facing(kFortyFiveDeg, 0.03)})}, {0.8, 45, 0.7}},
          {{"tissue", E::all({bright(0.2), deep(3)})}, {0.2, 30, 0.15}}};
}
PresetEntries tendon_context() {
  return {{{"tendon", label(4)}, {0.65, 45, 0.7}},
          {{"muscle", E::all({textured(2, 5), bright(0.2), deep(3)})}, {0.3, 5, 0.5}},
          {{"skin", deep(-1e4, 3)}, {0.05, 20, 0.2}}};
}
PresetEntries layers() {
  return {{{"skin", label(1)}, {0.1, 25, 0.4}},
          {{"muscle", label(2)}, {0.3, 5, 0.6}},
          {{"target", label(4)}, {0.6, 50, 0.7}}};
}

/// Recorded volumes of the abdomen or pelvis, without scan lines: fluid-filled tubes, interfaces
/// and the tissue around them. Parts too small for an organ are left out.
PresetEntries abdomen() {
  return {{{"vessels", E::connected(E::kind("vesselness", {0.12, 1}), 150), 0.45}, {0.6, 215, 0.8}},
          {{"interfaces", E::connected(E::all({steep(0.06), bright(0.35)}), 60)}, {0.3, 45, 0.6}},
          {{"tissue", bright(0.12)}, {0.1, 25, 0.3}}};
}
/// Recorded volumes of thyroid and carotid artery, without scan lines: the artery and the vein as
/// tubes, the homogeneous gland, and the tissue around them.
PresetEntries thyroid() {
  return {
      {{"vessels", E::connected(E::kind("vesselness", {0.2, 1}), 60), 0.45}, {0.6, 0, 0.85}},
      {{"gland", E::connected(E::all({textured(2.5, 8), bright(0.2, 0.8)}), 300)}, {0.25, 45, 0.5}},
      {{"tissue", bright(0.15)}, {0.15, 25, 0.3}}};
}

const std::vector<std::pair<std::string, PresetEntries (*)()>>& presets() {
  static const std::vector<std::pair<std::string, PresetEntries (*)()>> all{
      {"carotid-context", carotid_context},
      {"carotid-vessel", carotid_vessel},
      {"shoulder-muscle", shoulder_muscle},
      {"shoulder-bone", shoulder_bone},
      {"tendon", tendon},
      {"tendon-fibres", tendon_fibres},
      {"tendon-context", tendon_context},
      {"layers", layers},
      {"abdomen", abdomen},
      {"thyroid", thyroid}};
  return all;
}

Result<PredicateModel> assemble(PresetEntries entries) {
  PredicateModel model;
  std::vector<PredicateHistogram::Bar> bars;
  for (PresetEntry& e : entries) {
    model.entries.push_back(std::move(e.entry));
    bars.push_back(e.bar);
  }
  auto histogram = PredicateHistogram::create(std::move(bars));
  if (!histogram) return histogram.error();
  model.histogram = *std::move(histogram);
  return model;
}

}  // namespace

std::vector<std::string> predicate_preset_names() {
  std::vector<std::string> names;
  for (const auto& [name, make] : presets()) names.push_back(name);
  return names;
}

Result<PredicateModel> preset_predicates(const std::string& name) {
  std::string known;
  for (const auto& [key, make] : presets()) {
    if (key == name) return assemble(make());
    known += (known.empty() ? "" : ", ") + key;
  }
  return Error{ErrorCode::kNotFound,
               "predicate preset: expected one of " + known + ", found \"" + name + "\""};
}

}  // namespace nav::render
