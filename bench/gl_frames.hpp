// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/engine.hpp"

namespace nav::bench {

/// Placeholder of an image that is not read back.
class BlankImage {
 public:
  /// A black image; shared between calls for one size.
  const Image2d<RgbaF>& of(int width, int height) {
    if (image_.width() != width || image_.height() != height) {
      const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
      image_ = {width, height, std::vector<RgbaF>(count, RgbaF{0, 0, 0, 1})};
    }
    return image_;
  }

 private:
  Image2d<RgbaF> image_;
};

/// The GL engine as an application window uses it: render() returns when the device has drawn, and
/// the image stays on the device. The returned image is black; samples and rays of its statistics
/// are 0. kUnavailable without OpenGL.
Result<std::unique_ptr<render::Engine>> make_gl_frames(const render::GlOptions& options = {});

}  // namespace nav::bench
