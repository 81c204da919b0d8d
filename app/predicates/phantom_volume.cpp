// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/phantom_volume.hpp"

#include <utility>

#include "sim/predicate_patient.hpp"

namespace nav::app {

Result<render::PredicateVolume> phantom_volume(const std::string& phantom, int side) {
  // Features are derived as in any other volume, not taken from the phantom's truth.
  auto made = phantom == "neck" ? sim::neck_volume(side) : sim::simulated_ultrasound(phantom, side);
  if (!made) return made.error();
  auto labels = render::LabelVolume::create(made->ultrasound->grid(), std::move(made->labels),
                                            std::move(made->labels_name));
  if (!labels) return labels.error();
  render::PredicateVolume out{std::move(made->name), std::move(made->ultrasound), {}};
  out.predicates.scan = render::ParallelScan{made->face_ct, made->into_ct};
  out.predicates.features.labels = *std::move(labels);
  return out;
}

}  // namespace nav::app
