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
  bool reads = true;            ///< Else pictures stay on the device, and black is returned.
  std::optional<bool> compute;  ///< By a compute shader; empty: where the device draws faster so.
  /// Interpolates by hand; empty: where the device's own filter is coarse, as the GL engine, since
  /// that filter makes another picture.
  std::optional<bool> manual_filter;
};

/// Schulte zu Berge et al. 2014 as they describe it, in GLSL: brute force, a texture for each
/// feature, Eqs. 3 to 8 and 10 to 12 for every sample; see shaders/paper_predicates.frag. A peer
/// for measurements, on the device of the GL engine. Draws the volume by predicates and nothing
/// else; hues have the linear mean, whatever the scene says. Refuses features with undefined
/// voxels. kUnavailable without OpenGL.
Result<std::unique_ptr<render::Engine>> make_paper_shader(const PaperShaderOptions& options = {});

}  // namespace nav::bench
