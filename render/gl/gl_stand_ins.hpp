// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "render/gl/gl_textures.hpp"

namespace nav::render {

/// Textures of a few texels in place of those that the generic program of predicates could read but
/// a set does not need. Mesa's software rasteriser compiles a program again if a texture is bound
/// where there was none, if its format changes, or if its edges change to or from powers of two.
/// These stand-ins are of the kinds that features, undefined voxels and labels of up to 16
/// different bits have. Never read. Internal to render/; needs the context current.
class GlStandIns {
 public:
  /// Makes the stand-ins for a volume of this size, voxels.
  void update(const std::array<int, 3>& size);
  void release();
  [[nodiscard]] unsigned feature() { return feature_.id(); }
  [[nodiscard]] unsigned pairs() { return pairs_.texture.id(); }
  [[nodiscard]] unsigned undefined() { return undefined_.id(); }
  [[nodiscard]] unsigned labels() { return labels_.id(); }

 private:
  std::array<int, 3> size_{};
  GlTexture feature_, undefined_, labels_;
  GlTable pairs_;
};

}  // namespace nav::render
