// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_kernel.hpp"
#include "render/cpu/cpu_kernel_cull.hpp"
#include "render/cpu/cpu_kernel_project.hpp"
#include "render/cpu/cpu_kernel_rays.hpp"

/// The march compiled for every key. See cpu_kernel.hpp for V and for the files that may include
/// this.
namespace nav::render {

template <class V, MarchClassify kClassify, MarchShade kShade, bool kFade, MarchCells kCells>
void march_with(const MarchInputs& in, RayPacket& rays, MarchCounts& counts) {
  for (int lane = 0; lane < kPacketLanes; lane += V::kLanes) {
    Marcher<V, kClassify, kShade, kFade, kCells>(in, rays, lane, counts).march();
  }
}

template <class V, MarchClassify kClassify, MarchShade kShade, bool kFade>
March composite_cells(const MarchKey& key) {
  switch (key.cells) {
    case MarchCells::kAll:
      return march_with<V, kClassify, kShade, kFade, MarchCells::kAll>;
    case MarchCells::kVisible:
      return march_with<V, kClassify, kShade, kFade, MarchCells::kVisible>;
  }
  return nullptr;
}

template <class V, MarchClassify kClassify, MarchShade kShade>
March composite_fading(const MarchKey& key) {
  return key.fade ? composite_cells<V, kClassify, kShade, true>(key)
                  : composite_cells<V, kClassify, kShade, false>(key);
}

template <class V, MarchClassify kClassify>
March composite_shading(const MarchKey& key) {
  switch (key.shade) {
    case MarchShade::kNone:
      return composite_fading<V, kClassify, MarchShade::kNone>(key);
    case MarchShade::kPhong:
      return composite_fading<V, kClassify, MarchShade::kPhong>(key);
    case MarchShade::kGooch:
      return composite_fading<V, kClassify, MarchShade::kGooch>(key);
  }
  return nullptr;
}

/// The instance for a key.
template <class V>
March composite_march(const MarchKey& key) {
  switch (key.classify) {
    case MarchClassify::kPreIntegrated:
      return composite_shading<V, MarchClassify::kPreIntegrated>(key);
    case MarchClassify::kPostClassified:
      return composite_shading<V, MarchClassify::kPostClassified>(key);
    case MarchClassify::kWindows:
      return composite_shading<V, MarchClassify::kWindows>(key);
  }
  return nullptr;
}

/// All functions compiled for one V.
template <class V>
MarchSet march_set() {
  return {.composite = composite_march<V>,
          .project = project_march<V>,
          .cull = cull_with<V>,
          .meet = meet_with<V>,
          .start = start_rays<V>,
          .aim = aim_cut_rays<V>};
}

}  // namespace nav::render
