// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "render/cpu/cpu_surface_bounds.hpp"
#include "render/gl/gl_layers.hpp"
#include "render/gl/gl_program.hpp"
#include "render/quality/sparse_rays.hpp"
#include "render/skipping/visible_spans.hpp"

namespace nav::render {

/// The passes of sparse_rays.hpp if OpenGL runs on the processor. Rays are cast side by side in a
/// separate target, because software runs a program for several fragments at once, no matter how
/// many of them are wanted. Blocks of pixels that can see nothing get no rays. The results are
/// compared and averaged here, which costs a tenth of what a program does. Every function needs the
/// context current. Internal to render/.
class GlPackedRays {
 public:
  GlPackedRays() = default;
  ~GlPackedRays() { release(); }
  GlPackedRays(const GlPackedRays&) = delete;
  GlPackedRays& operator=(const GlPackedRays&) = delete;

  /// Draws a scene's image into the layers, which have its size. shell: of its volume; null: every
  /// pixel may see something. rays: program of raycast.frag, with its uniforms set. Leaves another
  /// framebuffer bound.
  Result<void> draw(const Scene& scene, const SparseRays& sparse, const BrickShell* shell,
                    bool plane, GlProgram& rays, const std::function<void()>& draw_triangle,
                    GlLayers& layers);
  void release();

 private:
  using Texel = std::array<float, 4>;

  [[nodiscard]] std::size_t texel_of(int x, int y) const;
  void look_at_blocks(const Scene& scene, const spec::View<double>& view, const BrickShell* shell);
  void list_lattice(const PixelLattice& lattice);
  void find_even(const PixelLattice& lattice, int side, float error);
  [[nodiscard]] Texel compared_at(std::size_t texel) const;
  /// Tests whether a square is even, from the texels of its corners.
  [[nodiscard]] static bool is_even(const std::array<Texel, 4>& corners, float error);
  [[nodiscard]] bool even_around(const PixelLattice& lattice, int x, int y, int side) const;
  void list_halves(const PixelLattice& lattice, int side, const Surfaces& surfaces,
                   const spec::View<double>& view);
  void fill(int x, int y, int side);
  Result<void> cast_listed(GlProgram& rays, const std::function<void()>& draw_triangle);
  Result<void> make_room(int columns, int rows);
  void read_back(int columns, int rows);
  void send(GlLayers& layers) const;

  int width_ = 0;
  int height_ = 0;
  bool plane_ = false;
  // Copied from the scene.
  std::array<float, 3> background_{};
  float plane_opacity_ = 0;
  float opaque_at_ = 1;
  // Texels of the layers; the lowest row of the image comes first.
  std::vector<Texel> front_, spent_, behind_;
  std::vector<std::array<float, 2>> live_at_;
  /// The objects that may be visible in a block of pixels.
  struct Block {
    bool something;
    SurfaceReach reach;
  };
  std::vector<Block> blocks_;
  int blocks_across_ = 0;
  int blocks_down_ = 0;
  std::vector<std::uint8_t> even_;  ///< For each square of this pass; 1: even.
  int squares_across_ = 0;
  std::vector<std::int32_t> listed_;  ///< Pixels that get rays: column | row << 16.

  GlLayers packed_;
  unsigned framebuffer_ = 0;
  int packed_columns_ = 0;
  int packed_rows_ = 0;
  bool packed_plane_ = false;
  GlTable list_;
};

/// Order of the fragments of a packed target: blocks of 4 × 4, row by row, as software processes
/// them. Same as in set_pixel() of shaders/include/sparse.glsl.
struct PackedOrder {
  static constexpr int kBlock = 4;
  int columns;  ///< Columns of the target, a multiple of kBlock.

  /// An order with enough rows for count fragments, at most 8192, which every device supports.
  static PackedOrder of(std::size_t count);
  [[nodiscard]] int rows(std::size_t count) const;
  /// Column and row of a fragment.
  [[nodiscard]] std::array<int, 2> place(std::size_t n) const;
};

}  // namespace nav::render
