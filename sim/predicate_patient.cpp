// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/predicate_patient.hpp"

#include <array>

#include "sim/anatomy/patient.hpp"
#include "sim/ultrasound_volume.hpp"

namespace nav::sim {
namespace {

/// A patient, one of the standard views, width and depth, and the target tissue.
struct Recipe {
  const char* name;
  const char* family;
  std::uint64_t seed;
  std::size_t view;
  double width_mm, depth_mm, thickness_mm;
  std::vector<Tissue> target;
};

Recipe carotid_of(const char* name, std::uint64_t seed) {
  return {.name = name,
          .family = "neck",
          .seed = seed,
          .view = 0,
          .width_mm = 36,
          .depth_mm = 40,
          .thickness_mm = 44,
          .target = {Tissue::kArtery, Tissue::kVesselWall}};
}

const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> all{carotid_of("carotid", 2),
                                       carotid_of("carotid-2", 5),
                                       {.name = "shoulder",
                                        .family = "shoulder",
                                        .seed = 1,
                                        .view = 0,
                                        .width_mm = 40,
                                        .depth_mm = 40,
                                        .thickness_mm = 40,
                                        .target = {Tissue::kBone}},
                                       {.name = "tendon",
                                        .family = "tendon",
                                        .seed = 1,
                                        .view = 0,
                                        .width_mm = 36,
                                        .depth_mm = 30,
                                        .thickness_mm = 44,
                                        .target = {Tissue::kTendon}}};
  return all;
}

Result<PredicatePhantom> acquire(const Recipe& recipe, int side) {
  const auto patient = make_patient(recipe.family, {recipe.seed, Contrast::kPortal});
  if (!patient) return patient.error();
  const StandardView& view = patient->views.at(recipe.view);
  UltrasoundVolumeOptions options;
  options.probe = view.probe;
  options.size = {side, side, side};
  options.width_mm = recipe.width_mm;
  options.depth_mm = recipe.depth_mm;
  options.thickness_mm = recipe.thickness_mm;
  auto scanned = scan_ultrasound_volume(*patient->anatomy, view.ct_from_image, options);
  if (!scanned) return scanned.error();
  auto labels = label_bits(*patient->anatomy, scanned->volume.grid(),
                           {{Tissue::kSkin, Tissue::kFat}, {Tissue::kMuscle}, recipe.target});
  return PredicatePhantom{
      .name = recipe.name,
      .ultrasound = std::make_shared<const StoredVolume>(std::move(scanned->volume)),
      .face_ct = scanned->face_ct,
      .into_ct = scanned->into_ct,
      .labels = std::move(labels),
      .labels_name = std::string(recipe.name) + ": truth"};
}

}  // namespace

std::string simulated_ultrasound_names() {
  std::string names;
  for (const Recipe& recipe : recipes())
    names += (names.empty() ? "" : ", ") + std::string(recipe.name);
  return names;
}

Result<PredicatePhantom> simulated_ultrasound(const std::string& name, int side) {
  for (const Recipe& recipe : recipes()) {
    if (name == recipe.name) return acquire(recipe, side);
  }
  return Error{ErrorCode::kUsage, "phantom: expected neck or one of " +
                                      simulated_ultrasound_names() + ", found '" + name + "'"};
}

}  // namespace nav::sim
