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
#include "render/interrupt.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// The cost of an image. Values that a scene did not need are zero.
struct RenderStatistics {
  std::uint64_t rays = 0;                ///< Rays that were cast; reused pixels are not counted.
  std::uint64_t pixels_without_ray = 0;  ///< Interpolated pixels, means of others: sparse_rays.hpp.
  std::uint64_t volume_samples = 0;      ///< Interpolated CT values that rays needed.
  std::uint64_t passed_samples = 0;      ///< Samples that rays skipped, see visible_cells.hpp.
  std::uint64_t gradient_samples = 0;    ///< Shaded samples.
  std::uint64_t window_gradients = 0;    ///< Gradients that gradient windows asked for.
  std::uint64_t cutaway_rays = 0;        ///< Rays that meet a surface of the cutaway in the volume.
  std::uint64_t faded_cells = 0;         ///< Cells sampled in front of the outer surface.
  std::uint64_t bricks = 0;
  std::uint64_t bricks_occupied = 0;
  double prepare_s = 0;      ///< Wall time to rebuild bricks, tables and uploads.
  double cast_s = 0;         ///< Wall time of the ray casting itself.
  bool provisional = false;  ///< Drawn from every 2nd or 4th voxel: Quality::provisional.
  std::string note{};        ///< One sentence: what was given up to draw; empty: nothing.
};

/// A finished image, composited over the background, top row first.
struct RenderedImage {
  Image2d<RgbaF> pixels;  ///< Alpha is 1 everywhere; colours in [0, 1].
  RenderStatistics statistics;
};

/// The 8-bit form: round(255 · clamp(x, 0, 1)). Every engine rounds in this way.
Image2d<Rgba8> to_8bit(const Image2d<RgbaF>& pixels);

/// Root mean square difference of the colours of two images of the same size.
double rms_difference(const Image2d<RgbaF>& a, const Image2d<RgbaF>& b);

/// One way to draw a scene. Not thread-safe. It caches what the last scenes needed: bricks keyed on
/// the volume, tables keyed on the transfer function.
class Engine {
 public:
  virtual ~Engine() = default;
  /// Stable lower-case name: "cpu", "gl", "reference".
  [[nodiscard]] virtual std::string name() const = 0;
  /// The device it runs on, for reports ("AVX-512, 2 threads", "llvmpipe (LLVM 15.0.6, 256 bits)").
  [[nodiscard]] virtual std::string device() const = 0;
  /// Draws a scene. Rejects an invalid scene; never returns a NaN pixel. An image that is
  /// interrupted ends with kCancelled, some milliseconds later on a processor; the images after it
  /// are those of an engine that was never interrupted. Data that the engine keeps for later images
  /// are completed first.
  Result<RenderedImage> render(const Scene& scene, const Interrupt& interrupt = {}) {
    return render_image(scene, interrupt);
  }

 private:
  virtual Result<RenderedImage> render_image(const Scene& scene, const Interrupt& interrupt) = 0;
};

/// The instructions that the CPU engine uses. All vector instruction sets draw the same bytes; the
/// portable one rounds products separately from sums.
enum class CpuLanes { kPortable, kAvx2, kAvx512, kFastest };

struct CpuOptions {
  int threads = 0;  ///< 0: all cores. The image does not depend on it, byte for byte.
  /// Other values are for tests and comparison. A processor without them uses fewer lanes.
  CpuLanes lanes = CpuLanes::kFastest;
};
/// A vectorised, multithreaded ray caster that needs no GPU.
std::unique_ptr<Engine> make_cpu_engine(const CpuOptions& options = {});

struct ReferenceOptions {
  int threads = 0;
};
/// Evaluates the same equations in double precision by brute force: no skipping, no early
/// termination.
std::unique_ptr<Engine> make_reference_engine(const ReferenceOptions& options = {});

struct GlOptions {
  /// Cast rays by compute shaders. They need OpenGL 4.3 and cast a ray for every pixel, whatever
  /// quality.pixel_error allows. Absent: used if they are measured to be faster.
  std::optional<bool> compute;
};
/// A GLSL ray caster inside a VTK render pass, off screen on EGL; needs no X server. Returns
/// kUnavailable, with the name of what is missing.
Result<std::unique_ptr<Engine>> make_gl_engine(Diagnostics& diagnostics,
                                               const GlOptions& options = {});

}  // namespace nav::render
