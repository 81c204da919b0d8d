// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene.hpp"

namespace nav::render {

/// What of a picture has to be made anew, from the least work to the most.
enum class SceneChange {
  kNothing,   ///< The same picture.
  kPixels,    ///< Only the pixels of the ultrasound picture: no ray is cast.
  kGeometry,  ///< Plane, needle, spheres, lines or objects of the cutaway moved, appeared, vanished
              ///< or changed their state: rays that none of them affects stay.
  kView,      ///< Everything else.
};

/// Compares values; the CT and meshes by identity.
SceneChange change_between(const Scene& before, const Scene& after);

/// Whether the predicates that `after` is drawn by, if any, are those of `before` in the same
/// combinations: parameters, importances and colours may differ.
bool asks_same_predicates(const Scene& before, const Scene& after);

}  // namespace nav::render
