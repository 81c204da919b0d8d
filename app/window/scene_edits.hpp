// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/predicates/volume_scene.hpp"
#include "render/scene.hpp"
#include "session/critical_structures.hpp"

namespace nav::app {

/// Settings of a cutaway that the user edits; the objects that cut are the session's.
struct CutawayEdit {
  bool on = true;
  double theta1_rad = 0;
  double theta2_rad = 0;
  double overlay_mm = 0;  ///< Infinity: no clear region.
};
bool operator==(const CutawayEdit& a, const CutawayEdit& b);

/// Changes of the user to the session's scenes. Absent parts are the session's. A plain value
/// that does not change once it is shared.
struct SceneEdits {
  std::shared_ptr<const render::PredicateVolume> predicates{};
  std::optional<render::TransferFunction> transfer{};
  std::optional<CutawayEdit> cutaway{};
  std::optional<double> emphasis{};  ///< E of Burns et al. 2007 §3.2, [0, 1].
  std::optional<render::ShadingStyle> style{};
  std::vector<session::CriticalStructure::Sphere> structures{};  ///< Drawn as faint spheres.
};

/// Puts the changes into a scene of the session. Predicates of a needle that the scene does not
/// have are true nowhere.
void apply_edits_to(const SceneEdits& edits, render::Scene& scene);

}  // namespace nav::app
