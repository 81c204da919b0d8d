// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/anatomy/layout.hpp"

namespace nav::sim {

Patient make_abdomen(const PatientOptions& options) {
  auto phantom =
      std::make_shared<const AbdomenPhantom>(PhantomOptions{options.seed, options.contrast});
  Layout layout;
  layout.skin_mm = [phantom](const auto& p) {
    if constexpr (std::is_same_v<ScalarOf<decltype(p)>, double>) {
      return phantom->skin_distance_mm({p});
    } else {
      return Dual(phantom->skin_distance_mm({{p.x().value, p.y().value, p.z().value}}));
    }
  };
  const NeedlePlan plan = phantom->plan();
  const Vec3d lesion = plan.target_ct.mm;
  const Vec3d way_out = plan.entry_ct.mm - lesion;
  layout.view("lesion", convex_abdominal(), lesion, way_out, Vec3d::UnitZ());
  return {.family = "abdomen",
          .anatomy = std::move(phantom),
          .views = std::move(layout.views),
          .contrast = options.contrast,
          .plan = plan};
}

const std::vector<PatientFamily>& patient_families() {
  static const std::vector<PatientFamily> families = {
      {"abdomen", "liver with lesion and vessel trees, gallbladder, kidneys, spine, ribs, gas",
       make_abdomen},
      {"neck", "carotid bifurcations with plaque, jugular veins, thyroid, trachea, muscles, spine",
       make_neck},
      {"shoulder", "humeral head, rotator cuff with a tear, bursa, biceps tendon, deltoid, scapula",
       make_shoulder},
      {"tendon", "Achilles tendon with a tear, paratenon, bursa, heel bone, calf muscles",
       make_tendon},
      {"head", "skull with a craniotomy, folded cortex, ventricles, falx, arteries, tumour",
       make_head},
      {"spine", "lumbar vertebrae with arches and processes, canal, back muscles", make_spine},
  };
  return families;
}

Result<Patient> make_patient(const std::string& family, const PatientOptions& options) {
  std::string known;
  for (const PatientFamily& f : patient_families()) {
    if (f.name == family) {
      Patient patient = f.make(options);
      patient.contrast = options.contrast;
      return patient;
    }
    known += (known.empty() ? "" : ", ") + f.name;
  }
  return Error{ErrorCode::kUsage, "simulated patient: expected one of the families " + known +
                                      ", found '" + family + "'"};
}

}  // namespace nav::sim
