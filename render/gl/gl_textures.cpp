// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <bit>
#include <sys/mman.h>

#include "nav/check.hpp"
#include "nav/large_pages.hpp"
#include "render/gl/gl_bricks.hpp"
#include "render/gl/gl_gradients.hpp"
#include "render/gl/gl_textures.hpp"
#include "render/gl/gl_upload.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {
namespace {

/// Sends rows if they differ from those on the device.
void send(GlRows&& rows, GlTexture& texture, GlRows& sent) {
  if (rows == sent || rows.height == 0) return;
  glBindTexture(GL_TEXTURE_2D, texture.id());
  gl::set_sampling(GL_TEXTURE_2D, GL_NEAREST);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, rows.width, rows.height, 0, GL_RGBA, GL_FLOAT,
               rows.texels.data());
  sent = std::move(rows);
}

/// Three texels for each entry, and for one before the first: shaders/include/preintegrated.glsl.
std::vector<std::int32_t> point_texels(const TransferTable& table) {
  const auto value = [&](int entry) {
    const float* at = table.rgbat().data() + std::size_t{4} * static_cast<std::size_t>(entry);
    return Eigen::Vector4f(at[0] * at[3], at[1] * at[3], at[2] * at[3], at[3]);
  };
  std::vector<std::int32_t> texels;
  texels.reserve(std::size_t{12} * static_cast<std::size_t>(table.size() + 1));
  const auto append = [&](const Eigen::Vector4f& numbers) {
    for (const float number : numbers) texels.push_back(std::bit_cast<std::int32_t>(number));
  };
  for (int i = -1; i < table.size(); ++i) {
    const int entry = std::max(i, 0);
    append(value(entry));
    append(value(std::min(i + 1, table.size() - 1)) - value(entry));
    const auto integral = table.integrals().begin() + std::ptrdiff_t{4} * entry;
    texels.insert(texels.end(), integral, integral + 4);
  }
  return texels;
}

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

unsigned GlTable::buffer_id() {
  if (buffer_ == 0) glGenBuffers(1, &buffer_);
  return buffer_;
}

void* GlTable::own_memory(std::size_t bytes) {
  void* at = mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                  MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (at == MAP_FAILED) return nullptr;
  ask_for_large_pages(at, bytes);
  memory_ = at;
  memory_bytes_ = bytes;
  return at;
}

void GlTable::release() {
  texture.release();
  if (memory_ != nullptr) glFinish();
  if (buffer_ != 0) glDeleteBuffers(1, &buffer_);
  buffer_ = 0;
  if (memory_ != nullptr) munmap(memory_, memory_bytes_);
  memory_ = nullptr;
}

Result<void> GlTextures::update(const Scene& scene) {
  const gl::PackedRows packed;
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  const auto fits = [&](const char* what, int count) -> Result<void> {
    if (count <= largest) return {};
    return Error{ErrorCode::kUnsupportedData,
                 std::string(what) + ": expected at most " + std::to_string(largest) +
                     " on this OpenGL device, found " + std::to_string(count)};
  };
  cut_ = spec::make_cutaway(scene, false);
  GlRows solids_now = solid_rows(scene);
  GlRows cut_now = cut_rows(cut_);
  if (auto ok = fits("needle, spheres and lines", solids_now.height); !ok) return ok;
  if (auto ok = fits("cutaway objects", cut_now.height); !ok) return ok;
  const bool plane = scene.plane && scene.plane->safety.state != SafetyState::kLost;
  if (plane) {
    const Image2d<std::uint8_t>& pixels = scene.plane->frame.pixels;
    if (auto ok =
            fits("edge of the ultrasound image, pixels", std::max(pixels.width(), pixels.height()));
        !ok)
      return ok;
  }
  if (auto sent = update_volume(scene.ct); !sent) return sent;
  if (scene.projection != Projection::kComposite) {
    if (scene.quality.skip_empty_bricks) update_brick_ranges();
  } else if (!scene.predicates) {
    update_transfer(scene.transfer);
    const bool needs_gradients = scene.shading.enabled || scene.transfer.uses_gradient();
    source_ = scene.gradient_source;
    if (needs_gradients && (source_ || (gradient_texture_ && !pairs_))) update_gradients();
    if (scene.quality.skip_empty_bricks && !bricks_valid_) update_bricks();
  }
  if (plane) update_image(scene.plane->frame.pixels);
  solid_count_ = solids_now.height;
  send(std::move(solids_now), solids, solid_rows_);
  send(std::move(cut_now), cut_objects, cut_rows_);
  return {};
}

