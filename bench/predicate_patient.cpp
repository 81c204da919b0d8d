// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/predicate_patient.hpp"

#include <array>

#include "render/features/derived_features.hpp"
#include "sim/anatomy/patient.hpp"
#include "sim/ultrasound_volume.hpp"

namespace nav::bench {
namespace {

using sim::Tissue;

/// A patient, one of the standard views, width and depth, and preset predicate sets.
struct Recipe {
  const char* name;
  const char* family;
  std::uint64_t seed;
  std::size_t view;
  double width_mm, depth_mm, thickness_mm;
  std::vector<Tissue> target;
  std::vector<std::string> looks;
};

Recipe carotid_of(const char* name, std::uint64_t seed) {
  return {name,
          "neck",
          seed,
          0,
          36,
          40,
          44,
          {Tissue::kArtery, Tissue::kVesselWall},
          {"carotid-context", "carotid-vessel"}};
}

const std::vector<Recipe>& recipes() {
  static const std::vector<Recipe> all{carotid_of("carotid", 2),
                                       carotid_of("carotid-2", 5),
                                       {"shoulder",
                                        "shoulder",
                                        1,
                                        0,
                                        40,
                                        40,
                                        40,
                                        {Tissue::kBone},
                                        {"shoulder-muscle", "shoulder-bone"}},
                                       {"tendon",
                                        "tendon",
                                        1,
                                        0,
                                        36,
                                        30,
                                        44,
                                        {Tissue::kTendon},
                                        {"tendon-fibres", "tendon-context"}}};
  return all;
}

Result<render::LabelVolume> truth_of(const sim::Patient& patient, const Recipe& recipe,
                                     const VoxelGrid& grid) {
  return render::LabelVolume::create(
      grid,
      sim::label_bits(*patient.anatomy, grid,
                      {{Tissue::kSkin, Tissue::kFat}, {Tissue::kMuscle}, recipe.target}),
      std::string(recipe.name) + ": truth");
}

Result<PredicateVolume> acquire(const Recipe& recipe, int side) {
  const auto patient = sim::make_patient(recipe.family, {recipe.seed, sim::Contrast::kPortal});
  if (!patient) return patient.error();
  const sim::StandardView& view = patient->views.at(recipe.view);
  sim::UltrasoundVolumeOptions options;
  options.probe = view.probe;
  options.size = {side, side, side};
  options.width_mm = recipe.width_mm;
  options.depth_mm = recipe.depth_mm;
  options.thickness_mm = recipe.thickness_mm;
  auto scanned = sim::scan_ultrasound_volume(*patient->anatomy, view.ct_from_image, options);
  if (!scanned) return scanned.error();
  PredicateVolume out{
      recipe.name, std::make_shared<const Volume>(std::move(scanned->volume)), {}, {}};
  out.predicates.scan = render::ParallelScan{scanned->face_ct, scanned->into_ct};
  auto labels = truth_of(*patient, recipe, out.ultrasound->grid());
  if (!labels) return labels.error();
  out.predicates.features.labels = *std::move(labels);
  for (const std::string& look : recipe.looks) {
    const auto model = render::preset_predicates(look);
    if (!model) return model.error();
    out.looks.push_back({look, *model});
  }
  return out;
}

}  // namespace

std::string simulated_ultrasound_names() {
  std::string names;
  for (const Recipe& recipe : recipes())
    names += (names.empty() ? "" : ", ") + std::string(recipe.name);
  return names;
}

Result<PredicateVolume> simulated_ultrasound(const std::string& name, int side) {
  for (const Recipe& recipe : recipes()) {
    if (name == recipe.name) return acquire(recipe, side);
  }
  return Error{ErrorCode::kUsage, "phantom: expected neck or one of " +
                                      simulated_ultrasound_names() + ", found '" + name + "'"};
}

Result<void> add_features(const render::PredicateModel& model, PredicateVolume& volume) {
  volume.predicates.model = model;
  render::DerivedFeatureOptions derive;
  derive.gradient.smoothing_mm = render::features::kUsualSmoothingMm;
  derive.vesselness.smallest_radius_mm = 2;  // Smallest radius of a carotid artery.
  derive.vesselness.largest_radius_mm = 4.5;
  render::features::DerivedVolumes service;
  return render::add_derived_features(volume.ultrasound, derive, service, volume.predicates);
}

}  // namespace nav::bench
