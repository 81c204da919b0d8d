// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <bit>
#include <optional>

#include "nav/index.hpp"
#include "render/gl/gl_packed_rays.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/gl/gl_upload.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

constexpr int kTile = 8;            // In pixels; whole squares of every pass.
constexpr float kSeesLive = -1e6F;  // Columns of the ultrasound image are greater.
constexpr float kNowhere = -1e9F;   // Same as in raycast.frag.

/// Adds in pairs, so that a mean does not depend on a direction: b is opposite a, d opposite c.
template <std::size_t kChannels>
std::array<float, kChannels> mean(const std::vector<std::array<float, kChannels>>& of,
                                  std::size_t a, std::size_t b) {
  std::array<float, kChannels> out;
  for (std::size_t i = 0; i < kChannels; ++i) out[i] = 0.5F * (of[a][i] + of[b][i]);
  return out;
}
template <std::size_t kChannels>
std::array<float, kChannels> mean(const std::vector<std::array<float, kChannels>>& of,
                                  std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
  std::array<float, kChannels> out;
  for (std::size_t i = 0; i < kChannels; ++i) {
    out[i] = 0.25F * ((of[a][i] + of[b][i]) + (of[c][i] + of[d][i]));
  }
  return out;
}

}  // namespace

PackedOrder PackedOrder::of(std::size_t count) {
  constexpr std::size_t kMostRows = 8192;
  PackedOrder order{64};
  while (count > as_size(order.columns) * kMostRows) order.columns *= 2;
  return order;
}

int PackedOrder::rows(std::size_t count) const {
  const std::size_t of_blocks = as_size(columns) * kBlock;
  return static_cast<int>((count + of_blocks - 1) / of_blocks) * kBlock;
}

std::array<int, 2> PackedOrder::place(std::size_t n) const {
  constexpr std::size_t kSize = kBlock * kBlock;
  const std::size_t across = as_size(columns) / kBlock;
  const std::size_t block = n / kSize;
  const auto within = static_cast<int>(n % kSize);
  return {static_cast<int>(block % across) * kBlock + within % kBlock,
          static_cast<int>(block / across) * kBlock + within / kBlock};
}

std::size_t GlPackedRays::texel_of(int x, int y) const {
  return as_size(height_ - 1 - y) * as_size(width_) + as_size(x);
}

Result<void> GlPackedRays::draw(const Scene& scene, const SparseRays& sparse,
                                const BrickShell* shell, bool plane, GlProgram& rays,
                                const std::function<void()>& draw_triangle, GlLayers& layers) {
  width_ = scene.width;
  height_ = scene.height;
  plane_ = plane;
  Eigen::Map<Eigen::Vector3f>(background_.data()) = scene.background_rgb.cast<float>();
  plane_opacity_ = scene.plane ? static_cast<float>(scene.plane->opacity) : 0;
  opaque_at_ = static_cast<float>(opaque_at(scene));
  const std::size_t count = as_size(width_) * as_size(height_);
  front_.assign(count, Texel{});
  spent_.assign(count, Texel{});
  behind_.assign(plane ? count : 0, Texel{});
  live_at_.assign(plane ? count : 0, {kNowhere, kNowhere});
  const Surfaces surfaces(scene);
  const auto view = spec::make_view<double>(scene.camera, width_, height_, scene.ct->grid());
  look_at_blocks(scene, view, shell);
  const PixelLattice lattice(width_, height_, sparse.stride);
  list_lattice(lattice);
  if (auto ok = cast_listed(rays, draw_triangle); !ok) return ok;
  for (int pass = 1; pass < lattice.passes(); ++pass) {
    const int side = lattice.side(pass);
    find_even(lattice, side, sparse.error);
    list_halves(lattice, side, surfaces, view);
    if (auto ok = cast_listed(rays, draw_triangle); !ok) return ok;
  }
  send(layers);
  return {};
}

void GlPackedRays::look_at_blocks(const Scene& scene, const spec::View<double>& view,
                                  const BrickShell* shell) {
  const SurfaceBounds bounds(scene);
  std::optional<VisibleSpans> spans;
  if (shell != nullptr && VisibleSpans::worth(scene, *shell)) spans.emplace(scene, *shell, 0);
  static_assert(VisibleSpans::kSide == kTile);
  blocks_across_ = (width_ + kTile - 1) / kTile;
  blocks_down_ = (height_ + kTile - 1) / kTile;
  blocks_.resize(as_size(blocks_across_) * as_size(blocks_down_));
  for_each_index(blocks_down_, 0, [&](int row) {
    for (int column = 0; column < blocks_across_; ++column) {
      const SurfaceReach reach = bounds.reach(view, column * kTile, row * kTile, kTile);
      const bool empty = spans && spans->at(column * kTile, row * kTile).empty();
      blocks_[as_size(row) * as_size(blocks_across_) + as_size(column)] = {!empty || reach.any(),
                                                                           reach};
    }
  });
}

