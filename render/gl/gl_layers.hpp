// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/gl/gl_textures.hpp"

namespace nav::render {

/// The textures that shaders/raycast.frag writes, at its locations 0 to 3. Needs the context
/// current. Internal to render/.
struct GlLayers {
  GlTexture front;    ///< The whole image; with an ultrasound image, only what lies in front of it.
  GlTexture spent;    ///< The cost of the rays.
  GlTexture behind;   ///< Only with an ultrasound image, like live_at.
  GlTexture live_at;  ///< Column and row at which the ray meets the ultrasound image.

  /// Makes them targets of the framebuffer that is bound. plane: the scene has an ultrasound image.
  /// signatures: location 4 is drawn to as well; the caller owns its target.
  void attach(int width, int height, bool plane, bool signatures);
  void release();
};

}  // namespace nav::render
