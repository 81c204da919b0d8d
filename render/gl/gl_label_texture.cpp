// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <bit>
#include <functional>
#include <numeric>

#include "nav/index.hpp"
#include "render/gl/gl_label_texture.hpp"
#include "render/gl/gl_predicate_rows.hpp"
#include "render/gl/gl_upload.hpp"

namespace nav::render {
namespace {

std::size_t labels_a_slice(const LabelVolume& labels) {
  const auto& size = labels.grid().size;
  return as_size(size[0]) * as_size(size[1]);
}

/// The bits that occur in any voxel.
std::uint32_t bits_used(const LabelVolume& labels) {
  const std::size_t slice = labels_a_slice(labels);
  const int slices = labels.grid().size[2];
  std::vector<std::uint32_t> used(as_size(slices));
  for_each_index(slices, 0, [&](int k) {
    const auto here = labels.bits().subspan(as_size(k) * slice, slice);
    used[as_size(k)] = std::reduce(here.begin(), here.end(), std::uint32_t{0}, std::bit_or<>());
  });
  return std::reduce(used.begin(), used.end(), std::uint32_t{0}, std::bit_or<>());
}

template <class T>
void send_bits(const LabelVolume& labels, std::uint32_t kept, gl::SliceRange slices, GLint internal,
               GLenum type) {
  const std::size_t slice = labels_a_slice(labels);
  const auto fill = [&](int k, T* to) {
    const auto from = labels.bits().subspan(as_size(k) * slice, slice);
    // Usually the kept bits are the lowest ones, so nothing moves.
    if ((kept & (kept + 1)) == 0) {
      std::transform(from.begin(), from.end(), to,
                     [&](std::uint32_t b) { return static_cast<T>(b & kept); });
      return;
    }
    std::transform(from.begin(), from.end(), to,
                   [&](std::uint32_t b) { return static_cast<T>(packed_bits(b, kept)); });
  };
  gl::send_slices<T>(internal, GL_RED_INTEGER, type, labels.grid().size, slices, 1, fill);
}

}  // namespace

int GlLabelTexture::missing_slices(const LabelVolume& labels) const {
  const bool begun = labels_ && labels_->bits().data() == labels.bits().data();
  return labels.grid().size[2] - (begun ? slices_ : 0);
}

std::size_t GlLabelTexture::missing_bytes(const LabelVolume& labels) const {
  return as_size(missing_slices(labels)) * labels_a_slice(labels) * sizeof(std::uint32_t);
}

Result<void> GlLabelTexture::update(const LabelVolume& labels, gl::SendLimit& limit) {
  const int missing = missing_slices(labels);
  const int count = limit.take(missing, labels_a_slice(labels) * sizeof(std::uint32_t));
  if (count == 0) return {};
  const int begin = labels.grid().size[2] - missing;
  if (begin == 0) {
    // Nearly always the same kind of texture, because software rasterisers compile again for
    // another kind.
    const std::uint32_t all = bits_used(labels);
    const bool packs = std::popcount(all) <= 16;
    bits_ = packs ? all : ~0U;
    format_ = packs ? GL_R16UI : GL_R32UI;
  }
  labels_.reset();
  const gl::SliceRange slices{begin, begin + count};
  glBindTexture(GL_TEXTURE_3D, texture_.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_NEAREST);
  if (format_ == GL_R16UI) {
    send_bits<std::uint16_t>(labels, bits_, slices, format_, GL_UNSIGNED_SHORT);
  } else {
    send_bits<std::uint32_t>(labels, bits_, slices, format_, GL_UNSIGNED_INT);
  }
  if (glGetError() != GL_NO_ERROR) {
    return Error{
        ErrorCode::kUnsupportedData,
        labels.name() +
            ": the memory of this OpenGL device is full; the CPU engine draws such scenes"};
  }
  labels_ = labels;
  slices_ = slices.end;
  return {};
}

void GlLabelTexture::release() {
  texture_.release();
  labels_.reset();
  slices_ = 0;
}

}  // namespace nav::render
