// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>
#include <vtk_glew.h>

#include "nav/result.hpp"
#include "render/gl/gl_textures.hpp"
#include "render/parallel.hpp"

/// Sending of textures. Only for render/gl/*.cpp.
namespace nav::render::gl {

/// Sets the filter of the texture that is bound, and makes its edges repeat the outermost texel.
inline void set_sampling(GLenum target, GLint filter) {
  glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
  for (const GLenum axis : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T, GL_TEXTURE_WRAP_R}) {
    glTexParameteri(target, axis, GL_CLAMP_TO_EDGE);
  }
}

/// The kind of texture in which volumes are kept: GlTextures::set_slices().
inline GLenum kind_of_volumes(bool slices) { return slices ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_3D; }

/// Bindings at which compute shaders find tables as storage buffers, which some devices read faster
/// than textures: the bindings in shaders/include/ where STORAGE is defined.
enum StorageUnit { kOpacityStorage, kAppearancesStorage, kPointsStorage, kTransferStorage };

inline void bind_storage(StorageUnit unit, unsigned buffer) {
  if (GLEW_VERSION_4_3 != 0) glBindBufferBase(GL_SHADER_STORAGE_BUFFER, unit, buffer);
}

/// True if the device can hold a volume as an array of slices.
inline bool fits_slices(const std::array<int, 3>& size) {
  GLint edge = 0;
  GLint slices = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &edge);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &slices);
  return size[0] <= edge && size[1] <= edge && size[2] <= slices;
}

/// Sets packed rows, as our arrays have them, and restores the state for VTK's own uploads.
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

inline std::uint32_t pair_of(std::int16_t low, std::int16_t high) {
  return static_cast<std::uint16_t>(low) |
         static_cast<std::uint32_t>(static_cast<std::uint16_t>(high)) << 16U;
}

/// The number of bytes that may still be sent.
struct SendLimit {
  std::size_t bytes = std::numeric_limits<std::size_t>::max();
  /// Takes as many of the slices as the limit allows: at least one, or none if no bytes are left.
  int take(int slices, std::size_t slice_bytes) {
    if (bytes == 0) return 0;
    const std::size_t most = std::max<std::size_t>(bytes / slice_bytes, 1);
    const std::size_t taken = std::min(most, static_cast<std::size_t>(slices));
    bytes -= std::min(bytes, taken * slice_bytes);
    return static_cast<int>(taken);
  }
};

/// Slices [begin, end) of a volume.
struct SliceRange {
  int begin;
  int end;
};

/// Sends slices of the 3D texture that is bound, slab by slab, so that the whole is never copied.
/// The first slice creates a new texture. fill(k, to) writes slice k as a sequence of numbers,
/// per_texel for each texel; it is called on several threads.
template <class T, class Fill>
void send_slices(GLint internal, GLenum format, GLenum type, const std::array<int, 3>& size,
                 SliceRange slices, std::size_t per_texel, const Fill& fill) {
  constexpr std::size_t kSlabBytes = std::size_t{4} << 20U;
  const std::size_t slice =
      static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * per_texel;
  const int slab = static_cast<int>(std::clamp<std::size_t>(kSlabBytes / (slice * sizeof(T)), 1,
                                                            static_cast<std::size_t>(size[2])));
  std::vector<T> texels(slice * static_cast<std::size_t>(slab));
  if (slices.begin == 0) {
    glTexImage3D(GL_TEXTURE_3D, 0, internal, size[0], size[1], size[2], 0, format, type, nullptr);
  }
  for (int first = slices.begin; first < slices.end; first += slab) {
    const int count = std::min(slab, slices.end - first);
    for_each_index(count, 0, [&](int k) {
      fill(first + k, texels.data() + static_cast<std::size_t>(k) * slice);
    });
    glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, first, size[0], size[1], count, format, type,
                    texels.data());
  }
}

/// Number of words of a volume's pairs. Beyond the last voxel the shader reads a slice, a row and a
/// word whose weight is zero.
inline std::size_t words_of_pairs(const std::array<int, 3>& size) {
  const auto row = static_cast<std::size_t>(size[0]);
  const std::size_t slice = row * static_cast<std::size_t>(size[1]);
  return slice * static_cast<std::size_t>(size[2]) + slice + row + 1;
}

