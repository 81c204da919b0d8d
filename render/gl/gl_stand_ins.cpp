// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "render/gl/gl_stand_ins.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/gl/gl_upload.hpp"

namespace nav::render {
namespace {

struct StandInKind {
  GLint internal;
  GLenum layout;
  GLenum type;
  GLint filter;
};

/// The kinds that GlFeatureTextures and GlPredicates send.
constexpr StandInKind kFeatureKind{GL_RGBA16_SNORM, GL_RGBA, GL_SHORT, GL_LINEAR};
constexpr StandInKind kUndefinedKind{GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, GL_NEAREST};
constexpr StandInKind kLabelKind{GL_R16UI, GL_RED_INTEGER, GL_UNSIGNED_SHORT, GL_NEAREST};

void send(const StandInKind& kind, const std::array<int, 3>& size, GlTexture& texture) {
  const std::vector<std::uint8_t> nothing(27 * 8);
  glBindTexture(GL_TEXTURE_3D, texture.id());
  gl::set_sampling(GL_TEXTURE_3D, kind.filter);
  glTexImage3D(GL_TEXTURE_3D, 0, kind.internal, size[0], size[1], size[2], 0, kind.layout,
               kind.type, nothing.data());
}

}  // namespace

void GlStandIns::update(const std::array<int, 3>& size) {
  std::array<int, 3> least{};
  std::transform(size.begin(), size.end(), least.begin(),
                 [](int n) { return std::has_single_bit(static_cast<unsigned>(n)) ? 1 : 3; });
  if (least == size_) return;
  const gl::PackedRows packed;
  glActiveTexture(GL_TEXTURE0 + kTarget);
  send(kFeatureKind, least, feature_);
  send(kUndefinedKind, least, undefined_);
  send(kLabelKind, least, labels_);
  gl::send_table(pairs_, GL_R32I, std::vector<std::int32_t>(300));
  size_ = least;
}

void GlStandIns::release() {
  for (GlTexture* texture : {&feature_, &undefined_, &labels_}) texture->release();
  pairs_.release();
  size_ = {};
}

}  // namespace nav::render
