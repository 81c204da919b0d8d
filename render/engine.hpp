// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// What a picture cost. Zero where a scene did not need it.
struct RenderStatistics {
  std::uint64_t rays = 0;                ///< Cast anew; pixels that could stay are not counted.
  std::uint64_t pixels_without_ray = 0;  ///< Means of their neighbours: sparse_rays.hpp.
  std::uint64_t volume_samples = 0;      ///< Interpolated CT values that rays needed.
  std::uint64_t passed_samples = 0;      ///< That they did not need, by visible_cells.hpp.
  std::uint64_t gradient_samples = 0;    ///< Shaded samples.
  std::uint64_t window_gradients = 0;    ///< Gradients that gradient windows asked for.
  std::uint64_t cutaway_rays = 0;  ///< Rays that a surface of the cutaway meets in the volume.
  std::uint64_t faded_cells = 0;   ///< Cells sampled in front of the outer surface.
  std::uint64_t bricks = 0;
  std::uint64_t bricks_occupied = 0;
  double prepare_s = 0;      ///< Wall time of what had to be rebuilt (bricks, tables, uploads).
  double cast_s = 0;         ///< Wall time of the ray casting itself.
  bool provisional = false;  ///< Drawn of every second or fourth voxel: Quality::provisional.
  std::string note{};        ///< What was given up to draw at all, one sentence; empty: nothing.
};

/// A finished picture, composited over the background, top row first.
struct RenderedImage {
  Image2d<RgbaF> pixels;  ///< Alpha is 1 everywhere; colours in [0, 1].
  RenderStatistics statistics;
};

/// 8-bit form: round(255 · clamp(x, 0, 1)). The same rounding for every engine.
Image2d<Rgba8> to_8bit(const Image2d<RgbaF>& pixels);

/// Root mean square over the colours of two pictures of one size.
double rms_difference(const Image2d<RgbaF>& a, const Image2d<RgbaF>& b);

/// One way to draw a scene. Not thread-safe; caches what the last scenes needed (bricks keyed on
/// the volume, tables keyed on the transfer function).
class Engine {
 public:
  virtual ~Engine() = default;
  /// Stable lower-case name: "cpu", "gl", "reference".
  [[nodiscard]] virtual std::string name() const = 0;
  /// What it runs on, for reports ("AVX-512, 2 threads", "llvmpipe (LLVM 15.0.6, 256 bits)").
  [[nodiscard]] virtual std::string device() const = 0;
  /// Refuses an invalid scene; never returns a NaN pixel.
  virtual Result<RenderedImage> render(const Scene& scene) = 0;
};

/// What the CPU engine computes with. The vector sets draw the same bytes; the portable one rounds
/// products apart from sums. kAvx512: voxels are fetched lane by lane; kFastest: or by gathers,
/// whichever is faster on this processor.
enum class CpuLanes { kPortable, kAvx2, kAvx512, kAvx512Gathers, kFastest };

struct CpuOptions {
  int threads = 0;  ///< 0: all cores. The picture does not depend on it, byte for byte.
  /// Other ones: for tests and comparison; less where the processor has less.
  CpuLanes lanes = CpuLanes::kFastest;
};
/// Vectorised multithreaded ray caster; needs no GPU.
std::unique_ptr<Engine> make_cpu_engine(const CpuOptions& options = {});

struct ReferenceOptions {
  int threads = 0;
};
/// The same equations in double precision, brute force, no skipping, no early termination.
std::unique_ptr<Engine> make_reference_engine(const ReferenceOptions& options = {});

struct GlOptions {
  /// Whether rays are cast by compute shaders, which need OpenGL 4.3 and cast one for every pixel,
  /// whatever quality.pixel_error allows. Absent: where they are measured to be faster.
  std::optional<bool> compute;
};
/// GLSL ray caster inside a VTK render pass, off screen on EGL; needs no X server. kUnavailable
/// names what is missing.
Result<std::unique_ptr<Engine>> make_gl_engine(Diagnostics& diagnostics,
                                               const GlOptions& options = {});

}  // namespace nav::render
