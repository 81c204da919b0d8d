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

/// The labels of predicates on the device, of the bits that occur. Internal to render/; needs the
/// context current.
class GlLabelTexture {
 public:
  /// Sends what is not there, as far as a limit allows, which is lowered. kUnsupportedData for what
  /// the device's memory does not hold.
  Result<void> update(const LabelVolume& labels, gl::SendLimit& limit);
  /// Bytes that the next update() reads where nothing limits it.
  [[nodiscard]] std::size_t missing_bytes(const LabelVolume& labels) const;
  void release();

  [[nodiscard]] unsigned id() { return texture_.id(); }
  /// Internal format, 0: none was sent yet.
  [[nodiscard]] int format() const { return format_; }
  /// That it keeps, packed_bits().
  [[nodiscard]] std::uint32_t bits() const { return bits_; }

 private:
  [[nodiscard]] int missing_slices(const LabelVolume& labels) const;

  GlTexture texture_;
  std::optional<LabelVolume> labels_;  ///< There, or being sent.
  int slices_ = 0;                     ///< Of them there.
  int format_ = 0;
  std::uint32_t bits_ = ~0U;
};

}  // namespace nav::render