/// Also writes the cost of pixels in blocks that can see nothing.
void GlPackedRays::list_lattice(const PixelLattice& lattice) {
  constexpr Texel kOneRay{0, 0, 0, 1};
  listed_.clear();
  for (int n = 0; n < blocks_across_ * blocks_down_; ++n) {
    const int left = n % blocks_across_ * kTile;
    const int top = n / blocks_across_ * kTile;
    const bool something = blocks_[as_size(n)].something;
    for (int y = top; y < std::min(top + kTile, height_); ++y) {
      for (int x = left; x < std::min(left + kTile, width_); ++x) {
        const bool on = ((x | y) & (lattice.stride - 1)) == 0;
        if (!something) {
          spent_[texel_of(x, y)] = kOneRay;  // A ray that took no sample.
        } else if (on || lattice.beyond(x, y)) {
          listed_.push_back(x | y << 16);
        }
      }
    }
  }
}

/// The colour around the ultrasound image, and the weight of that image, as the CPU engine keeps
/// them.
GlPackedRays::Texel GlPackedRays::compared_at(std::size_t texel) const {
  auto [r, g, b, alpha] = front_[texel];
  Texel out{r, g, b, 0};
  if (plane_ && live_at_[texel][0] > kSeesLive) {
    out[3] = (1 - alpha) * plane_opacity_;
    const float left = 1 - alpha - out[3];
    for (std::size_t c = 0; c < 3; ++c) out[c] += left * behind_[texel][c];
    alpha += out[3] + left * behind_[texel][3];
  }
  if (alpha >= opaque_at_) {
    for (float& part : out) part /= alpha;
  } else {
    for (std::size_t c = 0; c < 3; ++c) out[c] += (1 - alpha) * background_[c];
  }
  return out;
}

bool GlPackedRays::is_even(const std::array<Texel, 4>& corners, float error) {
  for (std::size_t i = 0; i < corners[0].size(); ++i) {
    const auto [low, high] =
        std::minmax({corners[0][i], corners[1][i], corners[2][i], corners[3][i]});
    const bool some_see = i == 3 && high > 0;
    if (!(high - low <= error) || (some_see && !(low > 0))) return false;
  }
  return true;
}

void GlPackedRays::find_even(const PixelLattice& lattice, int side, float error) {
  squares_across_ = lattice.last_x / side;
  const int down = lattice.last_y / side;
  even_.resize(as_size(squares_across_) * as_size(down));
  for_each_index(down, 0, [&](int row) {
    const auto edge = [&](int x) {
      return std::array{compared_at(texel_of(x, row * side)),
                        compared_at(texel_of(x, (row + 1) * side))};
    };
    auto left = edge(0);
    for (int column = 0; column < squares_across_; ++column) {
      const auto right = edge((column + 1) * side);
      even_[as_size(row) * as_size(squares_across_) + as_size(column)] =
          is_even({left[0], right[0], left[1], right[1]}, error) ? 1 : 0;
      left = right;
    }
  });
}

bool GlPackedRays::even_around(const PixelLattice& lattice, int x, int y, int side) const {
  return lattice.even_around(
      x, y, std::countr_zero(static_cast<unsigned>(side)), [this](int column, int row) {
        return even_[as_size(row) * as_size(squares_across_) + as_size(column)] != 0;
      });
}

void GlPackedRays::fill(int x, int y, int side) {
  const int across = x & (side - 1);
  const int down = y & (side - 1);
  const std::size_t to = texel_of(x, y);
  const std::size_t a = texel_of(x - across, y - down);
  const std::size_t b = texel_of(x + across, y + down);
  const bool two = across == 0 || down == 0;
  const std::size_t c = two ? a : texel_of(x - across, y + down);
  const std::size_t d = two ? b : texel_of(x + across, y - down);
  front_[to] = two ? mean(front_, a, b) : mean(front_, a, b, c, d);
  if (!plane_) return;
  behind_[to] = two ? mean(behind_, a, b) : mean(behind_, a, b, c, d);
  live_at_[to] = two ? mean(live_at_, a, b) : mean(live_at_, a, b, c, d);
}

