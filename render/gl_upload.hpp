// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <vector>
#include <vtk_glew.h>

#include "nav/result.hpp"
#include "render/gl_textures.hpp"
#include "render/parallel.hpp"

/// How textures are sent. Only for render/gl_*.cpp.
namespace nav::render::gl {

/// Filter, and edges that repeat the outermost texel, of the texture that is bound.
inline void set_sampling(GLenum target, GLint filter) {
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

/// Sends the 3D texture that is bound slab by slab, so that no copy of the whole is made. fill(k,
/// to) writes slice k, numbers one after another, per_texel of them for each texel; it is called on
/// several threads.
template <class T, class Fill>
void send_slices(GLint internal, GLenum format, GLenum type, const std::array<int, 3>& size,
                 std::size_t per_texel, const Fill& fill) {
  constexpr std::size_t kSlabBytes = std::size_t{4} << 20U;
  const std::size_t slice =
      static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * per_texel;
  const int slab = static_cast<int>(std::clamp<std::size_t>(kSlabBytes / (slice * sizeof(T)), 1,
                                                            static_cast<std::size_t>(size[2])));
  std::vector<T> texels(slice * static_cast<std::size_t>(slab));
  glTexImage3D(GL_TEXTURE_3D, 0, internal, size[0], size[1], size[2], 0, format, type, nullptr);
  for (int first = 0; first < size[2]; first += slab) {
    const int count = std::min(slab, size[2] - first);
    for_each_index(count, 0, [&](int k) {
      fill(first + k, texels.data() + static_cast<std::size_t>(k) * slice);
    });
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, first, size[0], size[1], count, format, type,
                    texels.data());
  }
}

/// Entries of a table, as a texture without filter or edges.
template <class T>
void send_table(GlTable& table, GLenum internal, const std::vector<T>& entries) {
  glBindBuffer(GL_TEXTURE_BUFFER, table.buffer_id());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(entries.size() * sizeof(T)),
               entries.data(), GL_STATIC_DRAW);
  glBindTexture(GL_TEXTURE_BUFFER, table.texture.id());
  glTexBuffer(GL_TEXTURE_BUFFER, internal, table.buffer_id());
  glBindBuffer(GL_TEXTURE_BUFFER, 0);
}

/// Makes a texture the target of the framebuffer that is bound.
inline void attach(GlTexture& texture, GLenum attachment, GLint format, int width, int height) {
  glBindTexture(GL_TEXTURE_2D, texture.id());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  const bool whole_numbers = format == GL_RG32UI;
  glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, whole_numbers ? GL_RG_INTEGER : GL_RGBA,
               whole_numbers ? GL_UNSIGNED_INT : GL_FLOAT, nullptr);
  glBindTexture(GL_TEXTURE_2D, 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, attachment, GL_TEXTURE_2D, texture.id(), 0);
}

inline Result<void> complete_framebuffer() {
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return {};
  return Error{ErrorCode::kUnavailable,
               "OpenGL: expected a single-precision colour target, found none"};
}

}  // namespace nav::render::gl
