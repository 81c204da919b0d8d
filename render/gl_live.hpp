// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/scene.hpp"

namespace nav::render {

/// What has to be drawn again. Internal to render/.
enum class GlChange {
  kNothing,
  kPicture,  ///< Another ultrasound picture at the same place: the layers around it still hold.
  kAll,
};

/// Compares a scene with the one drawn before. The background is nobody's layer. Volumes and
/// pictures are compared by their storage, which is immutable once shared.
GlChange change_between(const Scene& before, const Scene& now);

}  // namespace nav::render
