// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/tissue.hpp"

#include <array>
#include <cstddef>

#include "nav/check.hpp"
#include "sim/named_kind.hpp"

namespace nav::sim {
namespace {

/// Grey values: HU in three phases, and of MR.
struct Grey {
  double native, arterial, portal, mr;
};

struct Properties {
  const char* name;
  Grey grey;
  double sound_speed;
  Acoustics acoustics;
};

// HU: Kalender, Computed Tomography (2011), ch. 1, and usual contrast phases. Acoustics: Szabo,
// Diagnostic Ultrasound Imaging (2014), app. B. Scatter relative to liver: the same book and the
// usual appearance in B-mode (bile and blood nearly none, renal sinus bright). MR: the order of
// grey values of a spin echo at short TR and TE. Speeds of sound: Duck, Physical Properties of
// Tissue (1990), ch. 4, and Szabo.
constexpr std::array<Properties, static_cast<std::size_t>(Tissue::kCount)> kTable = {{
    {"air", {-1000, -1000, -1000, 0}, 1540, {0.0004F, 1.0F, 0.0F}},
    {"skin", {30, 40, 50, 420}, 1610, {1.72F, 0.70F, 1.6F}},
    {"fat", {-105, -105, -100, 900}, 1450, {1.38F, 0.50F, 0.45F}},
    {"muscle", {55, 60, 65, 330}, 1580, {1.67F, 0.70F, 0.6F}},
    {"peritoneal_fat", {-100, -100, -95, 880}, 1450, {1.40F, 0.50F, 1.9F}},
    {"bone", {900, 900, 900, 40}, 1540, {6.00F, 15.0F, 1.0F}},
    {"marrow", {180, 185, 200, 760}, 1540, {2.2F, 8.0F, 0.8F}},
    {"disc", {80, 80, 85, 300}, 1620, {1.75F, 1.0F, 0.5F}},
    {"spinal_canal", {25, 25, 25, 150}, 1515, {1.52F, 0.10F, 0.1F}},
    {"cartilage", {100, 100, 105, 380}, 1660, {1.85F, 2.2F, 0.35F}},
    {"lung", {-830, -825, -820, 20}, 1540, {0.18F, 20.0F, 1.0F}},
    {"diaphragm", {50, 55, 60, 300}, 1580, {1.72F, 0.8F, 2.2F}},
    {"liver", {58, 68, 112, 480}, 1580, {1.65F, 0.50F, 1.0F}},
    {"lesion", {42, 85, 70, 330}, 1560, {1.63F, 0.60F, 0.42F}},
    {"hepatic_vein", {42, 50, 165, 180}, 1575, {1.61F, 0.15F, 0.03F}},
    {"portal_vein", {42, 75, 180, 180}, 1575, {1.61F, 0.15F, 0.03F}},
    {"portal_wall", {50, 60, 100, 320}, 1600, {1.69F, 0.6F, 2.4F}},
    {"aorta", {42, 320, 165, 120}, 1575, {1.61F, 0.15F, 0.03F}},
    {"vena_cava", {42, 60, 145, 170}, 1575, {1.61F, 0.15F, 0.03F}},
    {"gallbladder_wall", {35, 45, 60, 360}, 1580, {1.70F, 0.6F, 2.0F}},
    {"bile", {6, 6, 8, 200}, 1530, {1.56F, 0.05F, 0.004F}},
    {"kidney_cortex", {34, 170, 175, 440}, 1565, {1.62F, 0.60F, 0.62F}},
    {"kidney_medulla", {30, 80, 150, 340}, 1565, {1.62F, 0.60F, 0.32F}},
    {"renal_sinus", {-60, -60, -40, 820}, 1470, {1.45F, 0.60F, 2.2F}},
    {"spleen", {48, 110, 120, 370}, 1570, {1.65F, 0.45F, 0.95F}},
    {"bowel_wall", {40, 60, 85, 360}, 1580, {1.66F, 0.7F, 0.5F}},
    {"bowel_content", {25, 25, 25, 250}, 1540, {1.60F, 0.8F, 1.1F}},
    {"gas", {-950, -950, -950, 0}, 1540, {0.0004F, 20.0F, 0.3F}},
    {"artery", {42, 330, 170, 110}, 1575, {1.61F, 0.15F, 0.03F}},
    {"vein", {42, 60, 160, 160}, 1575, {1.61F, 0.15F, 0.03F}},
    {"vessel_wall", {45, 60, 75, 320}, 1600, {1.71F, 0.8F, 0.2F}},
    {"plaque", {60, 65, 70, 360}, 1560, {1.66F, 0.9F, 0.8F}},
    {"calcification", {700, 700, 700, 60}, 1540, {4.8F, 12.0F, 1.4F}},
    {"thyroid", {105, 170, 165, 460}, 1560, {1.65F, 0.55F, 1.35F}},
    {"nerve", {32, 34, 38, 340}, 1630, {1.66F, 0.8F, 0.5F}},
    {"tendon", {85, 87, 90, 120}, 1700, {1.74F, 1.1F, 1.7F}},
    {"fascia", {40, 42, 45, 200}, 1600, {1.73F, 0.9F, 2.3F}},
    {"fluid", {12, 12, 14, 130}, 1525, {1.53F, 0.05F, 0.006F}},
    {"grey_matter", {38, 42, 44, 440}, 1541, {1.61F, 0.55F, 0.42F}},
    {"white_matter", {28, 30, 32, 560}, 1552, {1.62F, 0.60F, 0.62F}},
    {"cerebrospinal_fluid", {6, 6, 6, 130}, 1515, {1.52F, 0.02F, 0.006F}},
    {"dura", {55, 70, 80, 300}, 1600, {1.72F, 0.8F, 2.2F}},
    {"tumour", {36, 62, 70, 380}, 1550, {1.63F, 0.60F, 1.3F}},
    {"gel", {0, 0, 0, 60}, 1500, {1.60F, 0.05F, 0.0F}},
}};

const Properties& properties(Tissue tissue) {
  const auto index = static_cast<std::size_t>(tissue);
  NAV_CHECK(index < kTable.size(), index);
  return kTable[index];
}

}  // namespace

const char* to_string(Tissue tissue) { return properties(tissue).name; }

const char* to_string(Contrast contrast) {
  switch (contrast) {
    case Contrast::kNative:
      return "native";
    case Contrast::kArterial:
      return "arterial";
    case Contrast::kPortal:
      return "portal";
    case Contrast::kMr:
      return "mr";
  }
  return "unknown";
}

Result<Contrast> contrast_from(std::string_view name) {
  return kind_by_name(
      "contrast", {Contrast::kNative, Contrast::kArterial, Contrast::kPortal, Contrast::kMr}, name);
}

double tissue_hu(Tissue tissue, Contrast contrast) {
  const Properties& p = properties(tissue);
  if (contrast == Contrast::kNative) return p.grey.native;
  if (contrast == Contrast::kMr) return p.grey.mr;
  return contrast == Contrast::kArterial ? p.grey.arterial : p.grey.portal;
}

const Acoustics& tissue_acoustics(Tissue tissue) { return properties(tissue).acoustics; }

double sound_speed(Tissue tissue) { return properties(tissue).sound_speed; }

bool blocks_ultrasound(Tissue tissue) {
  return tissue == Tissue::kBone || tissue == Tissue::kMarrow || tissue == Tissue::kLung ||
         tissue == Tissue::kGas || tissue == Tissue::kAir || tissue == Tissue::kCalcification;
}

}  // namespace nav::sim