/// True if a table of this many volumes is within the device's limit.
inline bool has_room_for_pairs(const std::array<int, 3>& size, std::size_t volumes) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  return volumes * words_of_pairs(size) + 256 <= static_cast<std::size_t>(most);
}

/// Makes room for the pairs of this many volumes, which fill_pairs() fills. Returns false if the
/// device has no room.
inline bool start_pairs(GlTable& table, const std::array<int, 3>& size, std::size_t volumes) {
  std::size_t bytes = volumes * words_of_pairs(size) * sizeof(std::uint32_t);
  // See send_roomy_table() of render/gl/gl_predicates.cpp.
  if ((bytes >> 8U & 0xFFU) == 0) bytes += 256;
  table.release();
  // The rasteriser would first fill memory of its own with zeros, on one core: half of the time of
  // sending. So the words lie in our memory, if it can use that.
  constexpr GLenum kOurs = 0x9160;  // GL_EXTERNAL_VIRTUAL_MEMORY_BUFFER_AMD
  if (GLEW_AMD_pinned_memory != 0) {
    if (void* memory = table.own_memory(bytes)) {
      glBindBuffer(kOurs, table.buffer_id());
      glBufferData(kOurs, static_cast<GLsizeiptr>(bytes), memory, GL_STREAM_DRAW);
      glBindBuffer(kOurs, 0);
      if (glGetError() != GL_NO_ERROR) table.release();
    }
  }
  glBindBuffer(GL_TEXTURE_BUFFER, table.buffer_id());
  if (table.memory() == nullptr) {
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STATIC_DRAW);
  }
  glBindTexture(GL_TEXTURE_BUFFER, table.texture.id());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_R32I, table.buffer_id());
  glBindBuffer(GL_TEXTURE_BUFFER, 0);
  return glGetError() == GL_NO_ERROR;
}

/// Writes slices of a volume as the words of one of the volumes of a table. The high half of a word
/// holds the next voxel of the row: VOXEL_PAIRS of shaders/include/ct.glsl. value_of: maps a voxel
/// to its value.
template <class Value>
bool fill_pairs(GlTable& table, std::size_t which, const StoredVolume& volume, SliceRange slices,
                const Value& value_of) {
  const auto& size = volume.grid().size;
  const auto row = static_cast<std::size_t>(size[0]);
  const std::size_t slice = row * static_cast<std::size_t>(size[1]);
  const std::size_t count = words_of_pairs(size);
  // The words beyond the last slice belong to it.
  const std::size_t from = slice * static_cast<std::size_t>(slices.begin);
  const std::size_t until =
      slices.end == size[2] ? count : slice * static_cast<std::size_t>(slices.end);
  constexpr std::size_t kWord = sizeof(std::uint32_t);
  glBindBuffer(GL_TEXTURE_BUFFER, table.buffer_id());
  const bool ours = table.memory() != nullptr;
  auto* words = ours ? static_cast<std::uint32_t*>(table.memory()) + which * count + from
                     : static_cast<std::uint32_t*>(glMapBufferRange(
                           GL_TEXTURE_BUFFER, static_cast<GLintptr>((which * count + from) * kWord),
                           static_cast<GLsizeiptr>((until - from) * kWord),
                           GL_MAP_WRITE_BIT | GL_MAP_INVALIDATE_RANGE_BIT));
  if (words != nullptr) {
    for_each_index(slices.end - slices.begin, 0, [&](int k) {
      const std::size_t first = static_cast<std::size_t>(k) * slice;
      for (std::size_t at = first; at < first + slice; at += row) {
        const std::int16_t* voxels = volume.values().data() + from + at;
        std::uint32_t* to = words + at;
        for (std::size_t i = 0; i + 1 < row; ++i) {
          to[i] = pair_of(value_of(voxels[i]), value_of(voxels[i + 1]));
        }
        to[row - 1] = pair_of(value_of(voxels[row - 1]), value_of(voxels[row - 1]));
      }
    });
    const std::size_t there = slice * static_cast<std::size_t>(slices.end) - from;
    std::fill(words + there, words + (until - from), 0U);
  }
  const bool filled = words != nullptr && (ours || glUnmapBuffer(GL_TEXTURE_BUFFER) == GL_TRUE);
  glBindBuffer(GL_TEXTURE_BUFFER, 0);
  return glGetError() == GL_NO_ERROR && filled;
}

/// Sends the entries of a table, as a texture without filter or edges.
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
