// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "render/transfer_function.hpp"

namespace nav::render {
namespace {

// Colours as anatomy atlases show them; HU ranges from clinical CT: fat -110…-70, muscle and
// unenhanced liver 40…70, enhanced liver 100…130, arterial contrast 200…450, cancellous bone
// 200…500, cortical bone above 700.

/// Bone alone, opaque; everything softer is invisible.
std::vector<TransferNode> bone() {
  return {{-1024, {0.80, 0.55, 0.40}, 0.0, 0.0}, {160, {0.80, 0.55, 0.40}, 0.0, 0.0},
          {260, {0.88, 0.70, 0.52}, 0.10, 0.4},  {420, {0.93, 0.84, 0.68}, 0.55, 0.8},
          {800, {0.96, 0.92, 0.82}, 0.92, 1.0},  {1800, {1.00, 0.98, 0.94}, 0.97, 1.0}};
}

/// Skin, muscle and organs as a faint body: 100 mm of liver let half of the light through, so a
/// plane inside stays readable; bone shines through as landmark.
std::vector<TransferNode> soft_tissue() {
  return {{-1024, {0.90, 0.72, 0.55}, 0.0, 0.0},    {-250, {0.90, 0.72, 0.55}, 0.0, 0.0},
          {-100, {0.93, 0.80, 0.58}, 0.0006, 0.05}, {0, {0.85, 0.58, 0.46}, 0.0035, 0.1},
          {60, {0.78, 0.40, 0.33}, 0.0065, 0.2},    {130, {0.80, 0.36, 0.30}, 0.0100, 0.3},
          {200, {0.88, 0.62, 0.50}, 0.030, 0.4},    {350, {0.93, 0.84, 0.68}, 0.18, 0.6},
          {800, {0.97, 0.93, 0.83}, 0.60, 0.8},     {1800, {1.00, 0.98, 0.94}, 0.80, 0.8}};
}

/// CT angiography: contrast-filled vessels red, bone ivory, organs a haze. The blurred rim of bone
/// passes through the vessels' HU, so red is denser than a rim is thick and thinner than a vessel.
/// Cancellous bone shares the vessels' HU; no 1D function can tell them apart.
std::vector<TransferNode> vessels() {
  return {{-1024, {0.80, 0.50, 0.42}, 0.0, 0.0}, {-30, {0.80, 0.50, 0.42}, 0.0, 0.0},
          {50, {0.80, 0.46, 0.38}, 0.0012, 0.1}, {125, {0.78, 0.30, 0.25}, 0.0025, 0.3},
          {160, {0.72, 0.10, 0.08}, 0.01, 0.9},  {220, {0.80, 0.08, 0.06}, 0.08, 1.0},
          {300, {0.86, 0.10, 0.07}, 0.21, 1.0},  {450, {0.90, 0.16, 0.10}, 0.25, 1.0},
          {540, {0.94, 0.86, 0.72}, 0.80, 0.6},  {800, {0.97, 0.93, 0.83}, 0.96, 0.6},
          {1800, {1.00, 0.98, 0.94}, 0.98, 0.6}};
}

struct Preset {
  const char* name;
  std::vector<TransferNode> (*nodes)();
};
constexpr std::array<Preset, 3> kPresets{
    {{"ct-bone", bone}, {"ct-soft-tissue", soft_tissue}, {"cta-vessels", vessels}}};

}  // namespace

Result<TransferFunction> preset_transfer_function(const std::string& name) {
  std::string known;
  for (const Preset& preset : kPresets) {
    if (name == preset.name) return TransferFunction::create(name, preset.nodes());
    known += (known.empty() ? "" : ", ") + std::string(preset.name);
  }
  return Error{ErrorCode::kNotFound,
               "transfer function: expected one of " + known + ", found " + name};
}

}  // namespace nav::render