void GlTextures::set_slices(bool wanted) {
  if (wanted == slices_) return;
  slices_ = wanted;
  // A texture keeps its kind for its whole life.
  ct.release();
  volume_ = nullptr;
}

bool GlTextures::accepts(const std::array<int, 3>& size) const {
  glTexImage3D(GL_PROXY_TEXTURE_3D, 0, GL_R16_SNORM, size[0], size[1], size[2], 0, GL_RED, GL_SHORT,
               nullptr);
  GLint accepted = 0;
  glGetTexLevelParameteriv(GL_PROXY_TEXTURE_3D, 0, GL_TEXTURE_WIDTH, &accepted);
  while (glGetError() != GL_NO_ERROR) {
  }
  return accepted != 0;
}

std::shared_ptr<const StoredVolume> GlTextures::fitting(
    const std::shared_ptr<const StoredVolume>& volume) {
  if (volume == full_) return fitted_;
  note_.clear();
  full_ = fitted_ = volume;
  if (limited_ != volume) most_voxels_ = std::numeric_limits<std::size_t>::max();
  GLint largest = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &largest);
  const auto& size = volume->grid().size;
  std::size_t most = std::min(volume->grid().voxel_count(), most_voxels_);
  const auto size_by = [&](const std::array<int, 3>& f) {
    return std::array<int, 3>{(size[0] + f[0] - 1) / f[0], (size[1] + f[1] - 1) / f[1],
                              (size[2] + f[2] - 1) / f[2]};
  };
  auto factors = factors_to_fit(size, std::min<int>(largest, largest_edge_), most);
  while (!accepts(size_by(factors)) && most > 1) {
    most /= 2;
    factors = factors_to_fit(size, std::min<int>(largest, largest_edge_), most);
  }
  if (factors == std::array<int, 3>{1, 1, 1}) return fitted_;
  const ReducedVolume smaller = reduced(*volume, factors);
  note_ = note_of(smaller, *volume);
  fitted_ = smaller.volume;
  return fitted_;
}

bool GlTextures::ask_for_less() {
  if (!out_of_memory_) return false;
  out_of_memory_ = false;
  most_voxels_ = fitted_->grid().voxel_count() / 2;
  limited_ = full_;
  full_ = fitted_ = nullptr;
  return most_voxels_ > 0;
}

Result<void> GlTextures::update_volume(const std::shared_ptr<const StoredVolume>& volume) {
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
  if (!accepts(size)) return refused("the memory of this OpenGL device's 3D textures");
  if (!send_volume(*volume) || volume->grid().voxel_count() > memory_voxels_) {
    out_of_memory_ = true;
    return refused("the free memory of this OpenGL device");
  }
  volume_ = volume;
  ++uploads_.volumes;
  return {};
}

void GlTextures::set_voxel_pairs(bool wanted) {
  if (wanted != wants_pairs_) volume_ = nullptr;
  wants_pairs_ = wanted;
}

bool GlTextures::send_volume(const StoredVolume& volume) {
  const auto& size = volume.grid().size;
  pairs_ = wants_pairs_ && gl::has_room_for_pairs(size, 1);
  if (pairs_) {
    ct.release();
    return gl::start_pairs(ct_pairs, size, 1) &&
           gl::fill_pairs(ct_pairs, 0, volume, {0, size[2]}, [](std::int16_t v) { return v; });
  }
  ct_pairs.release();
  const GLenum kind = gl::kind_of_volumes(slices_);
  glBindTexture(kind, ct.id());
  gl::set_sampling(kind, GL_LINEAR);
  glTexImage3D(kind, 0, GL_R16_SNORM, size[0], size[1], size[2], 0, GL_RED, GL_SHORT,
               volume.values().data());
  return glGetError() == GL_NO_ERROR;
}

