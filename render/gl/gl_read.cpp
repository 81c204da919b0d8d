// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <cstring>

#include "render/gl/gl_read.hpp"

namespace nav::render {

void GlReadBuffer::read(unsigned attachment, int width, int height, bool direct,
                        std::vector<RgbaF>& pixels) {
  pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  glReadBuffer(attachment);
  if (direct) {
    glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, pixels.data());
    return;
  }
  const std::size_t bytes = pixels.size() * sizeof(RgbaF);
  make_room(bytes);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, nullptr);
  const auto size = static_cast<GLsizeiptr>(bytes);
  const void* read = glMapBufferRange(GL_PIXEL_PACK_BUFFER, 0, size, GL_MAP_READ_BIT);
  if (read != nullptr) {
    std::memcpy(pixels.data(), read, bytes);
    glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  if (read == nullptr) glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, pixels.data());
}

void GlReadBuffer::make_room(std::size_t bytes) {
  if (buffer_ != 0 && bytes <= room_) return;
  release();
  glGenBuffers(1, &buffer_);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer_);
  const auto size = static_cast<GLsizeiptr>(bytes);
  if (GLEW_VERSION_4_4 != 0 || GLEW_ARB_buffer_storage != 0) {
    glBufferStorage(GL_PIXEL_PACK_BUFFER, size, nullptr, GL_MAP_READ_BIT | GL_CLIENT_STORAGE_BIT);
  } else {
    glBufferData(GL_PIXEL_PACK_BUFFER, size, nullptr, GL_STREAM_READ);
  }
  room_ = bytes;
}

void GlReadBuffer::release() {
  if (buffer_ != 0) glDeleteBuffers(1, &buffer_);
  buffer_ = 0;
  room_ = 0;
}

}  // namespace nav::render
