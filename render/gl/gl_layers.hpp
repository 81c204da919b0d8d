// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/gl/gl_textures.hpp"

namespace nav::render {

/// What shaders/raycast.frag writes, at its locations 0 to 3. Needs the context current. Internal
/// to render/.
struct GlLayers {
  GlTexture front;    ///< All of the picture, or with an ultrasound picture what is in front of it.
  GlTexture spent;    ///< What the rays cost.
  GlTexture behind;   ///< Only with an ultrasound picture, as live_at.
  GlTexture live_at;  ///< Column and row where the ray meets it.

  /// Makes them targets of the framebuffer that is bound. plane: with an ultrasound picture;
  /// signatures: location 4 is drawn to as well, its target is the caller's.
  void attach(int width, int height, bool plane, bool signatures);
  void release();
};

}  // namespace nav::render
