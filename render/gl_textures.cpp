// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW first: every other GL header depends on it.
#include <algorithm>

#include "render/gl_textures.hpp"
#include "render/ray_spec.hpp"

namespace nav::render {
namespace {

void set_sampling(GLenum target, GLint filter) {
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
    glTexParameteri(target, axis, GL_CLAMP_TO_EDGE);
  }
}

/// Rows of our arrays are packed; VTK's own uploads find the state that they left.
class PackedRows {
 public:
  PackedRows() {
    glGetIntegerv(GL_UNPACK_ALIGNMENT, &before_);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  }
  ~PackedRows() { glPixelStorei(GL_UNPACK_ALIGNMENT, before_); }
  PackedRows(const PackedRows&) = delete;
  PackedRows& operator=(const PackedRows&) = delete;

 private:
  GLint before_ = 4;
};

std::string text_of(const std::array<int, 3>& size) {
  return std::to_string(size[0]) + " x " + std::to_string(size[1]) + " x " +
         std::to_string(size[2]);
}

}  // namespace

unsigned GlTexture::id() {
  if (id_ == 0) glGenTextures(1, &id_);
  return id_;
}

void GlTexture::release() {
  if (id_ != 0) glDeleteTextures(1, &id_);
  id_ = 0;
}

Result<void> GlTextures::update(const Scene& scene) {
  const PackedRows packed;
  if (auto sent = update_volume(scene.ct); !sent) return sent;
  update_transfer(scene.transfer);
  if (scene.quality.skip_empty_bricks && !bricks_valid_) update_bricks();
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  const auto fits = [&](const char* what, std::size_t count) -> Result<void> {
    if (count <= static_cast<std::size_t>(largest)) return {};
    return Error{ErrorCode::kUnsupportedData,
                 std::string(what) + ": expected at most " + std::to_string(largest) +
                     " on this OpenGL device, found " + std::to_string(count)};
  };
  if (auto ok = fits("spheres", scene.spheres.size()); !ok) return ok;
  if (scene.plane) {
    const Image2d<std::uint8_t>& pixels = scene.plane->frame.pixels;
    const int longest = std::max(pixels.width(), pixels.height());
    if (auto ok = fits("ultrasound picture edge", static_cast<std::size_t>(longest)); !ok)
      return ok;
    update_picture(pixels);
  }
  if (!scene.spheres.empty()) update_spheres(scene.spheres, scene.ct->grid());
  return {};
}

Result<void> GlTextures::update_volume(const std::shared_ptr<const Volume>& volume) {
  if (volume == volume_) return {};
  volume_ = nullptr;
  bricks_valid_ = false;
  const auto& size = volume->grid().size;
  const auto refused = [&](const std::string& limit) {
    return Error{ErrorCode::kUnsupportedData, volume->name() + ": expected a volume within " +
                                                  limit + ", found " + text_of(size) + " voxels"};
  };
  GLint largest = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &largest);
  if (std::max({size[0], size[1], size[2]}) > largest) {
    return refused("this OpenGL device's limit of " + std::to_string(largest) +
                   " voxels along an edge");
  }
  glTexImage3D(GL_PROXY_TEXTURE_3D, 0, GL_R16_SNORM, size[0], size[1], size[2], 0, GL_RED, GL_SHORT,
               nullptr);
  GLint accepted = 0;
  glGetTexLevelParameteriv(GL_PROXY_TEXTURE_3D, 0, GL_TEXTURE_WIDTH, &accepted);
  while (glGetError() != GL_NO_ERROR) {
  }
  if (accepted == 0) return refused("the memory of this OpenGL device's 3D textures");
  glBindTexture(GL_TEXTURE_3D, ct.id());
  set_sampling(GL_TEXTURE_3D, GL_LINEAR);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_R16_SNORM, size[0], size[1], size[2], 0, GL_RED, GL_SHORT,
               volume->hu().data());
  if (glGetError() != GL_NO_ERROR) return refused("the free memory of this OpenGL device");
  volume_ = volume;
  ++uploads_.volumes;
  return {};
}

void GlTextures::update_transfer(const TransferFunction& function) {
  if (function_ && same_classification(*function_, function)) return;
  function_ = function;
  table_.emplace(function);
  bricks_valid_ = false;
  glBindTexture(GL_TEXTURE_1D, transfer.id());
  set_sampling(GL_TEXTURE_1D, GL_NEAREST);
  glTexImage1D(GL_TEXTURE_1D, 0, GL_RGBA32F, table_->size(), 0, GL_RGBA, GL_FLOAT,
               table_->rgbat().data());
  ++uploads_.transfers;
}

void GlTextures::update_bricks() {
  if (ranges_volume_ != volume_) {
    ranges_ = make_brick_grid(*volume_, 0);
    ranges_volume_ = volume_;
  }
  const BrickDistances distances = brick_distances(ranges_, *table_);
  bricks_occupied_ = distances.occupied;
  glBindTexture(GL_TEXTURE_3D, bricks.id());
  set_sampling(GL_TEXTURE_3D, GL_NEAREST);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_R8UI, ranges_.count.x(), ranges_.count.y(), ranges_.count.z(),
               0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, distances.distance.data());
  bricks_valid_ = true;
  ++uploads_.bricks;
}

void GlTextures::update_picture(const Image2d<std::uint8_t>& pixels) {
  if (!pixels_.empty() && pixels_.pixels().data() == pixels.pixels().data()) return;
  pixels_ = pixels;
  glBindTexture(GL_TEXTURE_2D, picture.id());
  set_sampling(GL_TEXTURE_2D, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R8, pixels.width(), pixels.height(), 0, GL_RED,
               GL_UNSIGNED_BYTE, pixels.pixels().data());
  ++uploads_.pictures;
}

void GlTextures::update_spheres(const std::vector<SphereShape>& shapes, const VoxelGrid& grid) {
  // A few dozen bytes: cheaper to send than to compare.
  std::vector<float> rows;
  for (const SphereShape& shape : shapes) {
    const auto s = spec::make_sphere<float>(shape, grid);
    rows.insert(rows.end(), {s.a.x(), s.a.y(), s.a.z(), s.radius});
    rows.insert(rows.end(), {s.rgb.x(), s.rgb.y(), s.rgb.z(), s.alpha});
  }
  glBindTexture(GL_TEXTURE_2D, spheres.id());
  set_sampling(GL_TEXTURE_2D, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, 2, static_cast<GLsizei>(shapes.size()), 0, GL_RGBA,
               GL_FLOAT, rows.data());
}

void GlTextures::release() {
  for (GlTexture* texture : {&ct, &transfer, &bricks, &picture, &spheres}) texture->release();
  volume_ = nullptr;
  function_.reset();
  bricks_valid_ = false;
  pixels_ = {};
}

}  // namespace nav::render