/// Handles the middles of a pass' squares and of their edges: a mean, or an entry in the list.
void GlPackedRays::list_halves(const PixelLattice& lattice, int side, const Surfaces& surfaces,
                               const spec::View<double>& view) {
  const int step = side / 2;
  std::vector<std::vector<std::int32_t>> rows(as_size(blocks_down_));
  for_each_index(blocks_down_, 0, [&](int row) {
    auto& listed = rows[as_size(row)];
    for (int column = 0; column < blocks_across_; ++column) {
      const auto [something, reach] =
          blocks_[as_size(row) * as_size(blocks_across_) + as_size(column)];
      if (!something) continue;
      const int right = std::min((column + 1) * kTile - 1, lattice.last_x);
      const int bottom = std::min((row + 1) * kTile - 1, lattice.last_y);
      for (int y = row * kTile; y <= bottom; y += step) {
        for (int x = column * kTile; x <= right; x += step) {
          if (((x | y) & (side - 1)) == 0) continue;
          if (reach.shapes || !even_around(lattice, x, y, side) ||
              (reach.plane && surfaces.meets_border(spec::ray_of(view, x, y)))) {
            listed.push_back(x | y << 16);
          } else {
            fill(x, y, side);
          }
        }
      }
    }
  });
  listed_.clear();
  for (const auto& row : rows) listed_.insert(listed_.end(), row.begin(), row.end());
}

Result<void> GlPackedRays::make_room(int columns, int rows) {
  if (framebuffer_ != 0 && columns <= packed_columns_ && rows <= packed_rows_ &&
      packed_plane_ == plane_) {
    return {};
  }
  packed_columns_ = std::max(packed_columns_, columns);
  packed_rows_ = std::max(packed_rows_, rows);
  packed_plane_ = plane_;
  if (framebuffer_ == 0) glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glActiveTexture(GL_TEXTURE0 + kTarget);
  packed_.attach(packed_columns_, packed_rows_, plane_, false);
  return gl::complete_framebuffer();
}

Result<void> GlPackedRays::cast_listed(GlProgram& rays,
                                       const std::function<void()>& draw_triangle) {
  if (listed_.empty()) return {};
  const PackedOrder order = PackedOrder::of(listed_.size());
  const int rows = order.rows(listed_.size());
  if (auto ok = make_room(order.columns, rows); !ok) return ok;
  const std::size_t count = listed_.size();
  listed_.resize(as_size(order.columns) * as_size(rows), listed_.back());
  glActiveTexture(GL_TEXTURE0 + kRayList);
  gl::send_table(list_, GL_R32I, listed_);
  listed_.resize(count);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, order.columns, rows);
  rays.set("ray_columns", order.columns);
  draw_triangle();
  read_back(order.columns, rows);
  return {};
}

void GlPackedRays::read_back(int columns, int rows) {
  const auto scatter = [&](GLenum attachment, GLenum format, auto& to) {
    std::decay_t<decltype(to)> seen(as_size(columns) * as_size(rows));
    glReadBuffer(attachment);
    glReadPixels(0, 0, columns, rows, format, GL_FLOAT, seen.data());
    const PackedOrder order{columns};
    for (std::size_t n = 0; n < listed_.size(); ++n) {
      const auto [column, row] = order.place(n);
      to[texel_of(listed_[n] & 0xFFFF, listed_[n] >> 16)] =
          seen[as_size(row) * as_size(columns) + as_size(column)];
    }
  };
  scatter(GL_COLOR_ATTACHMENT0, GL_RGBA, front_);
  scatter(GL_COLOR_ATTACHMENT1, GL_RGBA, spent_);
  if (!plane_) return;
  scatter(GL_COLOR_ATTACHMENT2, GL_RGBA, behind_);
  scatter(GL_COLOR_ATTACHMENT3, GL_RG, live_at_);
}

void GlPackedRays::send(GlLayers& layers) const {
  const gl::PackedRows packed;
  glActiveTexture(GL_TEXTURE0 + kTarget);
  const auto send_one = [&](GlTexture& texture, GLenum format, const auto& texels) {
    glBindTexture(GL_TEXTURE_2D, texture.id());
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width_, height_, format, GL_FLOAT, texels.data());
  };
  send_one(layers.front, GL_RGBA, front_);
  send_one(layers.spent, GL_RGBA, spent_);
  if (plane_) {
    send_one(layers.behind, GL_RGBA, behind_);
    send_one(layers.live_at, GL_RG, live_at_);
  }
  glBindTexture(GL_TEXTURE_2D, 0);
}

void GlPackedRays::release() {
  packed_.release();
  if (framebuffer_ != 0) glDeleteFramebuffers(1, &framebuffer_);
  framebuffer_ = 0;
  packed_columns_ = packed_rows_ = 0;
  list_.release();
  front_ = spent_ = behind_ = {};
  live_at_ = {};
}

}  // namespace nav::render