void GlTextures::update_transfer(const TransferFunction& function) {
  if (function_ && same_classification(*function_, function)) return;
  function_ = function;
  table_.emplace(function);
  bricks_valid_ = false;
  gl::send_table(transfer, GL_RGBA32F, table_->rgbat());
  gl::send_table(importances, GL_R32F, table_->importance());
  gl::send_table(integrals, GL_RGBA32I, point_texels(*table_));
  ++uploads_.transfers;
}

void GlTextures::update_gradients() {
  const auto& of = source_ ? source_ : volume_;
  if (gradients_tried_ == of) return;
  gradients_tried_ = of;
  gradients_of_ = nullptr;
  // Another volume's gradients exist only as a texture, whatever their size.
  if (!source_ && of->grid().voxel_count() > kMostGradientVoxels) return;
  const std::vector<std::int16_t> differences = neighbour_differences(*of);
  if (differences.empty()) return;
  const auto& size = of->grid().size;
  glBindTexture(GL_TEXTURE_3D, gradients.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_LINEAR);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA16_SNORM, size[0], size[1], size[2], 0, GL_RGBA, GL_SHORT,
               differences.data());
  // Too little memory does not prevent drawing: six fetches from the CT take their place.
  if (glGetError() == GL_NO_ERROR) gradients_of_ = of;
}

void GlTextures::update_ranges() {
  if (ranges_volume_ == volume_) return;
  ranges_ = make_brick_grid(*volume_, 0);
  ranges_volume_ = volume_;
}

void GlTextures::update_brick_ranges() {
  update_ranges();
  if (brick_ranges_of_ == volume_) return;
  glBindTexture(GL_TEXTURE_3D, brick_ranges.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_NEAREST);
  const auto texels = brick_range_texels(ranges_);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RG16UI, ranges_.count.x(), ranges_.count.y(), ranges_.count.z(),
               0, GL_RG_INTEGER, GL_UNSIGNED_SHORT, texels.data());
  brick_ranges_of_ = volume_;
  ++uploads_.bricks;
}

void GlTextures::update_bricks() {
  update_ranges();
  if (part_ranges_of_ != volume_) part_ranges_ = make_part_grid(*volume_, 0);
  part_ranges_of_ = volume_;
  const BrickTexels made =
      brick_texels(ranges_, part_ranges_, hidden_bricks(ranges_, *table_, 0), *table_);
  bricks_occupied_ = made.occupied;
  glBindTexture(GL_TEXTURE_3D, bricks.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_NEAREST);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA8UI, ranges_.count.x(), ranges_.count.y(),
               ranges_.count.z(), 0, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE, made.texels.data());
  bricks_valid_ = true;
  ++uploads_.bricks;
}

void GlTextures::update_image(const Image2d<std::uint8_t>& pixels) {
  if (!pixels_.empty() && pixels_.pixels().data() == pixels.pixels().data()) return;
  pixels_ = pixels;
  glBindTexture(GL_TEXTURE_2D, image.id());
  gl::set_sampling(GL_TEXTURE_2D, GL_NEAREST);
  // 16 bits, because some devices interpolate no finer than the format.
  std::vector<std::uint16_t> values;
  values.reserve(pixels.pixels().size());
  for (const std::uint8_t value : pixels.pixels()) {
    values.push_back(static_cast<std::uint16_t>(value * 257));
  }
  glTexImage2D(GL_TEXTURE_2D, 0, GL_R16, pixels.width(), pixels.height(), 0, GL_RED,
               GL_UNSIGNED_SHORT, values.data());
  ++uploads_.images;
}

void GlTextures::release() {
  for (GlTexture* texture :
       {&ct, &gradients, &bricks, &brick_ranges, &image, &solids, &cut_objects}) {
    texture->release();
  }
  for (GlTable* table : {&transfer, &importances, &integrals, &ct_pairs}) table->release();
  volume_ = full_ = fitted_ = limited_ = gradients_of_ = gradients_tried_ = brick_ranges_of_ =
      source_ = nullptr;
  function_.reset();
  bricks_valid_ = false;
  pixels_ = {};
  solid_rows_ = {};
  cut_rows_ = {};
}

}  // namespace nav::render
