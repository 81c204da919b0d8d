// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/transfer_presets.hpp"

#include <array>

namespace nav::render {
namespace {

// Colours follow anatomy atlases. HU ranges follow clinical CT: fat -110…-70, muscle and unenhanced
// liver 40…70, enhanced liver 100…130, arterial contrast 200…450, cancellous bone 200…500, cortical
// bone above 700.
//
// Importance follows Burns et al. 2007 §4: skin, fat and flesh have the lowest, organs half. What
// must stay in front of the plane has 0.99 (it vanishes only in the clear region) to 1 (it never
// vanishes).

using Nodes = std::vector<TransferNode>;
using Components = std::vector<TransferComponent>;

/// Only bone, opaque; everything softer is invisible.
Components bone() {
  return {{"bone",
           {{-1024, {0.80, 0.55, 0.40}, 0.0, 0.99},
            {160, {0.80, 0.55, 0.40}, 0.0, 0.99},
            {260, {0.88, 0.70, 0.52}, 0.10, 0.99},
            {420, {0.93, 0.84, 0.68}, 0.55, 0.99},
            {800, {0.96, 0.92, 0.82}, 0.92, 0.99},
            {1800, {1.00, 0.98, 0.94}, 0.97, 0.99}},
           {}}};
}

/// Skin, muscle and organs as a faint body: 100 mm of liver let half of the light through, so that
/// a plane inside stays readable. Bone shines through as a landmark.
Components soft_tissue() {
  return {{"body",
           {{-1024, {0.90, 0.72, 0.55}, 0.0, 0.02},
            {-250, {0.90, 0.72, 0.55}, 0.0, 0.02},
            {-100, {0.93, 0.80, 0.58}, 0.0006, 0.02},
            {0, {0.85, 0.58, 0.46}, 0.0035, 0.05},
            {60, {0.78, 0.40, 0.33}, 0.0065, 0.10},
            {130, {0.80, 0.36, 0.30}, 0.0100, 0.50},
            {200, {0.88, 0.62, 0.50}, 0.030, 0.70},
            {350, {0.93, 0.84, 0.68}, 0.18, 0.99},
            {800, {0.97, 0.93, 0.83}, 0.60, 0.99},
            {1800, {1.00, 0.98, 0.94}, 0.80, 0.99}},
           {}}};
}

/// Liver in the portal phase: the organ half transparent, its vessels solid, flesh and fat a haze.
Components liver() {
  return {{"skin and fat",
           {{-300, {0.93, 0.78, 0.60}, 0.0, 0.01},
            {-120, {0.93, 0.80, 0.58}, 0.0008, 0.01},
            {-40, {0.90, 0.74, 0.56}, 0.0008, 0.02},
            {0, {0.88, 0.66, 0.52}, 0.0, 0.02}},
           {}},
          {"flesh",
           {{-10, {0.80, 0.46, 0.38}, 0.0, 0.05},
            {30, {0.78, 0.42, 0.35}, 0.003, 0.10},
            {75, {0.74, 0.36, 0.30}, 0.005, 0.10},
            {100, {0.70, 0.34, 0.28}, 0.0, 0.10}},
           {}},
          {"organs",
           {{75, {0.62, 0.24, 0.17}, 0.0, 0.50},
            {100, {0.64, 0.25, 0.17}, 0.020, 0.50},
            {135, {0.68, 0.27, 0.19}, 0.020, 0.50},
            {165, {0.72, 0.30, 0.22}, 0.0, 0.50}},
           {}},
          {"vessels",
           {{145, {0.86, 0.38, 0.42}, 0.0, 1.0},
            {180, {0.92, 0.42, 0.46}, 0.10, 1.0},
            {260, {0.95, 0.46, 0.48}, 0.20, 1.0},
            {330, {0.95, 0.50, 0.48}, 0.0, 1.0}},
           {}},
          {"bone",
           {{240, {0.92, 0.82, 0.66}, 0.0, 0.99},
            {400, {0.94, 0.87, 0.73}, 0.40, 0.99},
            {800, {0.97, 0.93, 0.83}, 0.90, 0.99},
            {1800, {1.00, 0.98, 0.94}, 0.95, 0.99}},
           {}}};
}

/// CT angiography: contrast-filled vessels red, bone ivory, organs a haze. The blurred rim of bone
/// passes through the vessels' HU. So the density of red is chosen so that a thin rim stays faint
/// and a thick vessel becomes solid. Cancellous bone has the same HU as the vessels; no 1D function
/// can tell them apart.
Components vessels() {
  return {{"haze",
           {{-1024, {0.80, 0.50, 0.42}, 0.0, 0.05},
            {-30, {0.80, 0.50, 0.42}, 0.0, 0.05},
            {50, {0.80, 0.46, 0.38}, 0.0012, 0.10},
            {125, {0.78, 0.30, 0.25}, 0.0025, 0.50},
            {170, {0.74, 0.16, 0.13}, 0.0, 0.50}},
           {}},
          {"vessels",
           {{130, {0.72, 0.12, 0.10}, 0.0, 1.0},
            {160, {0.72, 0.10, 0.08}, 0.01, 1.0},
            {220, {0.80, 0.08, 0.06}, 0.08, 1.0},
            {300, {0.86, 0.10, 0.07}, 0.21, 1.0},
            {450, {0.90, 0.16, 0.10}, 0.25, 1.0},
            {540, {0.90, 0.20, 0.14}, 0.0, 1.0}},
           {}},
          {"bone",
           {{440, {0.94, 0.86, 0.72}, 0.0, 0.70},
            {540, {0.94, 0.86, 0.72}, 0.80, 0.70},
            {800, {0.97, 0.93, 0.83}, 0.96, 0.70},
            {1800, {1.00, 0.98, 0.94}, 0.98, 0.70}},
           {}}};
}

/// cta-vessels for the liver's veins in front of an ultrasound plane. Blurred rims of bone have the
/// HU of blood, but steeper slopes (300 HU/mm and more) than the rims of veins (below 60 HU/mm). So
/// a gradient window keeps ribs from being coated in red. It also removes thin arteries, because
/// they consist of rim only.
Components liver_vessels() {
  Components components = vessels();
  components[1].gradient = GradientWindow{0, 0, 60, 110};
  return components;
}

/// MR, in shares of the volume's value range: muscle is a haze, organs half transparent. What is
/// bright (fat, unless the sequence suppresses it) is a solid body that the cutaway takes away.
Components mr() {
  return {{"flesh",
           {{0.15, {0.80, 0.50, 0.42}, 0.0, 0.05},
            {0.30, {0.80, 0.50, 0.42}, 0.004, 0.05},
            {0.42, {0.82, 0.54, 0.44}, 0.006, 0.10},
            {0.50, {0.84, 0.58, 0.46}, 0.0, 0.10}},
           {}},
          {"organs",
           {{0.42, {0.80, 0.55, 0.42}, 0.0, 0.50},
            {0.50, {0.86, 0.62, 0.48}, 0.030, 0.50},
            {0.62, {0.90, 0.72, 0.58}, 0.030, 0.50},
            {0.72, {0.92, 0.78, 0.66}, 0.0, 0.50}},
           {}},
          {"bright",
           {{0.75, {0.95, 0.86, 0.74}, 0.0, 0.10},
            {0.95, {1.00, 0.95, 0.88}, 0.10, 0.10},
            {1.10, {1.00, 0.98, 0.95}, 0.20, 0.10}},
           {}}};
}

struct Preset {
  const char* name;
  Components (*components)();
  bool relative;  ///< Values are shares of the value range.
};
constexpr std::array<Preset, 6> kPresets{{{"ct-bone", bone, false},
                                          {"ct-soft-tissue", soft_tissue, false},
                                          {"ct-liver", liver, false},
                                          {"cta-vessels", vessels, false},
                                          {"cta-liver-vessels", liver_vessels, false},
                                          {"mr-default", mr, true}}};

Result<TransferFunction> preset_over(const std::string& name, const ValueRange& range) {
  std::string known;
  for (const Preset& preset : kPresets) {
    if (name == preset.name) {
      auto function = TransferFunction::blend(name, preset.components());
      if (!function || !preset.relative) return function;
      return rescaled(*function, {0, 1}, range);
    }
    known += (known.empty() ? "" : ", ") + std::string(preset.name);
  }
  return Error{ErrorCode::kNotFound,
               "transfer function: expected one of " + known + ", found " + name};
}

}  // namespace

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : kPresets) names.emplace_back(preset.name);
  return names;
}

Result<TransferFunction> preset_for(const std::string& name, const StoredVolume& volume) {
  for (const Preset& preset : kPresets) {
    // Only a relative preset reads the volume.
    if (preset.relative && name == preset.name) return preset_over(name, value_range(volume));
  }
  return preset_over(name, {0, 1});
}

Result<TransferFunction> preset_transfer_function(const std::string& name) {
  return preset_over(name, kNominalRange);
}

}  // namespace nav::render
