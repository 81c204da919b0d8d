// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "render/gl/gl_textures.hpp"
#include "render/predicates/feature.hpp"

namespace nav::render {

namespace gl {
struct SendLimit;
}

/// The labels of predicates on the device, with the bits that occur. Internal to render/; needs the
/// context current.
class GlLabelTexture {
 public:
  /// Sends what the device lacks, as far as limit allows, and lowers limit. Returns
  /// kUnsupportedData if the device's memory is too small.
  Result<void> update(const LabelVolume& labels, gl::SendLimit& limit);
  /// Bytes that the next update() reads without a limit.
  [[nodiscard]] std::size_t missing_bytes(const LabelVolume& labels) const;
  void release();

  [[nodiscard]] unsigned id() { return texture_.id(); }
  /// Internal format; 0: none was sent yet.
  [[nodiscard]] int format() const { return format_; }
  /// The bits that the texture keeps: packed_bits().
  [[nodiscard]] std::uint32_t bits() const { return bits_; }

 private:
  [[nodiscard]] int missing_slices(const LabelVolume& labels) const;

  GlTexture texture_;
  std::optional<LabelVolume> labels_;  ///< The labels that are sent or being sent.
  int slices_ = 0;                     ///< Number of slices that were sent.
  int format_ = 0;
  std::uint32_t bits_ = ~0U;
};

}  // namespace nav::render
