// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "nav/result.hpp"
#include "render/engine.hpp"

namespace nav::bench {

struct PaperShaderOptions {
  bool reads = true;  ///< False: images stay on the device, and a black image is returned.
  /// Uses a compute shader; empty: if the device draws faster with it.
  std::optional<bool> compute;
  /// Interpolates in the shader instead of by the texture filter; empty: if the device's filter is
  /// coarse, as in the GL engine, because that filter gives a different image.
  std::optional<bool> manual_filter;
};

/// The method of Schulte zu Berge et al. 2014 in GLSL as they describe it: brute force, a texture
/// for each feature, Eqs. 3 to 8 and 10 to 12 for every sample; see shaders/paper_predicates.frag.
/// It is a comparison for measurements, on the device of the GL engine. It draws the volume by
/// predicates and nothing else; hues have the linear mean, whatever the scene says. Rejects
/// features with undefined voxels. kUnavailable without OpenGL.
Result<std::unique_ptr<render::Engine>> make_paper_shader(const PaperShaderOptions& options = {});

}  // namespace nav::bench
