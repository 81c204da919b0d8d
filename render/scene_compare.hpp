// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene.hpp"

namespace nav::render {

/// The part of an image that has to be made again, from the least work to the most.
enum class SceneChange {
  kNothing,   ///< The image stays as it is.
  kPixels,    ///< Only the pixels of the ultrasound image: no ray is cast.
  kGeometry,  ///< Plane, needle, spheres, lines or objects of the cutaway moved, appeared, vanished
              ///< or changed their state: rays that none of them affects stay.
  kView,      ///< Everything else.
};

/// Compares two scenes by value, but the CT and meshes by identity.
SceneChange change_between(const Scene& before, const Scene& after);

/// True if `after` is drawn by no predicates, or by the predicates of `before` in the same
/// combinations. Parameters, importances and colours may differ.
bool asks_same_predicates(const Scene& before, const Scene& after);

}  // namespace nav::render
